"""An outsole quickens the gait by its length and slows it by its mass."""

import dataclasses
import math
from functools import partial

import pytest

from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.run import neighbour, outsole_effect, zero_of
from stages.biped.rubber import soled
from tests.analytic.designs import RUBBER, SLOPE, TABLE_1, found_gait


def test_the_sign_turns_where_the_frequency_is_the_bare_feets():
    _, point = found_gait(TABLE_1)
    near = partial(neighbour, DesignPoint(TABLE_1, SLOPE), point.z, 1e-10)
    usual = near(TABLE_1)[1]
    found = outsole_effect(near, TABLE_1, RUBBER, 0.002)
    assert found.mass == pytest.approx(9.856e-3)
    assert found.frequency_with_mass < usual < found.frequency_without_mass
    assert 0.0 < found.turning_mass < found.mass
    assert near(soled(TABLE_1, RUBBER, 0.002, found.turning_mass))[1] == pytest.approx(usual, abs=1e-8)
    # most of what the mass does it does as inertia about the leg's mass centre, which Table 1 does not have
    weighed = soled(TABLE_1, RUBBER, 0.002, found.mass)
    as_points = near(dataclasses.replace(weighed, leg_inertia=0.0))[1]
    assert found.frequency_with_mass < as_points < usual


def test_a_layer_that_slows_without_mass_has_no_turning_mass():
    assert math.isnan(zero_of(lambda mass: -1.0 - mass, (0.0, -1.0), (0.01, -1.01)))
    assert zero_of(lambda mass: 1.0 - 100.0 * mass, (0.0, 1.0), (0.02, -1.0)) == pytest.approx(0.01)
