"""A walk kept as the integrator's own steps, and its state at any time.

The state between two accepted steps is computed by one shorter step from the earlier one, so a sample is as
accurate as the integration itself.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from stages.analytic.compiled import compiled
from stages.analytic.errors import StepFailed
from stages.analytic.gait.poincare import STEP_LIMIT_OF_A_PHASE, TIME_LIMIT_OF_A_PHASE, step_failure
from stages.analytic.integration.integrator import STAGES, take_step
from stages.analytic.integration.phase import CHATTER, EVENT, FIRST_LENGTH, MOST_PHASES, WEDGED, integrate
from stages.analytic.model.kinds import Kind, Rigid, natural_lengths, radii
from stages.analytic.model.stiffness import attainable_tolerance
from stages.analytic.model.walker import Vector, Walker
from stages.analytic.phases.guards import contact_rates, foot_clearance
from stages.analytic.phases.motion import HOVERING, NORMAL, PHASES, ROLL, flow, in_contact
from stages.analytic.phases.section import section_state
from stages.analytic.phases.succession import ends_step, first_phase, single_stance, succeed

#: Steps of a phase that are kept room for at first, and the factor of more room.
ROOM = 4096
GROWTH = 16


@dataclass(frozen=True)
class Segment:
    """One phase of a walk (dimensionless): its nodes, when and where it starts, who stands, and its end state.

    `times` (n,) and `states` (n, size) are the accepted step starts; `origin` is x_0 of eq. (7). `last` shows whether
    it is the last one of its step, single stance, which ends with heel strike. `height` is that of the standing foot's
    ground, zero but for feet put down at a given time.
    """

    phase: int
    start: float
    duration: float
    stance_leg: int
    origin: float
    times: np.ndarray
    states: np.ndarray
    end: np.ndarray
    last: bool
    height: float = 0.0


def integrate_segment(
    walker: Walker, phase: int, y: Vector, start: float, stance_leg: int, origin: float, tolerance: float,
    first: float = FIRST_LENGTH,
) -> tuple[Segment, Vector, float]:  # fmt: skip
    """Integrate one phase from `y`, state and any variations, to its event, keeping its nodes; what `y` is there.

    `first` is the length of its first integration step, and the last number that of the one that would follow. Raises
    StepFailed if the event does not come.
    """
    room = ROOM
    while True:
        nodes, end = np.empty((room, 10)), y.copy()
        status, duration, h, count, _ = integrate(
            phase, end, walker.p, tolerance, TIME_LIMIT_OF_A_PHASE, STEP_LIMIT_OF_A_PHASE, first, nodes, None)
        if status != EVENT:
            raise StepFailed(step_failure(status, phase))
        if count < room:
            break
        room *= GROWTH  # a stiff phase takes many steps: once more, with room for them
    size = walker.size
    kept = nodes[:count] if count else np.array([[0.0, phase, *y[:size]]])
    return Segment(
        phase, start, duration, stance_leg, origin, kept[:, 0].copy(), kept[:, 2 : 2 + size].copy(), end[:size].copy(),
        ends_step(phase, end, walker.p)), end, h


def next_origin(walker: Walker, segment: Segment) -> float:
    """x_0 of the step after heel strike: the new stance foot's centre, less its own rolling, eq. (7)."""
    p, y = walker.on(segment.stance_leg).p, segment.end
    theta, psi = y[0], y[1 if walker.rigid else 2]
    stance, swing = natural_lengths(p) if walker.rigid else (y[1], y[3])
    radius = radii(p)[1]
    centre = segment.origin + p.r * theta + (stance - p.r) * np.sin(theta) + (swing - radius) * np.sin(psi)
    return float(centre + radius * psi)


def rise(walker: Walker, segment: Segment) -> float:
    """Height over the standing foot's ground at which a foot is put down at a given time; zero where it lands."""
    if not walker.timed:
        return 0.0
    y = segment.end
    return float(foot_clearance(y, walker.on(segment.stance_leg).p, y, 2)[0])


def record(
    walker: Walker, y: Vector, heel_strikes: int, tolerance: float, phase: int | None = None, elapsed: float = 0.0
) -> list[Segment]:
    """Segments of a walk that starts at state `y` with leg 0 standing, up to the given heel strike.

    `walker` is the one in whose step leg 0 stands. The walk starts in `phase`, by default the one that follows a heel
    strike; `elapsed` of the step's time is over. Raises StepFailed if the walker does not get there.
    """
    tolerance = attainable_tolerance(walker.p, tolerance)
    segments: list[Segment] = []
    start, leg, origin, height, strikes, decided = 0.0, 0, 0.0, 0.0, 0, True
    if phase is None:
        phase, decided = first_phase(y, walker.p)
    while True:
        if not decided:
            raise StepFailed(step_failure(WEDGED, phase))
        standing = walker.on(leg)
        begun = standing if segments or not standing.timed else shortened(standing, elapsed)
        segment, y, _ = integrate_segment(begun, phase, y, start, leg, origin, tolerance)
        segments.append(replace(segment, height=height))
        start += segment.duration
        if segment.last:
            strikes += 1
            if strikes == heel_strikes:
                return segments
            origin, height, leg = next_origin(walker, segment), height + rise(walker, segment), 1 - leg
        elif len(segments) > MOST_PHASES and not any(each.last for each in segments[-MOST_PHASES:]):
            raise StepFailed(step_failure(CHATTER, phase))
        phase, decided = succeed(phase, y, standing.p, None)


