"""Wheels as limits of walkers: the rimless wheel of the simplest walker, McGeer's synthetic wheel of round feet.

Rimless wheel: P. A. Bhounsule, rimlesswheel.m of 25 August 2013 (repository pab47/pab47.github.io, read there): six
spokes, lambda^2 = 2/3, mu = 2/3, slope 0.2, rate after impact 0.460341126609455. McGeer's paper (Int. J. Robotics
Research 9 (1990) 62) was found with its beginning only, so none of its digits stands here: what it calls a synthetic
wheel is derived below. The parameters of its test machine could not be looked up; that machine is not tested.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from stages.analytic.gait.gait_search import find_gaits
from stages.analytic.gait.poincare import by_stability
from stages.analytic.model.walker import build_walker
from stages.biped.design import Biped
from stages.ground.slope import Slope
from tests.authorities.test_simplest_walker import SLOPE, limit_of_light_feet


def rate_after_impact(half_angle: float, slope: float, kept: float, rate: float = 1.0) -> float:
    """Steady rate of a rimless wheel just after an impact that keeps the share `kept` of it.

    Over a step u-^2 = u+^2 + 4 rate^2 sin(half_angle) sin(slope), and u+ = kept u-.
    """
    gained = 4 * rate**2 * math.sin(half_angle) * math.sin(slope)
    return kept * math.sqrt(gained / (1 - kept**2))


def test_the_formula_has_the_published_digits():
    found = rate_after_impact(math.pi / 6, 0.2, 2 / 3, math.sqrt(2 / 3))
    assert found == pytest.approx(0.460341126609455, abs=1e-14)


@pytest.mark.parametrize("number", [0, 1], ids=["long step", "short step"])
def test_the_hip_of_the_simplest_walker_is_a_rimless_wheel(number):
    """Massless legs: a wheel whose spokes have the angle of the gait, and whose impact keeps cos(2 angle)."""
    angle, rate = limit_of_light_feet()[number][0][:2]
    assert rate == pytest.approx(rate_after_impact(angle, SLOPE, math.cos(2 * angle)), abs=2e-10)


def synthetic_wheel_period() -> float:
    """Period of McGeer's synthetic wheel in swing times 1 / omega: feet as large as the leg, a heavy hip, level ground.

    The hip rolls at constant speed, so the swing leg is a free pendulum. It starts at -alpha with the rate -Omega of
    the leg it was, and ends at alpha with the rate -Omega of the leg it becomes, Omega T = 2 alpha:
    A sin(x) = alpha, A omega cos(x) = -Omega with x = omega T / 2, that is tan(x) = -x.
    """
    return 2 * float(brentq(lambda x: math.sin(x) + x * math.cos(x), 1.6, 3.1, xtol=1e-14))


def test_round_feet_tend_to_mcgeers_synthetic_wheel():
    """Small steps on feet of .999 leg lengths: their period tends to the wheel's with the square of the angle."""
    radius, height = 0.999, 0.5
    angles, periods = [], []
    for share in (0.01, 0.02):
        biped = Biped("rigid", 1e7, 1.0, 1.0, radius, 1.0 - height, 1.0, 0.0, 0.0)
        slope = Slope(slope_deg=math.degrees(share * (1 - radius) ** 2), gravity=1.0)
        gaits = find_gaits(build_walker(biped, slope), 1e-12, unstable=False)
        wheel = min(gaits, key=lambda point: abs(point.steps[0].period - synthetic_wheel_period() * math.sqrt(height)))
        assert by_stability(wheel) < 1
        angles.append(-wheel.z[0])
        periods.append(wheel.steps[0].period / math.sqrt(height))
    slope_of_period, at_zero = np.polyfit(np.square(angles), periods, 1)
    assert slope_of_period > 0
    assert at_zero == pytest.approx(synthetic_wheel_period(), rel=5e-4)
