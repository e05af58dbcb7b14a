"""Integrates the phases of a step, each to its event, which is located to the integrator's own accuracy.

A phase is watched by its guards, that of the feet and that of a hip that rubs or sticks; the first that falls through
zero ends it, or the time at which a foot is put down. An event is found by taking the last step again with a shorter
length until the guard is zero, so its state carries the error of the integrator's step and no interpolant comes in.
"""

from collections.abc import Callable
from math import cos

import numpy as np

from stages.analytic.compiled import ByKind, compiled, inlined, uncounted
from stages.analytic.integration.integrator import STAGES, error_norm, step_factor, take_step
from stages.analytic.model import terms as eq
from stages.analytic.model.kinds import T_END, Compliant, Directions, Kind, Rigid
from stages.analytic.model.walker import Vector
from stages.analytic.phases.guards import guard, wedges
from stages.analytic.phases.motion import (
    DOUBLE_STANCE,
    HIP_STICKS,
    HOVERING,
    PHASES,
    RUBS_FORWARD,
    SLIDE,
    flow,
    in_contact,
    shape,
)
from stages.analytic.phases.succession import ends_step, first_phase, succeed

EVENT, FALL, TIME_LIMIT, STEP_FLOOR, STEP_LIMIT, BOTTOMED, WEDGED, CHATTER = 0, 1, 2, 3, 4, 5, 6, 7

#: Cosine of the stance angle below which the walker has fallen.
FALLEN = 0.3
SMALLEST_STEP = 1e-14
GUARD_STEP = 1e-7
#: A phase may start where a guard is zero up to round-off, as sliding, hovering and rubbing do, and be short: what the
#: guard does first is looked for; sliding's and hovering's first step is at most this long.
GUARD_FLOOR, FIRST_STEP = 1e-12, 1e-5
#: Below this a guard, which is of order one, is round-off.
ROUND_OFF = 1e-15
#: For a phase of which no steps are kept.
NO_NODES = np.empty((0, 10))
#: A trailing foot that changes between rolling, sliding and hovering more often than this does so without end.
MOST_PHASES = 100
#: Length of the first integration step of all, and the least one to begin a phase with.
FIRST_LENGTH, LEAST_LENGTH = 0.02, 1e-6
#: Evaluations a step may take in all its phases, for each integration step that one phase may take: some two phases'
#: worth, so that many phases that each creep do not add up to minutes.
MOST_EVALUATIONS = 24
#: Columns of what is known of each guard: value, rate, whether its fall is an event, whether it starts at zero.
VALUE, RATE, ARMED, LEAVING = 0, 1, 2, 3


@compiled
def rigid_failure(phase: int, y: Vector, p: Rigid) -> int:
    """`failure` of rigid legs."""
    return FALL if not (cos(y[0]) > FALLEN) or abs(y[1]) > 3.0 else EVENT


@compiled
def compliant_failure(phase: int, y: Vector, p: Compliant) -> int:
    """`failure` of compliant legs: one is pressed down to its foot or its mass, or friction wedges a sliding foot."""
    if not (cos(y[0]) > FALLEN) or abs(y[2]) > 3.0:
        return FALL
    radius, _, height = eq.swing_leg(p)
    if y[1] <= max(p.r, p.l) or y[3] <= max(radius, height):
        return BOTTOMED
    if PHASES[phase, SLIDE] != 0 and wedges(y, p, -PHASES[phase, SLIDE] * p.mu_d):
        return WEDGED
    return EVENT


#: The status that ends a phase before its event, or EVENT if nothing does: failure(phase, y, p).
failure: Callable[..., int] = ByKind({Rigid: rigid_failure, Compliant: compliant_failure})


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


