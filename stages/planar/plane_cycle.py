"""The penalty model's cycle from a few steps of walking.

Of the multipliers at mid-stance only two are far from zero, so a walker near its cycle comes into a plane after one
step: there the differences of successive states obey u_{k+1} = D u_k, which tells where they lead. D is nearly the same
for similar contact laws and is measured once, from two walkers on opposite sides of a guess.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from stages.planar.section import SCALES, NoLimitCycle, SectionStep

#: Times the fixed point is extrapolated until it is given up.
ROUNDS = 10
#: Swing angle and its rate among the section's numbers.
SWING = [1, 7]


@dataclass(frozen=True)
class PlaneCycle:
    """Fixed point in the section's scales (10,), its residual, and the step on it."""

    state: np.ndarray
    residual: float
    step: SectionStep


def plane_map(differences: list[np.ndarray]) -> np.ndarray:
    """The linear map D (j, j) on the span of the first two of three differences (j,), each D times the one before."""
    first, second, third = differences
    return np.asarray(np.column_stack([second, third]) @ np.linalg.pinv(np.column_stack([first, second])))


def follow(walk: Callable[[np.ndarray], SectionStep], state: np.ndarray, steps: int) -> list[np.ndarray]:
    """The states (10,) after each of so many steps, in `SCALES`."""
    states = [state]
    for _ in range(steps):
        states.append(walk(states[-1] * SCALES).numbers / SCALES)
    return states[1:]


def step_derivative(walk: Callable[[np.ndarray], SectionStep], guess: np.ndarray, size: float) -> np.ndarray:
    """D (10, 10) from half the difference of two walks, begun `size` away in the swing leg.

    So it is free of the second order, and after the first step of all that is not in the plane.
    """
    away = np.zeros(guess.size)
    away[SWING] = size
    sides = [follow(walk, guess + sign * away, 3) for sign in (1.0, -1.0)]
    return plane_map([0.5 * (ahead - behind) for ahead, behind in zip(*sides)])


def find_cycle(
    walk: Callable[[np.ndarray], SectionStep], guess: np.ndarray, residual: float, derivative: np.ndarray
) -> PlaneCycle:
    """The cycle near `guess`; `walk` takes a step from section numbers (10,). Raises NoLimitCycle.

    `guess` and the result are in `SCALES`; `derivative` is D (10, 10).
    """
    before, after = follow(walk, guess, 2)
    for _ in range(ROUNDS):
        state = after + derivative @ np.linalg.solve(np.eye(guess.size) - derivative, after - before)
        step = walk(state * SCALES)
        before, after = state, step.numbers / SCALES
        change = float(np.abs(after - before).max())
        if change < residual:
            return PlaneCycle(state, change, step)
    raise NoLimitCycle(f"no fixed point within {ROUNDS} extrapolations, residual {change:.1e}")