def shortened(walker: Walker, elapsed: float) -> Walker:
    """The walker in a step of which so much of its given time is over."""
    p: Any = walker.p
    return replace(walker, p=p._replace(T=p.T - elapsed))


def walk_on(
    walker: Walker, upright: Vector, steps: int, tolerance: float, elapsed: float = 0.0
) -> list[Segment]:  # fmt: skip
    """Segments of a walk from mid-stance, see `crossing`, over `steps` whole steps and the begun one.

    `elapsed` is the time of the begun step up to there, which counts where a foot is put down at a given time. Raises
    StepFailed if the walker does not get there.
    """
    return record(walker, upright, steps + 1, tolerance, single_stance(upright, walker.p), elapsed)


def in_single_stance(segment: Segment) -> bool:
    """Whether the swing foot is in play: it lands if it comes down."""
    return bool(PHASES[segment.phase, NORMAL] == 0 and segment.phase != HOVERING)


@compiled
def states_at(phase: int, node_times: Vector, node_states: np.ndarray, times: Vector, p: Kind) -> np.ndarray:
    """States at `times` (n,) inside a segment, by one step from the last node before each, shape (n, size)."""
    size = node_states.shape[1]
    stages, states = np.empty((STAGES, size)), np.empty((times.size, size))
    node = 0
    for i in range(times.size):
        while node + 1 < node_times.size and node_times[node + 1] <= times[i]:
            node += 1
        flow(phase, node_states[node], p, stages[0], None)
        take_step(phase, node_states[node], times[i] - node_times[node], p, stages, states[i], None)
    return states


def crossing(walker: Walker, z: Vector, tolerance: float) -> tuple[Vector, float]:
    """State at mid-stance, stance angle zero in single stance, on the step from section coordinates `z`, and its time.

    Raises StepFailed if the walker does not vault over its stance leg.
    """
    segments = record(walker, section_state(z, walker.p), 1, tolerance)
    begun = up_to_mid_stance(walker, segments[vaulting(segments)])
    return begun.end, begun.start + begun.duration


def crossing_state(walker: Walker, z: Vector, tolerance: float) -> np.ndarray:
    """The state of `crossing`. Raises StepFailed like it."""
    return crossing(walker, z, tolerance)[0]


def vaulting(step: list[Segment]) -> int:
    """Which segment of a step is the single stance in which the stance leg comes upright; the last if none does."""
    crossing = (index for index, each in enumerate(step) if in_single_stance(each) and each.states[0, 0] < 0)
    return next((index for index in crossing if step[index].end[0] > 0), len(step) - 1)


def up_to_mid_stance(walker: Walker, single: Segment) -> Segment:
    """The part of a single stance up to mid-stance. Raises StepFailed if the stance leg never is upright."""
    before = np.flatnonzero(single.states[:, 0] < 0)
    if not before.size or single.end[0] <= 0:
        raise StepFailed("the stance leg is never upright in single stance")
    node = before[-1]
    rate = walker.size // 2
    time, times, states = single.times[node], single.times[: node + 1], single.states[: node + 1]
    state: Vector = states[node]
    for _ in range(50):
        change = -state[0] / state[rate]
        time += change
        state = states_at(single.phase, times[node:], states[node:], np.array([time]), walker.p)[0]
        if abs(change) < 1e-15:
            break
    state[0] = 0.0
    return replace(single, duration=time, times=times, states=states, end=state)


def constraint_drift(walker: Walker, segments: list[Segment]) -> np.ndarray:
    """Clearance, its rate and the slip velocity of the trailing foot where it ends to roll, dimensionless, shape (3,).

    All three are zero at heel strike; what they are at toe-off is the drift of constraints that are held at
    acceleration level. For a foot that slides until toe-off, clearance and its rate there, and no slip velocity, which
    no constraint holds. Zero for rigid legs, which have no double stance.
    """
    both = [segment for segment in segments if in_contact(segment.phase)]
    if isinstance(walker.p, Rigid) or not both:
        return np.zeros(3)
    y, phase = both[-1].end, both[-1].phase
    p: Any = walker.on(both[-1].stance_leg).p
    rate, slip = contact_rates(y, p)
    return np.array([foot_clearance(y, p, y, 4)[0], rate, slip if PHASES[phase, ROLL] == 1 else 0.0])
