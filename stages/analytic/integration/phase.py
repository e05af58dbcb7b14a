"""Integrates one phase to its event, which is located to the integrator's own accuracy.

An event is found by taking the last step again with a shorter length until the guard is zero, so its state
carries the error of the integrator's step and no interpolant comes in.
"""

from __future__ import annotations

from collections.abc import Callable
from math import cos

import numpy as np

from stages.analytic.compiled import ByKind, compiled, inlined
from stages.analytic.integration.integrator import STAGES, error_norm, step_factor, take_step
from stages.analytic.model.kinds import (
    Compliant,
    DetailedCompliant,
    Kind,
    Limited,
    PlainCompliant,
    Rigid,
    Rolling,
    Smooth,
)
from stages.analytic.model.varied import Varied, VariedCompliant, VariedRigidLegs, VariedSmooth, keep_delay
from stages.analytic.model.walker import Vector
from stages.analytic.phases.coulomb_guard import wedges
from stages.analytic.phases.flow import DOUBLE_STANCE, HOVERING, SLIDING_FORWARD, flow
from stages.analytic.phases.guards import guard
from stages.analytic.phases.transitions import hidden_crossing

EVENT, FALL, TIME_LIMIT, STEP_FLOOR, STEP_LIMIT, BOTTOMED, WEDGED, CHATTER = 0, 1, 2, 3, 4, 5, 6, 7

#: Cosine of the stance angle below which the walker has fallen.
FALLEN = 0.3
SMALLEST_STEP = 1e-14
GUARD_STEP = 1e-7
#: A sliding or hovering phase may start where its guard is zero up to round-off, and be short: its first step is at
#: most this long, so that what the guard does first is seen.
GUARD_FLOOR, FIRST_STEP = 1e-12, 1e-5
#: For a phase of which no steps are kept.
NO_NODES = np.empty((0, 10))


@compiled
def rigid_failure(phase: int, y: Vector, p: Rigid) -> int:
    """`failure` of rigid legs."""
    return FALL if not (cos(y[0]) > FALLEN) or abs(y[1]) > 3.0 else EVENT


@compiled
def equal_legs_bottomed(y: Vector, p: PlainCompliant) -> bool:
    """`is_bottomed` of equal legs."""
    return bool(min(y[1], y[3]) <= max(p.r, p.l))


@compiled
def detailed_legs_bottomed(y: Vector, p: DetailedCompliant) -> bool:
    """`is_bottomed` of legs that may differ."""
    return bool(y[1] <= max(p.r, p.l) or y[3] <= max(p.r_2, p.l_2))


#: Whether a leg is pressed down to its foot or its mass: is_bottomed(y, p).
is_bottomed: Callable[..., bool] = ByKind({
    PlainCompliant: equal_legs_bottomed, DetailedCompliant: detailed_legs_bottomed})


@inlined
def rolling_failure(phase: int, y: Vector, p: Compliant) -> int:
    """`failure` of compliant legs whose feet roll."""
    if not (cos(y[0]) > FALLEN) or abs(y[2]) > 3.0:
        return FALL
    return BOTTOMED if is_bottomed(y, p) else EVENT


@compiled
def limited_failure(phase: int, y: Vector, p: Limited) -> int:
    """`failure` with limited friction: it may wedge a sliding foot."""
    status = rolling_failure(phase, y, p)
    if status == EVENT and DOUBLE_STANCE < phase < HOVERING:
        return WEDGED if wedges(y, p, -p.mu_d if phase == SLIDING_FORWARD else p.mu_d) else EVENT
    return status


@compiled
def four(p: Kind) -> int:
    """`state_size` of rigid legs."""
    return 4


@compiled
def eight(p: Kind) -> int:
    """`state_size` of compliant legs."""
    return 8


#: Length of a state and of each of its variations: state_size(p).
state_size: Callable[..., int] = ByKind({Rigid | VariedRigidLegs: four, Compliant | VariedCompliant: eight})
#: The status that ends a phase before its event, or EVENT if nothing does: failure(phase, y, p).
failure: Callable[..., int] = ByKind({Rigid: rigid_failure, Rolling: rolling_failure, Limited: limited_failure})


@inlined
def copy(source: Vector, target: Vector) -> None:
    """Copy entry by entry: slices bring numba's checks of shapes, and the strings for their errors, into the code."""
    for i in range(source.size):
        target[i] = source[i]


@inlined
def store_node(nodes: np.ndarray, count: int, time: float, phase: int, y: Vector, size: int) -> int:
    """Keep the start of an accepted step as (time, phase, state of this size) while there is room; the nodes filled."""
    if count == nodes.shape[0]:
        return count
    nodes[count, 0], nodes[count, 1] = time, phase
    for i in range(size):
        nodes[count, 2 + i] = y[i]
    return count + 1


