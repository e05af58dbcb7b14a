"""The engine of the constraint walkers, integrating penalty walkers: the same steps, error control and event location.

Its functions are chosen by the type of the walker's numbers; here they learn what this room's type does.
"""

from __future__ import annotations

from math import pi

import numpy as np

from stages.analytic.compiled import extend
from stages.analytic.integration import dop853_step, integrator, phase
from stages.analytic.model import varied
from stages.analytic.phases import flow, guards
from stages.analytic.walk import recording
from stages.penalty.compiled import again, compiled
from stages.penalty.model.varied import VariedPenalty
from stages.penalty.model.walker import Walker
from stages.penalty.motion.accelerations import accelerations
from stages.penalty.motion.feet import penalty_guard
from stages.penalty.motion.flow import penalty_rates, varied_rates

#: Length of a step, in the walker's scales, that need not be shorter to pass a corner of a contact law.
CORNER = 1e-12


@compiled
def twelve(p: Walker) -> int:
    """`state_size`."""
    return 12


@compiled
def penalty_failure(now: int, y: np.ndarray, p: Walker) -> int:
    """`failure`: the hip is too low, or a leg is level."""
    return phase.EVENT if y[1] >= p.fallen and max(abs(y[2]), abs(y[3])) <= 0.5 * pi else phase.FALL


@compiled
def varied_guard(phase: int, y: np.ndarray, v: VariedPenalty, dy: np.ndarray, start: int) -> tuple[float, float, bool]:
    """`guard` of a walker whose numbers vary: that of the plain one.

    A change of the numbers moves the moments in which a foot comes into play or lands, but nothing jumps there: a
    variation may be carried past them by any delay, as the rates before and after are the same. The end of a step,
    where the delays are counted, is an angle, which no number moves.
    """
    found: tuple[float, float, bool] = penalty_guard(phase, y, v.plain, dy, start)
    return found


@compiled
def varied_failure(now: int, y: np.ndarray, v: VariedPenalty) -> int:
    """`failure`: that of the plain walker."""
    found: int = penalty_failure(now, y, v.plain)
    return found


@compiled
def add_delay(v: VariedPenalty, start: int, delay: float) -> None:
    """`keep_delay` of a walker whose numbers vary."""
    v.delays[start // 12 - 1] += delay


plain_error_norm = again(dop853_step.error_norm)


@compiled
def varied_error_norm(
    y: np.ndarray, new: np.ndarray, h: float, v: VariedPenalty, stages: np.ndarray, tolerance: float
) -> float:
    """`error_norm` of a walker whose numbers vary: a step that could not be shorter is good enough.

    Where the ground lets a foot go, the rates of variations jump, though they themselves do not: no step over that
    moment is short enough for a tight tolerance, and what a step of `CORNER` leaves is that share of the jump.
    """
    error: float = plain_error_norm(y, new, h, v, stages, tolerance)
    return 1.0 if h < CORNER and error > 1.0 else error


for function, plain, of_varied in (
    (flow.flow, penalty_rates, varied_rates), (guards.guard, penalty_guard, varied_guard),
    (phase.failure, penalty_failure, varied_failure), (phase.state_size, twelve, twelve),
    (varied.keep_delay, again(varied.forget_delay), add_delay),
    (integrator.take_step, *2 * [again(dop853_step.take_step)]),
    (integrator.error_norm, plain_error_norm, varied_error_norm),
):  # fmt: skip
    extend(function, {Walker: plain, VariedPenalty: of_varied})

#: `integrate` of the engine.
integrate = again(phase.integrate_smooth)
#: `states_at` of the constraint walkers' recording.
states_at = again(recording.states_at)


@compiled
def readings(phases: np.ndarray, states: np.ndarray, p: Walker) -> np.ndarray:
    """Of states (n, 12) in their phases (n,), (n, 10): accelerations, then normal force and friction of both feet."""
    rows = np.empty((states.shape[0], 10))
    for i in range(states.shape[0]):
        qdd, force, _, _, _ = accelerations(phases[i], states[i], p)
        rows[i, 0], rows[i, 1], rows[i, 2], rows[i, 3], rows[i, 4], rows[i, 5] = qdd
        rows[i, 6], rows[i, 7], rows[i, 8], rows[i, 9] = force
    return rows
