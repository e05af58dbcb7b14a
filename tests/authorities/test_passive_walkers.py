"""Walkers with hip mass, leg inertia and round feet against the roots in P. A. Bhounsule's published programs.

Both have M = 1, m = 0.5, I = 0.02, hip to foot centre 1, hip to mass centre 0.5, gravity 1, slope 0.01. Coordinates
are (q1, u1, q2, u2): stance angle and rate, and the swing leg's relative to it.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from stages.analytic.gait.gait_search import by_stability, find_gait
from stages.analytic.integration.phase import EVENT, NO_NODES, integrate
from stages.analytic.model import terms as eq
from stages.analytic.model.walker import Walker, build_walker
from stages.analytic.phases.motion import RIGID
from stages.biped.design import Biped
from stages.ground.slope import Slope

SLOPE = Slope(slope_deg=math.degrees(0.01), gravity=1.0)
#: Point feet; the program counts q2 with the other sign.
POINT_FEET = (0.162597833780052, -0.231869638058967, 0.325195667560120, -0.037978468073739)
#: "passivewalker", 26 December 2009, round feet of radius 0.2.
ROUND_FEET = (0.189472782205104, -0.239124222551699, 0.378945564410209, -0.053691703909393)


def walker_with_feet(radius: float) -> Biped:
    return Biped(legs="rigid", hip_mass=1.0, foot_mass=0.5, leg_length=1.0 + radius, foot_radius=radius,
                 foot_com=0.5 + radius, stiffness=1.0, damping=0.0, leg_inertia=0.02)


def published_coordinates(walker: Walker, y: np.ndarray) -> np.ndarray:
    """(q1, u1, q2, u2) of a rigid state in the published units."""
    theta, psi, dtheta, dpsi = y * walker.scales()
    return np.array([-theta, -dtheta, -theta - psi, -dtheta - dpsi])


def test_point_feet_to_twelve_digits():
    walker, point = find_gait(walker_with_feet(0.0), SLOPE, 1e-13)
    assert published_coordinates(walker, point.steps[0].state) == pytest.approx(POINT_FEET, abs=1e-12)
    assert by_stability(point) < 1


def published_step(walker: Walker, z: np.ndarray) -> np.ndarray:
    """One step with the impact as the published program has it.

    Its balance of the trailing leg about the hip has a term -I u2 too much: the leg is the old stance leg, whose
    spin is I u1 alone. Adding that term here is the whole difference.
    """
    y = np.array([z[0], -abs(z[0]), z[1], z[2]])
    status, *_ = integrate(RIGID, y, walker.p, 1e-13, 30.0, 10_000, 0.02, NO_NODES)
    assert status == EVENT
    stray = walker.p.I * (y[2] + y[3])
    momentum = np.array(eq.rigid_handover(y[0], y[1], walker.p)).reshape(2, 2) @ y[2:] + stray
    m11, m12, m22, *_ = eq.rigid_terms(-y[1], -y[0], 0.0, 0.0, walker.p)
    return np.array([-y[1], *np.linalg.solve([[m11, m12], [m12, m22]], momentum)])


def test_round_feet_to_twelve_digits_with_the_published_impact():
    """The published root is that of an impact with a stray term; with it, all digits agree."""
    walker = build_walker(walker_with_feet(0.2), SLOPE)
    z = np.array([-0.19, 0.24, 0.05 - 0.24]) * [1, math.sqrt(1.2), math.sqrt(1.2)]
    for _ in range(200):
        z = published_step(walker, z)
    found = published_coordinates(walker, np.array([z[0], -abs(z[0]), z[1], z[2]]))
    assert found == pytest.approx(ROUND_FEET, abs=1e-11)


def test_round_feet_without_the_stray_term():
    """The impact that keeps the trailing leg's angular momentum has a gait nearby, not the same."""
    walker, point = find_gait(walker_with_feet(0.2), SLOPE, 1e-13)
    found = published_coordinates(walker, point.steps[0].state)
    assert np.abs(found - ROUND_FEET).max() == pytest.approx(2.3e-3, rel=0.05)
    assert abs(found[0] - ROUND_FEET[0]) < 1e-4 and by_stability(point) < 1
