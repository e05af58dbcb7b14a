"""Basin of attraction: which starts lead to which gait and after how many steps, and how the other walks end."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from stages.analytic.compiled import compiled
from stages.analytic.gait.poincare import STEP_LIMIT_OF_A_PHASE, TIME_LIMIT_OF_A_PHASE
from stages.analytic.integration.phase import EVENT, FALL, TIME_LIMIT, walk_step
from stages.analytic.model.kinds import Kind
from stages.analytic.model.terms import exchanged
from stages.analytic.model.walker import Vector, Walker
from stages.analytic.phases.section import section_coordinates, section_state
from stages.analytic.result import BACK, FORWARD, NO_START, OTHERWISE, REACHES, STILL, WALKS_ON, Basin

NONE = -1


@compiled
def unlanded(status: int, y: Vector) -> int:
    """Why a step does not end at a heel strike with the hip between the feet; 0 if it does."""
    if status == EVENT:
        return BACK if y[y.size // 4] >= 0.0 else REACHES  # the trailing leg's angle: entry 1 of 4, or 2 of 8
    if status == TIME_LIMIT:
        return STILL
    if status == FALL:
        return FORWARD if y[0] > 0.0 else BACK
    return OTHERWISE


@compiled
def walk_starts(
    starts: np.ndarray, p: Kind, gaits: np.ndarray, gait_steps: int, near: float, steps: int, tolerance: float,
    time_limit: float, step_limit: int, made: Vector, reached: Vector, ending: Vector,
) -> None:  # fmt: skip
    """Walk every start (n, j) up to `steps` steps; a walk ends early within `near` of a gait of `gaits` (g, j).

    It is compared with the gaits after every `gait_steps` steps.
    """
    for i in range(starts.shape[0]):
        standing = p
        y = section_state(starts[i], p)
        made[i], reached[i], ending[i] = 0, NONE, WALKS_ON
        if not np.isfinite(y).all():
            ending[i] = NO_START
            continue
        for _ in range(steps):
            status, _, _, _, _ = walk_step(y, standing, tolerance, time_limit, step_limit, None)
            why = unlanded(status, y)
            if why != REACHES:
                ending[i] = why
                break
            made[i] += 1
            standing = exchanged(standing)
            if made[i] % gait_steps != 0:
                continue
            z = section_coordinates(y, standing)
            for g in range(gaits.shape[0]):
                if np.abs(z - gaits[g]).max() < near:
                    reached[i], ending[i] = g, REACHES
            if reached[i] >= 0:
                break


def basin_of_attraction(
    walker: Walker,
    gaits: list[Vector],
    angles: np.ndarray,
    rates: np.ndarray,
    *,
    steps: int = 30,
    near: float = 1e-3,
    tolerance: float = 1e-6,
    workers: int = 1,
    progress: Callable[[float], None] = lambda share: None,
) -> Basin:
    """Walk from a grid over stance angle [rad], foot ahead positive, and rate [rad/s]; all else as in the first gait.

    A start that comes within `near` of a stable gait in all section coordinates is said to reach it; `gaits` should
    be stable ones, else a walk that passes an unstable gait ends there. The result does not depend on `workers`.
    """
    grid = np.repeat(np.asarray(gaits[0])[None, :], angles.size * rates.size, axis=0)
    rate = walker.rate_entry
    grid[:, 0] = -np.repeat(angles, rates.size)
    grid[:, rate] = np.tile(rates, angles.size) * walker.time
    kept = np.zeros((3, len(grid)), dtype=np.int64)
    known = np.array(gaits)
    # Interleaved shares: neighbours take about the same time, so every share is equally long.
    shares = [np.arange(start, len(grid), 64) for start in range(min(64, len(grid)))]

    def work(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        found = np.zeros((3, rows.size), dtype=np.int64)
        walk_starts(grid[rows], walker.p, known, walker.gait_steps, near, steps, tolerance,
                    TIME_LIMIT_OF_A_PHASE, STEP_LIMIT_OF_A_PHASE, *found)
        return rows, found

    with ThreadPoolExecutor(workers) as pool:  # the compiled function lets go of the interpreter lock
        for done, (rows, found) in enumerate(pool.map(work, shares), 1):
            kept[:, rows] = found
            progress(done / len(shares))
    made, reached, ending = kept.reshape(3, angles.size, rates.size)
    gait = gaits[0]
    return Basin(angles, rates, made, reached, ending, float(-gait[0]), float(gait[rate] / walker.time), steps, near)
