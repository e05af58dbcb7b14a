"""The step map: from just after one heel strike to just after the next, legs renamed."""

from __future__ import annotations

import numpy as np

from stages.analytic.compiled import compiled
from stages.analytic.integration.phase import CHATTER, EVENT, STEP_LIMIT, WEDGED, integrate
from stages.analytic.model.kinds import Directions, Kind
from stages.analytic.model.walker import Vector
from stages.analytic.phases.motion import in_contact
from stages.analytic.phases.succession import ends_step, first_phase, succeed

#: A trailing foot that changes between rolling, sliding and hovering more often than this does so without end.
MOST_PHASES = 100
#: Length of the first integration step of all, and the least one to begin a phase with.
FIRST_LENGTH, LEAST_LENGTH = 0.02, 1e-6
#: Evaluations a step may take in all its phases, for each integration step that one phase may take: some two phases'
#: worth, so that many phases that each creep do not add up to minutes.
MOST_EVALUATIONS = 24


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
