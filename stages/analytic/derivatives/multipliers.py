"""Derivatives of a gait's multipliers by parameters, along the gaits of the changed designs.

The monodromy matrix itself is exact, and so is the tangent (dz, dp) along which gait and parameters move together. What
is left is one derivative of the matrix along that tangent: central differences, extrapolated to zero step
(Richardson), with the error that the extrapolation leaves. A multiplier's derivative is then that of a single
eigenvalue, w dD v / (w v), which needs the others at a distance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from stages.analytic.derivatives.gait import VariedGait
from stages.analytic.derivatives.numbers import moved
from stages.analytic.errors import StepFailed
from stages.analytic.gait.poincare import poincare_derivative
from stages.analytic.model.stiffness import attainable_tolerance
from stages.analytic.model.walker import Vector, Walker

#: Multipliers of at least this share of the largest lead: the others die out within a step or two.
LEADING = 0.05
#: Closer than this, two multipliers have no derivatives of their own.
APART = 1e-3
#: Largest step of the differences, a share of a parameter; it is halved twice. Tolerance of the matrices.
STEP, TOLERANCE = 4e-3, 1e-13
#: What the extrapolation may leave, as a share of the largest derivative.
SURE = 1e-6


@dataclass(frozen=True)
class MultiplierDerivatives:
    """The leading multipliers (m,), largest first, and their derivatives (m, n) for whole shares of the parameters.

    `errors` (n,): what extrapolation leaves of each parameter's. A derivative that is not to be had is NaN, and
    `refused` says why.
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
        shares: np.ndarray = np.real(self.derivatives / self.values[:, None])
        return shares


def multiplier_derivatives(gait: VariedGait) -> MultiplierDerivatives:
    """Derivatives of the gait's leading multipliers; those that the parameters do not have are refused in words."""
    values, left, right = eigensystem(gait.step.by_state)
    count = int((np.abs(values) >= LEADING * np.abs(values[0])).sum())
    refused, names = [], gait.changes.names
    matrices, errors = [], []
    for row, name in enumerate(names):
        try:
            matrix, error = matrix_derivative(gait.walker, gait.point.z, gait.z[:, row], gait.changes.along[row])
        except StepFailed as reason:
            matrix, error = np.full_like(gait.step.by_state, np.nan), np.nan
            refused.append(f"by {name} the multipliers have no derivative: beside the design {reason}")
        matrices.append(matrix)
        errors.append(error)
    derivatives = np.full((count, len(names)), np.nan, dtype=complex)
    for index in range(count):
        distance = np.abs(np.delete(values, index) - values[index]).min()
        if distance < APART:
            refused.append(f"multiplier {index + 1}, {shown(values[index])}, has no derivative of its own: another is "
                           f"only {distance:.1g} away")
            continue
        for row, matrix in enumerate(matrices):
            derivatives[index, row] = left[index] @ matrix @ right[:, index]
    for row, name in enumerate(names):
        largest = np.nanmax(np.abs(derivatives[:, row]), initial=0.0)
        if errors[row] > SURE * max(largest, 1.0):
            refused.append(f"by {name} the multipliers' derivative is not sure: differences agree to {errors[row]:.1g}")
            derivatives[:, row] = np.nan
    return MultiplierDerivatives(values[:count], derivatives, np.array(errors), tuple(refused))


def eigensystem(matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Eigenvalues, largest first, left eigenvectors as rows and right ones as columns, scaled so that w v = 1."""
    values, right = np.linalg.eig(matrix.astype(complex))
    order = np.lexsort((-values.imag, -np.round(np.abs(values), 12)))
    values, right = values[order], right[:, order]
    lefts, vectors = np.linalg.eig(matrix.T.astype(complex))
    left = np.array([vectors[:, int(np.argmin(np.abs(lefts - value)))] for value in values])
    products = np.einsum("ij,ji->i", left, right)
    with np.errstate(divide="ignore", invalid="ignore"):
        return values, left / products[:, None], right


def matrix_derivative(walker: Walker, z: Vector, dz: Vector, along: Vector) -> tuple[np.ndarray, float]:
    """Derivative (j, j) of the monodromy matrix along (dz, dp), and what extrapolation leaves of error in it.

    Raises StepFailed where a gait beside has no step.
    """
    tolerance = attainable_tolerance(walker.p, TOLERANCE)

    def matrix(share: float) -> np.ndarray:
        beside = moved(walker, share * along)
        return poincare_derivative(beside, z + share * dz, tolerance)[1]

    slopes = [(matrix(step) - matrix(-step)) / (2 * step) for step in (STEP, STEP / 2, STEP / 4)]
    once = [(4 * fine - coarse) / 3 for coarse, fine in pairwise(slopes)]
    twice: np.ndarray = (16 * once[1] - once[0]) / 15
    return twice, float(np.abs(twice - once[1]).max())


def shown(value: complex) -> str:
    """A multiplier in words."""
    return f"{value.real:.6g}" if value.imag == 0 else f"{value.real:.6g}{value.imag:+.6g}j"
