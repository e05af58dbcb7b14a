"""The constraint model walked by SciPy's integrators, phase by phase.

The paper takes an explicit pair of order 3(2) in single stance (MATLAB's ode23) and a variable-order implicit one in
double stance (ode15s), sections 2.1 and 2.3. SciPy has their relatives: RK23 is the same pair, BDF the like of ode15s.
Events are found by SciPy on its own interpolants. Rates come from the compiled terms, or, to be independent of them,
from `readable`: the derivation through numpy.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from stages.analytic.gait.poincare import TIME_LIMIT_OF_A_PHASE
from stages.analytic.integration.readable import STRIDE_ON, accelerations
from stages.analytic.model.walker import Vector, Walker
from stages.analytic.phases.flow import DOUBLE_STANCE, SINGLE_STANCE, flow
from stages.analytic.phases.guards import guard
from stages.analytic.phases.succession import first_phase, succeed
from stages.analytic.walk.recording import Segment, is_last, next_origin
from stages.tradeoff.way import WayFailed

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


def walk_by_scipy(
    walker: Walker,
    y: Vector,
    heel_strikes: int,
    methods: Mapping[int, str],
    tolerance: float,
    rates: Rates = compiled_rates,
    phase: int | None = SINGLE_STANCE,
) -> tuple[list[Segment], Vector, int]:
    """Segments of a walk from `y` (8,) as by `record`, the state after its last heel strike, and rate evaluations.

    `methods` names SciPy's method for single stance and, by DOUBLE_STANCE, for all phases with both feet down.
    Raises WayFailed.
    """
    segments: list[Segment] = []
    start, leg, origin, strikes, evaluations, decided = 0.0, 0, 0.0, 0, 0, True
    if phase is None:
        phase, decided = first_phase(y, walker.p)
    for _ in range(MOST_PHASES * heel_strikes):
        if not decided:
            raise WayFailed("friction wedges the trailing foot")
        method = methods[SINGLE_STANCE if phase <= SINGLE_STANCE else DOUBLE_STANCE]
        standing = walker.on(leg)
        times, states, end, spent = one_phase(standing, phase, y, method, tolerance, rates)
        evaluations += spent
        segment = Segment(
            phase, start, float(times[-1]), leg, origin, times[:-1], states[:-1], end, phase <= SINGLE_STANCE)
        segments.append(segment)
        start += segment.duration
        y = end.copy()
        if is_last(segment):
            strikes += 1
            origin, leg = next_origin(walker, segment), 1 - leg
        phase, decided = succeed(phase, y, standing.p)
        if strikes == heel_strikes:
            return segments, y, evaluations
    raise WayFailed("the trailing foot changes its contact without end")


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
            raise WayFailed("the phase does not end")
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
