"""Pushes to the side: what is walked off, what is left of it, what is refused."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest

from pipeline.errors import StudyError
from stages.twin_pushes.run import Inputs, again, run
from tests.planar_start import ROUGH
from tests.study import parameters_of


@pytest.fixture(scope="module")
def parameters():
    return parameters_of("twin_pushes")


@pytest.fixture(scope="module")
def given(parameters):
    """Four steps after one soft and one deadly push to the side and a soft one of each other kind."""
    analytic = SimpleNamespace(mid_stance=ROUGH, walk=SimpleNamespace(standing_force=9.4))
    settings = dataclasses.replace(
        parameters.settings, steps=4, tolerance=1e-4, sideways_speeds=(0.05, 1.0), roll_rates=(0.2,), yaw_rates=(0.5,),
        yaw_angles=(0.05,),
    )  # fmt: skip
    return dataclasses.replace(parameters, settings=settings), Inputs(analytic)


@pytest.fixture(scope="module")
def result(given):
    return run(*given)


def test_for_errors_the_largest_push_that_is_survived_and_the_smallest_that_is_not_are_walked_again(given, result):
    harder = dataclasses.replace(result.walks[1], size=2.0)
    found = dataclasses.replace(result, walks=(*result.walks[:2], harder, *result.walks[2:]))
    closer = again(*given, found)
    assert [one is other for one, other in zip(closer.walks, found.walks, strict=True)] == [
        False, False, True, False, False, False]
    np.testing.assert_array_equal(closer.walks[0].roll, result.walks[0].roll)  # at the same settings


def test_a_soft_push_is_walked_off_and_a_hard_one_is_not(result):
    soft, hard = result.walks[:2]
    assert soft.survived and soft.steps == 4
    assert not hard.survived and hard.reason and np.isnan(hard.yaw_left)
    assert result.limits()[0] == ("speed to the side", "m/s", 0.05, 1.0)
    assert result.limits()[1][2:] == (0.2, np.inf)


@pytest.mark.parametrize(("friction", "falls"), [(0.05, True), (1.1, False)])
def test_who_falls_without_a_push_too_is_not_pushed_over(given, friction, falls):
    """On ice no push is needed; where one of several pushes is survived, none is tried without."""
    parameters, inputs = given
    contact = dataclasses.replace(parameters.contact, static_friction=friction, dynamic_friction=0.9 * friction)
    hard = dataclasses.replace(parameters.settings, sideways_speeds=(1.0,), roll_rates=(20.0,), yaw_rates=(30.0,),
                               yaw_angles=(1.2,))  # fmt: skip
    found = run(dataclasses.replace(parameters, contact=contact, settings=hard), inputs)
    assert not any(walk.survived for walk in found.walks) and found.falls_alone == falls
    assert ("falls without a push too" in found.summary()) == falls
    assert again(dataclasses.replace(parameters, contact=contact, settings=hard), inputs, found).falls_alone == falls


def test_roll_dies_out_and_yaw_stays(result):
    for walk in result.walks[:1] + result.walks[2:]:
        assert walk.survived
        if np.abs(walk.roll).max() > 1e-4:
            assert walk.roll_left < 0.1 * np.abs(walk.roll).max()
    turned = result.walks[-1]
    assert turned.yaw[0] == pytest.approx(0.05) and turned.yaw_left == pytest.approx(0.05, rel=0.02)
    assert turned.lateral[-1] < -0.02, "a machine that has turned walks off to the side"


def test_histories_belong_together(result):
    for walk in result.walks:
        assert len(walk.time) == len(walk.roll) == len(walk.yaw) == len(walk.lateral)
        assert np.isfinite(walk.lateral).all() and walk.time[0] == 0.0


def test_the_table_names_every_push(result):
    ((_, columns, rows),) = result.tables()
    assert len(rows) == 5 and all(len(row) == len(columns) for row in rows)
    assert rows[1][1] == "1 m/s" and rows[1][3] == result.walks[1].reason
    assert "0.05 m/s survived, 1 not" in result.summary()


def test_sizes_that_are_null_are_table_1s_and_another_robots_in_its_own_scales(parameters):
    """A robot of a quarter of Table 1's leg was pushed by as much, which is twice as much in its own speed."""
    assert parameters.settings.sideways_speeds == (0.02, 0.05, 0.1, 0.15, 0.2)
    assert parameters_of("twin_pushes", "twin_pushes.sizes=few").settings.yaw_rates == (2.0, 8.0)
    small = ("biped.leg_length=0.08325", "biped.foot_radius=0.02", "biped.foot_com=0.025", "twin.inertia=planar")
    other = parameters_of("twin_pushes", *small, "twin_pushes.yaw_rates=[0.3]").settings
    assert other.sideways_speeds == pytest.approx((0.01, 0.025, 0.05, 0.075, 0.1), rel=1e-14)
    assert other.roll_rates == pytest.approx((0.4, 1.0, 2.0, 4.0), rel=1e-14)
    assert other.yaw_rates == (0.3,) and other.yaw_angles == (0.05, 0.2), "a size that is given stands"


@pytest.mark.parametrize("sizes", ["[]", "[0.2, 0.1]", "[0.2, 0.2]", "[-0.1]"])
def test_sizes_must_rise(sizes):
    with pytest.raises(StudyError, match=r": sideways_speeds = .* allowed: .*each larger than the one before"):
        parameters_of("twin_pushes", f"twin_pushes.sideways_speeds={sizes}")
