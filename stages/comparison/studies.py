"""Numbers of claims that follow from the studies: work at equal error, changes of a contact set, parts of a difference.

Numbers are NaN where a study has nothing to say.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from stages.campaign.result import RunTruth
from stages.comparison.claims.verdict import Parts
from stages.error_budget.result import EFFECTS, UNEXPLAINED, Split
from stages.tradeoff.result import Row, cost_at

#: Words in the names of implicit ways to compute a walk.
IMPLICIT = ("BDF", "Radau", "LSODA", "trapezoidal", "generalized_alpha")
#: Part of the largest contribution below which another is not named.
NEGLIGIBLE = 0.05
NAN = float("nan")


def explicit(row: Row) -> bool:
    """Whether a way takes explicit steps alone."""
    return not any(word in row.way for word in IMPLICIT)


def least_work(rows: Iterable[Row], error: float) -> float:
    """Evaluations a step of the cheapest of these ways at a hip error [m]."""
    ways: dict[str, list[tuple[float, float]]] = {}
    for row in rows:
        if row.completed and math.isfinite(row.errors.hip_position):
            ways.setdefault(row.way, []).append((row.errors.hip_position, row.evaluations))
    costs = [cost_at(sorted(points), error) for points in ways.values()]
    return min((cost for cost in costs if math.isfinite(cost)), default=NAN)


def of_the_paper(rows: Iterable[Row], model: str) -> Row | None:
    """The way that is the paper's, or stands in for it."""
    return next((row for row in rows if row.model == model and "paper" in row.mark and row.completed), None)


def at(factors: Sequence[float], changes: Sequence[float], factor: float) -> float:
    """The change at one factor."""
    return next((change for f, change in zip(factors, changes) if math.isclose(f, factor)), NAN)


def ends(split: Split) -> Parts:
    """Contributions [m] to the hip's place down the slope at the end of the step, without negligible ones, each with
    half the interval in which the order of effects lets it lie."""
    parts = []
    for name in EFFECTS:
        least, most = (float(edge[-1, 0]) for edge in split.interval(name))
        if name != UNEXPLAINED:
            parts.append((name, (least + most) / 2, (most - least) / 2))
    largest = max(abs(part) for _, part, _ in parts)
    return tuple(part for part in parts if abs(part[1]) > NEGLIGIBLE * largest)


def pushes_and_frequency(truths: Iterable[RunTruth], frequencies: dict[str, float]) -> tuple[float, float, float]:
    """Correlation of the runs' frequencies with the push of the stance leg, its 5 % level, and the part of the
    frequencies' variance that the pushes of both legs explain; for runs whose truth is known."""
    from scipy.special import stdtrit

    known = [truth for truth in truths if truth.name in frequencies]
    count = len(known)
    found = np.array([frequencies[truth.name] for truth in known])
    if count < 5 or count < len(frequencies) or np.ptp(found) == 0:
        return NAN, NAN, NAN
    pushes = np.array([(truth.stance_push, truth.swing_push) for truth in known])
    if not (np.ptp(pushes, axis=0) > 0).all():
        return NAN, NAN, NAN
    t = stdtrit(count - 2, 0.975)
    terms = np.column_stack([np.ones(count), pushes])
    left = found - terms @ np.linalg.lstsq(terms, found, rcond=None)[0]
    explained = 1 - float((left**2).sum() / ((found - found.mean()) ** 2).sum())
    return float(np.corrcoef(pushes[:, 0], found)[0, 1]), float(t / math.sqrt(count - 2 + t**2)), explained


def of_model(rows: tuple[Row, ...], model: str) -> list[Row]:
    return [row for row in rows if row.model == model]
