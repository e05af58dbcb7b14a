"""One step of Radau IIA, order 13, on a phase: for springs and dampers so stiff that explicit steps would be tiny.

The stages' equations are solved by Newton's method with the exact Jacobian at the step's start, to round-off: a stiff
spring turns an error of its length into a force. Variations ride along, each with the same matrices.

Coefficients of the Radau IIA collocation method with seven stages, order 13, and of its error estimate.

Hairer and Wanner, Solving Ordinary Differential Equations II, sections IV.5 and IV.8. All matrices come from Legendre
polynomials, whose values at the nodes form a well-conditioned matrix.
"""

from math import sqrt

import numpy as np
from numpy.polynomial import legendre

from stages.analytic.compiled import compiled, inlined
from stages.analytic.model.kinds import Compliant, Directions
from stages.analytic.model.walker import Vector
from stages.analytic.phases.motion import flow

STAGES = 7


def nodes(stages: int) -> np.ndarray:
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


C = nodes(STAGES)
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


#: Length of the state of compliant legs, to which a variation or more may be joined.
SIZE = 8
ITERATIONS = 50
#: A correction of the state this small, or this small a share of a spring force's round-off, may be round-off itself.
SMALL, SHARE_OF_ROUND_OFF = 1e-11, 5e-17
#: Larger corrections must shrink by this factor after the first few, or the step fails.
SLOWEST, PATIENCE = 0.7, 4
#: What round-off may leave in a variation: a stiff spring multiplies that of a length of order one by its stiffness.
SMALL_VARIATION = 1e-6


@inlined
def jacobian(phase: int, y: Vector, p: Compliant) -> np.ndarray:
    """d(dy/dt)/dy of a phase at the state, shape (n, n), by unit variations."""
    n = SIZE
    augmented, rates, matrix = np.zeros(n * (n + 1)), np.empty(n * (n + 1)), np.empty((n, n))
    for i in range(n):
        augmented[i] = y[i]
        augmented[n * (i + 1) + i] = 1.0
    flow(phase, augmented, p, rates, None)
    for i in range(n):
        for j in range(n):
            matrix[i, j] = rates[n * (j + 1) + i]
    return matrix


@compiled
def invert(shift: complex, matrix: np.ndarray, b: np.ndarray) -> None:
    """Write the inverse of (shift - matrix), shape (n, n), into `b`, by Gauss and Jordan; not finite if singular."""
    n = matrix.shape[0]
    a = np.empty((n, n), np.complex128)
    for i in range(n):
        for j in range(n):
            a[i, j] = -matrix[i, j]
            b[i, j] = 0.0
        a[i, i] += shift
        b[i, i] = 1.0
    for k in range(n):
        pivot = k
        for i in range(k + 1, n):
            if abs(a[i, k].real) + abs(a[i, k].imag) > abs(a[pivot, k].real) + abs(a[pivot, k].imag):
                pivot = i
        factor = 1.0 / a[pivot, k]
        for j in range(n):
            a[pivot, j], a[k, j] = a[k, j], a[pivot, j] * factor
            b[pivot, j], b[k, j] = b[k, j], b[pivot, j] * factor
        for i in range(n):
            factor = a[i, k]
            if i != k and factor != 0.0:
                for j in range(n):
                    a[i, j] -= factor * a[k, j]
                    b[i, j] -= factor * b[k, j]


@compiled
def apply(matrix: np.ndarray, vector: Vector, result: Vector) -> None:
    """result = matrix times each block of a vector."""
    n = matrix.shape[0]
    for start in range(0, vector.size, n):
        for i in range(n):
            total = matrix[i, 0] * vector[start]
            for j in range(1, n):
                total += matrix[i, j] * vector[start + j]
            result[start + i] = total


@inlined
def residuals(
    phase: int, y: Vector, h: float, p: Compliant, z: np.ndarray, point: Vector, rates: np.ndarray,
    directions: Directions | None,
) -> None:  # fmt: skip
    """What the stages' equations leave at increments `z`, f(y + z) - A^-1 z / h, into `rates` (s, size)."""
    for i in range(STAGES):
        for m in range(y.size):
            point[m] = y[m] + z[i, m]
        flow(phase, point, p, rates[i], directions)
    for i in range(STAGES):
        for m in range(y.size):
            total = 0.0
            for j in range(STAGES):
                total += A_INVERSE[i, j] * z[j, m]
            rates[i, m] -= total / h


