"""Closed-form solution of the 4 x 4 mass matrix and of the constrained system, written out for scalars.

The swing leg's block of the mass matrix is diagonal (psi and L_2 are polar coordinates of one mass), so the
elimination starts there and ends in a 2 x 2 system for the stance leg. A mass off the leg's line couples the two: they
are first made free of each other.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

from stages.analytic.compiled import ByKind, Constrained, Four, Numbers, compiled


class Coupled(NamedTuple):
    """Factors of a mass matrix with m34: those of the matrix in which `ratio` m34/m44 times the row and the column of
    L_2 is taken off those of psi.
    """

    factors: Numbers
    ratio: float


@compiled
def factor(
    m11: float, m12: float, m13: float, m14: float, m22: float, m23: float, m24: float, m33: float, m44: float
) -> Numbers:
    """Factors of the symmetric mass matrix with m34 = 0, for `solve`."""
    i33, i44 = 1.0 / m33, 1.0 / m44
    a13, a14, a23, a24 = m13 * i33, m14 * i44, m23 * i33, m24 * i44
    s11 = m11 - m13 * a13 - m14 * a14
    s12 = m12 - m13 * a23 - m14 * a24
    s22 = m22 - m23 * a23 - m24 * a24
    inverse = 1.0 / (s11 * s22 - s12 * s12)
    return i33, i44, a13, a14, a23, a24, s22 * inverse, -s12 * inverse, s11 * inverse


@compiled
def coupled_factor(
    m11: float, m12: float, m13: float, m14: float, m22: float, m23: float, m24: float, m33: float, m34: float,
    m44: float,
) -> Coupled:  # fmt: skip
    """Factors of a symmetric mass matrix, for `solve`."""
    ratio = m34 / m44
    return Coupled(
        factor(m11, m12, m13 - ratio * m14, m14, m22, m23 - ratio * m24, m24, m33 - ratio * m34, m44), ratio)


@compiled
def solve_coupled(factors: Coupled, f1: float, f2: float, f3: float, f4: float) -> Four:
    """`solve` with m34."""
    x1, x2, x3, x4 = solve_uncoupled(factors.factors, f1, f2, f3 - factors.ratio * f4, f4)
    return x1, x2, x3, x4 - factors.ratio * x3


@compiled
def solve_uncoupled(factors: Numbers, f1: float, f2: float, f3: float, f4: float) -> Four:
    """`solve` without m34."""
    i33, i44, a13, a14, a23, a24, c11, c12, c22 = factors
    g1 = f1 - a13 * f3 - a14 * f4
    g2 = f2 - a23 * f3 - a24 * f4
    x1 = c11 * g1 + c12 * g2
    x2 = c12 * g1 + c22 * g2
    return x1, x2, i33 * f3 - a13 * x1 - a23 * x2, i44 * f4 - a14 * x1 - a24 * x2


#: Solution of M x = f from the factors of M: solve(factors, f1, f2, f3, f4).
solve: Callable[..., Four] = ByKind({Coupled: solve_coupled, tuple: solve_uncoupled}, by="factors")


@compiled
def dot(a: Four, b: Four) -> float:
    """Scalar product of two 4-tuples."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]


@compiled
def factor_constrained(factors: Any, normal: Four, roll: Four) -> Constrained:
    """Factors of [[M, -Pi], [Pi^T, 0]] for Pi = (normal, roll): the two columns of M^-1 Pi and (Pi^T M^-1 Pi)^-1."""
    y1 = solve(factors, normal[0], normal[1], normal[2], normal[3])
    y2 = solve(factors, roll[0], roll[1], roll[2], roll[3])
    s11, s12, s22 = dot(normal, y1), dot(normal, y2), dot(roll, y2)
    inverse = 1.0 / (s11 * s22 - s12 * s12)
    return y1, y2, s22 * inverse, -s12 * inverse, s11 * inverse
