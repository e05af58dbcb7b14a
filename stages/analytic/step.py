"""The step map: from just after one heel strike to just after the next, legs renamed."""

from __future__ import annotations

from math import acos, cos, sin

import numpy as np

from stages.analytic.compiled import compiled
from stages.analytic.flow import DOUBLE_STANCE, RIGID, SINGLE_STANCE
from stages.analytic.phase import EVENT, integrate
from stages.analytic.transitions import heel_strike_reset

NO_NODES = np.empty((0, 10))


@compiled
def walk_step(rigid, y, p, tolerance, time_limit, step_limit, nodes):
    """Advance state and variations by one step, in place; compliant legs start in double stance.

    Returns (status, phase, double stance time, period, nodes filled, evaluations): `phase` is where it ended if
    the status is not EVENT.
    """
    double, single, count, evaluations, h = 0.0, 0.0, np.int64(0), 0, 0.02
    phase = RIGID if rigid else DOUBLE_STANCE
    status = EVENT
    for _ in range(1 if rigid else 2):  # one call, no constants in it: each constant is compiled apart
        status, duration, h, count, more = integrate(phase, y, p, tolerance, time_limit, step_limit, h, nodes, count)
        evaluations += more
        if phase == DOUBLE_STANCE:
            double = duration
            if status != EVENT:
                break
            phase = SINGLE_STANCE
            h = max(min(h, 0.02), 1e-6)
        else:
            single = duration
    if status == EVENT:
        heel_strike_reset(phase, y, p)
    return status, phase, double, double + single, count, evaluations


@compiled
def section_state(rigid, z, p):
    """State just after heel strike from its section coordinates, eqs. (3) and (4).

    Rigid: z = (theta, dtheta, dpsi). Compliant: z = (theta, L_1, L_2, dtheta, dL_1); the trailing foot's angle
    and two rates follow from its constraints.
    """
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
def section_coordinates(rigid, y):
    """The section coordinates z of a state just after heel strike, or of a variation of it."""
    if rigid:
        return np.array([y[0], y[2], y[3]])
    return np.array([y[0], y[1], y[3], y[4], y[5]])
