"""What a model puts wrong: whether what a fit leaves is the sensors' noise, and what fits of other machines' runs miss.

Noise leaves residuals of one sigma whose mean at every phase of the step is zero, and of which none shows the next.
What the model lacks comes back at the same phase of every step.

An error that is alike in every step, like a contact that is softer than the model's, scatters nowhere: no residual of a
run shows it. Fits of other runs of the study's twin, whose truth is known, do. What they miss on average is taken off,
their scatter over builds, starts and ramps is the interval.

A fit can show itself how far its model pulled it: the ingest knows sensors' clocks to a few parts in ten thousand, and
a fit that moves them by a thousandth has misses that go along with that.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.special import chdtrc, chdtri

from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.model.walker import Vector
from stages.biped.quantity import count_of
from stages.calibration.estimation.least_squares import TOTAL_MASS, Known
from stages.calibration.estimation.run_fit import Equations
from stages.calibration.information.identifiability import listed, short
from stages.calibration.observation.measured_run import SIDES, MeasuredRun
from stages.calibration.observation.prediction import AXES
from stages.calibration.result import HALF_WIDTH, Misses, Result

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


def structure(run: MeasuredRun, equations: Equations) -> list[Structure]:
    """That of every signal with residuals."""
    found = []
    for side in SIDES:
        part = step_parts(run.sampling.of(side), run.strikes)
        for column, axis in enumerate(AXES):
            left = equations.pulls(side)[:, column]
            seen = np.isfinite(left) & (part >= 0)
            if seen.sum() <= 2 * max(PARTS, LAGS):
                continue
            groups = [left[seen & (part == each)] for each in range(PARTS)]
            means = np.array([one.mean() if one.size else 0.0 for one in groups])
            off = sum(one.size * one.mean() ** 2 for one in groups if one.size)
            filled = sum(bool(one.size) for one in groups)
            found.append(Structure(side, axis, float(np.sqrt((left[seen] ** 2).mean())), means,
                                   float(chdtrc(filled, off)), whiteness(np.where(seen, left, np.nan))))
    return found


def structure_in_words(runs: Sequence[MeasuredRun], fits: Sequence[Equations]) -> list[str]:
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


def correlation_length(every: Sequence[np.ndarray]) -> float:
    """How many samples of traces of residuals together are worth one independent one: 1 + 2 sum of autocorrelations.

    Up to the first that is negative (Geyer's rule in its plainest form).
    """
    power = sum(float((one**2).sum()) for one in every) / sum(one.size for one in every)
    total, shortest = 1.0, min(len(one) for one in every)
    for lag in range(1, shortest):
        products = sum(float((one[lag:] * one[:-lag]).sum()) for one in every)
        rho = products / sum(one[lag:].size for one in every) / power
        if rho <= 0.0:
            break
        total += 2.0 * rho
    return total


#: A share of readings that no fit is below which is worth anything.
LEAST = 0.1
#: Traces with fewer samples show nothing of how neighbours hang together.
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
    length = correlation_length([one for one in seen if len(one) > FEWEST])
    return math.sqrt(size), max(1.0, math.sqrt(variance * max(1.0, length)))


#: How many more runs than coefficients show a scatter at all.
SPARE = 2
#: How sure it is that an interval holds what it says: a scatter of few runs may be too small by luck, and then all
#: intervals of the study are.
SURE = 0.9


@dataclass(frozen=True)
class Discrepancy:
    """What fits of a model miss, estimate less truth, in shares of the drawing's values: on average `mean` (n,), and by
    `slope` (n,) more for each unit that a fit is pulled more than `pull`; covariance (n, n) about that.

    From `count` runs with pulls of the mean square `width`, zero where the pull was not looked at.
    """

    mean: Vector
    slope: Vector
    covariance: np.ndarray
    count: int
    pull: float = 0.0
    width: float = 0.0

    @classmethod
    def of(cls, misses: np.ndarray, pulls: Vector | None = None) -> Discrepancy:
        """From misses (count, n), by the pulls (count,) of their fits if these are given. Raises ValueError where there
        are too few."""
        count, n = misses.shape
        coefficients = 1 if pulls is None else 2
        if count < coefficients + SPARE:
            raise ValueError(f"a scatter needs {coefficients + SPARE} runs at least")
        mean, slope, middle, width = misses.mean(axis=0), np.zeros(n), 0.0, 0.0
        left = misses - mean
        if pulls is not None:
            middle = float(pulls.mean())
            off = pulls - middle
            width = float((off**2).mean())
            slope = off @ left / (count * width) if width else slope
            left = left - np.outer(off, slope)
        return cls(mean, slope, left.T @ left / (count - coefficients), count, middle, width)

    @classmethod
    def from_misses(cls, misses: Misses) -> Discrepancy | None:
        """From what a study's runs miss; none where too few show it."""
        try:
            return cls.of(misses.shares, misses.pulls)
        except ValueError:
            return None

    def factor(self, pull: float) -> float:
        """Half widths in standard deviations for a fit with that pull: of a Gaussian tolerance interval, which holds
        95 % of further runs' errors in 90 % of the studies that are made (W. G. Howe, J. Am. Stat. Assoc. 64, 1969,
        610; along a line, W. A. Wallis, 2nd Berkeley Symposium, 1951, 43)."""
        free = self.count - (2 if self.width else 1)
        apart = (pull - self.pull) ** 2 / self.width if self.width else 0.0
        return HALF_WIDTH * float(np.sqrt(free * (1.0 + (1.0 + apart) / self.count) / chdtri(free, SURE)))

    def expected(self, scales: Vector, pull: float = 0.0) -> Vector:
        """What a fit with that pull misses on average, (n,)."""
        return np.asarray((self.mean + self.slope * (pull - self.pull)) * scales)

    def spread(self, scales: Vector, pull: float = 0.0) -> np.ndarray:
        """Covariance (n, n) of a Gaussian whose 95 % intervals are as wide as those about one more run's estimate."""
        return np.asarray((self.factor(pull) / HALF_WIDTH) ** 2 * self.covariance * np.outer(scales, scales))


#: Drawings whose numbers differ by less are the same.
SAME = 1e-6
ALONE = "intervals contain noise and residuals alone, and not an error that the model makes in every step"


@dataclass(frozen=True)
class Judged:
    """A design (d,) with standard deviations (d,), as wide as Gaussian ones of the same 95 % intervals; what to say of
    them, and how many runs give them what the model puts wrong (0: none)."""

    values: Vector
    sd: Vector
    words: str
    other_runs: int = 0


def judged(
    names: Sequence[str], values: Vector, sd: Vector, known: Sequence[Known], design: DesignPoint,
    lever_arm_sd: float, pull: float, calibration: tuple[Any, str],
) -> Judged:
    """What was found (d,) with noise `sd` (d,), less what fits of the study's runs miss on average and widened by
    their scatter, where the study has made fits of this kind; else as it is, and why.

    `lever_arm_sd` [m]: how well the foot sensor's place was known. `pull`: by how much the fit moved clocks.
    `calibration` is the study's own and its file, or none and why.
    """
    study, source = calibration
    why = source if study is None else unfit(names, known, design, lever_arm_sd, study, source)
    if why:
        return Judged(values, sd, f"{ALONE}: {why}")
    term = Discrepancy.of(study.misses.shares, study.misses.pulls)
    order = [study.names.index(name) for name in names]
    off = term.expected(study.drawn, pull)[order]
    wide = np.sqrt(np.diag(term.spread(study.drawn, pull))[order])
    first, last = study.misses.runs[0], study.misses.runs[-1]
    largest = int(np.argmax(np.abs(off / values)))
    return Judged(
        values - off, np.hypot(sd, wide),
        f"intervals contain the model's error, from fits of {term.count} runs of other robots made by the Exudyn "
        f"twin ({source}, {first} to {last}): what they miss where clocks are pulled as far is taken off "
        f"({short(names[largest])} by {-100 * off[largest] / values[largest]:+.2f} %), their scatter is in the "
        "intervals. That holds for a robot as near to its nominal design as those, on ground like the twin's",
        term.count)


def unfit(
    names: Sequence[str], known: Sequence[Known], design: DesignPoint, lever_arm_sd: float, study: Result, source: str
) -> str:
    """Why a study's fits do not show what these miss; nothing where they do."""
    if Discrepancy.from_misses(study.misses) is None:
        few = len(study.misses.runs)
        return (f"{source} has {count_of(few, 'fit') if few else 'no fits'} of other robots' runs"
                f"{', too few' * (few > 0)} (calibration.discrepancy_runs)")
    if set(names) != set(study.names):
        return (f"{source} shows it for fits that seek {listed([short(name) for name in study.names])}; the bill of "
                "parts begins such a fit (design: parts)")
    if {one.name for one in known} != {TOTAL_MASS}:
        return f"{source} shows it for robots of which the mass is known and nothing else"
    if not math.isclose(lever_arm_sd, study.lever_arm_sd, rel_tol=0.1):
        return (f"{source} shows it for robots whose foot sensor is where it is said to be within "
                f"{study.lever_arm_sd:.2g} m, here within {lever_arm_sd:.2g} m (calibration.lever_arm_sd)")
    other = [short(name) for name, drawn in zip(study.names, study.drawn, strict=True)
             if abs(design.value(name) - drawn) > SAME * abs(drawn)]
    return f"{source} is of a robot with another {listed(other)}" if other else ""
