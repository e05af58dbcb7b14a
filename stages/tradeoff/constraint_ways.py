"""Ways to walk the constraint model: compiled code and SciPy's integrators, rolling or with limited friction.

The paper takes an explicit pair of order 3(2) in single stance (MATLAB's ode23) and a variable-order implicit one in
double stance (ode15s), sections 2.1 and 2.3. SciPy has their relatives: RK23 is the same pair, BDF the like of ode15s.
Events are found by SciPy on its own interpolants. Rates come from the compiled terms, or, to be independent of them,
from `readable`: the derivation through numpy.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from stages.analytic.errors import StepFailed
from stages.analytic.gait.gait_search import find_gait
from stages.analytic.gait.poincare import TIME_LIMIT_OF_A_PHASE, fixed_point, iterate, multipliers_of, poincare_map
from stages.analytic.integration.readable import STRIDE_ON, accelerations
from stages.analytic.model.walker import Vector, Walker, build_walker
from stages.analytic.phases.guards import guard
from stages.analytic.phases.motion import DOUBLE_STANCE, SINGLE_STANCE, flow
from stages.analytic.phases.section import section_coordinates, section_state
from stages.analytic.phases.succession import first_phase, succeed
from stages.analytic.walk.recording import Segment, crossing_state, next_origin, record
from stages.analytic.walk.sampling import sample_walk
from stages.analytic.walk.validity import FEET, NORMAL, Phase
from stages.biped.design import Biped
from stages.biped.walk import StanceState
from stages.ground.slope import Friction, Slope
from stages.tradeoff.way import GRID_HZ, Walked, Way

ROLLING, COULOMB = "constraint model, rolling", "constraint model, coulomb"
DETAILED = "detailed constraint model"
#: Steps of the differences for SciPy's multiplier at a tight tolerance: lengths change less than springs do.
DIFFERENCE = np.array([3e-5, 3e-6, 3e-6, 3e-5, 3e-5])
#: Those of them that rigid legs have: an angle and two rates.
ANGLES = [0, 3, 4]
SETTLING_STEPS = 12
#: Longest step [pendulum times], so that no crossing of the ground is stepped over.
LONGEST_STEP = 0.1
MOST_PHASES = 40
#: A sliding or hovering foot may start where its guard is zero up to round-off: what ends it is looked for after this.
SEEN_AFTER = 1e-6

Rates = Callable[[Walker, int, Vector], Vector]


def compiled_rates(walker: Walker, phase: int, y: Vector) -> Vector:
    """dy/dt by the compiled terms."""
    rates = np.empty_like(y)
    flow(phase, y, walker.p, rates)
    return rates


def readable_rates(walker: Walker, phase: int, y: Vector) -> Vector:
    """dy/dt by the derivation's own terms; single and double stance of rolling feet only."""
    return np.concatenate([y[y.size // 2 :], accelerations(walker, y, phase == DOUBLE_STANCE)[0]])


@dataclass(frozen=True)
class Scene:
    """The walker, the mid-stance all walk from, the gait's section coordinates, and the number of steps."""

    model: str
    walker: Walker
    upright: Vector
    gait: Vector
    steps: int


def scene(biped: Biped, slope: Slope, friction: Friction | None, upright: StanceState, steps: int) -> Scene:
    """The scene of one kind of trailing foot; its gait is found by walking on from the mid-stance given.

    Raises StepFailed if no gait is found.
    """
    walker = build_walker(biped, slope, friction)
    y = walker.from_stance(upright)
    after = record(walker, y, SETTLING_STEPS, 1e-12, SINGLE_STANCE)[-1].end
    succeed(SINGLE_STANCE, after, walker.p)
    point = fixed_point(walker, section_coordinates(after, walker.p), 1e-14)
    if point is None:
        raise StepFailed("Newton's method finds no gait next to the mid-stance given")
    return Scene(ROLLING if friction is None else COULOMB, walker, y, point.z, steps)


def detailed_scene(biped: Biped, slope: Slope, steps: int) -> Scene:
    """The scene of a detailed design with rolling feet, from mid-stance of its own gait. Raises NoGait, StepFailed."""
    walker, point = find_gait(biped, slope, 1e-13)
    return Scene(DETAILED, walker, crossing_state(walker, point.z, 1e-13), point.z, steps)


def compiled_way(at: Scene, tolerance: float, mark: str = "") -> Way:
    """The compiled integrator of order 8 at a tolerance, with exact multipliers."""
    integrate = partial(record, at.walker, at.upright, at.steps, tolerance, SINGLE_STANCE)

    def walk() -> Walked:
        return measured(at.walker, integrate(), poincare_map(at.walker, at.gait, tolerance).evaluations)

    def multiplier() -> float:
        _, derivative = iterate(at.walker, at.gait, at.walker.gait_steps, tolerance)
        return float(np.abs(multipliers_of(derivative))[0])

    return Way(at.model, "compiled", {"tolerance": tolerance}, integrate, walk, multiplier, mark)


def scipy_way(
    at: Scene, methods: tuple[str, ...], tolerance: float, rates: Rates = compiled_rates, *,
    multiplier: bool = False, mark: str = "",
) -> Way:  # fmt: skip
    """SciPy's method, or that for single stance and another for all phases with both feet down.

    If requested, where the foot rolls, with a multiplier by central differences.
    """
    walk_from = partial(walk_by_scipy, at.walker, methods=methods, tolerance=tolerance, rates=rates)
    integrate = partial(walk_from, at.upright, at.steps)

    def walk() -> Walked:
        segments, _, evaluations = integrate()
        return measured(at.walker, segments, evaluations / at.steps)

    def step(z: Vector) -> Vector:
        return np.asarray(section_coordinates(walk_from(section_state(z, at.walker.p), 1, phase=None)[1], at.walker.p))

    def by_differences() -> float:
        columns = [(step(at.gait + change) - step(at.gait - change)) / (2 * change.sum())
                   for change in np.diag(DIFFERENCE[ANGLES] if at.walker.rigid else DIFFERENCE)]
        return float(np.abs(multipliers_of(np.column_stack(columns)))[0])

    name = f"{'readable, ' * (rates is readable_rates)}SciPy {' and '.join(methods)}"
    measures = by_differences if multiplier and at.walker.rolls else None
    return Way(at.model, name, {"tolerance": tolerance}, integrate, walk, measures, mark)


def measured(walker: Walker, segments: list[Segment], cost: float) -> Walked:
    """What is compared of a walk."""
    walk = sample_walk(walker, segments, GRID_HZ)
    strikes = walk.heel_strike_time
    return Walked(walk.hip_position[: int(strikes[-1] * GRID_HZ)], float(strikes[-1]), float(strikes[-1] - strikes[-2]),
                  peak_force(walker, segments), float(cost))


def peak_force(walker: Walker, segments: list[Segment]) -> float:
    """Largest normal force on a foot [N]."""
    phases = [Phase(walker.on(segment.stance_leg), segment) for segment in segments
              if not (segment.last and segment is segments[0])]

    def normal(_: np.ndarray, f: np.ndarray, foot: slice) -> np.ndarray:
        return np.asarray(f[:, foot][:, NORMAL])

    return max(phase.largest(partial(normal, foot=foot))[1] for phase in phases for foot in FEET) * walker.force


def walk_by_scipy(
    walker: Walker,
    y: Vector,
    heel_strikes: int,
    methods: tuple[str, ...],
    tolerance: float,
    rates: Rates,
    phase: int | None = SINGLE_STANCE,
) -> tuple[list[Segment], Vector, int]:
    """Segments of a walk from `y` (8,) as by `record`, the state after its last heel strike, and rate evaluations.

    `methods` names SciPy's method for single stance and, last, that for all phases with both feet down.
    Raises StepFailed.
    """
    segments: list[Segment] = []
    start, leg, origin, strikes, evaluations, decided = 0.0, 0, 0.0, 0, 0, True
    if phase is None:
        phase, decided = first_phase(y, walker.p)
    for _ in range(MOST_PHASES * heel_strikes):
        if not decided:
            raise StepFailed("friction wedges the trailing foot")
        method = methods[0 if phase <= SINGLE_STANCE else -1]
        standing = walker.on(leg)
        times, states, end, spent = one_phase(standing, phase, y, method, tolerance, rates)
        evaluations += spent
        segment = Segment(
            phase, start, float(times[-1]), leg, origin, times[:-1], states[:-1], end, phase <= SINGLE_STANCE)
        segments.append(segment)
        start += segment.duration
        y = end.copy()
        if segment.last:
            strikes += 1
            origin, leg = next_origin(walker, segment), 1 - leg
        phase, decided = succeed(phase, y, standing.p)
        if strikes == heel_strikes:
            return segments, y, evaluations
    raise StepFailed("the trailing foot changes its contact without end")


def one_phase(
    walker: Walker, phase: int, y: Vector, method: str, tolerance: float, rates: Rates
) -> tuple[Vector, np.ndarray, Vector, int]:
    """Times (n,) and states (n, 8) at the solver's steps of one phase, its end state and rate evaluations."""
    spare, evaluations = np.zeros_like(y), 0

    def counted(_: float, state: Vector) -> Vector:
        nonlocal evaluations  # SciPy's own count leaves out what numerical Jacobians take
        evaluations += 1
        return rates(walker, phase, state)

    def event(now: float, state: Vector) -> float:
        if phase > DOUBLE_STANCE and now < SEEN_AFTER:
            return 1.0
        return float(guard(phase, state, walker.p, spare, 0)[0])

    event.terminal, event.direction = True, -1  # type: ignore[attr-defined]
    times, states, time = [], [], 0.0
    while True:
        solution: Any = solve_ivp(
            counted, (time, TIME_LIMIT_OF_A_PHASE), y, method=method,
            rtol=max(tolerance, 3e-14), atol=tolerance, events=event, max_step=LONGEST_STEP)
        if not solution.success or not solution.t_events[0].size:
            raise StepFailed("the phase does not end")
        times.append(solution.t[:-1])
        states.append(solution.y[:, :-1].T)
        time, y = float(solution.t_events[0][0]), solution.y_events[0][0]
        if guard(phase, y, walker.p, spare, 0)[2]:
            y = on_guard(walker, phase, y)
            kept = np.vstack([*states, y])
            return np.concatenate([*times, [time]]), kept, y, evaluations
        # the swing foot scuffs behind the stance foot: go on just below the ground
        y = y + STRIDE_ON * rates(walker, phase, y)
        time += STRIDE_ON


def on_guard(walker: Walker, phase: int, y: Vector) -> Vector:
    """The event's state moved along its rates until the guard is zero up to round-off, not only to SciPy's root.

    A foot that comes to rest has to be at rest, or it would start to slide again.
    """
    for _ in range(3):
        rates = compiled_rates(walker, phase, y)
        value, rate, _ = guard(phase, y, walker.p, rates, 0)
        y = y - rates * (value / rate) if rate != 0.0 else y
    return y
