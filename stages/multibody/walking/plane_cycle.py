"""The penalty model's cycle from a few steps of walking: its fixed point, hip motion and two largest multipliers.

Of the multipliers at mid-stance only two are far from zero, so a walker near its cycle moves in a plane after one step:
differences of successive states obey u_{k+1} = D u_k there, which gives D on that plane and with it the fixed point.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from stages.multibody.walking.section import SCALES, NoLimitCycle, SectionStep

#: Times the fixed point is extrapolated until it is given up, and steps of walking before the first time.
ROUNDS, STEPS = 10, 3
#: Swing angle and its rate among the section's numbers.
SWING = [1, 7]


@dataclass(frozen=True)
class PlaneCycle:
    """Fixed point in the section's scales (10,), its residual, the step on it, a direction in the plane (10,)."""

    state: np.ndarray
    residual: float
    step: SectionStep
    direction: np.ndarray


def plane_map(differences: list[np.ndarray]) -> np.ndarray:
    """The linear map D (j, j) on the span of the first two of three differences (j,), each D times the one before."""
    first, second, third = differences
    return np.asarray(np.column_stack([second, third]) @ np.linalg.pinv(np.column_stack([first, second])))


def find_cycle(
    walk: Callable[[np.ndarray], SectionStep],
    guess: np.ndarray,
    residual: float,
    away: float,
    derivative: np.ndarray | None = None,
) -> PlaneCycle:
    """The cycle near `guess`; `walk` takes a step from section numbers (10,). Raises NoLimitCycle.

    `guess` and the result are in `SCALES`. The search starts `away` from the guess in the swing leg: a walker on its
    cycle would show no differences. `derivative` is D (10, 10) of a similar model; without it one step more shows it.
    """

    def follow(state: np.ndarray, steps: int) -> list[np.ndarray]:
        states = [state]
        for _ in range(steps):
            states.append(walk(states[-1] * SCALES).numbers / SCALES)
        return states

    start = guess.copy()
    start[SWING] += away
    states = follow(start, STEPS)
    moves = [later - earlier for earlier, later in pairwise(states[1:])]
    direction = moves[-1]
    if derivative is None:
        derivative = plane_map([*moves, walk(states[-1] * SCALES).numbers / SCALES - states[-1]])
    for _ in range(ROUNDS):
        move = states[-1] - states[-2]
        state = states[-1] + derivative @ np.linalg.solve(np.eye(guess.size) - derivative, move)
        step = walk(state * SCALES)
        after = step.numbers / SCALES
        change = float(np.abs(after - state).max())
        if change < residual:
            return PlaneCycle(state, change, step, direction)
        states = [after, *follow(after, 1)[1:]]
    raise NoLimitCycle(f"no fixed point within {ROUNDS} extrapolations, residual {change:.1e}")


def plane_multipliers(
    walk: Callable[[np.ndarray], SectionStep], cycle: PlaneCycle, size: float
) -> tuple[np.ndarray, np.ndarray]:
    """Real parts of the two largest multipliers, larger first, and D (10, 10), by walking from both sides of a cycle.

    Half the difference of both walks, begun `size` away, is free of the second order.
    """
    sides = []
    for sign in (1.0, -1.0):
        states = [cycle.state + sign * size * cycle.direction / np.abs(cycle.direction).max()]
        for _ in range(2):
            states.append(walk(states[-1] * SCALES).numbers / SCALES)
        sides.append(states)
    moves = [0.5 * (ahead - behind) for ahead, behind in zip(*sides)]
    derivative = plane_map(moves)
    values = np.linalg.eigvals(derivative)
    two = values[np.argsort(-np.abs(values))[:2]].real
    return np.asarray(np.sort(two)[::-1]), derivative
