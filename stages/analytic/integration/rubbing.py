"""Integrates phases that end otherwise: where a hip that rubs or sticks turns, or at a given time of the step."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from stages.analytic.compiled import ByKind, compiled, extend
from stages.analytic.integration.integrator import STAGES, error_norm, step_factor, take_step
from stages.analytic.integration.phase import (
    EVENT,
    GUARD_STEP,
    SMALLEST_STEP,
    STEP_FLOOR,
    STEP_LIMIT,
    TIME_LIMIT,
    copy,
    failure,
    integrate,
    locate,
    shift_to_event,
    state_size,
    store_node,
)
from stages.analytic.model.kinds import RubbingRigid, RubbingRolling, TimedRigid
from stages.analytic.model.varied import VariedRubbing, VariedRubbingRolling, VariedTimed, keep_delay, plain
from stages.analytic.model.walker import Vector
from stages.analytic.phases.flow import HIP_STICKS, flow
from stages.analytic.phases.guards import guard
from stages.analytic.phases.hip_friction import AT_REST, hip_guard, hip_rate, sign_of
from stages.analytic.phases.transitions import hidden_crossing

Rubbing = RubbingRigid | RubbingRolling | VariedRubbing | VariedRubbingRolling


@compiled
def located_turn(phase: int, y: Vector, h: float, p: Rubbing, stages: np.ndarray, event: Vector) -> float:
    """Length of the step from `y` after which the hip's guard is zero, by false position with bisections."""
    low, high, numbers = 0.0, h, plain(p)
    g_low, g_high = max(hip_guard(phase, y, numbers), 0.0), -1.0
    take_step(phase, y, h, p, stages, event)
    g_high = hip_guard(phase, event, numbers)
    length = h
    for turn in range(100):
        length = 0.5 * (low + high)
        if turn % 3 < 2 and g_low > 0.0:
            length = low + (high - low) * g_low / (g_low - g_high)
        take_step(phase, y, length, p, stages, event)
        g = hip_guard(phase, event, numbers)
        if g >= 0.0:
            low, g_low = length, g
        else:
            high, g_high = length, g
        if abs(g) <= 1e-16 or high - low <= 1e-16 + 4e-16 * h:
            break
    return length


@compiled
def cross_turn(phase: int, y: Vector, p: Rubbing) -> None:
    """Variations of a state at which a slipping hip stops, at the time of that event, in place."""
    base, numbers = state_size(p), plain(p)
    before = np.empty(base)
    flow(phase, y[:base].copy(), numbers, before)
    closing = hip_rate(before, 0, numbers)
    for start in range(base, y.size, base):
        delay = -hip_rate(y, start, numbers) / closing
        keep_delay(p, start, delay)
        for i in range(base):
            y[start + i] += before[i] * delay


@compiled
def integrate_rubbing(
    phase: int, y: Vector, p: Rubbing, tolerance: float, time_limit: float, step_limit: int, h: float,
    nodes: np.ndarray,
) -> tuple[int, float, float, int, int]:  # fmt: skip
    """`integrate` with friction at the hip.

    Where a hip that sticks lets go the rates do not jump, and variations need no shift to that event.
    """
    size, count, time, evaluations, rejected, numbers = y.size, 0, 0.0, 1, False, plain(p)
    base = state_size(p)
    stages, new, rates = np.empty((STAGES, size)), np.empty(size), np.empty(size)
    event, event_rates = np.empty(size), np.empty(size)
    flow(phase, y, p, stages[0])
    g0, d0, armed0 = guard(phase, y, p, stages[0], 0)
    if phase > HIP_STICKS and (g0 < 0.0 or (g0 == 0.0 and d0 < 0.0)):  # the trailing foot leaves at once
        return EVENT, 0.0, h, count, evaluations
    for _ in range(step_limit):
        if h < SMALLEST_STEP:
            return STEP_FLOOR, time, h, count, evaluations
        evaluations += take_step(phase, y, h, p, stages, new)
        error = error_norm(y, new, h, p, stages, tolerance)
        if not error <= 1.0:  # written so that NaN is refused
            h *= step_factor(error) if error == error else 0.1
            rejected = True
            continue
        flow(phase, new, p, rates)
        g1, d1, armed = guard(phase, new, p, rates, 0)
        hip0, hip1, sign = hip_guard(phase, y, numbers), hip_guard(phase, new, numbers), sign_of(phase)
        slope0, slope1 = sign * hip_rate(stages[0], 0, numbers), sign * hip_rate(rates, 0, numbers)
        unseen = sign != 0 and hidden_crossing(max(hip0, 0.0), slope0, hip1, slope1, h)
        if h > GUARD_STEP and (unseen or (armed and hidden_crossing(g0, d0, g1, d1, h))):
            h *= 0.5
            continue
        count = store_node(nodes, count, time, phase, y, base)
        turn = located_turn(phase, y, h, p, stages, event) if hip1 < -AT_REST else 2.0 * h
        if g0 > 0.0 and g1 <= 0.0 and (armed or armed0):
            length = locate(phase, y, h, g0, d0, g1, d1, p, stages, event, event_rates)
            _, rate, over = guard(phase, event, p, event_rates, 0)
            if over and length < turn:
                copy(event, y)
                shift_to_event(phase, y, p, event, event_rates, rate)
                return EVENT, time + length, h, count, evaluations
        if turn <= h:
            take_step(phase, y, turn, p, stages, event)
            copy(event, y)
            if sign != 0:
                cross_turn(phase, y, p)
            return EVENT, time + turn, h, count, evaluations
        time += h
        copy(new, y)
        copy(rates, stages[0])
        g0, d0, armed0 = g1, d1, armed
        status = failure(phase, y, p)
        if status != EVENT:
            return status, time, h, count, evaluations
        if time > time_limit:
            return TIME_LIMIT, time, h, count, evaluations
        h *= min(1.0, step_factor(error)) if rejected else step_factor(error)
        rejected = False
    return STEP_LIMIT, time, h, count, evaluations


extend(integrate, {Rubbing: integrate_rubbing})


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
