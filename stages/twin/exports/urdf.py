"""URDF: a tree of links with one joint each, on a tilted base.

It has no springs, no start, no contact. The six coordinates of the inner frame need five links without mass.
"""

from stages.twin.exports.exported import COLOURS, QUARTER, Element, Exported, Link, Shape, Value, document, tag, tensor

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
#: Travel [m, rad], force and speed that a slide must be given; wide enough to never matter.
WIDE = {"lower": "-1000", "upper": "1000", "effort": "1e9", "velocity": "1e6"}


def write(exported: Exported) -> bytes:
    """The file as bytes."""
    colours = [tag("material", tag("color", rgba=colour), name=name) for name, colour in COLOURS.items()]
    blocks = [_shape(kind, block, "block" * (kind == "visual"))
              for _, block in exported.blocks() for kind in ("visual", "collision")]  # fmt: skip
    tilted = tag("origin", rpy=(QUARTER, exported.slope.angle, 0.0))
    root = tag("robot", *colours, tag("link", name="world"), tag("link", *blocks, name="slope"),
               _joint("slope", "fixed", "world", "slope", before=[tilted]), name="bipedstudy_twin")  # fmt: skip
    for link in exported.links:
        for joint, parent, child in exported.chain(link, "slope"):
            moves = [tag("axis", xyz=joint.axis), tag("dynamics", damping=joint.damping, friction=joint.friction)]
            moves += [] if joint.turns else [tag("limit", **WIDE)]
            root.append(_joint(joint.name, "continuous" if joint.turns else "prismatic", parent, child, after=moves))
            root.append(_link(link, exported) if child == link.name else tag("link", name=child))
        for name, place in link.sites:
            there = tag("origin", xyz=place)
            root.append(tag("link", name=name))
            root.append(_joint(f"{name} place", "fixed", link.name, name, before=[there]))
    for element in root.iter():
        for key in ("name", "link"):
            if key in element.attrib:
                element.set(key, element.attrib[key].replace(" ", "_"))
    return document(root, "The twin of bipedstudy. URDF has no springs, no start and no contact law: docs/exports.md.")


def _joint(
    name: str, kind: str, parent: str, child: str, before: list[Element] | None = None,
    after: list[Element] | None = None
) -> Element:
    between = [tag("parent", link=parent), tag("child", link=child)]
    return tag("joint", *(before or []), *between, *(after or []), name=name, type=kind)


def _link(link: Link, exported: Exported) -> Element:
    body = link.body
    own = tag("inertial", tag("origin", xyz=body.centre), tag("mass", value=body.mass),
              tag("inertia", **tensor(body.inertia)))  # fmt: skip
    seen = [_shape("visual", shape, shape.colour) for shape in link.shapes()]
    touching = [_shape("collision", exported.foot(leg)) for leg in link.feet]
    return tag("link", own, *seen, *touching, name=link.name)


def _shape(kind: str, shape: Shape, colour: str = "") -> Element:
    turn: dict[str, Value] = {"rpy": shape.turn} if shape.turn else {}
    made = tag(kind, tag("origin", xyz=shape.place, **turn), tag("geometry", tag(shape.kind, **shape.sizes)))
    if colour:
        made.append(tag("material", name=colour))
    return made
