"""What runs can tell of a design: standard deviations, combinations that nothing is told of, and what limits the rest.

The information of a Gaussian fit is J^T W J; its inverse is the smallest covariance an unbiased estimate can have
(Cramer and Rao).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.model.walker import Vector
from stages.calibration.estimation.equations import Equations, Model, eliminated
from stages.calibration.estimation.known import Known, information_of

#: A combination is told nothing of if it may change by this share of its parameters, in standard deviations.
UNSEEN = 1.0
#: A parameter belongs to such a combination if it has this much of it.
BELONGS = 1e-3


@dataclass(frozen=True)
class Partner:
    """The unknown that a parameter's error goes along with most: its name, the correlation, and the parameter's
    standard deviation if it were known."""

    name: str
    correlation: float
    sd_without: float


@dataclass(frozen=True)
class Identifiability:
    """What `runs` runs tell of the parameters `names` (n,): `values`, `scales`, standard deviations `sd` (n,), infinite
    for those in a combination that is not seen, the `unseen` combinations (u, n) in shares of `scales`, and what limits
    each parameter.

    `covariance` (n, n) is without the unseen combinations.
    """

    names: tuple[str, ...]
    values: Vector
    scales: Vector
    runs: int
    sd: Vector
    covariance: np.ndarray
    unseen: np.ndarray
    partners: tuple[Partner, ...]


def scales_of(design: DesignPoint, names: Sequence[str]) -> Vector:
    """A whole share of each parameter: its value, or a size it could have."""
    from stages.analytic.derivatives.numbers import changes_of

    return changes_of(design, names).scales


def identifiability(
    design: DesignPoint, equations: Equations, model: Model, known: Sequence[Known], runs: int = 1
) -> Identifiability:
    """What `runs` runs like the one of `equations` tell, each with sensors and ramp of its own, and `known` values."""
    d = len(model.shared)
    names = (*model.shared, *model.own)
    scales = scales_of(design, names)
    others = len(model.layout.names)
    matrix = equations.matrix.copy()
    if runs > 1:  # the other runs' unknowns are gone already
        more, _ = eliminated(equations, d)
        matrix[:d, :d] += (runs - 1) * more
    order = [*range(d), *range(d + others, d + others + len(model.own)), *range(d, d + others)]
    matrix = matrix[np.ix_(order, order)]
    n = len(names)
    matrix[:n, :n] += information_of(known, names)
    unit = np.concatenate([scales, model.layout.sizes])
    scaled = matrix * unit * unit[:, None]
    design_only = _without(scaled, n)
    values, vectors = np.linalg.eigh(design_only)
    is_unseen = values < 1.0 / UNSEEN**2
    unseen = vectors[:, is_unseen].T
    seen = vectors[:, ~is_unseen]
    covariance = (seen / values[~is_unseen]) @ seen.T
    part_of = (np.abs(unseen) > BELONGS).any(axis=0) if len(unseen) else np.zeros(n, dtype=bool)
    sd = np.where(part_of, np.inf, np.sqrt(np.diag(covariance)) * scales)
    all_names = (*names, *model.layout.names)
    partners = _partners(scaled, unseen, n, all_names, scales)
    return Identifiability(names, np.array([design.value(name) for name in names]), scales, runs, sd,
                           covariance * scales * scales[:, None], unseen, partners)


def _without(matrix: np.ndarray, kept: int) -> np.ndarray:
    """The information about the first unknowns when the others are free."""
    cross, own = matrix[:kept, kept:], matrix[kept:, kept:]
    left = matrix[:kept, :kept] - cross @ np.linalg.lstsq(own, cross.T, rcond=1e-14)[0]
    return np.asarray(0.5 * (left + left.T))


def _partners(
    scaled: np.ndarray, unseen: np.ndarray, n: int, names: tuple[str, ...], scales: Vector
) -> tuple[Partner, ...]:
    """What each parameter's error goes along with, unseen combinations held."""
    held = scaled.copy()
    stiff = float(np.abs(np.diag(scaled)[:n]).max())
    held[:n, :n] += stiff * unseen.T @ unseen
    equal = 1.0 / np.sqrt(np.diag(held))
    covariance = np.linalg.inv(held * equal * equal[:, None]) * equal * equal[:, None]
    sd = np.sqrt(np.diag(covariance))
    correlation = covariance / sd / sd[:, None]
    found = []
    for row in range(n):
        others = np.where([name.startswith("start_") for name in names], 0.0, np.abs(correlation[row]))
        others[row] = 0.0  # nobody can measure where a walk starts, so it is no partner
        other = int(np.argmax(others))
        r = float(correlation[row, other])
        found.append(Partner(names[other], r, float(sd[row] * scales[row] * np.sqrt(max(0.0, 1.0 - r * r)))))
    return tuple(found)
