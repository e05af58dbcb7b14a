"""Whether the bill of parts is possible and adds up to Table 1."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from stages.biped.design import Biped
from stages.twin.machine.parts import FEET, FRAMES, SOLID_MARGIN, Material, Part
from stages.twin.machine.shapes import solid

#: How far the sums may be from Table 1, whose values have three decimals: half of the fourth, in kg and m.
ROUNDING = 5e-5


def sums(parts: Sequence[Part], biped: Biped) -> list[tuple[str, float, float]]:
    """Rows (what with its unit, sum of the bill, value of Table 1)."""
    hip = sum(part.mass * part.pieces for part in parts if part.group in FRAMES)
    rows = [("hip mass [kg]", hip, biped.hip_mass)]
    for group in FEET:
        mass, forward, height = _foot(parts, group, biped.leg_length)
        rows += [
            (f"{group.replace('_', ' ')} mass, both legs [kg]", mass, biped.foot_mass),
            (f"{group.replace('_', ' ')} mass centre above the foot's bottom [m]", height, biped.foot_com),
            (f"{group.replace('_', ' ')} mass centre forward of the leg [m]", forward, 0.0),
        ]
    return rows


def _foot(parts: Sequence[Part], group: str, leg_length: float) -> tuple[float, float, float]:
    mass = forward = height = 0.0
    for part in parts:
        if part.group == group:
            centroid = solid(part.shape, part.size, part.axis).centroid
            mass += part.mass * part.pieces
            forward += part.mass * part.pieces * (part.position[0] + centroid[0])
            height += part.mass * part.pieces * (part.position[1] + centroid[1] + leg_length)
    return (mass, forward / mass, height / mass) if mass else (0.0, 0.0, 0.0)


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
