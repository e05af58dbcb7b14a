"""MuJoCo's own format: everything but the contact law.

The ground is MuJoCo's: a soft constraint with its own time constant. Each pair's feet touch the blocks of its own
lane only, so a swinging foot goes down through the gaps of its lane as on the ramp, without a rule for scuffing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from xml.etree import ElementTree

from stages.twin.exports.exported import Exported, Link
from stages.twin.exports.solids import piece_place, surface
from stages.twin.exports.xml_text import Element, add, document, numbers
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
COLOURS = ("0 0.62 0.45 1", "0.84 0.37 0 1")
#: What a geometry does: seen only, or touches.
SEEN, TOUCHES = "1", "0"


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
    root = ElementTree.Element("mujoco", {"model": "bipedstudy twin"})
    add(root, "compiler", angle="radian", inertiafromgeom="false")
    add(root, "option", timestep=repr(ground.step), gravity=numbers((0, 0, -exported.slope.gravity)),
        integrator="implicitfast", cone="elliptic")  # fmt: skip
    add(add(root, "visual"), "headlight", ambient="0.4 0.4 0.4", diffuse="0.5 0.5 0.5")
    asset = add(root, "asset")
    add(asset, "texture", type="skybox", builtin="gradient", rgb1="0.9 0.94 0.97", rgb2="0.7 0.78 0.85", width="64",
        height="384")  # fmt: skip
    world = add(root, "worldbody")
    add(world, "light", pos="0 -1 2", dir="0 0.4 -1", directional="true")
    half = 0.5 * exported.slope.angle
    quarter = math.sqrt(0.5)
    turned = (quarter * math.cos(half), quarter * math.cos(half), quarter * math.sin(half), -quarter * math.sin(half))
    slope = add(world, "body", name="slope", quat=numbers(turned))
    _add_blocks(slope, exported, ground)
    placed: list[Element] = []
    sensors = add(root, "sensor")
    for link in exported.links:
        body = add(slope if link.parent < 0 else placed[link.parent], "body", name=link.name)
        placed.append(body)
        _fill(body, link, exported, ground, asset)
        for name, place in link.sites:
            add(body, "site", name=name, pos=numbers(place), size="0.004")
            add(sensors, "accelerometer", name=f"{name} specific force", site=name)
            add(sensors, "gyro", name=f"{name} angular velocity", site=name)
    key = add(root, "keyframe")
    starts = exported.coordinates()
    add(key, "key", name="start", qpos=numbers(q for _, q, _ in starts), qvel=numbers(v for _, _, v in starts))
    return document(root, "The twin of bipedstudy. Its contact is MuJoCo's, not the study's: docs/exports.md.")


def _add_blocks(slope: Element, exported: Exported, ground: Ground) -> None:
    length, height, width = exported.block_size
    size = numbers((length / 2, height / 2, width / 2))
    for block in exported.blocks():
        x, top, z = block.middle
        side = "left" if z > 0.0 else "right"
        add(slope, "geom", name=f"block {block.number + 1} {side}", type="box", size=size,
            pos=numbers((x, top - height / 2, z)), rgba="0.55 0.43 0.27 1",
            **_touch("conaffinity", block.pair, exported, ground),
        )  # fmt: skip
    span = (exported.ramp.sets - 1) * exported.ramp.step
    deck = (span / 2 + length, 0.005, exported.ramp.tracks[1] + width)
    add(slope, "geom", name="deck", type="box", size=numbers(deck), pos=numbers((span / 2, -height - 0.005, 0.0)),
        rgba="0.79 0.74 0.66 1", contype="0", conaffinity="0", group=SEEN)  # fmt: skip


def _touch(side: str, pair: int, exported: Exported, ground: Ground) -> dict[str, str]:
    """Contact of a pair's feet (side contype) with the blocks of its lane (conaffinity), and with nothing else."""
    return {
        "contype": "0", "conaffinity": "0", side: str(1 << pair), "group": TOUCHES, "condim": "3",
        "friction": numbers((exported.contact.static_friction, 0.0, 0.0)),
        "solref": numbers((ground.time_constant, ground.damping_ratio)),
    }  # fmt: skip


def _fill(body: Element, link: Link, exported: Exported, ground: Ground, asset: Element) -> None:
    for joint in link.joints:
        add(body, "joint", name=joint.name, type="hinge" if joint.turns else "slide", axis=numbers(joint.axis),
            stiffness=repr(joint.stiffness), damping=repr(joint.damping))  # fmt: skip
    inertia = link.body.inertia
    six = [inertia[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
    add(body, "inertial", pos=numbers(link.body.centre), mass=repr(float(link.body.mass)), fullinertia=numbers(six))
    for part, side in link.parts:
        _add_piece(body, part, side, COLOURS[part.group.startswith("outer")], asset)
    for leg in link.feet:
        middle, radius = exported.foot(leg)
        half = exported.machine.half_width
        about = {"rgba": "0 0 0 0", **_touch("contype", leg // 2, exported, ground)}
        if ground.foot == "spheres":
            for end, z in (("left", half), ("right", -half)):
                place = (middle[0], middle[1], middle[2] + z)
                add(body, "geom", name=f"{link.name} {leg} {end}", type="sphere", pos=numbers(place),
                    size=numbers((radius,)), **about)  # fmt: skip
        else:
            add(body, "geom", name=f"{link.name} {leg}", type=ground.foot, pos=numbers(middle),
                size=numbers((radius, half)), **about)  # fmt: skip


def _add_piece(body: Element, part: Part, side: float, colour: str, asset: Element) -> None:
    """What is seen of a piece; a tube is drawn full."""
    seen = {"pos": numbers(piece_place(part, side)), "rgba": colour, "contype": "0", "conaffinity": "0", "group": SEEN}
    if part.shape == "box":
        add(body, "geom", type="box", size=numbers(0.5 * value for value in part.size), **seen)
    elif part.shape in ("cylinder", "tube"):
        turn = {"x": "0 1 0 1.5707963267948966", "y": "1 0 0 1.5707963267948966", "z": "0 0 1 0"}[part.axis]
        add(body, "geom", type="cylinder", size=numbers((part.size[0], 0.5 * part.size[-1])), axisangle=turn, **seen)
    elif part.shape == "arc":
        name = f"arc {' '.join(f'{1e3 * value:g}' for value in part.size)}"
        if asset.find(f"mesh[@name='{name}']") is None:
            made = surface(part)
            assert made is not None
            add(asset, "mesh", name=name, vertex=numbers(made.corners.ravel().round(7)), inertia="shell",
                face=" ".join(str(corner) for corner in made.triangles.ravel()))  # fmt: skip
        add(body, "geom", type="mesh", mesh=name, **seen)
