"""Basin of attraction: which starts lead to a gait and after how many steps, and how the other walks end."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from stages.analytic.compiled import compiled
from stages.analytic.gait.poincare import STEP_LIMIT_OF_A_PHASE, TIME_LIMIT_OF_A_PHASE
from stages.analytic.integration.phase import EVENT, FALL, TIME_LIMIT, walk_step
from stages.analytic.model.kinds import Kind
from stages.analytic.model.terms import exchanged
from stages.analytic.model.walker import Vector, Walker
from stages.analytic.phases.motion import shape
from stages.analytic.phases.section import section_coordinates, section_state
from stages.analytic.result import BACK, FORWARD, NO_START, OTHERWISE, REACHES, STILL, WALKS_ON, Basin

NONE = -1
#: A walk is at the gait within this, in all section coordinates; the integrator's tolerance.
NEAR, TOLERANCE = 1e-3, 1e-6


@compiled
def unlanded(status: int, y: Vector, p: Kind) -> int:
    """Why a step does not end at a heel strike with the hip between the feet; 0 if it does."""
    size, end = shape(p)
    if status == EVENT:
        if y[size // 4] >= 0.0:  # the trailing leg's angle: entry 1 of 4, or 2 of 8
            return BACK
        # a foot that is put down at a given time may be behind the other one, and the hip ahead of both
        return FORWARD if end < np.inf and y[0] + y[1] >= 0.0 else REACHES
    if status == TIME_LIMIT:
        return STILL
    if status == FALL:
        return FORWARD if y[0] > 0.0 else BACK
    return OTHERWISE


@compiled
def walk_starts(
    starts: np.ndarray, p: Kind, gait: Vector, gait_steps: int, steps: int, made: Vector, ending: Vector
) -> None:
    """Walk every start (n, j) up to `steps` steps; a walk ends early within `NEAR` of the `gait` (j,).

    It is compared with the gait after every `gait_steps` steps.
    """
    for i in range(starts.shape[0]):
        standing = p
        y = section_state(starts[i], p)
        made[i], ending[i] = 0, WALKS_ON
        if not np.isfinite(y).all():
            ending[i] = NO_START
            continue
        for _ in range(steps):
            status, _, _, _, _ = walk_step(y, standing, TOLERANCE, TIME_LIMIT_OF_A_PHASE, STEP_LIMIT_OF_A_PHASE, None)
            why = unlanded(status, y, p)
            if why != REACHES:
                ending[i] = why
                break
            made[i] += 1
            standing = exchanged(standing)
            if made[i] % gait_steps == 0 and np.abs(section_coordinates(y, standing) - gait).max() < NEAR:
                ending[i] = REACHES
                break


def basin_of_attraction(
    walker: Walker,
    gait: Vector,
    angles: np.ndarray,
    rates: np.ndarray,
    *,
    steps: int,
    workers: int = 1,
    progress: Callable[[float], None] = lambda share: None,
) -> Basin:
    """Walk from a grid over stance angle [rad], foot ahead positive, and rate [rad/s]; all else as in the gait.

    The `gait` should be a stable one, else a walk that passes it ends there. The result does not depend on `workers`.
    """
    grid = np.repeat(gait[None, :], angles.size * rates.size, axis=0)
    rate = walker.rate_entry
    grid[:, 0] = -np.repeat(angles, rates.size)
    grid[:, rate] = np.tile(rates, angles.size) * walker.time
    kept = np.zeros((2, len(grid)), dtype=np.int64)
    # Interleaved shares: neighbours take about the same time, so every share is equally long.
    shares = [np.arange(start, len(grid), 64) for start in range(min(64, len(grid)))]

    def work(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        found = np.zeros((2, rows.size), dtype=np.int64)
        walk_starts(grid[rows], walker.p, gait, walker.gait_steps, steps, *found)
        return rows, found

    with ThreadPoolExecutor(workers) as pool:  # the compiled function lets go of the interpreter lock
        for done, (rows, found) in enumerate(pool.map(work, shares), 1):
            kept[:, rows] = found
            progress(done / len(shares))
    made, ending = kept.reshape(2, angles.size, rates.size)
    reached = np.where(ending == REACHES, 0, NONE)
    return Basin(angles, rates, made, reached, ending, float(-gait[0]), float(gait[rate] / walker.time), steps, NEAR)
