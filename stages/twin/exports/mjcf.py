"""MuJoCo's own format: everything but the contact law.

The ground is MuJoCo's: a soft constraint with its own time constant. Each pair's feet touch the blocks of its own
lane only, so a swinging foot goes down through the gaps of its lane as on the ramp, without a rule for scuffing.
"""

import math
from dataclasses import dataclass

from stages.twin.exports.exported import COLOURS, QUARTER, Element, Exported, Link, Value, document, tag, tensor
from stages.twin.exports.solids import piece_place, surface
from stages.twin.machine.parts import Part

ENDING = "xml"
OF = "MuJoCo"
CARRIES = {
    "inertias": "yes",
    "coordinates": "yes, by name and in order",
    "springs and dampers": "yes",
    "start": "yes, keyframe `start`",
    "sensors": "yes, sites with accelerometer and gyroscope",
    "slope": "yes, the ground is tilted",
    "stepping blocks": "yes, one contact bit a pair",
    "contact law": "no: MuJoCo's own, by `solref` and `solimp`",
    "friction": "one coefficient, the static one",
    "rule for scuffing": "no: blocks take its place",
    "shape": "yes",
    "motion": "no",
}
#: What a geometry that is seen only does, and the turns that bring z to an axis.
SEEN: dict[str, Value] = {"contype": "0", "conaffinity": "0", "group": "1"}
TURNS = {"x": f"0 1 0 {QUARTER}", "y": f"1 0 0 {QUARTER}", "z": "0 0 1 0"}


@dataclass(frozen=True)
class Ground:
    """MuJoCo's contact: time constant [s] and damping ratio of `solref`, the solver's step [s], shape of the feet.

    A capsule touches with the two end circles of the foot's cylinder, like the study's feet; its bulging ends stay in
    the air. MuJoCo's contact of a cylinder with a box is a search for one point, which wanders as the foot rolls.
    """

    time_constant: float = 0.002
    damping_ratio: float = 1.0
    step: float = 1e-4
    foot: str = "capsule"


def write(exported: Exported, ground: Ground = Ground()) -> bytes:
    """The file as bytes."""
    half, quarter = 0.5 * exported.slope.angle, math.sqrt(0.5)
    turned = (quarter * math.cos(half), quarter * math.cos(half), quarter * math.sin(half), -quarter * math.sin(half))
    asset = tag("asset", tag("texture", type="skybox", builtin="gradient", rgb1="0.9 0.94 0.97", rgb2="0.7 0.78 0.85",
                             width="64", height="384"))  # fmt: skip
    placed = [tag("body", *_blocks(exported, ground), name="slope", quat=turned)]
    for link in exported.links:
        placed.append(_body(link, exported, ground, asset))
        placed[link.parent + 1].append(placed[-1])
    sensors = [tag(kind, name=f"{name} {what}", site=name) for link in exported.links for name, _ in link.sites
               for kind, what in (("accelerometer", "specific force"), ("gyro", "angular velocity"))]  # fmt: skip
    _, places, rates = zip(*exported.coordinates(), strict=True)
    root = tag(
        "mujoco",
        tag("compiler", angle="radian", inertiafromgeom="false"),
        tag("option", timestep=ground.step, gravity=(0, 0, -exported.slope.gravity), integrator="implicitfast",
            cone="elliptic"),
        tag("visual", tag("headlight", ambient="0.4 0.4 0.4", diffuse="0.5 0.5 0.5")),
        asset,
        tag("worldbody", tag("light", pos="0 -1 2", dir="0 0.4 -1", directional="true"), placed[0]),
        tag("sensor", *sensors),
        tag("keyframe", tag("key", name="start", qpos=places, qvel=rates)),
        model="bipedstudy twin",
    )  # fmt: skip
    return document(root, "The twin of bipedstudy. Its contact is MuJoCo's, not the study's: docs/exports.md.")


def _blocks(exported: Exported, ground: Ground) -> list[Element]:
    """The blocks and the board under them."""
    blocks = [tag("geom", name=block.name, type="box", size=[0.5 * side for side in block.sizes["size"]],
                  pos=block.place, rgba=COLOURS["block"], **_touch("conaffinity", pair, exported, ground))
              for pair, block in exported.blocks()]  # fmt: skip
    deck = exported.board()
    half = [0.5 * side for side in deck.sizes["size"]]
    return [*blocks, tag("geom", name="deck", type="box", size=half, pos=deck.place, rgba="0.79 0.74 0.66 1", **SEEN)]


def _touch(side: str, pair: int, exported: Exported, ground: Ground) -> dict[str, Value]:
    """Contact of a pair's feet (side contype) with the blocks of its lane (conaffinity), and with nothing else."""
    return {
        "contype": "0", "conaffinity": "0", side: str(1 << pair), "group": "0", "condim": "3",
        "friction": (exported.contact.coefficients.static_friction, 0.0, 0.0),
        "solref": (ground.time_constant, ground.damping_ratio),
    }  # fmt: skip


def _body(link: Link, exported: Exported, ground: Ground, asset: Element) -> Element:
    """A link with its joints, what is seen of it and what touches; a mesh that is new goes to `asset`."""
    body = tag("body", name=link.name)
    for joint in link.joints:
        body.append(tag("joint", name=joint.name, type="hinge" if joint.turns else "slide", axis=joint.axis,
                        stiffness=joint.stiffness, springref=joint.rest, damping=joint.damping,
                        frictionloss=joint.friction))  # fmt: skip
    inertia = list(tensor(link.body.inertia).values())
    body.append(tag("inertial", pos=link.body.centre, mass=link.body.mass, fullinertia=inertia))
    body.extend(_piece(part, side, asset) for part, side in link.parts if part.shape != "point")
    half = exported.machine.half_width
    for leg in link.feet:
        foot = exported.foot(leg)
        (x, y, z), radius = foot.place, foot.sizes["radius"]
        kind, size, ends = ground.foot, [radius, half], {"": z}
        if kind == "spheres":
            kind, size, ends = "sphere", [radius], {" left": z + half, " right": z - half}
        body.extend(tag("geom", name=f"{link.name} {leg}{end}", type=kind, pos=(x, y, there), size=size, rgba="0 0 0 0",
                        **_touch("contype", leg // 2, exported, ground)) for end, there in ends.items())  # fmt: skip
    body.extend(tag("site", name=name, pos=place, size="0.004") for name, place in link.sites)
    return body


def _piece(part: Part, side: float, asset: Element) -> Element:
    """What is seen of a piece; a tube is drawn full."""
    if part.shape == "box":
        shape: dict[str, Value] = {"type": "box", "size": [0.5 * value for value in part.size]}
    elif part.shape == "arc":
        name = f"arc {' '.join(f'{1e3 * value:g}' for value in part.size)}"
        shape = {"type": "mesh", "mesh": name}
        if asset.find(f"mesh[@name='{name}']") is None and (made := surface(part)) is not None:
            faces = " ".join(str(corner) for corner in made.triangles.ravel())
            asset.append(tag("mesh", name=name, vertex=made.corners.ravel().round(7), inertia="shell", face=faces))
    else:
        shape = {"type": "cylinder", "size": (part.size[0], 0.5 * part.size[-1]), "axisangle": TURNS[part.axis]}
    return tag("geom", **shape, pos=piece_place(part, side), rgba=COLOURS[part.group.split("_")[0]], **SEEN)
