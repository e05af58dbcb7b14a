"""Integrates rigid legs whose feet are put down at a given time of the step: that event has a time, not a state."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from stages.analytic.compiled import ByKind, compiled, extend
from stages.analytic.integration.integrator import STAGES, error_norm, step_factor, take_step
from stages.analytic.integration.phase import (
    EVENT,
    SMALLEST_STEP,
    STEP_FLOOR,
    STEP_LIMIT,
    TIME_LIMIT,
    copy,
    failure,
    integrate,
    store_node,
)
from stages.analytic.model.kinds import TimedRigid
from stages.analytic.model.varied import VariedTimed, keep_delay, plain
from stages.analytic.model.walker import Vector
from stages.analytic.phases.flow import flow


@compiled
def keep_time(y: Vector, p: TimedRigid, rates: Vector) -> None:
    """`shift_to_time` of a walker whose numbers do not vary."""


@compiled
def shift_by_time(y: Vector, p: VariedTimed, rates: Vector) -> None:
    """`shift_to_time` where the time of the step may change with the others of the walker's numbers."""
    first = y.size - 4 * p.along.shape[0]
    for row in range(p.along.shape[0]):
        start, later = first + 4 * row, p.along[row, p.along.shape[1] - 1]
        keep_delay(p, start, later)
        for i in range(4):
            y[start + i] += rates[i] * later


#: Variations at a fixed time become variations at the end of the step, in `y`: shift_to_time(y, p, rates).
shift_to_time: Callable[..., None] = ByKind({TimedRigid: keep_time, VariedTimed: shift_by_time})


@compiled
def integrate_timed(
    phase: int, y: Vector, p: TimedRigid | VariedTimed, tolerance: float, time_limit: float, step_limit: int, h: float,
    nodes: np.ndarray,
) -> tuple[int, float, float, int, int]:  # fmt: skip
    """`integrate` up to the time of the step, at which the last integration step ends."""
    size, count, time, evaluations, end = y.size, 0, 0.0, 1, plain(p).T
    stages, new = np.empty((STAGES, size)), np.empty(size)
    flow(phase, y, p, stages[0])
    if end > time_limit:
        return TIME_LIMIT, time, h, count, evaluations
    for _ in range(step_limit):
        if h < SMALLEST_STEP:
            return STEP_FLOOR, time, h, count, evaluations
        last = h >= end - time
        length = end - time if last else h
        evaluations += take_step(phase, y, length, p, stages, new)
        error = error_norm(y, new, length, p, stages, tolerance)
        if not error <= 1.0:  # written so that NaN is refused
            h = length * (step_factor(error) if error == error else 0.1)
            continue
        count = store_node(nodes, count, time, phase, y, 4)
        time += length
        copy(new, y)
        flow(phase, y, p, stages[0])
        status = failure(phase, y, p)
        if status != EVENT:
            return status, time, h, count, evaluations
        if last:
            shift_to_time(y, p, stages[0])
            return EVENT, end, h, count, evaluations
        h *= step_factor(error)
    return STEP_LIMIT, time, h, count, evaluations


extend(integrate, {TimedRigid | VariedTimed: integrate_timed})
