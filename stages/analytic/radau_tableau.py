"""Coefficients of the Radau IIA collocation method with seven stages, order 13, and of its error estimate.

Hairer and Wanner, Solving Ordinary Differential Equations II, sections IV.5 and IV.8. All matrices come from Legendre
polynomials, whose values at the nodes form a well-conditioned matrix.
"""

from __future__ import annotations

import numpy as np
from numpy.polynomial import legendre

STAGES = 7


def nodes(stages: int = STAGES) -> np.ndarray:
    """Right Radau nodes c in (0, 1], shape (s,): the roots of P_s - P_(s-1), the last of them 1."""
    series = np.zeros(stages + 1)
    series[stages - 1 :] = -1.0, 1.0
    x = np.sort(legendre.legroots(series).real)
    for _ in range(3):
        x -= legendre.legval(x, series) / legendre.legval(x, legendre.legder(series))
    x[-1] = 1.0
    return (1.0 + x) / 2.0


def runge_kutta_matrix(c: np.ndarray) -> np.ndarray:
    """A of the collocation method with nodes c, shape (s, s): integrals of its Lagrange polynomials."""
    x = 2.0 * c - 1.0
    count = len(c)
    values = legendre.legvander(x, count)
    integrals = np.empty((count, count))
    integrals[:, 0] = c
    for k in range(1, count):
        integrals[:, k] = (values[:, k + 1] - values[:, k - 1]) / (2.0 * (2 * k + 1))
    return np.linalg.solve(values[:, :count].T, integrals.T).T


C = nodes()
A = runge_kutta_matrix(C)
A_INVERSE = np.linalg.inv(A)

# A^-1 = T diag(real, pairs, conjugates) T^-1: the stages' equations fall apart into one real and three complex ones
_values, _vectors = np.linalg.eig(A_INVERSE)
_inverse = np.linalg.inv(_vectors)
_real = int(np.argmin(np.abs(_values.imag)))
_pairs = np.flatnonzero(_values.imag > 1e-8)
REAL_VALUE = float(_values[_real].real)
PAIR_VALUES = _values[_pairs]
REAL_COLUMN = np.ascontiguousarray(_vectors[:, _real].real)
REAL_ROW = np.ascontiguousarray(_inverse[_real].real)
PAIR_COLUMNS = np.ascontiguousarray(_vectors[:, _pairs])
PAIR_ROWS = np.ascontiguousarray(_inverse[_pairs])

# An embedded formula of order s that also uses the rates at the start, with weight 1 / REAL_VALUE
_weights = np.linalg.solve(
    legendre.legvander(2.0 * C - 1.0, STAGES - 1).T,
    np.eye(STAGES)[0] - (-1.0) ** np.arange(STAGES) / REAL_VALUE,
)
#: Weights of the stages' increments in (embedded - main formula).
ESTIMATE = _weights @ A_INVERSE - np.eye(STAGES)[-1]