@inlined
def falling_root(g0: float, d0: float, g1: float, d1: float) -> float:
    """Where in [0, 1] the cubic with values g0 > 0 >= g1 and slopes d0, d1 at the ends falls through zero."""
    low, high = 0.0, 1.0
    s = g0 / (g0 - g1)
    for _ in range(8):
        a, b = g1 - g0 - d0, d1 - d0
        c3 = b - 2.0 * a
        c2 = a - c3
        value = g0 + s * (d0 + s * (c2 + s * c3))
        slope = d0 + s * (2.0 * c2 + 3.0 * s * c3)
        if value > 0.0:
            low = s
        else:
            high = s
        following = s - value / slope if slope < 0.0 else 0.5 * (low + high)
        s = following if low <= following <= high else 0.5 * (low + high)
    return s


@inlined
def locate(
    phase: int, y: Vector, h: float, g0: float, d0: float, g1: float, d1: float, p: Kind | Varied,
    stages: np.ndarray, event: Vector, rates: Vector,
) -> float:  # fmt: skip
    """Shorten the step from `y` until the guard is zero at its end; returns the length of that step.

    Leaves the state there in `event` and its rates in `rates`.

    Newton's method inside a shrinking bracket, until a correction is lost in round-off.
    """
    low, high = 0.0, h
    length = h * falling_root(g0, h * d0, g1, h * d1)
    last = h
    for _ in range(60):
        take_step(phase, y, length, p, stages, event)
        flow(phase, event, p, rates)
        value, rate, _ = guard(phase, event, p, rates, 0)
        if value > 0.0:
            low = length
        else:
            high = length
        change = -value / rate if rate < 0.0 else h
        following = length + change
        if not low <= following <= high:
            following = 0.5 * (low + high)
        change = abs(following - length)
        if change <= 1e-16 + 4e-16 * h or (change <= 1e-12 and change >= 0.25 * last):
            break
        length, last = following, change
    return length


@inlined
def shift_to_event(
    phase: int, y: Vector, p: Kind | Varied, event: Vector, event_rates: Vector, rate: float
) -> None:  # fmt: skip
    """Variations at fixed time become variations at the event, in `y`; `rate` is that of the guard there."""
    base = state_size(p)
    for start in range(base, y.size, base):
        delay = -guard(phase, event, p, event, start)[1] / rate
        keep_delay(p, start, delay)
        for i in range(base):
            y[start + i] += event_rates[i] * delay


@compiled
def integrate_smooth(
    phase: int, y: Vector, p: Kind, tolerance: float, time_limit: float, step_limit: int, h: float, nodes: np.ndarray
) -> tuple[int, float, float, int, int]:  # fmt: skip
    """Integrate `y` in place to the event of the phase.

    Returns (status, duration, last step size, nodes filled, evaluations). Each accepted step start is recorded as
    (duration, phase, state) in `nodes` while there is room.
    """
    size, base, count = y.size, state_size(p), 0
    stages, new, rates = np.empty((STAGES, size)), np.empty(size), np.empty(size)
    event, event_rates = np.empty(size), np.empty(size)
    time, evaluations = 0.0, 1
    flow(phase, y, p, stages[0])
    g0, d0, armed0 = guard(phase, y, p, stages[0], 0)
    rejected = False
    if phase == DOUBLE_STANCE and (g0 < 0.0 or (g0 == 0.0 and d0 < 0.0)):
        return EVENT, 0.0, h, count, evaluations
    leaving = phase > DOUBLE_STANCE and abs(g0) <= GUARD_FLOOR
    if phase > DOUBLE_STANCE:
        h = min(h, FIRST_STEP)
        g0 = 0.0 if leaving else g0
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
        if armed and h > GUARD_STEP and hidden_crossing(g0, d0, g1, d1, h):
            h *= 0.5
            continue
        if leaving and g1 < -GUARD_FLOOR:  # it rises and falls within the step: shorten it, to see the fall apart
            if h <= GUARD_STEP:
                return EVENT, time, h, count, evaluations
            h *= 0.25
            continue
        leaving = leaving and g1 <= GUARD_FLOOR
        count = store_node(nodes, count, time, phase, y, base)
        if g0 > 0.0 and g1 <= 0.0 and (armed or armed0):
            length = locate(phase, y, h, g0, d0, g1, d1, p, stages, event, event_rates)
            _, rate, over = guard(phase, event, p, event_rates, 0)
            if over:
                copy(event, y)
                shift_to_event(phase, y, p, event, event_rates, rate)
                return EVENT, time + length, h, count, evaluations
        time += h
        copy(new, y)
        copy(rates, stages[0])
        g0, d0, armed0 = 0.0 if leaving else g1, d1, armed
        status = failure(phase, y, p)
        if status != EVENT:
            return status, time, h, count, evaluations
        if time > time_limit:
            return TIME_LIMIT, time, h, count, evaluations
        h *= min(1.0, step_factor(error)) if rejected else step_factor(error)
        rejected = False
    return STEP_LIMIT, time, h, count, evaluations


#: Integrate `y` in place to the event of the phase: integrate(phase, y, p, tolerance, time_limit, step_limit, h, nodes)
#: as `integrate_smooth` says. Friction at the hip has its own, `rubbing`.
integrate: Callable[..., tuple[int, float, float, int, int]] = ByKind({Smooth | VariedSmooth: integrate_smooth})
