"""Error estimates of a gait and of a walk on it, and whether they are to be trusted.

An estimate is a leading term, and shows nothing where the integrator's steps are too long for it to lead. So the same
is computed with a tenth of the tolerance: both differ by what both estimates say, or the estimate is not given.

The global error of a recorded walk: the errors of its steps, carried along by one variation.

Each step of the integrator is taken again in two halves. What comes out differs by the step's own error, but for its
2^order-th part. A variation of the state takes these errors along through the flow, and through heel strikes and other
events with the shift of their time. Steps of a smooth phase that is resolved make this the leading term of the error;
see Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, II.8 (global error). Errors are exact minus
computed, dimensionless.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from stages.analytic.compiled import compiled
from stages.analytic.derivatives.gait import step_length_change
from stages.analytic.errors import StepFailed
from stages.analytic.gait.gait_search import step_length
from stages.analytic.gait.poincare import (
    STEP_LIMIT_OF_A_PHASE,
    FixedPoint,
    fixed_point,
    step_failure,
)
from stages.analytic.integration import radau
from stages.analytic.integration.integrator import STAGES, take_step
from stages.analytic.integration.phase import CHATTER, FIRST_LENGTH, LEAST_LENGTH, MOST_PHASES
from stages.analytic.model.kinds import Kind
from stages.analytic.model.stiffness import attainable_tolerance
from stages.analytic.model.walker import Vector, Walker
from stages.analytic.phases.guards import FEET, HIP, guard
from stages.analytic.phases.impact import heel_strike_reset
from stages.analytic.phases.motion import flow
from stages.analytic.phases.section import section_coordinates, section_derivative, section_state, section_tangent
from stages.analytic.phases.succession import first_phase, of_hip, succeed
from stages.analytic.result import NumericalError
from stages.analytic.walk.recording import (
    Segment,
    integrate_segment,
    record,
    up_to_mid_stance,
    vaulting,
    walk_on,
)
from stages.biped.quantity import quantity

#: A phase of so many steps has no estimate.
MOST_NODES = STEP_LIMIT_OF_A_PHASE // 10
#: Order of the integrator that walks: DOP853; and of Radau IIA, which walks on stiff legs.
ORDER, STIFF_ORDER = 8, 2 * radau.STAGES - 1


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
            flow(phase, y, p, stages[0], None)
            take_step(phase, y, 0.5 * lengths[n], p, stages, new, None)
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
    order = STIFF_ORDER if walker.stiff else ORDER
    carry(segment.phase, lengths, np.vstack([segment.states, segment.end]), walker.p, order, errors)
    return errors


def at_event(walker: Walker, segment: Segment, error: Vector) -> tuple[Vector, float]:
    """Error of the state at the event that ends the segment, (size,), and by how much that event comes too early."""
    p, phase, which = walker.p, segment.phase, HIP if of_hip(segment.phase, segment.end, walker.p) else FEET
    y, rates = np.concatenate([segment.end, error]), np.empty(2 * walker.size)
    if not segment.duration > 0.0:
        return error, 0.0  # it ended where it began: no event to shift
    flow(phase, y, p, rates)
    delay = -guard(phase, y, p, y, walker.size, None, which)[1] / guard(phase, y, p, rates, 0, None, which)[1]
    return error + rates[: walker.size] * delay, float(delay)


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
        if segment.last:
            # the change of x_0, `recording.next_origin`, has the terms of the step length with the other sign: it is
            # read before the legs change names
            origin -= longer(standing, segment.end, shifted)
        y = np.concatenate([segment.end, shifted])
        succeed(segment.phase, y, standing.p, None)
        error = y[walker.size :]
    return [*carried, CarriedError(error[None, :], delay, origin)]


def longer(walker: Walker, y: Vector, error: Vector) -> float:
    """Error of the length of the step that leads to the state `y`, from that of the state (size,)."""
    return float(step_length_change(walker, y, error[:, None], np.zeros((1, len(walker.p))))[0])


#: An estimate leads if what both differ by is off by at most this part of it.
OFF = 0.25
#: Two estimates of one number that differ by more than this part of the larger one are none.
CANCELLED = 0.5


@dataclass(frozen=True)
class GaitError:
    """Estimated errors of a gait's numbers, exact minus computed; None where there is no estimate."""

    period: float | None = quantity("s", "estimated error of the period, exact minus computed")
    step_length: float | None = quantity("m", "estimated error of the step length, exact minus computed")
    checked: str = quantity("-", "what the estimates rest on")


