"""The Exudyn twin as a robot with given numbers: its sensors show what the constraint model's would, nearly."""

import dataclasses

import numpy as np
import pytest

from stages.analytic.errors import StepFailed
from stages.calibrated_twin.robot import TwinRobot
from stages.calibration.information.identifiability import first_model
from stages.calibration.observation.measured_run import SIDES, MeasuredRun, Sampling
from stages.calibration.observation.prediction import predict
from stages.calibration.recordings import drawn_design, looked_for
from stages.twin.machine.machine import build
from tests.calibration.runs import BANDWIDTH_HZ, LATE
from tests.study import parameters_of

EVERY = parameters_of("calibrated_twin")


@pytest.fixture(scope="module")
def made():
    """Drawing, model, robot and a run of three steps to be sampled like."""
    drawn = drawn_design(EVERY)
    model = first_model(drawn, looked_for(drawn), EVERY)
    twin = dataclasses.replace(EVERY.twin, tolerance=1e-5)
    robot = TwinRobot(build(EVERY.biped, twin), EVERY.contact, twin, EVERY.settings, model.layout, 5000.0)
    begin = model.layout.middle[model.layout.place("mid_stance")]
    times = np.arange(begin + 0.05, 1.4, 0.01)
    sampling = Sampling(times, times + 0.003, LATE, BANDWIDTH_HZ, 0, below_hip=0.233)
    shape = {side: np.zeros((len(times), 3)) for side in SIDES}
    like = MeasuredRun("like", sampling, shape, {side: one > 0 for side, one in shape.items()}, 0.5 * np.arange(4), {})
    return drawn, model, robot, like


@pytest.fixture(scope="module")
def shown(made):
    """What the robot shows with the design and the unknowns of the drawing."""
    drawn, model, robot, like = made
    return robot.run(drawn, model.layout.middle, like)


def test_in_its_first_swing_the_twin_shows_what_the_model_does(made, shown):
    """Then no contact has yet changed anything but the standing foot's creep."""
    drawn, model, _, like = made
    expected = predict(drawn, (), model.layout.middle, model.layout, like.sampling, 1e-9)
    for side in SIDES:
        early = getattr(like.sampling, side) < shown.strikes[1] - 0.03
        assert early.sum() > 5
        off = np.abs(shown.samples[side] - expected.samples[side][:, :, 0])[early]
        assert off[:, :2].max() < 0.15
        assert off[:, 2].max() < 0.03
    assert shown.strikes[1] == pytest.approx(expected.strikes[0, 0], abs=5e-3)
    assert shown.used["hip"].any()
    assert len(shown.strikes) == len(like.strikes)


def test_its_numbers_are_those_it_is_given(made, shown):
    """A longer leg lands later than a shorter one, by what the constraint model says of it."""
    drawn, model, robot, like = made
    longer = drawn.with_values({"biped.leg_length": 0.345, "biped.other_leg_length": 0.345, "biped.foot_com": 0.112})
    ends = shown.strikes[1], robot.run(longer, model.layout.middle, like).strikes[1]
    said = [predict(each, (), model.layout.middle, model.layout, like.sampling, 1e-8).strikes[0, 0]
            for each in (drawn, longer)]
    assert ends[1] - ends[0] == pytest.approx(said[1] - said[0], rel=0.1)
    assert abs(said[1] - said[0]) > 1e-3


def test_sensors_errors_are_those_it_is_given(made, shown):
    drawn, model, robot, like = made
    unknowns = model.layout.middle.copy()
    unknowns[model.layout.place("hip_rate_bias")] += 0.01
    unknowns[model.layout.place("foot_up_gain")] += 0.02
    plain, wrong = shown.samples, robot.run(drawn, unknowns, like).samples
    np.testing.assert_allclose(wrong["hip"][:, 2] - plain["hip"][:, 2], 0.01, atol=1e-12)
    np.testing.assert_allclose(wrong["foot"][:, 1], 1.02 * plain["foot"][:, 1], rtol=1e-12)


def test_a_robot_that_falls_and_a_run_that_begins_on_the_other_leg_are_said(made):
    drawn, model, robot, like = made
    unknowns = model.layout.middle.copy()
    unknowns[model.layout.place("start_theta_rate")] = 0.05
    other = dataclasses.replace(like, sampling=dataclasses.replace(like.sampling, first_leg=1))
    for words, given in (("does not walk to the end", (unknowns, like)),
                         ("begins on the leg", (model.layout.middle, other))):  # fmt: skip
        with pytest.raises(StepFailed, match=words):
            robot.run(drawn, *given)
