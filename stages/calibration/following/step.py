"""One step of a robot that is followed: its samples one after another, and all of them again.

The readings are linear in the unknowns about those that the step was walked with. One after another they are a Kalman
filter; all again, about better unknowns, Gauss and Newton's method with what was known before.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from stages.analytic.model.walker import Vector
from stages.calibration.estimation.run_fit import Model
from stages.calibration.following.present import Instant, Present
from stages.calibration.observation.measured_run import SIDES, Sampling
from stages.calibration.observation.prediction import Shown, Walked
from stages.calibration.observation.readings import take_readings


@dataclass(frozen=True)
class Belief:
    """What is known of the unknowns (n,) of `Model.names` at a step's mid-stance: `mean` (n,) and `covariance` (n, n)
    in SI units, and the leg that stands."""

    mean: Vector
    covariance: np.ndarray
    leg: int


@dataclass(frozen=True)
class Sample:
    """A sample at `time` [s] on the clock of its `side`: readings (3,), and which of them count."""

    time: float
    side: str
    reading: Vector
    used: np.ndarray


@dataclass
class Taken:
    """Times [s], readings (3,) and their variances (3,), infinite for what is not used, of one side's samples."""

    times: list[float] = field(default_factory=list)
    readings: list[Vector] = field(default_factory=list)
    variances: list[Vector] = field(default_factory=list)


class Step:
    """A step from a mid-stance on, `walked` with the unknowns `at` (n,) to a tolerance.

    The times of samples that will come (m,) [s] are known of a recording, and all that should be read is computed at
    once.
    """

    def __init__(
        self, model: Model, sampling: Sampling, belief: Belief, at: Vector, walked: Walked, tolerance: float,
        coming: Mapping[str, Vector],
    ) -> None:  # fmt: skip
        self._model, self._sampling, self._belief, self._at = model, sampling, belief, at
        self._present, self.leg = Present(walked, tolerance), belief.leg
        self._shown = {side: Shown(walked, sampling, side) for side in SIDES}
        self._taken = {side: Taken() for side in SIDES}
        self._moved, self.covariance = belief.mean - at, belief.covariance.copy()
        self._surprise, self._count = 0.0, 0
        self._expected = {side: dict(zip(map(float, times), self._shown[side].read(times), strict=True))
                          for side, times in coming.items()}  # fmt: skip

    @property
    def ends(self) -> float:
        """Up to when it is walked [s]."""
        return self._present.ends

    @property
    def mean(self) -> Vector:
        """The unknowns (n,) by all samples so far."""
        return np.asarray(self._at + self._moved)

    def take(self, sample: Sample, kept: bool = True) -> None:
        """Take a sample that is not earlier than its side's last one; one that is not `kept` is not taken again."""
        taken, side = self._taken[sample.side], sample.side
        variances = np.where(sample.used, np.square(self._model.noise), np.inf)
        if sample.used.any():
            expected = self._expected.get(side, {}).get(sample.time)
            if expected is None:
                expected = self._shown[side].read(np.array([sample.time]))[0]
            self._surprise += take_readings(self._moved, self.covariance, sample.reading - expected[:, 0],
                                            expected[:, 1:], variances, self._model.robust)  # fmt: skip
            self._count += int(sample.used.sum())
        if kept:
            taken.times.append(sample.time)
            taken.readings.append(sample.reading)
            taken.variances.append(variances)

    def is_near_a_strike(self, time: float, before: float, after: float) -> bool:
        """Whether a time is from `before` to `after` a heel strike [s], or may be."""
        return self._present.is_near_a_strike(time, self._moved, self.covariance, before, after)

    def instant(self, time: float) -> Instant:
        """What is known at a time not before the last sample's [s]."""
        surprise = self._surprise / self._count if self._count else np.nan
        self._surprise, self._count = 0.0, 0
        return self._present.at(time, self._moved, self.covariance, surprise)

    def again(self, at: Vector, walked: Walked) -> Belief:
        """What is known before the step from all that it took, with the unknowns `at` (n,), which have `walked` so."""
        prior, n = self._belief, len(at)
        matrix, right = np.zeros((n, n)), np.zeros(n)
        for side, taken in self._taken.items():
            if taken.times:
                expected = Shown(walked, self._sampling, side).read(np.array(taken.times))
                rows = expected[:, :, 1:].reshape(-1, n)
                weighed = rows.T / np.ravel(taken.variances)
                left = (np.array(taken.readings) - expected[:, :, 0]).ravel()
                matrix += weighed @ rows
                right += weighed @ (left - rows @ (prior.mean - at))
        unit = np.sqrt(np.diag(prior.covariance))
        unit[unit == 0.0] = 1.0
        scaled = prior.covariance / unit / unit[:, None]
        known = np.linalg.solve(np.eye(n) + scaled @ (matrix * unit * unit[:, None]), scaled) * unit * unit[:, None]
        known = 0.5 * (known + known.T)
        return Belief(prior.mean + known @ right, known, prior.leg)