@dataclass(frozen=True)
class Estimated:
    """What is estimated at one tolerance, dimensionless, with the values that it is about.

    `gait` and `gait_error` (j + 2,): section coordinates, period, step length. `strikes` and `strike_error` (n, 2):
    time and x_0 of each heel strike of the walk. `hip_error` (m,): distance of the hip at the walk's nodes.
    """

    gait: Vector
    gait_error: Vector
    strikes: np.ndarray
    strike_error: np.ndarray
    hip_error: Vector


def estimate_errors(walker: Walker, point: FixedPoint, steps: int, tolerance: float) -> NumericalError:
    """Errors of the gait at `point` and of `steps` steps of a walk on it from mid-stance, both found at `tolerance`.

    They are checked against a tenth of the tolerance; where round-off hides what that changes, against ten times the
    tolerance, at which they lead less.
    """
    if walker.timed:
        return not_given("the estimate knows no strike at a given time")
    tolerance = attainable_tolerance(walker.p, tolerance)
    one = tried(walker, point, steps, tolerance)
    if isinstance(one, str):
        return not_given(one)
    reasons: list[str] = []
    for factor, named in ((0.1, "a tenth of"), (10.0, "ten times")):
        if factor * tolerance < attainable_tolerance(walker.p, 0.0):
            reasons.append(f"{named} the tolerance is below round-off")
            continue
        other = tried(walker, fixed_point(walker, point.z, factor * tolerance), steps, factor * tolerance)
        if isinstance(other, str):
            reasons.append(f"at {named} the tolerance {other}")
            continue
        off = missed(one, other)
        if off <= OFF:
            checked = f"at {named} the tolerance results differ by what is estimated, to {off:.1g} of it"
            return numerical_error(walker, one, other, checked)
        reasons.append(f"at {named} the tolerance results differ otherwise than estimated, by {off:.1g} of it")
    return not_given("; ".join(reasons))


def gait_error(walker: Walker, point: FixedPoint, tolerance: float) -> GaitError:
    """Errors of the gait at `point`, found at `tolerance`."""
    found = estimate_errors(walker, point, 1, tolerance)
    period, length = (value if np.isfinite(value) else None for value in (found.period, found.step_length))
    return GaitError(period, length, found.checked)


def tried(walker: Walker, point: FixedPoint | None, steps: int, tolerance: float) -> Estimated | str:
    """What is estimated of a gait found at this tolerance, None where it is not, or why nothing can be."""
    if point is None:
        return "the gait is lost"
    try:
        return estimated(walker, point, steps, tolerance)
    except (StepFailed, np.linalg.LinAlgError) as reason:
        return str(reason)


def missed(one: Estimated, other: Estimated) -> float:
    """How far the estimates miss what the results differ by, as part of the larger estimate; the worst of gait, times
    and places of the walk's heel strikes.
    """
    if one.strikes.shape != other.strikes.shape:
        return np.inf
    pairs = [(one.gait, other.gait, one.gait_error, other.gait_error)]
    pairs += zip(one.strikes.T, other.strikes.T, one.strike_error.T, other.strike_error.T, strict=True)
    parts = []
    for value, other_value, error, other_error in pairs:
        size = max(float(np.abs(error).max()), float(np.abs(other_error).max()))
        gap = float(np.abs((other_value - value) - (error - other_error)).max())
        parts.append(gap / size if size > 0.0 else np.inf)
    return max(parts)


def numerical_error(walker: Walker, one: Estimated, other: Estimated, checked: str) -> NumericalError:
    """The errors in SI units.

    The gait's numbers have two estimates, of which that from the finer results is the better one. Where leading terms
    cancel in a number, both show what is left of them, each another thing: then it has none.
    """
    finer = np.abs(other.gait_error).max() < np.abs(one.gait_error).max()
    error = other.gait - one.gait + other.gait_error if finer else one.gait_error.copy()
    both = np.abs([error, one.gait_error])
    error[np.abs(error - one.gait_error) > CANCELLED * both.max(axis=0)] = np.nan
    durations = np.diff(one.strike_error[:, 0])
    return NumericalError(
        float(error[-2] * walker.time),
        float(error[-1] * walker.length),
        float(one.hip_error.max() * walker.length),
        float(np.abs(durations).max(initial=0.0) * walker.time),
        checked,
    )


def not_given(reason: str) -> NumericalError:
    """No estimate, and why."""
    return NumericalError(np.nan, np.nan, np.nan, np.nan, reason)


