"""The step map: from just after one heel strike to just after the next, legs renamed."""

from __future__ import annotations

from math import acos, cos, sin
from typing import Any

import numpy as np

from stages.analytic.compiled import Numbers, compiled
from stages.analytic.integration.phase import CHATTER, EVENT, STEP_LIMIT, WEDGED, integrate
from stages.analytic.model.walker import Vector
from stages.analytic.phases.coulomb_section import landed_state, landing_coordinates
from stages.analytic.phases.flow import SINGLE_STANCE
from stages.analytic.phases.succession import first_phase, in_contact, succeed

NO_NODES = np.empty((0, 10))
#: A trailing foot that changes between rolling, sliding and hovering more often than this does so without end.
MOST_PHASES = 100
#: Evaluations a step may take in all its phases, for each integration step that one phase may take: some two phases'
#: worth, so that many phases that each creep do not add up to minutes.
MOST_EVALUATIONS = 24


@compiled
def walk_step(
    rigid: bool, y: Vector, p: Numbers, tolerance: float, time_limit: float, step_limit: int, nodes: np.ndarray
) -> tuple[int, int, float, float, int, int]:
    """Advance state and variations by one step, in place; compliant legs start in double stance.

    Returns (status, phase, double stance time, period, nodes filled, evaluations): `phase` is where it ended if
    the status is not EVENT.
    """
    double, time, evaluations, h = 0.0, 0.0, 0, 0.02
    count: Any = np.int64(0)
    phase, decided = first_phase(rigid, y, p)
    for _ in range(MOST_PHASES):  # one call, no constants in it: each constant is compiled apart
        if not decided:
            return WEDGED, phase, double, time, count, evaluations
        status, duration, h, count, more = integrate(phase, y, p, tolerance, time_limit, step_limit, h, nodes, count)
        time += duration
        evaluations += more
        if status != EVENT:
            return status, phase, double, time, count, evaluations
        if evaluations > MOST_EVALUATIONS * step_limit:
            return STEP_LIMIT, phase, double, time, count, evaluations
        if in_contact(phase):
            double = time
        ended = phase
        phase, decided = succeed(phase, y, p)
        if ended <= SINGLE_STANCE:
            return EVENT if decided else WEDGED, ended, double, time, count, evaluations
        h = max(min(h, 0.02), 1e-6)
    return CHATTER, phase, double, time, count, evaluations


@compiled
def section_state(rigid: bool, z: Vector, p: Numbers) -> Vector:
    """State just after heel strike from its section coordinates, eqs. (3) and (4).

    Rigid: z = (theta, dtheta, dpsi). Compliant: z = (theta, L_1, L_2, dtheta, dL_1); the trailing foot's angle
    and two rates follow from its constraints. With limited friction z goes on with those two rates of the trailing
    foot, see `coulomb_section`.
    """
    if not rigid and p[10] < np.inf:
        return landed_state(z, p)
    if rigid:
        return np.array([z[0], -abs(z[0]), z[1], z[2]])
    theta, stance, swing = z[0], z[1] - p[3], z[2] - p[3]
    psi = -acos(stance * cos(theta) / swing)
    dtheta, dstance = z[3], z[4]
    # clearance rate = 0 and slip of the trailing foot = 0, solved for (dpsi, dL_2)
    a11, a12 = swing * sin(psi), -cos(psi)
    a21, a22 = swing * cos(psi) + p[3], sin(psi)
    f1 = stance * sin(theta) * dtheta - dstance * cos(theta)
    f2 = -(p[3] + stance * cos(theta)) * dtheta - sin(theta) * dstance
    inverse = 1.0 / (a11 * a22 - a12 * a21)
    dpsi = inverse * (f1 * a22 - a12 * f2)
    dswing = inverse * (a11 * f2 - a21 * f1)
    return np.array([theta, z[1], psi, z[2], dtheta, dstance, dpsi, dswing])


@compiled
def section_coordinates(rigid: bool, y: Vector, p: Numbers) -> Vector:
    """The section coordinates z of a state just after heel strike."""
    if not rigid and p[10] < np.inf:
        return landing_coordinates(y, p)
    return section_variation(rigid, y)


@compiled
def section_variation(rigid: bool, y: Vector) -> Vector:
    """The variation of the section coordinates, for a variation of a state on the section where feet roll."""
    if rigid:
        return np.array([y[0], y[2], y[3]])
    return np.array([y[0], y[1], y[3], y[4], y[5]])
