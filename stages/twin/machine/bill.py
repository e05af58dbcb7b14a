"""Whether the bill of parts is possible and adds up to Table 1, and the rule by which it follows a changed design.

The file says which design its parts are drawn for (`parts_hip_mass` and so on). For that design they are as written.
For another one lengths scale with the leg, masses above the springs with the hip mass, masses below with the foot mass.
Arcs are feet: they scale with the foot's radius about its centre. What else is below the springs moves along the leg
until the mass centre is at `foot_com`; it shrinks about its own where it would pass the ground or the hip, and the
arcs lose mass where that is not enough. So moments about the hip axis scale with mass times length squared; a
`leg_inertia` that the design gives scales the feet's tensors. Along the hip axis nothing changes: there the lanes of
`twin.yaml` hold.
"""

import dataclasses
from collections.abc import Iterator, Sequence

from stages.biped.design import Biped
from stages.twin.machine.parts import FEET, FRAMES, SOLID_MARGIN, Material, Part, solid

#: How far the sums may be from Table 1, whose values have three decimals: half of the fourth, in kg and m.
ROUNDING = 5e-5


def sums(parts: Sequence[Part], biped: Biped) -> list[tuple[str, float, float]]:
    """Rows (what with its unit, sum of the bill, value of Table 1)."""
    hip = sum(part.mass * part.pieces for part in parts if part.group in FRAMES)
    rows = [("hip mass [kg]", hip, biped.hip_mass)]
    for group in FEET:
        mass, forward, up = _centre([part for part in parts if part.group == group])
        height = up + biped.leg_length if mass else 0.0
        rows += [
            (f"{group.replace('_', ' ')} mass, both legs [kg]", mass, biped.foot_mass),
            (f"{group.replace('_', ' ')} mass centre above the foot's bottom [m]", height, biped.foot_com),
            (f"{group.replace('_', ' ')} mass centre forward of the leg [m]", forward, 0.0),
        ]
    return rows


def adds_up(parts: Sequence[Part], biped: Biped) -> bool:
    """Whether the bill's sums are those of the design."""
    return all(abs(found - wanted) <= ROUNDING for _, found, wanted in sums(parts, biped))


def faults(parts: Sequence[Part], materials: Sequence[Material], drawn: Biped, biped: Biped) -> Iterator[str]:
    """What is wrong with the bill as a whole, each in words that say what would be right.

    It is drawn for one of two designs: `drawn`, for which twin.yaml says it is, or `biped`.
    """
    density = {material.name: material.density for material in materials}
    for part in parts:
        if part.material not in density:
            yield f"{part.name}: a material of the list ({', '.join(density)}), not {part.material}"
        elif part.shape != "point" and part.mass > SOLID_MARGIN * part.volume * density[part.material]:
            heaviest = part.volume * density[part.material]
            yield f"{part.name}: at most {heaviest:.4f} kg, which is solid {part.material}, not {part.mass:g} kg"
    for group in FRAMES + FEET:
        if all(part.group != group for part in parts):
            yield f"at least one part of group {group}"
    for what, found, wanted in () if adds_up(parts, drawn) else sums(parts, biped):
        if abs(found - wanted) > ROUNDING:
            yield (
                f"parts that add up to the design in biped.yaml or to the one of parts_hip_mass, parts_foot_mass, "
                f"parts_leg_length, parts_foot_radius and parts_foot_com (or twin.inertia = planar, no parts): "
                f"{what} {wanted:.5g}, not {found:.5g}"
            )


def check(parts: Sequence[Part], materials: Sequence[Material], drawn: Biped, biped: Biped) -> None:
    """Raise ValueError, in one sentence, if the bill is impossible or adds up to neither of the designs."""
    wrong = "; ".join(faults(parts, materials, drawn, biped))
    if wrong:
        raise ValueError(f"the bill of parts in twin.yaml needs {wrong}")


#: Numbers of a design that a bill of parts is drawn for; `twin.yaml` has them with `parts_` before.
DRAWN = ("hip_mass", "foot_mass", "leg_length", "foot_radius", "foot_com")
#: Parts shrink to this share of their size at the least: thin ones could not be drawn.
SMALLEST = 0.01


def changes(parts: Sequence[Part], drawn: Biped, biped: Biped) -> tuple[str, ...]:
    """The numbers by which `biped` differs from the design of the parts, none where they are used as written.

    They are as well if they add up to `biped` and not to `drawn`: then they are the biped's own.
    """
    keys = tuple(key for key in DRAWN if getattr(drawn, key) != getattr(biped, key))
    return keys if keys and adds_up(parts, drawn) else ()