def estimated(walker: Walker, point: FixedPoint, steps: int, tolerance: float) -> Estimated:
    """The gait, a walk on it and the errors of both. Raises StepFailed."""
    start, count = section_state(point.z, walker.p), len(point.steps)
    cycle = record_map(walker, point.z, count, tolerance)
    y, standing = cycle[-1].end.copy(), walker.on(cycle[-1].stance_leg)
    heel_strike_reset(y, standing.p)
    after = np.concatenate([y, carried_error(walker, cycle, np.zeros(walker.size))[-1].states[0]])
    own = section_derivative(after, standing.exchanged.p)[:, 0]  # error of the section coordinates after the cycle
    moved = np.linalg.solve(np.eye(own.size) - point.monodromy_matrix, own)
    begun = moved @ section_tangent(point.z, start, walker.p).reshape(-1, walker.size)
    carried = carried_error(walker, cycle, begun)
    first = [0, *(index + 1 for index, segment in enumerate(cycle[:-1]) if segment.last)]
    lengths = [longer(walker.on(cycle[index].stance_leg), cycle[index].states[0], carried[index].states[0])
               for index in first]  # fmt: skip

    single = record(walker, start, 1, tolerance)
    place = vaulting(single)
    begin = up_to_mid_stance(walker, single[place])
    walk = walk_on(walker, begin.end, steps, tolerance)
    there = along(walker, begin, carried_error(walker, single, begun)[place].states[0])[-1]
    rates = np.empty(walker.size)
    flow(begin.phase, begin.end, walker.p, rates)
    path = carried_error(walker, walk, there - rates * there[0] / rates[0])
    ends = [index for index, segment in enumerate(walk) if segment.last]
    return Estimated(
        np.array([*point.z, point.period, step_length(walker, point)]),
        np.array([*moved, carried[-1].delay / count, sum(lengths) / count]),
        np.array([[walk[end].start + walk[end].duration, walk[end].origin] for end in ends]),
        np.array([[path[end + 1].delay, path[end].origin] for end in ends]),
        np.concatenate([hip_error(walker, segment, found) for segment, found in zip(walk, path, strict=False)]),
    )


def record_map(walker: Walker, z: Vector, steps: int, tolerance: float) -> list[Segment]:
    """Segments of the steps that the step map takes from section coordinates `z` with its derivatives, one by one.

    Its integration steps are other ones than those of a walk without variations, and so are its errors.
    """
    segments: list[Segment] = []
    for count in range(steps):
        taken, z = record_step(walker.on(count % 2), z, tolerance)
        segments += [replace(segment, stance_leg=count % 2) for segment in taken]
    return segments


def record_step(walker: Walker, z: Vector, tolerance: float) -> tuple[list[Segment], Vector]:
    """Segments of one step of the map with its derivatives, and the section coordinates after it."""
    state = section_state(z, walker.p)
    y = np.concatenate([state, section_tangent(z, state, walker.p)])
    h, start, segments = FIRST_LENGTH, 0.0, list[Segment]()
    phase, decided = first_phase(y, walker.p)
    while decided and not (segments and segments[-1].last):
        if len(segments) > MOST_PHASES:
            raise StepFailed(step_failure(CHATTER, phase))
        segment, y, h = integrate_segment(walker, phase, y, start, 0, 0.0, tolerance, h)
        segments.append(segment)
        if len(segment.times) >= MOST_NODES:
            raise StepFailed("there are more integration steps than are kept")
        start, h = start + segment.duration, max(min(h, FIRST_LENGTH), LEAST_LENGTH)
        phase, decided = succeed(phase, y, walker.p, None)
    return segments, section_coordinates(y[: walker.size], walker.exchanged.p)


def hip_error(walker: Walker, segment: Segment, carried: CarriedError) -> Vector:
    """Distance (n + 1,) of the hip from where it is to be at the times of the segment's nodes and of its end."""
    p, half = walker.on(segment.stance_leg).p, walker.size // 2
    y = np.vstack([segment.states, segment.end])
    error = carried.states[:, :half] - carried.delay * y[:, half:]  # rates are those of the coordinates
    theta, dtheta = y[:, 0], error[:, 0]
    stance, dstance = (p.L_nat, 0.0) if walker.rigid else (y[:, 1], error[:, 1])
    across = (stance - p.r) * dtheta
    forward = carried.origin + p.r * dtheta + dstance * np.sin(theta) + across * np.cos(theta)
    return np.asarray(np.hypot(forward, dstance * np.cos(theta) - across * np.sin(theta)))
