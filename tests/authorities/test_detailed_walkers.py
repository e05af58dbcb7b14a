"""Walkers with legs that differ, masses off the legs' lines and a hip with torque and friction, against published ones.

The numbers are what the published equations of motion give at the states below.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.model.walker import build_walker
from stages.analytic.phases.motion import RIGID, flow
from stages.analytic.walk.driven_stance import driven_stance
from stages.biped.design import Biped
from stages.ground.slope import Slope

#: P. A. Bhounsule, "passivewalker", 26 December 2009: M = 1, m = 0.5, I = 0.02, hip to foot centre 1, feet of radius
#: 0.2, mass centre 0.5 below the hip and w forward, slope 0.01, hip torque Th, at (q1, u1, q2, u2) below.
ROUND_FEET = Biped(
    "rigid", hip_mass=1.0, foot_mass=0.5, leg_length=1.2, foot_radius=0.2, foot_com=0.7, stiffness=1.0, damping=0.0,
    leg_inertia=0.02)  # fmt: skip
STATE = 0.19, -0.24, 0.35, -0.06
#: Accelerations of q1 and q2 by w and Th.
PUBLISHED = {
    (0.0, 0.0): (0.20986158624403897, -0.4591141028673396),
    (0.03, 0.0): (0.1890925799693329, -0.3484780261203298),
    (0.03, 0.02): (0.19990259518150155, -0.4967125147303366),
}

#: A. M. Boudali and J. Z. Tang, model of the asymmetric Sydney Compass-Gait Robot with hip friction (2017): inner leg
#: of 0.7 kg, 0.0448 m below the hip, outer of 0.6 kg, 0.0702 m, inertia 0.003 kg m^2 each, hip 2 kg, for gravity
#: -0.409 kg, at hip angle 0.31, stance angle 0.12, rates -1.1 and 0.9, signal 40. Legs with the inertias exchanged in
#: that program are alike here. Accelerations of hip and stance angle with the outer, then with the inner leg standing.
OUTER_FIRST = Biped(
    "rigid", hip_mass=2.0, foot_mass=0.6, leg_length=0.2778, foot_radius=0.0, foot_com=0.2778 - 0.0702, stiffness=1.0,
    damping=0.0, leg_inertia=0.003, hip_gravity_mass=-0.409, hip_damping=0.00156, hip_friction=0.00611,
    other_foot_mass=0.7, other_foot_com=0.2778 - 0.0448)  # fmt: skip
TORQUE = -0.0182 * 40.0
ROBOT = {"outer": (-180.15485013580025, 4.483212785837682), "inner": (-137.59785139198559, 4.690658049699934)}


@pytest.mark.parametrize(("offset", "torque"), PUBLISHED)
def test_offset_masses_and_a_torque_between_the_legs(offset, torque):
    """The torque comes from a spring here, which has it at this angle between the legs."""
    spring = torque / STATE[2]
    biped = dataclasses.replace(ROUND_FEET, foot_offset=offset, hip_stiffness=spring)
    walker = build_walker(biped, Slope(slope_deg=math.degrees(0.01), gravity=1.0), detailed=True)
    q1, u1, q2, u2 = STATE
    rates = np.empty(4)
    flow(RIGID, np.array([-q1, q1 - q2, -u1, u1 - u2]) / walker.scales(), walker.p, rates)
    theta, psi = (rates * walker.scales() / walker.time)[2:]
    assert (-theta, -theta - psi) == pytest.approx(PUBLISHED[offset, torque], rel=1e-14)


@pytest.mark.parametrize("stance", ROBOT)
def test_legs_that_differ_a_counterweight_and_friction(stance):
    """Acceleration over a microsecond from the start, extrapolated."""
    biped = OUTER_FIRST if stance == "outer" else OUTER_FIRST.exchanged
    design, short = DesignPoint(biped, Slope(slope_deg=0.0, gravity=9.81)), 1e-5
    rates = driven_stance(design, np.array([0.12, 0.19, 0.9, -2.0]), short, np.full(3, TORQUE)).states[:, 2:]
    theta, psi = (-1.5 * rates[0] + 2.0 * rates[1] - 0.5 * rates[2]) / short
    assert (theta + psi, theta) == pytest.approx(ROBOT[stance], rel=1e-7)
