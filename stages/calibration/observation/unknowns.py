"""What is not known of a run and of its sensors beside the design, with what is believed before a fit."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stages.analytic.model.walker import Vector, Walker
from stages.analytic.phases.section import section_state
from stages.analytic.walk.recording import record, up_to_mid_stance
from stages.calibration.observation.beliefs import Beliefs

#: The state at mid-stance without theta, by names, for rigid legs and compliant ones. Of a leg's length it has what it
#: is longer than its natural one: that is what is believed of it, however long the robot's legs turn out to be.
START = {3: ("start_psi", "start_theta_rate", "start_psi_rate"),
         7: ("start_stretch_1", "start_psi", "start_stretch_2", "start_theta_rate", "start_stretch_1_rate",
             "start_psi_rate", "start_stretch_2_rate")}
STRETCHES = ("start_stretch_1", "start_stretch_2")
SIDES = ("hip", "foot")
#: Of each sensor, in this order.
ERRORS = ("clock", "tilt", "forward_gain", "up_gain", "rate_gain", "forward_bias", "up_bias", "rate_bias")
UNITS = {"clock": "1", "tilt": "rad", "forward_gain": "1", "up_gain": "1", "rate_gain": "1", "forward_bias": "m/s^2",
         "up_bias": "m/s^2", "rate_bias": "rad/s"}


@dataclass(frozen=True)
class MidStance:
    """Where a walk's samples begin, dimensionless: the state without theta (size - 1,), the time since the heel strike
    before it, and the section coordinates after that."""

    state: Vector
    time: float
    strike: Vector


def mid_stance(walker: Walker, z: Vector, tolerance: float) -> MidStance:
    """That of the step from section coordinates `z`. Raises StepFailed if the walker does not vault over its leg."""
    single = record(walker, section_state(np.asarray(z, dtype=float), walker.p), 1, tolerance)[-1]
    upright = up_to_mid_stance(walker, single)
    return MidStance(upright.end[1:], single.start + upright.duration, np.asarray(z, dtype=float))


@dataclass(frozen=True)
class Layout:
    """Names, units and beliefs (standard deviations about `middle`) of a run's unknowns, in order, shape (k,) each.

    `sizes` (k,): changes that are neither large nor small, for numerics. The first `free` are the start's. `strike`:
    section coordinates after the heel strike before, in the gait.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    middle: Vector
    believed: Vector
    sizes: Vector
    free: int
    strike: Vector

    def place(self, name: str) -> int:
        """Where an unknown stands. Raises ValueError."""
        return self.names.index(name)

    def pull(self, unknowns: Vector) -> float:
        """By how much a fit moved the sensors' clocks from what the ingest knows them to be, relative, mean of both."""
        return float(np.mean([unknowns[self.place(f"{side}_clock")] for side in SIDES]))


def layout_of(walker: Walker, begin: MidStance, beliefs: Beliefs) -> Layout:
    """The unknowns of a run of a walker whose gait has the mid-stance `begin`."""
    scales, free = start_scales(walker), walker.size - 1
    names, units, believed, sizes = [], [], [], []
    for name, scale in zip(START[free], scales, strict=True):
        names.append(name)
        units.append(_unit(name))
        of_leg = beliefs.length_rate if name.endswith("rate") else beliefs.length
        believed.append(of_leg if "stretch" in name else np.inf)
        sizes.append(0.01 * scale)
    for name, sd in (("mid_stance", beliefs.mid_stance), ("foot_lag", beliefs.foot_lag)):
        names.append(name)
        units.append("s")
        believed.append(sd)
        sizes.append(1e-3)
    usual = {"clock": 1e-3, "tilt": 0.01, "forward_bias": 0.05, "up_bias": 0.05, "rate_bias": 0.01}
    for name, unit, sd, size in (("foot_place", "m", beliefs.place, 1e-3), ("bandwidth", "1", beliefs.bandwidth, 0.03)):
        names.append(name)
        units.append(unit)
        believed.append(sd)
        sizes.append(size)
    for side in SIDES:
        for error in ERRORS:
            names.append(f"{side}_{error}")
            units.append(UNITS[error])
            believed.append(beliefs.of(error))
            sizes.append(usual.get(error, 0.01))
    middle = np.zeros(len(names))
    middle[:free] = begin.state * scales
    for name in set(names) & set(STRETCHES):
        middle[names.index(name)] -= walker.length * walker.p.L_nat
    middle[free] = begin.time * walker.time
    return Layout(tuple(names), tuple(units), middle, np.array(believed), np.array(sizes), free,
                  begin.strike)


def start_scales(walker: Walker) -> Vector:
    """SI value of one dimensionless unit of each entry of the state at mid-stance but theta, (size - 1,)."""
    return walker.scales()[1:]


def _unit(name: str) -> str:
    if "theta" in name or "psi" in name:
        return "rad/s" if name.endswith("rate") else "rad"
    return "m/s" if name.endswith("rate") else "m"
