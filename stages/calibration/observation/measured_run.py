"""One run as the calibration takes it: its samples, when they were taken, and what is not known of it and its sensors.

Samples are on body axes. What is not known has a prior: a Gaussian about the gait's mid-stance and sensors without
errors.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from stages.analytic.model.walker import Vector, Walker
from stages.analytic.phases.section import section_state
from stages.analytic.walk.recording import record, up_to_mid_stance

SIDES = ("hip", "foot")
#: The state at mid-stance without theta; rigid legs have no stretches. Of a leg's length it has what it is longer than
#: its natural one: that is what the prior is of, however long the robot's legs turn out to be.
START = ("start_stretch_1", "start_psi", "start_stretch_2", "start_theta_rate", "start_stretch_1_rate",
         "start_psi_rate", "start_stretch_2_rate")  # fmt: skip
STRETCHES = ("start_stretch_1", "start_stretch_2")
#: Of a run, then of each sensor: by name, a change that is neither large nor small [SI].
OF_RUN = {"mid_stance": 1e-3, "foot_lag": 1e-3, "foot_place": 1e-3, "bandwidth": 0.03}
ERRORS = {"clock": 1e-3, "tilt": 0.01, "forward_gain": 0.01, "up_gain": 0.01, "rate_gain": 0.01, "forward_bias": 0.05,
          "up_bias": 0.05, "rate_bias": 0.01}  # fmt: skip


@dataclass(frozen=True)
class Sampling:
    """When and how a run was sampled: of each side the times (m,) [s] since its first heel strike, as its clock has it.

    Of each side, `late` [s] is what the samples were really taken after these times (the delay of the low pass that the
    ingest took out; 0 where its bandwidth is not declared, and then a usual one), and `bandwidth_hz` cuts the low pass
    off. Leg `first_leg` (0 carries the sensors) lands at the first heel strike, and no sample is earlier than the
    mid-stance after it. The foot sensor sits `below_hip` [m] on unloaded springs; where that is not known, `place` [m]
    above the foot's mass. Clocks are right `since` a time [s], which is on the hip's, and run apart from there, at
    rates whose relative standard errors are `rate_sd` where they are not as the settings have it.
    """

    hip: Vector
    foot: Vector
    late: Mapping[str, float]
    bandwidth_hz: Mapping[str, float]
    first_leg: int
    place: float = 0.0
    below_hip: float | None = None
    since: float = 0.0
    rate_sd: Mapping[str, float] = field(default_factory=dict)

    def of(self, side: str) -> Vector:
        """The times of one side."""
        return self.hip if side == "hip" else self.foot

    @property
    def declared(self) -> bool:
        """Whether both sensors say where their low pass cuts off."""
        return all(self.late[side] > 0 for side in SIDES)


@dataclass(frozen=True)
class MeasuredRun:
    """Samples of each side, (m, 3): forward and up [m/s^2], lateral rate [rad/s]; NaN where one is missing.

    `used` (m, 3) marks those that count. `strikes` (s,) [s] are the heel strikes that were measured, the first at 0.
    `own` are measurements of the run's own parameters of the design: name to (value, standard deviation).
    """

    name: str
    sampling: Sampling
    samples: Mapping[str, np.ndarray]
    used: Mapping[str, np.ndarray]
    strikes: Vector
    own: Mapping[str, tuple[float, float]]

    def upto(self, horizon: float) -> MeasuredRun:
        """The run without samples later than `horizon` [s]."""
        kept = {side: self.sampling.of(side) <= horizon for side in SIDES}
        return replace(
            self,
            sampling=replace(self.sampling, hip=self.sampling.hip[kept["hip"]],
                                         foot=self.sampling.foot[kept["foot"]]),
            samples={side: self.samples[side][kept[side]] for side in SIDES},
            used={side: self.used[side][kept[side]] for side in SIDES},
        )

    @property
    def duration(self) -> float:
        """Time of the last sample [s]."""
        return max(float(times[-1]) for times in (self.sampling.hip, self.sampling.foot) if times.size)


def usable(times: Vector, strikes: Vector, first: float, before: float, after: float) -> np.ndarray:
    """Mask (m, 3), alike for all channels, of times from `first` on and not from `before` to `after` around a strike
    [s]."""
    mask = np.asarray(times >= first)
    for strike in strikes:
        mask &= (times < strike - before) | (times > strike + after)
    return np.repeat(mask[:, None], 3, axis=1)


def mid_stance(walker: Walker, z: Vector, tolerance: float) -> tuple[Vector, float]:
    """Where a walk's samples begin, in the step from section coordinates `z`, dimensionless: the state without theta
    (size - 1,), and the time since the heel strike before it. Raises StepFailed if the walker does not vault over its
    leg."""
    single = record(walker, section_state(np.asarray(z, dtype=float), walker.p), 1, tolerance)[-1]
    upright = up_to_mid_stance(walker, single)
    return upright.end[1:], single.start + upright.duration


@dataclass(frozen=True)
class Layout:
    """Names of a run's unknowns, in order, and their priors: standard deviations `prior` about `middle`, (k,) each.

    `sizes` (k,): changes that are neither large nor small, for numerics. The first `free` are the start's. `strike`:
    section coordinates after the heel strike before, in the gait.
    """

    names: tuple[str, ...]
    middle: Vector
    prior: Vector
    sizes: Vector
    free: int
    strike: Vector

    def prior_at(self, sampling: Sampling) -> Vector:
        """The priors' standard deviations (k,) of a run whose clocks are known as its sampling says."""
        prior = self.prior.copy()
        for side, sd in sampling.rate_sd.items():
            prior[self.place(f"{side}_clock")] = sd
        return prior

    def place(self, name: str) -> int:
        """Where an unknown stands. Raises ValueError."""
        return self.names.index(name)

    def pull(self, unknowns: Vector) -> float:
        """By how much a fit moved the sensors' clocks from what the ingest knows them to be, relative, mean of both."""
        return float(np.mean([unknowns[self.place(f"{side}_clock")] for side in SIDES]))


def layout_of(walker: Walker, z: Vector, tolerance: float, priors: Mapping[str, float]) -> Layout:
    """The unknowns of a run about mid-stance of the step from section coordinates `z`; `priors` as `Parameters.priors`.

    Raises StepFailed like `mid_stance`.
    """
    begin, since = mid_stance(walker, z, tolerance)
    scales, free = walker.scales()[1:], walker.size - 1
    start = [name for name in START if free == len(START) or "stretch" not in name]
    of_legs = ["stretch_rate" if name.endswith("rate") else "stretch" for name in start]
    rows = [(name, priors[of_leg] if "stretch" in name else np.inf, 0.01 * scale)
            for name, of_leg, scale in zip(start, of_legs, scales, strict=True)]
    rows += [(name, priors[name], size) for name, size in OF_RUN.items()]
    rows += [(f"{side}_{error}", priors[error], size) for side in SIDES for error, size in ERRORS.items()]
    names, prior, sizes = zip(*rows, strict=True)
    middle = np.zeros(len(names))
    middle[:free] = begin * scales
    for name in set(names) & set(STRETCHES):
        middle[names.index(name)] -= walker.length * walker.p.L_nat
    middle[free] = since * walker.time
    return Layout(names, middle, np.array(prior), np.array(sizes), free, np.asarray(z, dtype=float))
