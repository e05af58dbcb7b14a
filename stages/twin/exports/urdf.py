"""URDF: a tree of links with one joint each, on a tilted base.

It has no springs, no start, no contact. The six coordinates of the inner frame need five links without mass.
"""

from __future__ import annotations

from xml.etree import ElementTree

from stages.twin.exports.exported import Exported, Link
from stages.twin.exports.solids import piece_place
from stages.twin.exports.xml_text import TENSOR, Element, add, document, numbers
from stages.twin.machine.parts import Part

ENDING = "urdf"
OF = "ROS, Pinocchio, Drake, PyBullet"
CARRIES = {
    "inertias": "yes",
    "coordinates": "yes, by name",
    "springs and dampers": "dampers only",
    "start": "no",
    "sensors": "places only, as links without mass",
    "slope": "yes, the first joint is tilted",
    "stepping blocks": "yes, shapes on the tilted base",
    "contact law": "no",
    "friction": "no",
    "rule for scuffing": "no",
    "shape": "boxes and cylinders; feet as full cylinders",
    "motion": "no",
}
COLOURS = {"inner": "0 0.62 0.45 1", "outer": "0.84 0.37 0 1", "block": "0.55 0.43 0.27 1"}
#: Travel [m, rad], force and speed that a slide must be given; wide enough to never matter.
WIDE = {"lower": "-1000", "upper": "1000", "effort": "1e9", "velocity": "1e6"}
QUARTER = "1.5707963267948966"


def write(exported: Exported) -> bytes:
    """The file as bytes."""
    root = ElementTree.Element("robot", {"name": "bipedstudy_twin"})
    for pair, colour in COLOURS.items():
        add(add(root, "material", name=pair), "color", rgba=colour)
    add(root, "link", name="world")
    _add_ground(add(root, "link", name="slope"), exported)
    base = add(root, "joint", name="slope", type="fixed")
    add(base, "origin", rpy=numbers((QUARTER, exported.slope.angle, 0.0)))
    add(base, "parent", link="world")
    add(base, "child", link="slope")
    for link in exported.links:
        parent = "slope" if link.parent < 0 else _named(exported.links[link.parent].name)
        for joint in link.joints:
            last = joint is link.joints[-1]
            child = _named(link.name) if last else f"after_{_named(joint.name)}"
            made = add(root, "joint", name=_named(joint.name), type="continuous" if joint.turns else "prismatic")
            add(made, "parent", link=parent)
            add(made, "child", link=child)
            add(made, "axis", xyz=numbers(joint.axis))
            add(made, "dynamics", damping=repr(joint.damping))
            if not joint.turns:
                add(made, "limit", **WIDE)
            if not last:
                add(root, "link", name=child)
            parent = child
        _fill(add(root, "link", name=_named(link.name)), link, exported)
        for name, place in link.sites:
            add(root, "link", name=_named(name))
            fixed = add(root, "joint", name=f"{_named(name)}_place", type="fixed")
            add(fixed, "origin", xyz=numbers(place))
            add(fixed, "parent", link=_named(link.name))
            add(fixed, "child", link=_named(name))
    return document(root, "The twin of bipedstudy. URDF has no springs, no start and no contact law: docs/exports.md.")


def _named(words: str) -> str:
    return words.replace(" ", "_")


def _add_ground(slope: Element, exported: Exported) -> None:
    size = exported.block_size
    for block in exported.blocks():
        x, top, z = block.middle
        for kind in ("visual", "collision"):
            made = add(slope, kind)
            add(made, "origin", xyz=numbers((x, top - size[1] / 2, z)))
            add(add(made, "geometry"), "box", size=numbers(size))
            if kind == "visual":
                add(made, "material", name="block")


def _fill(made: Element, link: Link, exported: Exported) -> None:
    inertia = link.body.inertia
    own = add(made, "inertial")
    add(own, "origin", xyz=numbers(link.body.centre))
    add(own, "mass", value=repr(float(link.body.mass)))
    add(own, "inertia", **{name: repr(float(inertia[place])) for name, place in TENSOR.items()})
    for part, side in link.parts:
        _add_piece(made, part, side)
    for leg in link.feet:
        middle, radius = exported.foot(leg)
        touch = add(made, "collision")
        add(touch, "origin", xyz=numbers(middle))
        add(add(touch, "geometry"), "cylinder", radius=repr(radius), length=repr(2.0 * exported.machine.half_width))


def _add_piece(made: Element, part: Part, side: float) -> None:
    """What is seen of a piece: a tube is drawn full, a rim as its whole wheel. A point is not seen."""
    turn = {"x": f"0 {QUARTER} 0", "y": f"{QUARTER} 0 0", "z": "0 0 0"}[part.axis if part.shape != "box" else "z"]
    if part.shape == "point":
        return
    seen = add(made, "visual")
    add(seen, "origin", xyz=numbers(piece_place(part, side)), rpy=turn)
    shape = add(seen, "geometry")
    if part.shape == "box":
        add(shape, "box", size=numbers(part.size))
    else:
        width = part.size[2] if part.shape == "arc" else part.size[-1]
        add(shape, "cylinder", radius=repr(float(part.size[0])), length=repr(float(width)))
    add(seen, "material", name=part.group.split("_")[0])
