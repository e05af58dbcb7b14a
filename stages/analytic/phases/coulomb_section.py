"""The section just after heel strike where the trailing foot may slip or rise.

Coordinates z = (theta, L_1, L_2, dtheta, dL_1, v_N, v_T): those of the rolling walker, then the rate of the trailing
foot's clearance and its slip velocity, zero for a foot that rolls. A foot on the ground has v_N = 0, and the map does
not ask for v_N below zero; where it is at rest, v_T = 0 has no neighbour either. Their columns of the derivative are
then zero: the derivative holds for the states that heel strikes lead to.
"""

from __future__ import annotations

from math import acos, cos

import numpy as np

from stages.analytic.compiled import Numbers, compiled
from stages.analytic.model import equations as eq
from stages.analytic.model.elimination import dot
from stages.analytic.model.walker import Vector
from stages.analytic.phases.coulomb_guard import slip_speed
from stages.analytic.phases.flow import contact_directions, row4_times

#: Slower than this, in leg lengths and pendulum times, the trailing foot is at rest: round-off of an impact.
AT_REST = 1e-11


@compiled
def landed_state(z: Vector, p: Numbers) -> Vector:
    """State y (8,) just after heel strike from its section coordinates z (7,); NaN where the foot is out of reach."""
    y = np.empty(8)
    y[0], y[1], y[3], y[4], y[5] = z[0], z[1], z[2], z[3], z[4]
    y[2] = -acos((z[1] - p[3]) * cos(z[0]) / (z[2] - p[3]))
    y[6], y[7] = 0.0, 0.0
    normal, roll, _, _ = contact_directions(y, p)
    rates = (y[4], y[5], 0.0, 0.0)
    f1, f2 = max(z[5], 0.0) - dot(normal, rates), z[6] - dot(roll, rates)
    inverse = 1.0 / (normal[2] * roll[3] - normal[3] * roll[2])
    y[6] = inverse * (f1 * roll[3] - normal[3] * f2)
    y[7] = inverse * (normal[2] * f2 - roll[2] * f1)
    return y


@compiled
def landing_coordinates(y: Vector, p: Numbers) -> Vector:
    """Section coordinates z (7,) of a state just after heel strike; speeds at round-off are zero."""
    height_rate, slip = slip_speed(y, p)
    return np.array([y[0], y[1], y[3], y[4], y[5], height_rate if height_rate > AT_REST else 0.0,
                     slip if abs(slip) > AT_REST else 0.0])


@compiled
def landing_tangent(z: Vector, y: Vector, p: Numbers) -> Vector:
    """Derivative of `landed_state` at its value y, columns one after another, shape (7 * 8,)."""
    normal, roll, _, _ = contact_directions(y, p)
    by_state = eq.contact_acceleration_jacobian(
        y[0], y[1], y[2], y[3], 0.0, 0.0, 0.0, 0.0, y[4], y[5], y[6], y[7], p)
    inverse = 1.0 / (normal[2] * roll[3] - normal[3] * roll[2])
    tangent = np.zeros(56)
    for column in range(7):
        if (column == 5 and z[5] <= 0.0) or (column == 6 and z[5] <= 0.0 and z[6] == 0.0):
            continue
        s = 8 * column
        if column < 5:
            tangent[s + (0, 1, 3, 4, 5)[column]] = 1.0
        tangent[s + 2] = -(normal[0] * tangent[s] + normal[1] * tangent[s + 1] + normal[3] * tangent[s + 3]) / normal[2]
        rates = (tangent[s + 4], tangent[s + 5], 0.0, 0.0)
        f1 = (1.0 if column == 5 else 0.0) - dot(normal, rates) - row4_times(by_state[0:4], tangent, s)
        f2 = (1.0 if column == 6 else 0.0) - dot(roll, rates) - row4_times(by_state[8:12], tangent, s)
        tangent[s + 6] = inverse * (f1 * roll[3] - normal[3] * f2)
        tangent[s + 7] = inverse * (normal[2] * f2 - roll[2] * f1)
    return tangent


@compiled
def landing_variations(y: Vector, p: Numbers) -> np.ndarray:
    """Derivative (7, j) of the section coordinates from the state and its j variations in y ((1 + j) * 8,)."""
    normal, roll, _, _ = contact_directions(y, p)
    by_state = eq.contact_acceleration_jacobian(
        y[0], y[1], y[2], y[3], 0.0, 0.0, 0.0, 0.0, y[4], y[5], y[6], y[7], p)
    z = landing_coordinates(y, p)
    derivative = np.zeros((7, y.size // 8 - 1))
    for j in range(derivative.shape[1]):
        s = 8 * (j + 1)
        for row, entry in enumerate((0, 1, 3, 4, 5)):
            derivative[row, j] = y[s + entry]
        rates = (y[s + 4], y[s + 5], y[s + 6], y[s + 7])
        if z[5] > 0.0:
            derivative[5, j] = dot(normal, rates) + row4_times(by_state[0:4], y, s)
        if z[5] > 0.0 or z[6] != 0.0:
            derivative[6, j] = dot(roll, rates) + row4_times(by_state[8:12], y, s)
    return derivative
