"""The simplest walking model against published numbers.

Garcia, Chatterjee, Ruina, Coleman, J. Biomech. Eng. 120 (1998) 281; the twelve digits are those of M. J. Coleman and
P. Bhounsule for hip mass 1000, foot mass 1 at the end of each leg, leg 1, gravity 1, slope 0.009.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from stages.analytic.gait.gait_search import find_gait
from stages.biped.design import Biped
from stages.ground.slope import Slope

#: stance angle, stance rate, swing angle relative to the stance leg, its rate: just after heel strike, Garcia's signs.
PUBLISHED = (0.200161072169750, -0.199906060087682, 0.400322144339512, -0.015805473227965)
SLOPE = 0.009


def simplest_walker(hip_mass: float = 1000.0) -> Biped:
    return Biped(legs="rigid", hip_mass=hip_mass, foot_mass=1.0, leg_length=1.0, foot_radius=0.0, foot_com=0.0,
                 stiffness=1.0, damping=0.0, leg_inertia=0.0)


@pytest.fixture(scope="module")
def gait():
    walker, point = find_gait(simplest_walker(), Slope(slope_deg=math.degrees(SLOPE), gravity=1.0), 1e-13)
    return walker.stance_state(point.steps[0].state), point


def test_fixed_point_to_ten_digits(gait):
    """Garcia's theta falls through the step and his phi is the stance angle minus the swing leg's own."""
    state, _ = gait
    found = (-state.stance_angle, -state.stance_rate,
             -state.stance_angle - state.swing_angle, -state.stance_rate - state.swing_rate)
    for value, published in zip(found, PUBLISHED, strict=True):
        assert value == pytest.approx(published, abs=1e-12), (found, PUBLISHED)


def test_gait_is_stable(gait):
    _, point = gait
    assert np.abs(point.floquet_multipliers).max() < 1


def test_step_angle_follows_the_cube_root_of_the_slope():
    """Garcia 1998, long-period gait to leading order: stance angle 0.970956 slope^(1/3), period 3.812."""
    angles = []
    for slope in (1e-4, 1e-5):
        _, point = find_gait(simplest_walker(1e7), Slope(slope_deg=math.degrees(slope), gravity=1.0), 1e-12)
        angles.append(-point.z[0] / slope ** (1 / 3))
        period = point.steps[0].period
    assert abs(angles[1] - 0.970956) < abs(angles[0] - 0.970956) < 0.01
    assert period == pytest.approx(3.812, rel=3e-3)
