"""The twin seen from the side: the planar machine that its bill of parts makes.

Each pair of legs is two bodies: the frame above the springs and the two feet below them, which move as one. What lies
along the hip axis drops out: a plane sees masses, mass centres and moments about z. The hip itself has no mass left; it
belongs to the frames and swings with the legs.
"""

from __future__ import annotations

from dataclasses import dataclass

from stages.twin.machine.bill import Body, join
from stages.twin.machine.machine import FRAME_BODY, Machine


@dataclass(frozen=True)
class PlanarBody:
    """Mass [kg], mass centre from the hip on the leg's axes, forward and up the leg [m], moment of inertia [kg m^2].

    The moment is about the mass centre. A foot's place is that on an unloaded leg.
    """

    mass: float
    forward: float
    upward: float
    inertia: float

    def inertia_about_hip(self) -> float:
        """Moment of inertia about the hip axis [kg m^2]."""
        return self.inertia + self.mass * (self.forward**2 + self.upward**2)


@dataclass(frozen=True)
class PlanarPair:
    """One pair of legs as a leg: bodies above and below its spring.

    `length` hip to foot bottom, unloaded, and `radius` of the foot [m]; `stiffness` [N/m] and `damping` [N s/m] of both
    legs together.
    """

    frame: PlanarBody
    foot: PlanarBody
    length: float
    radius: float
    stiffness: float
    damping: float


@dataclass(frozen=True)
class PlanarMachine:
    """The inner and the outer pair, joined at the hip; `hip_damping` [N m s]: viscous friction of its bearings."""

    inner: PlanarPair
    outer: PlanarPair
    hip_damping: float
    rigid: bool

    @property
    def mass(self) -> float:
        """Mass of the whole machine [kg]."""
        return sum(pair.frame.mass + pair.foot.mass for pair in (self.inner, self.outer))


def project(machine: Machine) -> PlanarMachine:
    """The planar machine that moves as `machine` does while it neither rolls nor yaws.

    Exact where the left and the right leg of each pair are alike; else the pair is what it is on average: sums of mass,
    stiffness and damping, means of lengths and radii.
    """
    inner, outer = (_pair(machine, pair) for pair in (0, 1))
    return PlanarMachine(inner, outer, machine.bearing_friction, machine.rigid)


def _pair(machine: Machine, pair: int) -> PlanarPair:
    legs = slice(2 * pair, 2 * pair + 2)
    frame = FRAME_BODY[pair]
    return PlanarPair(
        frame=_from_the_side(machine.bodies[frame]),
        foot=_from_the_side(join(machine.bodies[frame + 1 : frame + 3])),
        length=float(machine.length[legs].mean()),
        radius=float(machine.radius[legs].mean()),
        stiffness=float(machine.stiffness[legs].sum()),
        damping=float(machine.damping[legs].sum()),
    )


def _from_the_side(body: Body) -> PlanarBody:
    return PlanarBody(body.mass, float(body.centre[0]), float(body.centre[1]), float(body.inertia[2, 2]))
