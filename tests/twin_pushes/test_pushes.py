"""Pushes to the side: what is walked off, what is left of it, what is refused."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest

from pipeline.errors import StudyError
from stages.studies.result import COMPLETED
from stages.twin_pushes import run as stage
from stages.twin_pushes.result import PushedWalk, Result
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
    """On ice no push is needed."""
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


def made(size, outcome=COMPLETED, reason="", steps=4):
    """A walk that nobody walked, 3 mm to one side and with 0.02 rad of roll to the other."""
    return PushedWalk("speed to the side", "m/s", size, outcome, reason, steps, np.arange(3.0),
                      np.array([0.0, -0.02, 0.01]), np.zeros(3), np.array([1e-3, 5e-3, -2e-3]), 1e-4, -0.01)


def test_the_table_and_the_line_have_every_push_and_no_size_beyond_a_fall_counts_as_walked_off():
    found = Result((made(0.05), made(0.1, "fall", "fell in step 2", 1), made(0.2, steps=3)))
    ((_, _, rows),) = found.tables()
    assert rows[:2] == [
        ["speed to the side", "0.05 m/s", "4", "completed", "1.15", "5.7e-03", "-0.573", "-3.0"],
        ["speed to the side", "0.1 m/s", "1", "fell in step 2", "1.15", "", "", "-3.0"]]
    words = "pushes{}: speed to the side {} m/s {}survived{}".format
    assert found.summary() == "3 " + words(", walked off for 4 steps", 0.05, "", ", 0.1 not")
    alone = ", but the twin falls without a push too"
    assert Result((made(0.1, "fall"),), falls_alone=True).summary() == "1 " + words("", 0.1, "not ", alone)


def test_what_is_left_of_roll_is_the_largest_of_the_last_two_steps(monkeypatch):
    strikes = SimpleNamespace(heel_strike_time=np.array([0.1, 0.5, 0.9, 1.3, 1.7]))
    monkeypatch.setattr(stage, "find_events", lambda record: strikes)
    monkeypatch.setattr(stage, "largest_roll", lambda record, since: since)
    record = SimpleNamespace(time=np.array([0.0, 1.7]), at=lambda times: [np.zeros((len(times), 12))], completed=True,
                             position=np.zeros((2, 12)), outcome=COMPLETED, reason="", heel_strikes=5)  # fmt: skip
    assert stage.pushed_walk(record, "", "", 0.0, 100.0).roll_left == 0.9


def test_one_push_that_is_walked_off_tells_that_the_twin_walks(given, monkeypatch):
    most = max(given[0].settings.sideways_speeds)
    monkeypatch.setattr(stage, "walks_after", lambda pushes, *_: [
        made(size, COMPLETED if size == most else "fall") for _, size in pushes])
    assert not run(*given).falls_alone


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
