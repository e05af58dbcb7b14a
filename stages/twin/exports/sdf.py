"""SDFormat, of Gazebo and Drake: a world with gravity, the ramp's blocks, and the twin on a tilted frame.

Springs are `spring_stiffness` of a joint's axis. The contact of a foot is a linear spring and damper: a secant of the
study's law at the force of one standing foot.
"""

from __future__ import annotations

from xml.etree import ElementTree

from stages.ground.friction import static_penetration
from stages.twin.exports.exported import Exported, Link
from stages.twin.exports.solids import piece_place
from stages.twin.exports.urdf import COLOURS, QUARTER
from stages.twin.exports.xml_text import TENSOR, Element, add, document, numbers
from stages.twin.machine.machine import LEGS
from stages.twin.machine.parts import Part

ENDING = "sdf"
OF = "Gazebo, Drake"
CARRIES = {
    "inertias": "yes",
    "coordinates": "yes, by name",
    "springs and dampers": "yes",
    "start": "no",
    "sensors": "yes, `imu` on its link",
    "slope": "yes, the models stand tilted",
    "stepping blocks": "yes, one collision bit a pair",
    "contact law": "a linear spring, the law's secant at a standing foot, and its largest damping",
    "friction": "one coefficient, the static one",
    "rule for scuffing": "no: blocks take its place, where the bits are kept",
    "shape": "boxes and cylinders; feet as full cylinders",
    "motion": "no",
}


def write(exported: Exported) -> bytes:
    """The file as bytes."""
    root = ElementTree.Element("sdf", {"version": "1.9"})
    world = add(root, "world", name="slope")
    add(world, "gravity", numbers((0.0, 0.0, -exported.slope.gravity)))
    tilted = f"0 0 0 {QUARTER} {exported.slope.angle!r} 0"
    ramp = add(world, "model", name="ramp")
    add(ramp, "static", "true")
    add(ramp, "pose", tilted)
    _add_ground(add(ramp, "link", name="blocks"), exported)
    model = add(world, "model", name="twin")
    add(model, "pose", tilted)
    for link in exported.links:
        parent = "world" if link.parent < 0 else exported.links[link.parent].name
        for joint in link.joints:
            last = joint is link.joints[-1]
            child = link.name if last else f"after {joint.name}"
            if not last:
                massless(add(model, "link", name=child))
            made = add(model, "joint", name=joint.name, type="revolute" if joint.turns else "prismatic")
            add(made, "parent", parent)
            add(made, "child", child)
            axis = add(made, "axis")
            add(axis, "xyz", numbers(joint.axis))
            moving = add(axis, "dynamics")
            add(moving, "damping", repr(joint.damping))
            add(moving, "spring_reference", "0")
            add(moving, "spring_stiffness", repr(joint.stiffness))
            parent = child
        _fill(add(model, "link", name=link.name), link, exported)
    return document(root, "The twin of bipedstudy. SDFormat has no start and no contact law of the study's kind: "
                    "docs/exports.md.")  # fmt: skip


def massless(link: Element) -> None:
    """A link between two coordinates: SDFormat wants a mass, one that moves nothing."""
    own = add(link, "inertial")
    add(own, "mass", "0")
    inertia = add(own, "inertia")
    for name in TENSOR:
        add(inertia, name, "0")


def _add_ground(link: Element, exported: Exported) -> None:
    size = exported.block_size
    for block in exported.blocks():
        x, top, z = block.middle
        name = f"block {block.number + 1} {'left' if z > 0.0 else 'right'}"
        for kind in ("visual", "collision"):
            made = add(link, kind, name=name)
            add(made, "pose", numbers((x, top - size[1] / 2, z, 0, 0, 0)))
            add(add(add(made, "geometry"), "box"), "size", numbers(size))
            if kind == "collision":
                _add_surface(made, block.pair, exported)
            else:
                add(add(made, "material"), "diffuse", COLOURS["block"])


def _add_surface(made: Element, pair: int, exported: Exported) -> None:
    """What feet and blocks are made of: friction, and the secant of the law of a foot that carries half the machine."""
    law, load = exported.contact, exported.machine.mass * exported.slope.gravity
    surface = add(made, "surface")
    contact = add(surface, "contact")
    add(contact, "collide_bitmask", str(1 << pair))
    soft = add(contact, "ode")
    add(soft, "kp", repr(float(0.5 * load / static_penetration(law, load))))
    add(soft, "kd", repr(0.5 * law.contact_damping))
    sliding = add(add(surface, "friction"), "ode")
    add(sliding, "mu", repr(law.static_friction))
    add(sliding, "mu2", repr(law.static_friction))


def _fill(made: Element, link: Link, exported: Exported) -> None:
    body = link.body
    own = add(made, "inertial")
    add(own, "pose", numbers((*body.centre, 0, 0, 0)))
    add(own, "mass", repr(float(body.mass)))
    inertia = add(own, "inertia")
    for name, (row, column) in TENSOR.items():
        add(inertia, name, repr(float(body.inertia[row, column])))
    for number, (part, side) in enumerate(link.parts):
        _add_piece(made, part, side, number)
    for leg in link.feet:
        middle, radius = exported.foot(leg)
        touch = add(made, "collision", name=f"{LEGS[leg]} foot")
        add(touch, "pose", numbers((*middle, 0, 0, 0)))
        shape = add(add(touch, "geometry"), "cylinder")
        add(shape, "radius", repr(radius))
        add(shape, "length", repr(2.0 * exported.machine.half_width))
        _add_surface(touch, leg // 2, exported)
    for name, place in link.sites:
        sensor = add(made, "sensor", name=name, type="imu")
        add(sensor, "pose", numbers((*place, 0, 0, 0)))


def _add_piece(made: Element, part: Part, side: float, number: int) -> None:
    """What is seen of a piece: a tube is drawn full, a rim as its whole wheel. A point is not seen."""
    if part.shape == "point":
        return
    turn = {"x": f"0 {QUARTER} 0", "y": f"{QUARTER} 0 0", "z": "0 0 0"}[part.axis if part.shape != "box" else "z"]
    seen = add(made, "visual", name=f"{number} {part.name}")
    add(seen, "pose", f"{numbers(piece_place(part, side))} {turn}")
    shape = add(seen, "geometry")
    if part.shape == "box":
        add(add(shape, "box"), "size", numbers(part.size))
    else:
        made = add(shape, "cylinder")
        add(made, "radius", repr(float(part.size[0])))
        add(made, "length", repr(float(part.size[2] if part.shape == "arc" else part.size[-1])))
    add(add(seen, "material"), "diffuse", COLOURS[part.group.split("_")[0]])
