"""Whether what a fit leaves is the sensors' noise: its size, its whiteness, and where in the step it is not zero.

Noise leaves residuals of one sigma whose mean at every phase of the step is zero, and of which none tells the next.
What the model lacks comes back at the same phase of every step.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import chdtrc

from stages.analytic.model.walker import Vector
from stages.calibration.angles.prediction import correlation_length
from stages.calibration.estimation.equations import Equations
from stages.calibration.observation.measured_run import MeasuredRun
from stages.calibration.observation.prediction import AXES
from stages.calibration.observation.unknowns import SIDES

#: Parts of a step, from strike to strike, and lags of the test of Ljung and Box.
PARTS, LAGS = 6, 10
#: A trace is said not to be noise where noise would look like it in so few cases.
RARE = 1e-3


@dataclass(frozen=True)
class Structure:
    """Residuals of one signal of one sensor, in sigmas: root mean square, mean in each part of the step (p,), the
    probabilities that white noise has means so far from zero and neighbours so alike."""

    side: str
    axis: str
    rms: float
    means: Vector
    by_phase: float
    white: float

    @property
    def is_noise(self) -> bool:
        """Whether both tests let it pass."""
        return min(self.by_phase, self.white) >= RARE


def structure(run: MeasuredRun, equations: Equations) -> tuple[Structure, ...]:
    """That of every signal with residuals."""
    return tuple(_structures(run, equations))


def _structures(run: MeasuredRun, equations: Equations) -> Iterator[Structure]:
    for side in SIDES:
        part = step_parts(getattr(run.sampling, side), run.strikes)
        for column, axis in enumerate(AXES):
            left = equations.pulls(side)[:, column]
            seen = np.isfinite(left) & (part >= 0)
            if seen.sum() <= 2 * max(PARTS, LAGS):
                continue
            groups = [left[seen & (part == each)] for each in range(PARTS)]
            means = np.array([one.mean() if one.size else 0.0 for one in groups])
            off = sum(one.size * one.mean() ** 2 for one in groups if one.size)
            filled = sum(bool(one.size) for one in groups)
            yield Structure(side, axis, float(np.sqrt((left[seen] ** 2).mean())), means,
                            float(chdtrc(filled, off)), whiteness(np.where(seen, left, np.nan)))


def told_structure(runs: Sequence[MeasuredRun], fits: Sequence[Equations]) -> list[str]:
    """A sentence for each signal that is not noise in most runs: how large, and where in the step it is off most."""
    found: dict[tuple[str, str], list[Structure]] = {}
    for run, equations in zip(runs, fits, strict=True):
        for one in structure(run, equations):
            found.setdefault((one.side, one.axis), []).append(one)
    lines = []
    for (side, axis), every in found.items():
        if 2 * sum(one.is_noise for one in every) >= len(every):
            continue
        means = np.mean([one.means for one in every], axis=0)
        part = int(np.abs(means).argmax())
        rms = float(np.sqrt(np.mean([one.rms**2 for one in every])))
        lines.append(f"residuals of {side} {axis} are not noise: {rms:.2f} sigma, and off by {means[part]:+.2f} on "
                     f"average in the step's part {part + 1} of {PARTS} after a heel strike")
    return lines


def step_parts(times: Vector, strikes: Vector) -> np.ndarray:
    """Which of the `PARTS` of its step each of the times (m,) [s] lies in; -1 before the first and after the last."""
    number = np.searchsorted(strikes, times, side="right") - 1
    inside = (number >= 0) & (number < len(strikes) - 1)
    at = np.where(inside, number, 0)
    share = (times - strikes[at]) / np.diff(strikes)[at]
    return np.where(inside, np.clip((PARTS * share).astype(int), 0, PARTS - 1), -1)


def whiteness(left: Vector) -> float:
    """Probability that white noise has neighbours as alike as those of `left` (m,), NaN where a sample is missing."""
    known = np.isfinite(left)
    values = np.where(known, left - left[known].mean(), 0.0)
    count, power, statistic = int(known.sum()), float((values**2).sum()), 0.0
    for lag in range(1, LAGS + 1):
        pairs = int((known[lag:] & known[:-lag]).sum())
        if pairs:
            rho = float((values[lag:] * values[:-lag]).sum()) / power * count / pairs
            statistic += pairs * rho**2
    return float(chdtrc(LAGS, statistic))


#: A share of readings that no fit is below which is worth anything.
LEAST = 0.1
#: Traces with fewer samples tell nothing of how neighbours hang together.
FEWEST = 10


def widening(fits: Sequence[Equations]) -> tuple[float, float]:
    """Root mean square residual of runs in sigmas, and the factor on intervals for it and for neighbours that hang
    together.

    Of a fit in which spikes pull no more than at `robust` sigmas, the variance is E psi^2 / (E psi')^2 over that of
    unit noise (P. J. Huber, Ann. Math. Stat. 35, 1964, 73), and the matrix of the fit has E psi / r of it already.
    """
    size = sum(one.chi2 for one in fits) / sum(one.count for one in fits)
    every = np.abs(np.concatenate([one.residuals[side].ravel() / one.robust for one in fits for side in SIDES]))
    beyond = np.fmax(every[np.isfinite(every)], 1.0)  # of those that pull as they are, one
    variance = size * float((1.0 / beyond).mean()) / max(float((beyond == 1.0).mean()), LEAST) ** 2
    traces = [one.pulls(side)[:, [column]] for one in fits for side in SIDES for column in range(3)]
    seen = [one[np.isfinite(one[:, 0])] for one in traces]
    length = correlation_length(dict(enumerate(one for one in seen if len(one) > FEWEST)))
    return math.sqrt(size), max(1.0, math.sqrt(variance * max(1.0, length)))