def rule(parts: Sequence[Part], drawn: Biped, biped: Biped) -> str:
    """In words how the parts are made to fit `biped`, "" if they are as written."""
    fields = {field.name: field.metadata["unit"] for field in dataclasses.fields(Biped)}
    said = [f"{key} {getattr(drawn, key):g} -> {getattr(biped, key):g} {fields[key]}"
            for key in changes(parts, drawn, biped)]
    across = ", lanes as in twin.yaml" if biped.leg_length != drawn.leg_length else ""
    scaled = [f"parts scaled from another design ({', '.join(said)}){across}"] if said else []
    given = [f"feet's moments scaled to leg_inertia {biped.leg_inertia:g} kg m^2"] if biped.leg_inertia > 0 else []
    return ", ".join(scaled + given)


def fitted(parts: Sequence[Part], drawn: Biped, biped: Biped) -> tuple[Part, ...]:
    """The parts of a machine of design `biped`, made from those of the design `drawn`."""
    if not changes(parts, drawn, biped):
        return tuple(parts)
    legs = biped.leg_length / drawn.leg_length
    frames = [part for part in parts if part.group in FRAMES]
    share = biped.hip_mass / sum(part.mass * part.pieces for part in frames)
    done = {id(part): _resized(part, legs, share * part.mass, 0.0, 0.0) for part in frames}
    for group in FEET:
        feet = [part for part in parts if part.group == group]
        done.update(zip(map(id, feet), _feet(feet, drawn, biped)))
    return tuple(done[id(part)] for part in parts)


def _feet(parts: Sequence[Part], drawn: Biped, biped: Biped) -> Iterator[Part]:
    """Parts below the springs of one pair, in their order."""
    legs = biped.leg_length / drawn.leg_length
    wide = biped.foot_radius / drawn.foot_radius if drawn.foot_radius else legs
    share = biped.foot_mass / sum(part.mass * part.pieces for part in parts)
    ankle, new_ankle = drawn.foot_radius - drawn.leg_length, biped.foot_radius - biped.leg_length
    round_feet = [part for part in parts if part.shape == "arc"]
    if len(round_feet) == len(parts):
        round_feet = []
    up = new_ankle - wide * ankle
    held, *at = _centre([_resized(part, wide, share * part.mass, 0.0, up) for part in round_feet])
    whole, centre = biped.foot_mass, (0.0, biped.foot_com - biped.leg_length)
    lighter = 1.0  # feet that would need the rest below the ground or above the hip
    for end in (-biped.leg_length, 0.0):
        if held * (at[1] - end) and (most := whole * (centre[1] - end) / (held * (at[1] - end))) < lighter:
            lighter = max(0.0, most)
    left = whole - lighter * held
    place = [(whole * c - lighter * held * a) / left for c, a in zip(centre, at)]  # of the rest's mass
    heavier = share * left / (whole - held)
    rest = [part for part in parts if part not in round_feet]
    _, *middle = _centre(rest)
    low = min(part.position[1] - _half_height(part) for part in rest)
    high = max(part.position[1] + _half_height(part) for part in rest)
    rooms = [(place[1] - min(-biped.leg_length, legs * low), middle[1] - low),
             (max(0.0, legs * high) - place[1], high - middle[1])]
    room = max(SMALLEST * legs, min([legs, *(there / needed for there, needed in rooms if needed > 0.0)]))
    shift = [there - room * m for there, m in zip(place, middle)]
    for part in parts:
        yield (_resized(part, wide, lighter * share * part.mass, 0.0, up) if part in round_feet
               else _resized(part, room, heavier * part.mass, *shift))


def _resized(part: Part, factor: float, mass: float, forward: float, up: float) -> Part:
    """A part with another mass, `factor` times as large across the hip axis and as far from it, then moved [m].

    What would be smaller than a thousandth is a point: an arc of feet without a radius.
    """
    x, y, z = part.position
    across = 2 if part.shape in ("box", "arc") else len(part.size) - 1 if part.axis == "z" else -1  # along the hip axis
    size = tuple(value if number == across else factor * value for number, value in enumerate(part.size))
    shape, size = ("point", ()) if factor < 1e-3 else (part.shape, size)
    return dataclasses.replace(
        part, shape=shape, size=size, mass=mass, position=(factor * x + forward, factor * y + up, z))


def _centre(parts: Sequence[Part]) -> tuple[float, float, float]:
    """Mass [kg] of all pieces, and their mass centre forward of the hip axis and above it [m]."""
    mass = sum(part.mass * part.pieces for part in parts)
    forward, up = 0.0, 0.0
    for part in parts:
        centroid = solid(part.shape, part.size, part.axis).centroid
        forward += part.mass * part.pieces * (part.position[0] + centroid[0])
        up += part.mass * part.pieces * (part.position[1] + centroid[1])
    return mass, forward / (mass or 1.0), up / (mass or 1.0)


def _half_height(part: Part) -> float:
    """How far a part reaches above and below its reference point [m]."""
    if not part.size:
        return 0.0
    if part.shape == "box":
        return 0.5 * part.size[1]
    return 0.5 * part.size[-1] if part.axis == "y" else part.size[0]