@compiled
def hidden_crossing(g0: float, d0: float, g1: float, d1: float, h: float) -> bool:
    """Whether the cubic through values g and rates d at both ends of a step crosses zero twice inside it."""
    if g0 * g1 <= 0.0:
        return False
    a = 6.0 * (g0 - g1) + 3.0 * h * (d0 + d1)
    b = 6.0 * (g1 - g0) - 2.0 * h * (2.0 * d0 + d1)
    c = h * d0
    discriminant = b * b - 4.0 * a * c
    if discriminant <= 0.0:
        return False
    root = np.sqrt(discriminant)
    for extremum in ((-b - root) / (2.0 * a), (-b + root) / (2.0 * a)) if a != 0.0 else (-c / b, -c / b):
        if 0.0 < extremum < 1.0:
            s = extremum
            value = (
                g0 * (1.0 + 2.0 * s) * (1.0 - s) ** 2
                + h * d0 * s * (1.0 - s) ** 2
                + g1 * s * s * (3.0 - 2.0 * s)
                - h * d1 * s * s * (1.0 - s)
            )
            if value * g0 < 0.0:
                return True
    return False


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
def look(phase: int, y: Vector, p: Kind, rates: Vector, count: int, rows: np.ndarray) -> None:
    """What the first `count` guards of a phase are at a state and its rates, into `rows`."""
    for which in range(count):
        value, rate, armed = guard(phase, y, p, rates, 0, None, which)
        rows[which, VALUE], rows[which, RATE], rows[which, ARMED] = value, rate, 1.0 if armed else 0.0


@inlined
def locate(
    phase: int, y: Vector, h: float, which: int, before: Vector, after: Vector, p: Kind, stages: np.ndarray,
    event: Vector, rates: Vector, directions: Directions | None,
) -> float:  # fmt: skip
    """Shorten the step from `y` until the guard is zero at its end; returns the length of that step.

    `before` and `after` are what it is at both ends of the whole step. Leaves the state there in `event` and its rates
    in `rates`. Newton's method inside a shrinking bracket, until a correction is lost in round-off: of the time, or of
    the guard, which can fall so slowly that it changes its sign back and forth between two times.
    """
    low, high = 0.0, h
    length = h * falling_root(before[VALUE], h * before[RATE], after[VALUE], h * after[RATE])
    last = h
    for _ in range(60):
        take_step(phase, y, length, p, stages, event, directions)
        flow(phase, event, p, rates, directions)
        value, rate, _ = guard(phase, event, p, rates, 0, None, which)
        if value > 0.0:
            low = length
        else:
            high = length
        change = -value / rate if rate < 0.0 else h
        following = length + change
        if not low <= following <= high:
            following = 0.5 * (low + high)
        change = abs(following - length)
        lost = change >= 0.25 * last and (change <= 1e-12 or abs(value) <= ROUND_OFF)
        if lost or change <= 1e-16 + 4e-16 * h:
            break
        length, last = following, change
    return length


@compiled
def keep_delay(directions: Directions | None, column: int, delay: float) -> None:
    """By how much a variation delays an event."""
    if directions is not None:
        directions.delays[column] += delay


