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

# A^-1 = T diag(values) T^-1: the stages' equations fall apart into one for each value. Conjugates give conjugate
# solutions, so that of each pair one is kept, with twice its column. The first value is the real one.
_values, _vectors = np.linalg.eig(A_INVERSE)
_kept = [index for index in np.argsort(np.abs(_values.imag)) if _values[index].imag > -1e-8]
VALUES = _values[_kept]
ROWS = np.ascontiguousarray(np.linalg.inv(_vectors)[_kept])
COLUMNS = np.ascontiguousarray(_vectors[:, _kept] * np.where(np.arange(len(_kept)) == 0, 1.0, 2.0))
REAL_VALUE = float(VALUES[0].real)

# An embedded formula of order s that also uses the rates at the start, with weight 1 / REAL_VALUE
_weights = np.linalg.solve(
    legendre.legvander(2.0 * C - 1.0, STAGES - 1).T,
    np.eye(STAGES)[0] - (-1.0) ** np.arange(STAGES) / REAL_VALUE,
)
#: Weights of the stages' increments in (embedded - main formula).
ESTIMATE = _weights @ A_INVERSE - np.eye(STAGES)[-1]
