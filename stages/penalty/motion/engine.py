"""The engine of the constraint walkers, integrating penalty walkers: the same steps, error control and event location.

Its functions are chosen by the type of the walker's numbers; here they learn what this room's type does.

Rates of the penalty walker's state, and of the variations that are carried with it.

The state is y = (q, qd) with q = (hip x, y, angle of leg 0 and 1, length of leg 0 and 1), followed by any number of
variations dy. The rates are continuous wherever the ground begins or ceases to act, where a foot touches it or leaves
it and at every corner of the contact laws, so variations need no jump there: their own rates jump at most.
"""

from math import pi

import numpy as np

from stages.analytic.compiled import Four, Numbers, extend
from stages.analytic.integration import integrator, phase
from stages.analytic.phases import guards, motion
from stages.analytic.walk import recording
from stages.penalty.compiled import again, compiled
from stages.penalty.model.walker import Directions, Penalty, leg_by, leg_change, leg_jacobian, leg_of
from stages.penalty.motion.accelerations import (
    FIRST,
    OTHER,
    Six,
    accelerations,
    hip_change,
    solve,
    torque_variation,
)
from stages.penalty.motion.feet import Slopes, acts_on, force_slopes, law_change, penalty_guard

Vector = np.ndarray


@compiled
def store(rates: Vector, y: Vector, start: int, qdd: Six) -> None:
    """Rates of one 12-vector (q, qd) stored from `start`."""
    for i in range(6):
        rates[start + i] = y[start + 6 + i]
    rates[start + 6], rates[start + 7], rates[start + 8] = qdd[0], qdd[1], qdd[2]
    rates[start + 9], rates[start + 10], rates[start + 11] = qdd[3], qdd[4], qdd[5]


@compiled
def moved_leg(y: Vector, leg: int, qdd: Six, normal: float, friction: float) -> Numbers:
    """What `leg_jacobian` and `leg_by` take of a leg at the state (12,), before its numbers."""
    turn, slide = (qdd[2], qdd[4]) if leg == 0 else (qdd[3], qdd[5])
    return y[2 + leg], y[4 + leg], y[8 + leg], y[10 + leg], qdd[0], qdd[1], turn, slide, normal, friction


@compiled
def leg_variation(
    j: Numbers, t: Numbers, slopes: Slopes, dy: Vector, start: int, leg: int
) -> tuple[float, float, float, float]:
    """Change of a leg's part of Q - C qd - M qdd and of the ground's push, at unchanged qdd, for the variation stored
    from `start`: x, y, angle, length.
    """
    angle, length = dy[start + 2 + leg], dy[start + 4 + leg]
    turning, sliding = dy[start + 8 + leg], dy[start + 10 + leg]
    depth = -dy[start + 1] - t[12] * angle - t[13] * length
    rate = j[16] * angle + j[17] * length - dy[start + 7] - t[12] * turning - t[13] * sliding
    slip = j[18] * angle + j[19] * length + dy[start + 6] + t[14] * turning + t[15] * sliding
    normal = slopes[0] * depth + slopes[1] * rate
    friction = slopes[2] * slip + slopes[3] * normal
    return (
        j[0] * angle + j[1] * length + j[2] * turning + j[3] * sliding + friction,
        j[4] * angle + j[5] * length + j[6] * turning + j[7] * sliding + normal,
        j[8] * angle + j[9] * length + j[10] * turning + j[11] * sliding + t[12] * normal + t[14] * friction,
        j[12] * angle + j[13] * length + j[14] * turning + j[15] * sliding + t[13] * normal + t[15] * friction,
    )


@compiled
def leg_along(
    c: Numbers, t: Numbers, slopes: Slopes, law: tuple[float, float]
) -> tuple[float, float, float, float]:
    """`leg_variation` at an unchanged state, along a direction: the change `c` of a leg's part and contact
    (`leg_change`), and that of normal force and friction by the contact law.
    """
    normal = slopes[0] * c[4] + slopes[1] * c[5] + law[0]
    friction = slopes[2] * c[6] + slopes[3] * normal + law[1]
    return (
        c[0] + friction,
        c[1] + normal,
        c[2] + t[12] * normal + t[14] * friction,
        c[3] + t[13] * normal + t[15] * friction,
    )