@inlined
def shift_to_event(
    phase: int, y: Vector, p: Kind, event: Vector, rates: Vector, which: int, directions: Directions | None
) -> None:
    """Variations at fixed time become variations at the event of a guard, in `y`; `rates` are those there."""
    base, _ = shape(p)
    rate = guard(phase, event, p, rates, 0, None, which)[1]
    for start in range(base, y.size, base):
        delay = -guard(phase, event, p, event, start, directions, which)[1] / rate
        keep_delay(directions, start // base - 1, delay)
        for i in range(base):
            y[start + i] += rates[i] * delay


@compiled
def shift_to_time(y: Vector, rates: Vector, base: int, directions: Directions | None) -> None:
    """Variations at a fixed time become variations at the end of the step, whose time may move, in `y`."""
    if directions is not None:
        count = directions.rows.shape[0]
        for row in range(count):
            start, later = y.size - base * (count - row), directions.rows[row, T_END]
            directions.delays[start // base - 1] += later
            for i in range(base):
                y[start + i] += rates[i] * later


@inlined
def first_event(
    phase: int, y: Vector, h: float, count: int, before: np.ndarray, after: np.ndarray, p: Kind, stages: np.ndarray,
    event: Vector, rates: Vector, directions: Directions | None,
) -> tuple[int, float]:  # fmt: skip
    """Which guard falls through zero first in a step of length `h`, and after which time; -1 if none is an event.

    Leaves the state there in `event` and its rates in `rates`.
    """
    first, least, last = -1, h, -1
    for which in range(count):
        armed = before[which, ARMED] + after[which, ARMED] > 0.0
        if armed and before[which, VALUE] > 0.0 and after[which, VALUE] <= 0.0:
            length = locate(phase, y, h, which, before[which], after[which], p, stages, event, rates, directions)
            last = which
            if length <= least and guard(phase, event, p, rates, 0, None, which)[2]:
                first, least = which, length
    if first >= 0 and last != first:
        take_step(phase, y, least, p, stages, event, directions)
        flow(phase, event, p, rates, directions)
    return first, least


@inlined
def unseen(h: float, count: int, before: np.ndarray, after: np.ndarray) -> float:
    """Factor by which a step of length `h` is to be shortened, to see what its guards do inside it; 1 if they are seen.

    Two crossings in one step are not seen. Nor is a guard that starts at zero and rises and falls within the step: the
    fall is to be apart.
    """
    for which in range(count):
        g0, g1 = before[which], after[which]
        if g1[ARMED] > 0.0 and h > GUARD_STEP and hidden_crossing(g0[VALUE], g0[RATE], g1[VALUE], g1[RATE], h):
            return 0.5
        if g0[LEAVING] > 0.0 and g1[VALUE] < -GUARD_FLOOR:
            return 0.25
    return 1.0


@inlined
def begin(phase: int, count: int, rows: np.ndarray) -> bool:
    """Whether a trailing foot leaves the ground at once; else mark which guards start at zero."""
    falls = rows[0, VALUE] < 0.0 or (rows[0, VALUE] == 0.0 and rows[0, RATE] < 0.0)
    if falls and (phase == DOUBLE_STANCE or phase > HIP_STICKS):
        return True
    for which in range(0 if phase <= HOVERING else 1, count):
        if abs(rows[which, VALUE]) <= GUARD_FLOOR and phase > DOUBLE_STANCE:
            rows[which, VALUE], rows[which, LEAVING] = 0.0, 1.0
    return False


@inlined
def go_on(count: int, before: np.ndarray, after: np.ndarray) -> None:
    """What the guards are at the end of a step is what they are before the next."""
    for which in range(count):
        leaving = before[which, LEAVING] > 0.0 and after[which, VALUE] <= GUARD_FLOOR
        for column in (VALUE, RATE, ARMED):
            before[which, column] = after[which, column]
        before[which, LEAVING] = 1.0 if leaving else 0.0
        if leaving:
            before[which, VALUE] = 0.0


@compiled
def integrated(
    phase: int, y: Vector, p: Kind, tolerance: float, time_limit: float, step_limit: int, h: float, nodes: np.ndarray,
    directions: Directions | None, room: np.ndarray, guards: np.ndarray,
) -> tuple[int, float, float, int, int]:  # fmt: skip
    """`integrate`, in `room` (stages + 4, size) and with zeros (2, 2, 4) for the `guards`, which the caller holds."""
    (base, end), filled, time, evaluations, rejected = shape(p), 0, 0.0, 1, False
    y, stages, nodes, guards = uncounted(y), uncounted(room), uncounted(nodes), uncounted(guards)
    new, rates, event, event_rates = stages[STAGES], stages[STAGES + 1], stages[STAGES + 2], stages[STAGES + 3]
    before, after = guards[0], guards[1]
    count = 0 if end < np.inf else 2 if phase >= RUBS_FORWARD else 1
    flow(phase, y, p, stages[0], directions)
    look(phase, y, p, stages[0], count, before)
    if end < np.inf and end > time_limit:
        return TIME_LIMIT, time, h, filled, evaluations
    if begin(phase, count, before):
        return EVENT, time, h, filled, evaluations
    if DOUBLE_STANCE < phase <= HOVERING:
        h = min(h, FIRST_STEP)
    for _ in range(step_limit):
        if h < SMALLEST_STEP:
            return STEP_FLOOR, time, h, filled, evaluations
        last = h >= end - time
        step = end - time if last else h
        evaluations += take_step(phase, y, step, p, stages, new, directions)
        error = error_norm(y, new, step, p, stages, tolerance)
        if not error <= 1.0:  # written so that NaN is refused
            h = step * (step_factor(error) if error == error else 0.1)
            rejected = True
            continue
        flow(phase, new, p, rates, directions)
        look(phase, new, p, rates, count, after)
        factor = unseen(step, count, before, after)
        if factor < 1.0:
            if step <= GUARD_STEP:
                return EVENT, time, h, filled, evaluations
            h = step * factor
            continue
        filled = store_node(nodes, filled, time, phase, y, base)
        which, length = first_event(
            phase, y, step, count, before, after, p, stages, event, event_rates, directions)
        if which >= 0:
            copy(event, y)
            shift_to_event(phase, y, p, event, event_rates, which, directions)
            return EVENT, time + length, h, filled, evaluations
        time += step
        copy(new, y)
        copy(rates, stages[0])
        go_on(count, before, after)
        status = failure(phase, y, p)
        if status != EVENT:
            return status, time, h, filled, evaluations
        if last:
            shift_to_time(y, rates, base, directions)
            return EVENT, end, h, filled, evaluations
        if time > time_limit:
            return TIME_LIMIT, time, h, filled, evaluations
        h = step * (min(1.0, step_factor(error)) if rejected else step_factor(error))
        rejected = False
    return STEP_LIMIT, time, h, filled, evaluations


#: `integrated` of a kind of walker; further kinds bring their own (`extend`).
to_event: Callable[..., tuple[int, float, float, int, int]] = ByKind({Kind: integrated})


@inlined
def integrate(
    phase: int, y: Vector, p: Kind, tolerance: float, time_limit: float, step_limit: int, h: float, nodes: np.ndarray,
    directions: Directions | None = None,
) -> tuple[int, float, float, int, int]:  # fmt: skip
    """Integrate `y`, state and variations, in place to the event of the phase.

    Returns (status, duration, last step size, nodes filled, evaluations). Each accepted step start is recorded as
    (duration, phase, state) in `nodes` while there is room.
    """
    return to_event(phase, y, p, tolerance, time_limit, step_limit, h, nodes, directions,
                    np.empty((STAGES + 4, y.size)), np.zeros((2, 2, 4)))


@compiled
def walk_step(
    y: Vector, p: Kind, tolerance: float, time_limit: float, step_limit: int, directions: Directions | None = None
) -> tuple[int, int, float, float, int]:
    """Advance state and variations by one step, in place; compliant legs start in double stance.

    Returns (status, phase, double stance time, period, evaluations): `phase` is where it ended if the status is not
    EVENT.
    """
    double, time, evaluations, h, no_nodes = 0.0, 0.0, 0, FIRST_LENGTH, np.empty((0, 10))
    phase, decided = first_phase(y, p)
    for _ in range(MOST_PHASES):  # one call, no constants in it: each constant is compiled apart
        if not decided:
            return WEDGED, phase, double, time, evaluations
        status, duration, h, _, more = integrate(
            phase, y, p, tolerance, time_limit, step_limit, h, no_nodes, directions)
        time += duration
        evaluations += more
        if status != EVENT:
            return status, phase, double, time, evaluations
        if evaluations > MOST_EVALUATIONS * step_limit:
            return STEP_LIMIT, phase, double, time, evaluations
        if in_contact(phase):
            double = time
        ended, last = phase, ends_step(phase, y, p)
        phase, decided = succeed(phase, y, p, directions)
        if last:
            return EVENT if decided else WEDGED, ended, double, time, evaluations
        h = max(min(h, FIRST_LENGTH), LEAST_LENGTH)
    return CHATTER, phase, double, time, evaluations
