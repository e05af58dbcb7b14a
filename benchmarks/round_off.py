"""Round-off of one step: the same scheme in single, double and extended precision, and the order of summation.

The readable equations (sympy's terms through numpy) are integrated by the classical Runge-Kutta method with fixed
steps over the phases of the gait of Table 1, so that three precisions make the same truncation error and their
difference is round-off alone. Run: python -m benchmarks.round_off
"""

from typing import Any

import numpy as np

from stages.analytic.gait.gait_search import find_gait
from stages.analytic.gait.poincare import FixedPoint
from stages.analytic.integration.readable import terms
from stages.analytic.model.walker import Walker
from stages.analytic.phases.section import section_state
from stages.biped.design import Biped
from stages.ground.slope import Slope

TABLE_1 = Biped("compliant", 0.316, 0.335, 0.333, 0.083, 0.1, 2800.0, 58.35, 0.0)
SLOPE = Slope(2.0, 9.81)
#: Runge-Kutta steps of double stance and of single stance.
STEPS = (100, 200)


def eliminate(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Solution of a linear system by Gaussian elimination with row pivots, in the precision of its entries."""
    a, b = matrix.copy(), right.copy()
    for k in range(len(b)):
        pivot = k + int(np.argmax(np.abs(a[k:, k])))
        a[[k, pivot]], b[[k, pivot]] = a[[pivot, k]], b[[pivot, k]]
        for row in range(k + 1, len(b)):
            factor = a[row, k] / a[k, k]
            a[row, k:] -= factor * a[k, k:]
            b[row] -= factor * b[k]
    for k in range(len(b) - 1, -1, -1):
        b[k] = (b[k] - a[k, k + 1 :] @ b[k + 1 :]) / a[k, k]
    return b


def system(walker: Walker, y: np.ndarray, both_feet: bool, kind: Any) -> tuple[np.ndarray, np.ndarray]:
    """Matrix and right-hand side of eq. (6) for the accelerations (and the forces), in precision `kind`."""
    t, p = terms("compliant"), [kind(value) for value in walker.p]
    y = y.astype(kind)
    mass, force = t.mass(y, p).astype(kind), t.force(y, p).ravel().astype(kind)
    if not both_feet:
        return mass, force
    pi, bias = t.constraint_jacobian(y, p).astype(kind), t.constraint_bias(y, p).ravel().astype(kind)
    return np.block([[mass, -pi], [pi.T, np.zeros((2, 2), dtype=kind)]]), np.concatenate([force, -bias])


def step(walker: Walker, start: np.ndarray, durations: tuple[float, float], kind: Any) -> np.ndarray:
    """State just before heel strike, double and single stance by fixed steps in precision `kind`."""
    y = start.astype(kind)
    half, sixth = kind(1) / kind(2), kind(1) / kind(6)
    for both_feet, duration, count in zip((True, False), durations, STEPS, strict=True):
        h = kind(duration) / kind(count)

        def rates(y: np.ndarray, both_feet: bool = both_feet) -> np.ndarray:
            return np.concatenate([y[4:], eliminate(*system(walker, y, both_feet, kind))[:4]])

        for _ in range(count):
            a = rates(y)
            b = rates(y + half * h * a)
            c = rates(y + half * h * b)
            d = rates(y + h * c)
            y = y + sixth * h * (a + kind(2) * b + kind(2) * c + d)
    return y


def precisions(walker: Walker, point: FixedPoint) -> dict[str, float]:
    """Largest difference of a step in single and in double precision from that in extended precision."""
    start = section_state(point.z, walker.p)
    taken = point.steps[0]
    durations = taken.double_stance, taken.period - taken.double_stance
    best = step(walker, start, durations, np.longdouble)
    return {
        name: float(np.abs(step(walker, start, durations, kind).astype(np.longdouble) - best).max())
        for name, kind in (("single", np.float32), ("double", np.float64))
    }


def orders_of_summation(walker: Walker, states: np.ndarray) -> float:
    """Largest difference of double stance accelerations (relative to the largest) over orders of the equations.

    A permuted system is eliminated in another order, so every sum in it is taken in another order.
    """
    worst = 0.0
    generator = np.random.default_rng(1)
    for y in states:
        matrix, right = system(walker, y, True, np.float64)
        usual = eliminate(matrix, right)
        for _ in range(5):
            order = generator.permutation(len(right))
            other = np.empty_like(usual)
            other[order] = eliminate(matrix[np.ix_(order, order)], right[order])
            worst = max(worst, float(np.abs(other - usual).max() / np.abs(usual).max()))
    return worst


def similarity(factors: tuple[float, float, float]) -> float:
    """Largest difference of the dimensionless gaits of Table 1 and of a biped scaled in mass, length and gravity."""
    mass, length, gravity = factors
    time = (length / gravity) ** 0.5
    scaled = Biped(
        "compliant", 0.316 * mass, 0.335 * mass, 0.333 * length, 0.083 * length, 0.1 * length,
        2800.0 * mass / time**2, 58.35 * mass / time, 0.0,
    )  # fmt: skip
    (_, one), (_, other) = find_gait(TABLE_1, SLOPE, 1e-12), find_gait(scaled, Slope(2.0, 9.81 * gravity), 1e-12)
    return float(max(np.abs(one.z - other.z).max(), abs(one.steps[0].period - other.steps[0].period)))


if __name__ == "__main__":
    gait = find_gait(TABLE_1, SLOPE, 1e-12)
    for name, difference in precisions(*gait).items():
        bits = np.finfo(np.longdouble).nmant + 1
        print(f"one step, {name} against extended precision ({bits} bits): {difference:.1e}")
    from tests.analytic.designs import double_stance_states

    print(f"order of summation, accelerations: {orders_of_summation(gait[0], double_stance_states(gait[0], 50)):.1e}")
    for factors in ((1e-3, 1e-2, 0.165), (2.7, 3.1, 0.38), (1e6, 30.0, 2.53)):
        print(f"similar biped, factors of mass, length, gravity {factors}: {similarity(factors):.1e}")
