"""SDFormat, of Gazebo and Drake: a world with gravity, the ramp's blocks, and the twin on a tilted frame.

Springs are `spring_stiffness` of a joint's axis. The contact of a foot is a linear spring and damper: a secant of the
study's law at the force of one standing foot, and the law's largest damping, or that at this force where it grows with
it.
"""

import numpy as np

from stages.ground.friction import static_penetration
from stages.twin.exports.exported import (
    COLOURS,
    QUARTER,
    Element,
    Exported,
    Joint,
    Link,
    Shape,
    document,
    tag,
    tensor,
    text,
)
from stages.twin.machine.machine import LEGS

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
    "contact law": "a linear spring, the law's secant at a standing foot, and its damping",
    "friction": "one coefficient, the static one",
    "rule for scuffing": "no: blocks take its place, where the bits are kept",
    "shape": "boxes and cylinders; feet as full cylinders",
    "motion": "no",
}


def write(exported: Exported) -> bytes:
    """The file as bytes."""
    tilted = f"0 0 0 {QUARTER} {exported.slope.angle!r} 0"
    blocks = tag("link", *(_shape(kind, block.name, block, more) for pair, block in exported.blocks() for kind, more in
                           (("visual", _colour("block")), ("collision", _surface(pair, exported)))),
                 name="blocks")  # fmt: skip
    ramp = tag("model", tag("static", "true"), tag("pose", tilted), blocks, name="ramp")
    model = tag("model", tag("pose", tilted), name="twin")
    for link in exported.links:
        for joint, parent, child in exported.chain(link, "world"):
            if child != link.name:  # SDFormat wants a mass, one that moves nothing
                none = tag("inertia", *(tag(name, "0") for name in tensor(np.zeros((3, 3)))))
                model.append(tag("link", tag("inertial", tag("mass", "0"), none), name=child))
            model.append(_joint(joint, parent, child))
        model.append(_link(link, exported))
    world = tag("world", tag("gravity", (0.0, 0.0, -exported.slope.gravity)), ramp, model, name="slope")
    return document(tag("sdf", world, version="1.9"),
                    "The twin of bipedstudy. SDFormat has no start and no contact law of the study's kind: "
                    "docs/exports.md.")  # fmt: skip


def _joint(joint: Joint, parent: str, child: str) -> Element:
    moving = tag("dynamics", tag("damping", joint.damping), tag("friction", joint.friction),
                 tag("spring_reference", joint.rest), tag("spring_stiffness", joint.stiffness))  # fmt: skip
    return tag("joint", tag("parent", parent), tag("child", child), tag("axis", tag("xyz", joint.axis), moving),
               name=joint.name, type="revolute" if joint.turns else "prismatic")  # fmt: skip


def _link(link: Link, exported: Exported) -> Element:
    body = link.body
    own = tag("inertial", _pose(body.centre), tag("mass", body.mass),
              tag("inertia", *(tag(name, value) for name, value in tensor(body.inertia).items())))  # fmt: skip
    seen = [_shape("visual", shape.name, shape, _colour(shape.colour)) for shape in link.shapes()]
    touching = [_shape("collision", f"{LEGS[leg]} foot", exported.foot(leg), _surface(leg // 2, exported))
                for leg in link.feet]  # fmt: skip
    sensors = [tag("sensor", _pose(place), name=name, type="imu") for name, place in link.sites]
    return tag("link", own, *seen, *touching, *sensors, name=link.name)


def _pose(place: tuple[float, ...] | np.ndarray, turn: str = "") -> Element:
    return tag("pose", f"{text(place)} {turn or '0.0 0.0 0.0'}")


def _shape(kind: str, name: str, shape: Shape, more: Element) -> Element:
    sizes = [tag(what, value) for what, value in shape.sizes.items()]
    return tag(kind, _pose(shape.place, shape.turn), tag("geometry", tag(shape.kind, *sizes)), more, name=name)


def _colour(name: str) -> Element:
    return tag("material", tag("diffuse", COLOURS[name]))


def _surface(pair: int, exported: Exported) -> Element:
    """What feet and blocks are made of: friction, and the secant of the law of a foot that carries half the machine."""
    law, load = exported.contact, exported.machine.mass * exported.slope.gravity
    damping = law.numbers.normal.damping_under(load)
    soft = tag("ode", tag("kp", 0.5 * load / static_penetration(law, load)), tag("kd", 0.5 * damping))
    held = law.coefficients.static_friction
    sliding = tag("ode", tag("mu", held), tag("mu2", held))
    return tag("surface", tag("contact", tag("collide_bitmask", str(1 << pair)), soft), tag("friction", sliding))
