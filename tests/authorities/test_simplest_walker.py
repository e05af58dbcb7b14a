"""The simplest walking model against published numbers.

Garcia, Chatterjee, Ruina, Coleman, J. Biomech. Eng. 120 (1998) 281; the twelve digits are those of M. J. Coleman and
P. Bhounsule for hip mass 1000, foot mass 1 at the end of each leg, leg 1, gravity 1, slope 0.009. With feet of no mass:
simplestwalker.m of 25 August 2013, P. A. Bhounsule (repository pab47/pab47.github.io, read there); he closes its gaits
to some 1e-10. A stance angle of .200310900544287, which is remembered, could not be looked up; this walker has it.
"""

import math
from functools import cache

import numpy as np
import pytest

from stages.analytic.gait.gait_search import find_gait, find_gaits
from stages.analytic.gait.poincare import poincare_map
from stages.analytic.model.walker import build_walker
from stages.biped.design import Biped
from stages.ground.slope import Slope

#: stance angle, stance rate, swing angle relative to the stance leg, its rate: just after heel strike, Garcia's signs.
PUBLISHED = (0.200161072169750, -0.199906060087682, 0.400322144339512, -0.015805473227965)
SLOPE = 0.009
#: Feet of no mass, long step and short step: stance angle, stance rate, period.
WITHOUT_MASS = ((0.200310900563820, -0.199832473025474, 3.882), (0.193937369810188, -0.203866927442012, 3.096))
#: Multipliers of the long step as a program found in public quotes them, beside the same gait.
QUOTED = complex(-0.19120868949940, 0.55633363687106)


def simplest_walker(hip_mass: float = 1000.0) -> Biped:
    return Biped(legs="rigid", hip_mass=hip_mass, foot_mass=1.0, leg_length=1.0, foot_radius=0.0, foot_com=0.0,
                 stiffness=1.0, damping=0.0, leg_inertia=0.0)


def test_fixed_point_to_ten_digits():
    """Garcia's theta falls through the step and his phi is the stance angle minus the swing leg's own."""
    walker, point = find_gait(simplest_walker(), Slope(slope_deg=math.degrees(SLOPE), gravity=1.0), 1e-13)
    state = walker.stance_state(point.steps[0].state)
    found = (-state.stance_angle, -state.stance_rate,
             -state.stance_angle - state.swing_angle, -state.stance_rate - state.swing_rate)
    for value, published in zip(found, PUBLISHED, strict=True):
        assert value == pytest.approx(published, abs=1e-12), (found, PUBLISHED)
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


@cache
def limit_of_light_feet():
    """(stance angle, stance rate, period) and multipliers of both gaits, extrapolated to feet of no mass.

    The gait depends on the mass ratio e smoothly; three ratios a factor 10 apart leave an error of order e^3.
    """
    found = []
    for hip_mass in (1e4, 1e5, 1e6):
        walker = build_walker(simplest_walker(hip_mass), Slope(slope_deg=math.degrees(SLOPE), gravity=1.0))
        gaits = find_gaits(walker, 1e-14, unstable=True)[:2]
        found.append([np.array([-gait.z[0], gait.z[1] / walker.time, gait.steps[0].period * walker.time,
                                *gait.floquet_multipliers[:2]]) for gait in gaits])  # fmt: skip
    limits = []
    for coarse, middle, fine in zip(*found, strict=True):
        once, twice = (10 * middle - coarse) / 9, (10 * fine - middle) / 9
        limit = (100 * twice - once) / 99
        limits.append((limit[:3].real, limit[3:]))
    return limits


@pytest.mark.parametrize("number", [0, 1], ids=["long step", "short step"])
def test_light_feet_tend_to_the_published_gaits(number):
    found, _ = limit_of_light_feet()[number]
    angle, rate, period = WITHOUT_MASS[number]
    assert found[:2] == pytest.approx([angle, -rate], abs=3e-10)
    assert found[2] == pytest.approx(period, abs=5e-4)


def test_the_remembered_thirteen_digits():
    """Not looked up, see above: what a limit in the mass of the feet gives."""
    found, _ = limit_of_light_feet()[0]
    assert found[:2] == pytest.approx([0.200310900544287, 0.199832473004977], abs=1e-12)


def by_differences(walker, gait, h):
    """Leading multiplier by central differences of the map over 2 h."""
    columns = [(poincare_map(walker, gait.z + e, 1e-14).z - poincare_map(walker, gait.z - e, 1e-14).z) / (2 * h)
               for e in h * np.eye(3)]  # fmt: skip
    multipliers = np.linalg.eigvals(np.column_stack(columns))
    return multipliers[np.argmax(multipliers.imag)]


def test_multipliers_of_light_feet():
    """Two digits of the quoted multipliers are right, no more; the short step's are quoted as 4.000 and 0.459.

    Central differences of the map tend to the exact derivative with the square of their step; they are as far off as
    the quoted numbers, 1.7e-3, at a step of some 4e-4.
    """
    _, multipliers = limit_of_light_feet()[0]
    found = complex(multipliers[np.argmax(multipliers.imag)])
    assert found == pytest.approx(complex(-0.190099841, 0.557598777), abs=2e-8)
    assert abs(found - QUOTED) == pytest.approx(1.7e-3, rel=0.05)
    walker = build_walker(simplest_walker(1e6), Slope(slope_deg=math.degrees(SLOPE), gravity=1.0))
    gait = find_gaits(walker, 1e-14, unstable=False)[0]
    exact = gait.floquet_multipliers[0]
    errors = [abs(by_differences(walker, gait, h) - exact) for h in (4e-4, 1e-5, 1e-6)]
    assert errors[2] < 5e-8 and errors[1] / errors[2] == pytest.approx(100, rel=0.2)
    assert 1e-3 < errors[0] < 3e-3
    _, short = limit_of_light_feet()[1]
    assert short.real == pytest.approx([4.0039, 0.45959], abs=1e-4)
    assert short.real == pytest.approx([4.000, 0.459], abs=5e-3)