@inlined
def corrections(inverses: np.ndarray, rates: np.ndarray, part: Vector, solved: Vector, change: np.ndarray) -> None:
    """Newton's correction of the increments for the residuals in `rates`, into `change` (s, size)."""
    size = part.size
    for i in range(STAGES):
        for m in range(size):
            change[i, m] = 0.0
    for k in range(VALUES.size):
        for m in range(size):
            value = 0.0j
            for j in range(STAGES):
                value += ROWS[k, j] * rates[j, m]
            part[m] = value
        apply(inverses[k], part, solved)
        for i in range(STAGES):
            for m in range(size):
                change[i, m] += (COLUMNS[i, k] * solved[m]).real


@inlined
def solve_stages(
    phase: int, y: Vector, h: float, p: Compliant, inverses: np.ndarray, directions: Directions | None
) -> tuple[np.ndarray, int]:
    """Increments z of the stages, z = h A f(y + z), shape (s, size), and the iterations; z[0, 0] is NaN on failure.

    `inverses` are those of value / h - J, one for each value of A^-1.
    """
    n, size = SIZE, y.size
    z, rates, change = np.zeros((STAGES, size)), np.empty((STAGES, size)), np.empty((STAGES, size))
    point, part, solved = np.empty(size), np.empty(size, np.complex128), np.empty(size, np.complex128)
    last, small = 1e300, max(SMALL, SHARE_OF_ROUND_OFF * p.k)
    for iteration in range(ITERATIONS):
        residuals(phase, y, h, p, z, point, rates, directions)
        corrections(inverses, rates, part, solved, change)
        largest, of_variations = 0.0, 0.0
        for i in range(STAGES):
            for m in range(size):
                z[i, m] += change[i, m]
                relative = abs(change[i, m]) / (1.0 + abs(y[m]))
                if m < n:
                    largest = max(largest, relative)
                else:
                    of_variations = max(of_variations, relative)
        settled = largest <= 2e-16 or (largest <= small and largest >= SLOWEST * last)
        if settled and of_variations <= SMALL_VARIATION:
            return z, iteration + 1
        if not largest < 1e10 or (iteration >= PATIENCE and largest > SLOWEST * last and not settled):
            break
        last = largest
    z[0, 0] = np.nan
    return z, ITERATIONS


@compiled
def take_step(
    phase: int, y: Vector, h: float, p: Compliant, stages: np.ndarray, new: Vector, directions: Directions | None = None
) -> int:
    """Advance `y` by `h` into `new`, and its estimated error into `stages[1]`; returns the evaluations of the rates,
    with one for each column of the Jacobian.

    `stages[0]` must hold dy/dt at `y`. A step whose equations cannot be solved ends in NaN.
    """
    n, size = SIZE, y.size
    if h == 0.0:  # an event at the start of a step
        for m in range(size):
            new[m], stages[1, m] = y[m], 0.0
        return 0
    matrix = jacobian(phase, y, p)
    inverses = np.empty((VALUES.size, n, n), np.complex128)
    for k in range(VALUES.size):
        invert(VALUES[k] / h, matrix, inverses[k])
    z, iterations = solve_stages(phase, y, h, p, inverses, directions)
    if np.isnan(z[0, 0]):
        for m in range(size):
            new[m], stages[1, m] = np.nan, np.nan
        return STAGES * iterations + SIZE
    # embedded formula, filtered twice so that stiff components do not spoil the estimate (Hairer and Wanner, IV.8.20)
    part, filtered, rates = np.empty(size, np.complex128), np.empty(size, np.complex128), stages[0]
    for repeat in range(2):
        for m in range(size):
            total = 0.0
            for j in range(STAGES):
                total += ESTIMATE[j] * z[j, m]
            part[m] = total * REAL_VALUE / h + rates[m]
        apply(inverses[0], part, filtered)
        for m in range(size):
            stages[1, m] = filtered[m].real
            new[m] = y[m] + stages[1, m]
        rates = stages[2]
        if repeat == 0:
            flow(phase, new, p, rates, directions)
    for m in range(size):
        new[m] = y[m] + z[STAGES - 1, m]
    return STAGES * iterations + SIZE + 1


@compiled
def error_norm(y: Vector, new: Vector, h: float, p: Compliant, stages: np.ndarray, tolerance: float) -> float:
    """Estimated error of the step in units of the tolerance (absolute and relative alike); NaN if it is not finite.

    Only the state counts: its variations are those of the computed steps, whatever their size. In a stiff spring a unit
    of length makes them so large that their round-off would rule the step size.
    """
    total = 0.0
    for m in range(SIZE):
        total += (stages[1, m] / (1.0 + max(abs(y[m]), abs(new[m])))) ** 2
    return sqrt(total / SIZE) / tolerance
