"""One step of a robot that is followed: its samples one after another, and all of them again.

The readings are linear in the unknowns about those that the step was walked with. One after another they are a Kalman
filter; all again, about better unknowns, Gauss and Newton's method with what was known before.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from stages.analytic.model.walker import Vector
from stages.calibration.compiled import compiled
from stages.calibration.estimation.run_fit import Model
from stages.calibration.following.present import Instant, Present, falls
from stages.calibration.observation.measured_run import SIDES, Sampling
from stages.calibration.observation.prediction import Shown, Walked


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
    """Times [s], readings (3,) and which of them are used (3,), of one side's samples."""

    times: list[float] = field(default_factory=list)
    readings: list[Vector] = field(default_factory=list)
    used: list[np.ndarray] = field(default_factory=list)


class Step:
    """A step from a mid-stance on, `walked` with the unknowns `at` (n,); its states are `wrong` by so much,
    dimensionless.

    The times of samples that will come (m,) [s] are known of a recording, and all that should be read is computed at
    once.
    """

    def __init__(
        self, model: Model, sampling: Sampling, belief: Belief, at: Vector, walked: Walked, wrong: float,
        coming: Mapping[str, Vector],
    ) -> None:  # fmt: skip
        self._model, self._sampling, self._at, self._walked = model, sampling, at, walked
        self.belief, self._wrong, self._coming = belief, wrong, coming
        self._present, self.leg = Present(walked, wrong), belief.leg
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

    def take(self, sample: Sample, kept: bool = True) -> float:
        """Take a sample that is not earlier than its side's last one; one that is not `kept` is not taken again.

        Returns the mean square of its innovations, in their standard deviations; NaN where nothing is used.
        """
        taken, side, surprise = self._taken[sample.side], sample.side, math.nan
        variances = np.where(sample.used, np.square(self._model.noise), np.inf)
        if sample.used.any():
            expected = self._expected.get(side, {}).get(sample.time)
            if expected is None:
                expected = self._shown[side].read(np.array([sample.time]))[0]
            square = take_readings(self._moved, self.covariance, sample.reading - expected[:, 0], expected[:, 1:],
                                   variances, self._model.robust)  # fmt: skip
            count = int(sample.used.sum())
            self._surprise, self._count, surprise = self._surprise + square, self._count + count, square / count
        if kept:
            taken.times.append(sample.time)
            taken.readings.append(sample.reading)
            taken.used.append(sample.used)
        return surprise

    def has_landed(self, time: float) -> bool:
        """Whether the step's heel strike is over at a time [s]."""
        return time > self._present.strike(-math.inf, self._moved, self.covariance)[0]

    def forget(self, since: float) -> None:
        """Take no sample again that is not before a time [s]."""
        for side, taken in self._taken.items():
            count = sum(time < since for time in taken.times)
            self._taken[side] = Taken(taken.times[:count], taken.readings[:count], taken.used[:count])

    def is_near_a_strike(self, time: float, before: float, after: float) -> bool:
        """Whether a time is from `before` to `after` a heel strike [s], or may be."""
        return self._present.is_near_a_strike(time, self._moved, self.covariance, before, after)

    def instant(self, time: float) -> Instant:
        """What is known at a time not before the last sample's [s]."""
        surprise = self._surprise / self._count if self._count else np.nan
        self._surprise, self._count = 0.0, 0
        return self._present.at(time, self._moved, self.covariance, surprise)

    def anew(self, belief: Belief, at: Vector, walked: Walked, known: Step | None = None) -> Step:
        """The step with the unknowns `at` (n,), and without its samples; or as it is `known` by these, with them."""
        prior = known.belief if known else belief
        step = Step(self._model, self._sampling, prior, at, walked, self._wrong, self._coming)
        if known:
            step._taken, step._moved, step.covariance = self._taken, belief.mean - at, belief.covariance.copy()
        return step

    def falls(self) -> Vector:
        """Probabilities to fall within so many steps after the next heel strike, by what is known now."""
        return falls(self._walked, self._moved, self.covariance)

    def again(self, at: Vector, walked: Walked) -> tuple[Belief, float]:
        """What is known before the step from all that it took, with the unknowns `at` (n,), which have `walked` so.

        Beside it the sum of squares of what is left of the samples there, in noises, as Huber's estimate has it.
        """
        prior, n = self.belief, len(at)
        matrix, right, misfit = np.zeros((n, n)), np.zeros(n), 0.0
        for side, taken in self._taken.items():
            if taken.times:
                expected = Shown(walked, self._sampling, side).read(np.array(taken.times))
                rows = expected[:, :, 1:].reshape(-1, n)
                left, noise = np.array(taken.readings) - expected[:, :, 0], np.asarray(self._model.noise)
                pull = np.maximum(np.abs(left) / noise / self._model.robust, 1.0)  # Huber's
                misfit += float((np.square(left / noise) / pull)[np.array(taken.used)].sum())
                left, weighed = left.ravel(), rows.T * np.ravel(np.array(taken.used) / (pull * noise**2))
                matrix += weighed @ rows
                right += weighed @ (left - rows @ (prior.mean - at))
        unit = np.sqrt(np.diag(prior.covariance))
        unit[unit == 0.0] = 1.0
        scaled = prior.covariance / unit / unit[:, None]
        known = np.linalg.solve(np.eye(n) + scaled @ (matrix * unit * unit[:, None]), scaled) * unit * unit[:, None]
        known = 0.5 * (known + known.T)
        return Belief(prior.mean + known @ right, known, prior.leg), misfit


@compiled
def take_readings(
    mean: Vector, covariance: np.ndarray, left: Vector, rows: np.ndarray, variances: Vector, robust: float
) -> float:
    """Take readings (r,) less what they should have been for a mean of zero, in place; those of no finite variance not.

    `rows` (r, n) are their derivatives by the unknowns; `mean` (n,), `covariance` (n, n) what is known of these. What
    is more than `robust` standard deviations off pulls less: `variances` (r,) grow as Huber's estimate has it. Returns
    the sum of squares of the innovations in their standard deviations.
    """
    n, total = mean.size, 0.0
    across = np.empty(n)
    for r in range(left.size):
        if variances[r] == np.inf:
            continue
        innovation, expected = left[r], variances[r]
        for i in range(n):
            value = 0.0
            for j in range(n):
                value += covariance[i, j] * rows[r, j]
            across[i] = value
            innovation -= rows[r, i] * mean[i]
            expected += rows[r, i] * value
        size = abs(innovation) / math.sqrt(expected)
        total += size * size
        more = variances[r] * max(size / robust - 1.0, 0.0)
        variances[r] += more
        for i in range(n):
            gain = across[i] / (expected + more)
            mean[i] += gain * innovation
            for j in range(n):
                covariance[i, j] -= gain * across[j]
    return total
