"""The global error of a recorded walk: the errors of its steps, carried along by one variation.

Each step of the integrator is taken again in two halves. What comes out differs by the step's own error, but for its
2^order-th part. A variation of the state takes these errors along through the flow, and through heel strikes and other
events with the shift of their time. Steps of a smooth phase that is resolved make this the leading term of the error;
see Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, II.8 (global error). Errors are exact minus
computed, dimensionless.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stages.analytic.compiled import compiled
from stages.analytic.derivatives.gait import step_length_change
from stages.analytic.integration.integrator import STAGES, take_step
from stages.analytic.model.kinds import Kind, Stiff
from stages.analytic.model.walker import Vector, Walker
from stages.analytic.phases.flow import flow
from stages.analytic.phases.guards import guard
from stages.analytic.phases.hip_friction import hip_rate, of_hip, sign_of
from stages.analytic.phases.succession import succeed
from stages.analytic.walk.recording import Segment, is_last

#: Order of the integrator that walks: DOP853; and of Radau IIA, which walks on stiff legs.
ORDER, STIFF_ORDER = 8, 5


@compiled
def carry(phase: int, lengths: Vector, states: np.ndarray, p: Kind, order: int, errors: np.ndarray) -> None:
    """Fill `errors` (n + 1, size), the error at `states` (n + 1, size), from its first row on.

    `lengths` (n,) are those of the integrator's steps.
    """
    size = states.shape[1]
    stages, y, new = np.empty((STAGES, 2 * size)), np.empty(2 * size), np.empty(2 * size)
    whole = 2.0**order / (2.0**order - 1.0)
    for n in range(lengths.size):
        for i in range(size):
            y[i], y[size + i] = states[n, i], errors[n, i]
        for _ in range(2):
            flow(phase, y, p, stages[0])
            take_step(phase, y, 0.5 * lengths[n], p, stages, new)
            for i in range(2 * size):
                y[i] = new[i]
        for i in range(size):
            errors[n + 1, i] = y[size + i] + whole * (y[i] - states[n + 1, i])


@dataclass(frozen=True)
class CarriedError:
    """The error along one segment: of the state (n + 1, size) at its nodes and end, counted from its own start; by how
    much that start comes too early (dimensionless time); and of x_0 of eq. (7).
    """

    states: np.ndarray
    delay: float
    origin: float


def along(walker: Walker, segment: Segment, error: Vector) -> np.ndarray:
    """Error of the state at the segment's nodes and at its end, (n + 1, size), from that at its start (size,)."""
    lengths = np.diff(np.append(segment.times, segment.duration))
    errors = np.empty((lengths.size + 1, walker.size))
    errors[0] = error
    order = STIFF_ORDER if isinstance(walker.p, Stiff) else ORDER
    carry(segment.phase, lengths, np.vstack([segment.states, segment.end]), walker.p, order, errors)
    return errors


def at_event(walker: Walker, segment: Segment, error: Vector) -> tuple[Vector, float]:
    """Error of the state at the event that ends the segment, (size,), and by how much that event comes too early."""
    p, phase, hips = walker.p, segment.phase, of_hip(segment.phase, segment.end, walker.p)
    y, rates = np.concatenate([segment.end, error]), np.empty(2 * walker.size)
    if not segment.duration > 0.0 or (hips and sign_of(phase) == 0):
        return error, 0.0  # it ended where it began, or a hip lets go, at which nothing jumps: no event to shift
    flow(phase, y, p, rates)
    if hips:
        delay = -hip_rate(y, walker.size, p) / hip_rate(rates, 0, p)
    else:
        delay = -guard(phase, y, p, y, walker.size)[1] / guard(phase, y, p, rates, 0)[1]
    return error + rates[: walker.size] * delay, float(delay)


def after_event(walker: Walker, segment: Segment, error: Vector) -> Vector:
    """Error of the state that the next segment starts from, (size,)."""
    y = np.concatenate([segment.end, error])
    succeed(segment.phase, y, walker.p)
    return y[walker.size :]


def carried_error(walker: Walker, segments: Sequence[Segment], error: Vector) -> list[CarriedError]:
    """The error along a walk that starts with `error` (size,), segment by segment, and after its last event.

    The last entry has the state after the last event alone, one row. `walker` is the one in whose step leg 0 stands.
    """
    carried: list[CarriedError] = []
    delay = origin = 0.0
    for segment in segments:
        standing = walker.on(segment.stance_leg)
        errors = along(standing, segment, error)
        carried.append(CarriedError(errors, delay, origin))
        shifted, later = at_event(standing, segment, errors[-1])
        delay += later
        if is_last(segment):
            origin += origin_error(standing, segment.end, shifted)
        error = after_event(standing, segment, shifted)
    return [*carried, CarriedError(error[None, :], delay, origin)]


def origin_error(walker: Walker, y: Vector, error: Vector) -> float:
    """Error of the change of x_0 at heel strike, `recording.next_origin`, from that of the state before it (size,).

    It has the terms of the step length with the other sign: it is read before the legs change names.
    """
    return -float(step_length_change(walker, y, error[:, None], np.zeros((1, len(walker.p))))[0])
