"""One step of a robot that is followed: its samples one after another, and all of them again.

The readings are linear in the unknowns about those that the step was walked with. One after another they are a Kalman
filter; all again, about better unknowns, Gauss and Newton's method with what was known before.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from stages.analytic.model.walker import Vector
from stages.calibration.compiled import compiled
from stages.calibration.estimation.run_fit import Model
from stages.calibration.following.present import Instant, Present, falls
from stages.calibration.observation.measured_run import SIDES, Sampling
from stages.calibration.observation.prediction import Shown, Walked

#: What is known for certain is as good as known to a millionth of a standard deviation of anything else.
CERTAIN = 1e-12


@dataclass(frozen=True)
class Estimate:
    """What is known of the unknowns (n,) of `Model.names` at a step's mid-stance: `mean` (n,) and `covariance` (n, n)
    in SI units; the leg that stands, and since when clocks run apart, are those of its `sampling`."""

    mean: Vector
    covariance: np.ndarray
    sampling: Sampling


@dataclass(frozen=True)
class Sample:
    """A sample at `time` [s] on the clock of its `side`: readings (r,), and which of them count."""

    time: float
    side: str
    reading: Vector
    used: np.ndarray


class Step:
    """A step from a mid-stance on, `walked` with the unknowns `at` (n,), of which an estimate from `before` it and the
    samples that it has `taken` show. Its states are `wrong` by so much, dimensionless."""

    def __init__(
        self, model: Model, wrong: float, before: Estimate, at: Vector, walked: Walked, taken: Sequence[Sample] = ()
    ) -> None:
        self._model, self._wrong, self.sampling = model, wrong, before.sampling
        self._noise = {side: model.noise_at(before.sampling, side) for side in SIDES}
        self._before, self.at, self.walked, self._taken = before, at, walked, list(taken)
        self._innovations, self._count, self._loss = 0.0, 0, 0.0

    @cached_property
    def _shown(self) -> dict[str, Shown]:
        return {side: Shown(self.walked, self.sampling, side) for side in SIDES}

    @cached_property
    def _present(self) -> Present:
        place = self._model.names.index(f"{SIDES[0]}_clock")
        return Present(self.walked, self._wrong, (place, float(self.at[place]), self.sampling.since))

    @property
    def ends(self) -> float:
        """Up to when it is walked [s]."""
        return self._present.ends

    @property
    def known(self) -> Estimate:
        """What all samples so far show of the unknowns."""
        moved, covariance = self._solved
        return Estimate(np.asarray(self.at + moved), covariance, self.sampling)

    def take(self, sample: Sample, kept: bool = True) -> float:
        """Take a sample that is not earlier than its side's last one; one that is not `kept` is not taken again.

        Returns the mean square of its innovations, in their standard deviations; NaN where nothing is used.
        """
        innovation = math.nan
        if sample.used.any():
            moved, covariance = self._solved
            expected = self._shown[sample.side].read(np.array([sample.time]))[0]
            left, variances = sample.reading - expected[:, 0], np.square(self._noise[sample.side])
            self._loss += self._lost(left, sample.used, sample.side)[1] if kept else 0.0
            off = take_readings(moved, covariance, left, expected[:, 1:], np.where(sample.used, variances, np.inf),
                                self._model.robust)[sample.used]  # fmt: skip
            self._innovations, self._count = self._innovations + float(off @ off), self._count + len(off)
            innovation = float(off @ off) / len(off)
        if kept:
            self._taken.append(sample)
        return innovation

    def is_near_a_strike(self, time: float, before: float, after: float) -> bool:
        """Whether a time is from `before` to `after` a heel strike [s], or may be."""
        return self._present.is_near_a_strike(time, *self._solved, before, after)

    def instant(self, time: float) -> Instant:
        """What is known at a time not before the last sample's [s]."""
        innovation = self._innovations / self._count if self._count else np.nan
        self._innovations, self._count = 0.0, 0
        return self._present.at(time, *self._solved, innovation)

    def falls(self) -> Vector:
        """Probabilities to fall within so many steps after the next heel strike, by what is known now."""
        return falls(self.walked, *self._solved, self._wrong)

    def about(self, at: Vector, walked: Walked) -> Step:
        """The step linearised about the unknowns `at` (n,), which have `walked` so."""
        step = Step(self._model, self._wrong, self._before, at, walked, self._taken)
        step._innovations, step._count = self._innovations, self._count
        return step

    def until(self, time: float) -> Step:
        """The step without what it took from a time [s] on."""
        taken = [one for one in self._taken if one.time < time]
        return Step(self._model, self._wrong, self._before, self.at, self.walked, taken)

    @property
    def cost(self) -> float:
        """How ill the unknowns that it was walked with go with all that it took, and with what was known before."""
        (off, unit, scaled), _ = self._prior, self._solved
        return self._loss + float(off / unit @ np.linalg.solve(scaled + CERTAIN * np.eye(len(off)), off / unit))

    @cached_property
    def _prior(self) -> tuple[Vector, Vector, np.ndarray]:
        """By how much what was known before is from `at` (n,), and its covariance (n, n) in units (n,)."""
        unit = np.sqrt(np.diag(self._before.covariance))
        unit[unit == 0.0] = 1.0
        return self._before.mean - self.at, unit, self._before.covariance / unit / unit[:, None]

    @cached_property
    def _solved(self) -> tuple[Vector, np.ndarray]:
        """What all that was taken shows: by how much the mean (n,) is from `at`, and the covariance (n, n).

        Each further sample changes them in place.
        """
        off, unit, scaled = self._prior
        n = len(off)
        matrix, right = np.zeros((n, n)), np.zeros(n)
        for side in SIDES:
            taken = [one for one in self._taken if one.side == side]
            if taken:
                expected = self._shown[side].read(np.array([one.time for one in taken]))
                rows = expected[:, :, 1:].reshape(-1, n)
                used, noise = np.array([one.used for one in taken]), self._noise[side]
                left = np.array([one.reading for one in taken]) - expected[:, :, 0]
                pull, loss = self._lost(left, used, side)
                weighed = rows.T * np.ravel(used / (pull * noise**2))
                matrix += weighed @ rows
                right += weighed @ (left.ravel() - rows @ off)
                self._loss += loss
        known = np.linalg.solve(np.eye(n) + scaled @ (matrix * unit * unit[:, None]), scaled) * unit * unit[:, None]
        known = 0.5 * (known + known.T)
        return off + known @ right, known

    def _lost(self, left: np.ndarray, used: np.ndarray, side: str) -> tuple[np.ndarray, float]:
        """How many times less residuals (..., 3) pull by Huber's estimate, and the loss of those that are `used`."""
        sigmas = np.abs(left) / self._noise[side]
        pull = np.maximum(sigmas / self._model.robust, 1.0)
        return pull, float((used * (sigmas / pull) ** 2 * (2.0 * pull - 1.0)).sum())


@compiled
def take_readings(
    mean: Vector, covariance: np.ndarray, left: Vector, rows: np.ndarray, variances: Vector, robust: float
) -> Vector:
    """Take readings (r,) less what they should have been for a mean of zero, in place; those of no finite variance not.

    `rows` (r, n) are their derivatives by the unknowns; `mean` (n,), `covariance` (n, n) what is known of these. What
    is more than `robust` standard deviations off pulls less: `variances` (r,) grow as Huber's estimate has it. Returns
    the innovations (r,) in their standard deviations, each what those before it leave; zero of what is not taken.
    """
    n, off = mean.size, np.zeros(left.size)
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
        off[r] = innovation / math.sqrt(expected)
        more = variances[r] * max(abs(off[r]) / robust - 1.0, 0.0)
        variances[r] += more
        for i in range(n):
            gain = across[i] / (expected + more)
            mean[i] += gain * innovation
            for j in range(n):
                covariance[i, j] -= gain * across[j]
    return off
