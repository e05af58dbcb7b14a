"""Rubber under the feet: its mass, and one leg made of a leg and its sole."""

import math

import numpy as np
import pytest

from stages.biped.design import Biped
from stages.biped.rubber import Rubber, ring_sector, soled

TABLE_1 = Biped("compliant", 0.316, 0.335, 0.333, 0.083, 0.1, 2800.0, 58.35, 0.0)
RUBBER = Rubber(foot_width=0.02, outsole_arc=0.112, outsole_density=1100.0)


def grains(outer, thickness, half_angle, count=400):
    """Place (n, 2) and area (n,) of the small pieces of a sector, by the midpoint rule."""
    radius = outer - thickness + thickness * (np.arange(count) + 0.5) / count
    angle = half_angle * (2.0 * (np.arange(count) + 0.5) / count - 1.0)
    radius, angle = (values.ravel() for values in np.meshgrid(radius, angle))
    area = radius * (thickness / count) * (2.0 * half_angle / count)
    return np.column_stack([radius * np.sin(angle), -radius * np.cos(angle)]), area


SECTORS = [(0.085, 0.002, 0.67), (1.0, 1.0, math.pi / 2), (2.0, 0.5, 3.0)]


@pytest.mark.parametrize(("outer", "thickness", "half"), SECTORS)
def test_a_sectors_moments_are_those_of_its_pieces(outer, thickness, half):
    place, area = grains(outer, thickness, half)
    found = ring_sector(outer, thickness, half)
    centre = area @ place / area.sum()
    assert found.area == pytest.approx(area.sum(), rel=1e-9)
    assert found.depth == pytest.approx(-centre[1], rel=1e-5)
    squares = area @ (place - centre) ** 2 / area.sum()
    assert (found.across, found.along) == pytest.approx(tuple(squares), rel=1e-4)


def test_two_millimetres_under_a_foot_weigh_five_grams():
    assert RUBBER.mass(0.083, 0.002) == pytest.approx(0.002 * 0.020 * 0.112 * 1100.0)
    assert RUBBER.mass(0.083, 0.0) == 0.0


def test_leg_and_sole_keep_mass_moment_and_inertia_about_the_hip():
    mass, thickness = 0.0099, 0.002
    whole = soled(TABLE_1, RUBBER, thickness, mass)
    place, area = grains(TABLE_1.foot_radius + thickness, thickness, 0.112 / (2 * 0.083 + 0.002))
    from_hip = place[:, 1] - (TABLE_1.leg_length - TABLE_1.foot_radius)  # the disc's centre stays where it was
    share = area / area.sum()
    moment = TABLE_1.foot_mass * (TABLE_1.leg_length - TABLE_1.foot_com) - mass * share @ from_hip
    second = TABLE_1.foot_mass * (TABLE_1.leg_length - TABLE_1.foot_com) ** 2
    second += mass * share @ (from_hip**2 + place[:, 0] ** 2)
    arm = whole.leg_length - whole.foot_com
    assert whole.foot_mass == TABLE_1.foot_mass + mass
    assert whole.foot_mass * arm == pytest.approx(moment, rel=1e-6)
    assert whole.foot_mass * arm**2 + whole.leg_inertia == pytest.approx(second, rel=1e-6)


def test_without_mass_it_only_lengthens_and_widens():
    grown = soled(TABLE_1, RUBBER, 0.002, 0.0)
    assert (grown.leg_length, grown.foot_radius, grown.foot_com) == pytest.approx((0.335, 0.085, 0.102))
    assert (grown.foot_mass, grown.leg_inertia) == (TABLE_1.foot_mass, 0.0)
