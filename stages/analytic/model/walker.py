"""The biped as the integrator sees it: dimensionless parameters, and the scales that lead back to SI.

Mass is measured in total masses, length in leg lengths, time in sqrt(leg length / gravity). Tolerances then mean
the same for every size of biped, and similar bipeds have the same numbers.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from stages.analytic.model.kinds import (
    DetailedCompliant,
    DetailedRigid,
    Kind,
    Plain,
    PlainCompliant,
    PlainRigid,
    Rigid,
    Stiff,
    natural_lengths,
    with_legs_exchanged,
)
from stages.analytic.model.stiffness import judged
from stages.biped.accuracy.scales import scales_of
from stages.biped.design import BeyondModel, Biped, Leg
from stages.biped.walk import StanceState
from stages.ground.slope import Friction, Slope

Vector = np.ndarray


@dataclass(frozen=True)
class Walker:
    """Dimensionless parameters `p`, whose type is the kind of walker, and the scales of the design."""

    p: Kind
    mass: float
    length: float
    time: float
    #: Whether a foot is drawn in while it swings, so that it touches nothing.
    retracts: bool = False

    @property
    def timed(self) -> bool:
        """Whether its feet are put down at a given time of the step, wherever they are then."""
        return isinstance(self.p, Rigid) and math.inf > self.p.T

    @cached_property
    def exchanged(self) -> Walker:
        """The walker in its next step, in which the other leg stands."""
        if isinstance(self.p, Plain):
            return self
        return replace(self, p=with_legs_exchanged(self.p))

    def on(self, leg: int) -> Walker:
        """The walker in a step in which `leg` stands; leg 0 stands in its own."""
        return self if leg == 0 else self.exchanged

    @property
    def alternates(self) -> bool:
        """Whether its steps differ from one to the next, because its legs do."""
        return with_legs_exchanged(self.p) != self.p

    @property
    def gait_steps(self) -> int:
        """Steps after which a gait repeats at the earliest."""
        return 2 if self.alternates else 1

    @property
    def rigid(self) -> bool:
        """Whether the legs keep their length."""
        return isinstance(self.p, Rigid)

    @property
    def stiff(self) -> bool:
        """Whether its legs are stiff to an explicit integrator."""
        return isinstance(self.p, Stiff)

    @property
    def size(self) -> int:
        """Length of the state (q, qd)."""
        return 4 if self.rigid else 8

    @property
    def rolls(self) -> bool:
        """Whether a foot on the ground rolls, whatever friction that takes; else the trailing foot may slip or rise."""
        return isinstance(self.p, Rigid) or self.p.mu_s == math.inf

    @property
    def section_size(self) -> int:
        """Number of section coordinates just after heel strike."""
        if self.rigid:
            return 4 if self.timed else 3
        return 5 if self.rolls else 7

    @property
    def rate_entry(self) -> int:
        """Place of the stance leg's rate among the section coordinates."""
        if self.rigid:
            return 2 if self.timed else 1
        return 3

    @property
    def force(self) -> float:
        """Unit of force [N]."""
        return self.mass * self.length / self.time**2

    @property
    def energy(self) -> float:
        """Unit of energy [J]."""
        return self.force * self.length

    def scales(self) -> Vector:
        """SI value of one dimensionless unit of each state entry, shape (4,) or (8,)."""
        rate, speed = 1.0 / self.time, self.length / self.time
        if self.rigid:
            return np.array([1.0, 1.0, rate, rate])
        return np.array([1.0, self.length, 1.0, self.length, rate, speed, rate, speed])

    def stance_state(self, y: Vector) -> StanceState:
        """The state in SI units under its names, of a step of this walker; rigid legs have their natural lengths."""
        si = y[: self.size] * self.scales()
        if self.rigid:
            stance, swing = np.array(natural_lengths(self.p)) * self.length
            si = np.array([si[0], stance, si[1], swing, si[2], 0.0, si[3], 0.0])
        return StanceState(*si.tolist())

    def from_stance(self, state: StanceState) -> Vector:
        """The dimensionless state of a state in SI units, the inverse of `stance_state`; shape (4,) or (8,)."""
        si: Vector = np.array(list(vars(state).values()))
        return np.asarray((si[::2] if self.rigid else si) / self.scales())


def build_walker(
    biped: Biped, slope: Slope, friction: Friction | None = None, *, detailed: bool = False
) -> Walker:  # fmt: skip
    """Scale a design to its own mass, leg length and pendulum time.

    A design with details is of a detailed kind, and so is one that is built as `detailed`.

    With `friction` the trailing foot of compliant legs may slip and rise; without, it rolls until toe-off. Rigid legs
    have no double stance: their trailing foot leaves without an impulse, which no friction changes. Raises BeyondModel.
    """
    scales = scales_of(biped, slope.gravity)
    mass, length, time = scales.mass, scales.length, scales.time
    gravity, rigid = (math.sin(slope.angle), -math.cos(slope.angle)), biped.legs == "rigid"
    if biped.hip_friction > 0 and friction and not rigid:
        raise BeyondModel("the constraint model does not know Coulomb friction at the hip (hip_friction) together with "
                          "a trailing foot that may slip; it knows hip_damping; stages multibody and twin know both")
    more: dict[str, float] = {}
    if biped.hip_friction > 0:
        more["tau_h"] = biped.hip_friction * (time / length) ** 2 / mass
    if biped.strike_time is not None:
        more["T"] = biped.strike_time / time
    if friction and not rigid:
        held = friction.coefficients
        more |= {"mu_s": held.static_friction, "mu_d": held.dynamic_friction}
    p: Kind
    if detailed or biped.detailed:
        values = (*detailed_numbers(biped, mass, length, time), *gravity)
        p = DetailedRigid(*values, **more) if rigid else DetailedCompliant(*values, **more)
        return Walker(judged(p), mass, length, time, biped.feet_retract)
    geometry = (biped.hip_mass / mass, biped.foot_mass / mass, 1.0, biped.foot_radius / length, biped.foot_com / length)
    inertia = biped.leg_inertia / (mass * length**2)
    if rigid:
        p = PlainRigid(*geometry, inertia, *gravity, **more)
    else:
        springs = biped.stiffness * time**2 / mass, biped.damping * time / mass
        p = PlainCompliant(*geometry, *springs, inertia, *gravity, **more)
    return Walker(judged(p), mass, length, time)


def detailed_numbers(biped: Biped, mass: float, length: float, time: float) -> tuple[float, ...]:
    """The numbers of a detailed design by the given scales in the order of `DetailedRigid` or `DetailedCompliant`."""

    def of(leg: Leg) -> tuple[float, ...]:
        springs = (leg.stiffness * time**2 / mass, leg.damping * time / mass) if biped.legs == "compliant" else ()
        return (
            leg.foot_mass / mass, leg.leg_length / length, leg.foot_radius / length, leg.foot_com / length, *springs,
            leg.leg_inertia / (mass * length**2), leg.foot_offset / length, leg.frame_mass / mass,
            leg.frame_com / length, leg.frame_offset / length, leg.frame_inertia / (mass * length**2),
        )  # fmt: skip

    torque = mass * (length / time) ** 2
    return (
        biped.hip_mass / mass, biped.weighed_hip / mass, *of(biped.leg(0)), *of(biped.leg(1)),
        biped.hip_stiffness / torque, biped.hip_damping / (torque * time), -biped.hip_rest_angle,
    )  # fmt: skip
