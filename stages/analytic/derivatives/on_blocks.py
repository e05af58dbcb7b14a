"""A gait on blocks of drawn heights, to first order: the spread of its steps, and the gait sensitivity norm.

The step map of rough ground takes section coordinates z and three heights: of the block that the trailing foot leaves,
of that under the stance foot, and of that on which the swing foot lands. Its exact derivatives make a linear system of
z and the heights of the last two blocks, driven by independent heights of unit variance. Its covariance P solves the
discrete Lyapunov equation P = F P F' + G G', over the steps of a cycle where the gait has several.

The spread of a step's duration for heights of unit variance is the gait sensitivity norm with that duration as gait
indicator: D. G. E. Hobbelen and M. Wisse, A disturbance rejection measure for limit cycle walkers: the gait sensitivity
norm, IEEE Transactions on Robotics 23 (2007).
"""

import math

import numpy as np

from stages.analytic.derivatives.gait import moved_state, step_length_change, step_tangents
from stages.analytic.gait.gait_search import step_length
from stages.analytic.gait.poincare import FixedPoint, by_stability
from stages.analytic.model.kinds import H_AHEAD, H_BEHIND
from stages.analytic.model.stiffness import attainable_tolerance
from stages.analytic.model.walker import Vector, Walker
from stages.analytic.result import OnBlocks

#: Measures of a step that are given beside the state: its duration and its length.
DURATION, LENGTH, MEASURES = 0, 1, 2


def refusal(walker: Walker) -> str:
    """Why a walker has no answer on blocks; empty if it has one."""
    if walker.timed:
        return "feet that are put down at a given time (biped.strike_time) do not land on blocks of drawn heights"
    if not walker.rolls:
        return "on blocks of drawn heights feet roll: limited friction (analytic.transition = coulomb) is unknown there"
    return ""


def step_on_blocks(walker: Walker, z: Vector, tolerance: float) -> tuple[tuple[np.ndarray, ...], Vector]:
    """The derivatives of the step from section coordinates `z` (j,) on even ground, and the coordinates it leads to.

    Derivatives are dimensionless, by x = (z, height under the stance foot, height that the trailing foot leaves),
    (j + 2,), and by the height on which the swing foot lands: `state` (j + 2, j + 2) and `landing` (j + 2,) of x in the
    next step; `measures` (2, j + 2) and `by_landing` (2,) of duration and length.

    Raises StepFailed like `poincare_map`.
    """
    free, numbers = len(z), np.eye(len(walker.p))
    found = step_tangents(walker, z, numbers[[H_AHEAD, H_BEHIND]], tolerance)
    heights = np.array([[-1.0, 0.0], [-1.0, 1.0]])  # of h_ahead and h_behind by those under stance and trailing foot
    state, measures = np.zeros((free + 2, free + 2)), np.zeros((MEASURES, free + 2))
    state[:free] = np.hstack([found.by_start, found.along @ heights])
    state[free + 1, free] = 1.0
    landing = np.concatenate([found.along[:, 0], [1.0, 0.0]])
    measures[DURATION] = np.concatenate([found.time_by_start, found.time_along @ heights])
    # The step's length is that between both feet just after it, where the foot ahead stands on the block landed on.
    after = walker.exchanged
    along = np.zeros((free + 1, len(walker.p)))
    along[free, H_BEHIND] = 1.0
    lengths = step_length_change(after, *moved_state(after, found.z, np.eye(free, free + 1), along), along)
    measures[LENGTH] = lengths[:free] @ state[:free]
    measures[LENGTH, free] += lengths[free]
    by_landing = np.array([found.time_along[0], lengths[:free] @ landing[:free] - lengths[free]])
    return (state, landing, measures, by_landing), found.z


def spreads(walker: Walker, z: Vector, steps: int, tolerance: float) -> Vector:
    """Spreads (2 + j,) of duration, length and section coordinates of the steps of a stable gait at `z`, dimensionless.

    By the rms height of blocks, the root of their mean variance over the `steps` of its cycle.

    Raises StepFailed like `poincare_map`.
    """
    from scipy.linalg import solve_discrete_lyapunov

    taken, free = [], len(z)
    tolerance = attainable_tolerance(walker.p, tolerance)
    for _ in range(steps):
        step, z = step_on_blocks(walker, z, tolerance)
        taken.append(step)
        walker = walker.exchanged
    cycle, driven = np.eye(free + 2), np.zeros((free + 2, free + 2))
    for state, landing, _, _ in taken:
        cycle = state @ cycle
        driven = state @ driven @ state.T + np.outer(landing, landing)
    covariance = solve_discrete_lyapunov(cycle, driven)
    variances = np.zeros(MEASURES + free)
    for state, landing, measures, by_landing in taken:
        of_measures = measures @ covariance @ measures.T
        variances[:MEASURES] += np.diag(of_measures) + by_landing**2
        covariance = state @ covariance @ state.T + np.outer(landing, landing)
        variances[MEASURES:] += np.diag(covariance)[:free]
    return np.asarray(np.sqrt(variances / steps))


def on_blocks(walker: Walker, point: FixedPoint, tolerance: float) -> OnBlocks | None:
    """The spread of a gait's steps on blocks; None for an unstable gait, or a walker that has no answer on blocks."""
    if refusal(walker) or by_stability(point) >= 1.0:
        return None
    found = spreads(walker, point.z, len(point.steps), tolerance)
    norm = float(found[DURATION]) * walker.time / walker.length
    of_a_degree = math.radians(1.0) * step_length(walker, point) * walker.length
    return OnBlocks(norm, norm * of_a_degree, float(found[LENGTH]), found[MEASURES:])
