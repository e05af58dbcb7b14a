"""Derivatives of a gait's multipliers by parameters, along the gaits of the changed designs.

The monodromy matrix itself is exact, and so is the tangent (dz, dp) along which gait and parameters move together. What
is left is one derivative of the matrix along that tangent: central differences, extrapolated to zero step
(Richardson), with the error that the extrapolation leaves. A multiplier's derivative is then that of a single
eigenvalue, w dD v / (w v), which needs the others at a distance.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise

import numpy as np

from stages.analytic.derivatives.gait import GaitTangents
from stages.analytic.derivatives.numbers import moved
from stages.analytic.errors import StepFailed
from stages.analytic.gait.poincare import iterate, largest_first
from stages.analytic.model.stiffness import attainable_tolerance
from stages.analytic.model.walker import Vector

#: Multipliers of at least this share of the largest lead: the others die out within a step or two.
LEADING = 0.05
#: Closer than this, two multipliers have no derivatives of their own.
APART = 1e-3
#: Largest step of the differences, a share of a parameter, halved twice; where the map bends too much for the first,
#: the next. Tolerance of the matrices.
STEPS, TOLERANCE = (4e-3, 1e-3, 2.5e-4), 1e-13
#: A multiplier whose imaginary part is a smaller share of it is real: what a complex solver leaves of it.
ROUND_OFF = 1e-12
#: Differences of a smooth map fall by four where the step is halved, within so much; else extrapolation gains nothing
#: that is sure, as beside a bend of a contact law, or where round-off is all that is left.
SMOOTH = 0.5
#: What the extrapolation may leave, as a share of the largest derivative by the parameter, or of one.
SURE = 1e-6


@dataclass(frozen=True)
class MultiplierDerivatives:
    """The leading multipliers (m,), largest first, and their derivatives (m, n) for whole shares of the parameters.

    `errors` (n,): what extrapolation leaves of them at most, by parameter. A derivative that is not to be had is NaN,
    and `refused` says why.
    """

    values: np.ndarray
    derivatives: np.ndarray
    errors: Vector
    refused: tuple[str, ...]

    def only(self, rows: Sequence[int]) -> MultiplierDerivatives:
        """The same by some of the parameters."""
        chosen = list(rows)
        return replace(self, derivatives=self.derivatives[:, chosen], errors=self.errors[chosen])

    def elasticities(self) -> np.ndarray:
        """Shares by which the magnitudes change for a share of each parameter, (m, n)."""
        return np.asarray(np.real(self.derivatives / self.values[:, None]))


def multiplier_derivatives(gait: GaitTangents) -> MultiplierDerivatives:
    """Derivatives of the gait's leading multipliers; those that the parameters do not have are refused in words."""
    values, left, right = eigensystem(gait.by_state)
    count = int((np.abs(values) >= LEADING * np.abs(values[0])).sum())
    names, refused = gait.changes.names, []
    single = []
    for index in range(count):
        distance = np.abs(np.delete(values, index) - values[index]).min()
        if distance >= APART:
            single.append(index)
        else:
            refused.append(f"multiplier {index + 1}, {shown(values[index])}, has no derivative of its own: another is "
                           f"only {distance:.1g} away")
    derivatives, errors = np.full((count, len(names)), np.nan, dtype=complex), np.full(len(names), np.nan)
    for row, name in enumerate(names if single else ()):
        try:
            found, errors[row] = along_the_gait(partial(matrix_slope, gait, row), left[single], right[:, single])
        except StepFailed as reason:
            refused.append(f"by {name} the multipliers have no derivative: beside the design {reason}")
            continue
        if errors[row] <= SURE * max(float(np.abs(found).max()), 1.0):
            derivatives[single, row] = found
        else:
            refused.append(f"by {name} the multipliers' derivative is not sure: differences agree to {errors[row]:.1g}")
    return MultiplierDerivatives(values[:count], derivatives, errors, tuple(refused))


def eigensystem(matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Eigenvalues, largest first, left eigenvectors as rows and right ones as columns, scaled so that w v = 1."""
    values, right = np.linalg.eig(matrix.astype(complex))
    order = largest_first(values)
    values, right = values[order], right[:, order]
    lefts, vectors = np.linalg.eig(matrix.T.astype(complex))
    left = np.array([vectors[:, int(np.argmin(np.abs(lefts - value)))] for value in values])
    products = np.einsum("ij,ji->i", left, right)
    with np.errstate(divide="ignore", invalid="ignore"):
        return values, left / products[:, None], right


def along_the_gait(
    matrix_slope: Callable[[float], np.ndarray], left: np.ndarray, right: np.ndarray
) -> tuple[np.ndarray, float]:
    """Derivatives (m,) of multipliers along the tangent (dz, dp) of one parameter, and what is left of error in them.

    `matrix_slope` is that below, of a share; `left` (m, j) and `right` (j, m) are their eigenvectors. Raises what it
    raises where a gait beside has no step.
    """
    best, least = np.full(len(left), np.nan), np.inf
    for step in STEPS:
        slopes = [matrix_slope(share) for share in (step, step / 2, step / 4)]
        of_each = [np.einsum("ij,jk,ki->i", left, slope, right) for slope in slopes]
        apart = -np.diff(of_each, axis=0)
        once = [(4 * fine - coarse) / 3 for coarse, fine in pairwise(of_each)]
        found = (16 * once[1] - once[0]) / 15
        smooth = np.abs(apart[0] - 4 * apart[1]) < SMOOTH * np.abs(apart[1])
        error = float((np.abs(once[1] - once[0]) * np.where(smooth, 1 / 15, 1.0)).max())
        if error >= least:  # round-off, of which smaller steps have more
            break
        best, least = found, error
        if least <= SURE * max(1.0, float(np.abs(best).max())):
            break
    return best, least


def matrix_slope(gait: GaitTangents, row: int, share: float) -> np.ndarray:
    """Central difference (j, j) of the exact monodromy matrix over a share of a parameter to both sides of the gait, a
    smaller one where the gait's coordinates change by a larger one, as with the length of one leg."""
    tolerance, share = attainable_tolerance(gait.walker.p, TOLERANCE), share / max(1.0, np.abs(gait.z[:, row]).max())
    sides = [
        iterate(
            moved(gait.walker, side * share * gait.changes.along[row]),
            gait.point.z + side * share * gait.z[:, row], len(gait.point.steps), tolerance)[1]
        for side in (1.0, -1.0)
    ]
    return np.asarray((sides[0] - sides[1]) / (2 * share))


def shown(value: complex) -> str:
    """A multiplier in words."""
    real = abs(value.imag) <= ROUND_OFF * abs(value)
    return f"{value.real:.6g}" if real else f"{value.real:.6g}{value.imag:+.6g}j"