@compiled
def sum_of(a: Four, b: Four) -> Four:
    """a + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]


@compiled
def penalty_rates(phase: int, y: Vector, p: Penalty, rates: Vector, directions: Directions | None = None) -> None:
    """`flow`: dy/dt of state and variations, and what the directions of the numbers add to the last of these."""
    qdd, force, factors, t, u = accelerations(phase, y, p)
    store(rates, y, 0, qdd)
    if y.size > 12:
        j = leg_jacobian(*moved_leg(y, 0, qdd, force[0], force[1]), leg_of(p, 0))
        k = leg_jacobian(*moved_leg(y, 1, qdd, force[2], force[3]), leg_of(p, 1))
        first = force_slopes(acts_on(phase, 0), t[9], t[10], t[11], p.law)
        second = force_slopes(acts_on(phase, 1), u[9], u[10], u[11], p.law)
        count = 0
        if directions is not None:
            by0 = leg_by(*moved_leg(y, 0, qdd, force[0], force[1]), leg_of(p, 0))
            by1 = leg_by(*moved_leg(y, 1, qdd, force[2], force[3]), leg_of(p, 1))
            count = y.size // 12 - directions.rows.shape[0]
        for start in range(12, y.size, 12):
            a = leg_variation(j, t, first, y, start, 0)
            b = leg_variation(k, u, second, y, start, 1)
            x, upward, turned = 0.0, 0.0, torque_variation(y, start, p)
            if directions is not None and start // 12 >= count:
                row = start // 12 - count
                of_law0, of_law1 = (0.0, 0.0), (0.0, 0.0)
                if directions.of_law[row]:
                    of_law0 = law_change(acts_on(phase, 0), t[9], t[10], t[11], p.law, directions.laws[row])
                    of_law1 = law_change(acts_on(phase, 1), u[9], u[10], u[11], p.law, directions.laws[row])
                c0 = leg_change(by0, directions.rows, row, FIRST, leg_of(p, 0))
                c1 = leg_change(by1, directions.rows, row, OTHER, leg_of(p, 1))
                a, b = sum_of(a, leg_along(c0, t, first, of_law0)), sum_of(b, leg_along(c1, u, second, of_law1))
                x, upward, torque = hip_change(y, directions.rows, row, qdd[0], qdd[1], p)
                turned += torque
            store(rates, y, start, solve(
                factors, a[0] + b[0] + x, a[1] + b[1] + upward, a[2] + turned, b[2] - turned, a[3], b[3]))


#: Length of a step, in the walker's scales, that need not be shorter to pass a corner of a contact law.
CORNER = 1e-12


@compiled
def penalty_shape(p: Penalty) -> tuple[int, float]:
    """`shape`: guards end every phase."""
    return 12, np.inf


@compiled
def penalty_failure(now: int, y: np.ndarray, p: Penalty) -> int:
    """`failure`: the hip is too low, or a leg is level."""
    return phase.EVENT if y[1] >= p.fallen and max(abs(y[2]), abs(y[3])) <= 0.5 * pi else phase.FALL


@compiled
def guard(
    phase: int, y: Vector, p: Penalty, dy: Vector, start: int, directions: Directions | None = None, which: int = 0
) -> tuple[float, float, bool]:
    """`guard`: that of the state, whatever the directions.

    They move the moments in which a foot comes into play or lands, but nothing jumps there: a variation may be carried
    past them by any delay, as the rates before and after are the same. The end of a step, where the delays are counted,
    is an angle, which no number moves.
    """
    found: tuple[float, float, bool] = penalty_guard(phase, y, p, dy, start)
    return found


error_norm = again(integrator.DOP853.error_norm)


@compiled
def penalty_error_norm(
    y: np.ndarray, new: np.ndarray, h: float, p: Penalty, stages: np.ndarray, tolerance: float
) -> float:
    """`error_norm`: with variations a step that could not be shorter is good enough.

    Where the ground lets a foot go, the rates of variations jump, though they themselves do not: no step over that
    moment is short enough for a tight tolerance, and what a step of `CORNER` leaves is that share of the jump.
    """
    error: float = error_norm(y, new, h, p, stages, tolerance)
    return 1.0 if h < CORNER and error > 1.0 and y.size > 12 else error


for function, ours in (
    (motion.flow, penalty_rates), (motion.shape, penalty_shape), (guards.guard, guard),
    (phase.failure, penalty_failure), (phase.to_event, again(phase.integrated)),
    (integrator.take_step, again(integrator.DOP853.take_step)),
    (integrator.error_norm, penalty_error_norm),
):  # fmt: skip
    extend(function, {Penalty: ours})

#: `integrate` of the engine.
integrate = again(phase.integrate)
#: `states_at` of the constraint walkers' recording.
states_at = again(recording.states_at)


@compiled
def readings(phases: np.ndarray, states: np.ndarray, p: Penalty) -> np.ndarray:
    """Of states (n, 12) in their phases (n,), (n, 10): accelerations, then normal force and friction of both feet."""
    rows = np.empty((states.shape[0], 10))
    for i in range(states.shape[0]):
        qdd, force, _, _, _ = accelerations(phases[i], states[i], p)
        rows[i, 0], rows[i, 1], rows[i, 2], rows[i, 3], rows[i, 4], rows[i, 5] = qdd
        rows[i, 6], rows[i, 7], rows[i, 8], rows[i, 9] = force
    return rows
