"""Basin of attraction: which starts lead to which gait, and how many steps the others survive."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from stages.analytic.compiled import compiled
from stages.analytic.gait.poincare import STEP_LIMIT_OF_A_PHASE, TIME_LIMIT_OF_A_PHASE
from stages.analytic.integration.phase import EVENT
from stages.analytic.integration.step import walk_step
from stages.analytic.model.kinds import Kind
from stages.analytic.model.terms import exchanged
from stages.analytic.model.walker import Vector, Walker
from stages.analytic.phases.section import section_coordinates, section_state

NONE = -1


@dataclass(frozen=True)
class Basin:
    """Map over two section coordinates `first` (n,) and `second` (m,), dimensionless.

    `survived` (n, m): steps made, at most the number asked for. `reached` (n, m): index of the gait reached, or -1.
    """

    first: np.ndarray
    second: np.ndarray
    survived: np.ndarray
    reached: np.ndarray


@compiled
def walk_starts(
    starts: np.ndarray, p: Kind, gaits: np.ndarray, gait_steps: int, near: float, steps: int, tolerance: float,
    time_limit: float, step_limit: int, survived: Vector, reached: Vector,
) -> None:  # fmt: skip
    """Walk every start (n, j) up to `steps` steps; a walk ends early within `near` of a gait of `gaits` (g, j).

    It is compared with the gaits after every `gait_steps` steps.
    """
    for i in range(starts.shape[0]):
        standing = p
        y = section_state(starts[i], p)
        survived[i], reached[i] = 0, -1
        for _ in range(steps):
            if not np.isfinite(y).all():
                break
            status, _, _, _, _ = walk_step(y, standing, tolerance, time_limit, step_limit)
            if status != EVENT:
                break
            survived[i] += 1
            standing = exchanged(standing)
            if survived[i] % gait_steps != 0:
                continue
            z = section_coordinates(y, standing)
            for g in range(gaits.shape[0]):
                if np.abs(z - gaits[g]).max() < near:
                    reached[i] = g
                    survived[i] = steps
            if reached[i] >= 0:
                break


def basin_of_attraction(
    walker: Walker,
    gaits: list[Vector],
    coordinates: tuple[int, int],
    first: np.ndarray,
    second: np.ndarray,
    *,
    steps: int = 30,
    near: float = 1e-3,
    tolerance: float = 1e-6,
    workers: int = 1,
    progress: Callable[[float], None] = lambda share: None,
) -> Basin:
    """Walk from a grid over two section coordinates (indices into z), the others as in the first gait.

    A start that comes within `near` of a stable gait in all section coordinates is said to reach it; `gaits` should
    be stable ones, else a walk that passes an unstable gait ends there. The result does not depend on `workers`.
    """
    grid = np.repeat(np.asarray(gaits[0])[None, :], first.size * second.size, axis=0)
    grid[:, coordinates[0]] = np.repeat(first, second.size)
    grid[:, coordinates[1]] = np.tile(second, first.size)
    survived, reached = np.zeros(len(grid), dtype=np.int64), np.full(len(grid), NONE, dtype=np.int64)
    known = np.array(gaits)
    # Interleaved shares: neighbours take about the same time, so every share is equally long.
    shares = [np.arange(start, len(grid), 64) for start in range(min(64, len(grid)))]

    def work(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        made, where = np.zeros(rows.size, dtype=np.int64), np.full(rows.size, NONE, dtype=np.int64)
        walk_starts(grid[rows], walker.p, known, walker.gait_steps, near, steps, tolerance,
                    TIME_LIMIT_OF_A_PHASE, STEP_LIMIT_OF_A_PHASE, made, where)
        return rows, made, where

    with ThreadPoolExecutor(workers) as pool:  # the compiled function lets go of the interpreter lock
        for done, (rows, made, where) in enumerate(pool.map(work, shares), 1):
            survived[rows], reached[rows] = made, where
            progress(done / len(shares))
    shape = (first.size, second.size)
    return Basin(first, second, survived.reshape(shape), reached.reshape(shape))
