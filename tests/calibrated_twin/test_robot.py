"""The Exudyn twin as a robot with given numbers: its sensors show what the constraint model's would, nearly."""

import dataclasses
import math
from functools import cache

import numpy as np
import pytest

from stages.analytic.errors import StepFailed
from stages.analytic.gait.gait_search import find_gait, gait_near
from stages.calibrated_twin.result import Check, Result
from stages.calibrated_twin.robot import TwinRobot
from stages.calibrated_twin.run import Fitted, design_of, frequency, pairs_of, robot_of
from stages.calibration.information.identifiability import first_model
from stages.calibration.intervals.model_error import Discrepancy
from stages.calibration.observation.measured_run import SIDES, MeasuredRun, Sampling
from stages.calibration.observation.prediction import predict
from stages.calibration.recordings import drawn_design, looked_for
from stages.calibration.result import HALF_WIDTH, LAB, FittedRun, Trace
from stages.twin.machine.machine import build
from tests.calibration.runs import BANDWIDTH_HZ, DESIGN, LATE
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


# --- What is told of calibrated robots: errors, gaits and what an outsole does, from fits that are made up.


NAMES = ("biped.foot_mass", "biped.leg_length", "biped.foot_radius", "biped.foot_com")
VALUES = np.array([DESIGN.value(name) for name in NAMES])
NONE = Trace(np.zeros(0), np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 3)))
SD = np.array([3e-4, 2e-4, 1e-4, 1e-4])
BIAS = np.array([3e-3, 1e-3, -2e-3, 5e-4])


@cache
def near():
    """Section coordinates of the design's gait."""
    return find_gait(DESIGN.biped, DESIGN.slope, 1e-6)[1].z


def fit(name, kind, truth, off=0.0, wider=2.0):
    return FittedRun(name, kind, truth + BIAS + off, np.array([2.0, 0.333]), np.zeros(25), np.diag((wider * SD) ** 2),
                     truth, 1.5, wider, 30, True, "", NONE, NONE, np.arange(8.0))


def corrections(bias=BIAS):
    return {0: (bias, None)}


def test_a_correction_takes_the_bias_off_and_all_of_it_counts_where_nothing_tells_what_it_leaves():
    fitted = Fitted("with outsole", DESIGN, [fit("run 01", "with outsole", VALUES)], corrections(), VALUES)
    robot = robot_of(fitted, NAMES, near())
    assert "whole of what the correction took off" in robot.by_what
    for row, number in enumerate(robot.numbers):
        assert number.corrected == pytest.approx(number.truth, rel=1e-12)
        assert number.found == pytest.approx(number.truth + BIAS[row])
        assert number.sd == pytest.approx(math.hypot(2.0 * SD[row], BIAS[row]))
        lower, upper = number.interval(2.0)
        assert upper - lower == pytest.approx(4.0 * number.sd)
    assert robot.frequency == pytest.approx(robot.true_frequency, rel=1e-9)
    assert (robot.runs, robot.corrected_runs) == (1, 1)
    np.testing.assert_allclose(robot.correlations, np.eye(4))


def test_without_a_correction_intervals_stay_widened():
    found = dataclasses.replace(fit("run 01", "lab", np.full(4, math.nan)), design=VALUES)
    robot = robot_of(Fitted("lab", DESIGN, [found], {}, VALUES), NAMES, near())
    assert robot.by_what == "the fit's noise and residuals alone"
    for row, number in enumerate(robot.numbers):
        assert number.corrected == number.found
        assert number.sd == pytest.approx(2.0 * SD[row])
        assert math.isnan(number.truth)
    assert math.isnan(robot.true_frequency)


def test_more_runs_tell_more_but_for_the_bias():
    one = Fitted("lab", DESIGN, [fit("run 01", "lab", VALUES)], {}, VALUES)
    four = Fitted("lab", DESIGN, [fit(f"run 0{number}", "lab", VALUES) for number in range(1, 5)], {}, VALUES)
    np.testing.assert_allclose(np.diag(four.covariance) / np.diag(one.covariance), 0.25)
    twin = dataclasses.replace(four, corrections=corrections())
    assert (np.diag(twin.covariance) > BIAS**2).all()


def test_where_other_machines_tell_what_fits_miss_that_is_taken_off_and_its_scatter_is_the_interval():
    rng = np.random.default_rng(4)
    pulls = rng.normal(size=12) * 1e-3
    shares = BIAS / VALUES + 1e-3 * rng.normal(size=(12, 4)) + np.outer(pulls, [1.0, 0.0, -5.0, 0.0])
    term = Discrepancy.of(shares, pulls)
    one = fit("run 01", "with outsole", VALUES)
    robot = robot_of(Fitted("with outsole", DESIGN, [one], corrections(), VALUES, 1e-3, term), NAMES, near())
    expected, half = term.expected(VALUES, 1e-3), HALF_WIDTH * np.sqrt(np.diag(term.spread(VALUES, 1e-3)))
    for row, number in enumerate(robot.numbers):
        assert number.corrected == pytest.approx(one.design[row] - expected[row])
        assert number.by_twin == pytest.approx(VALUES[row])
        lower, upper = number.interval(HALF_WIDTH)
        assert upper - lower == pytest.approx(2 * half[row])
    assert robot.by_what == "the errors of fits of 12 other robots' runs"


def test_a_frequencys_error_is_that_of_differences():
    """Along one parameter alone: the slope that carries its error is the gait's own."""
    covariance = np.zeros((4, 4))
    covariance[1, 1] = 1e-8
    value, sd = frequency(design_of(DESIGN, NAMES, VALUES), NAMES, covariance, near())
    step = np.array([0.0, 1e-5, 0.0, 0.0])
    ends = [frequency(design_of(DESIGN, NAMES, VALUES + part * step), NAMES, covariance, near())[0] for part in (1, -1)]
    assert sd == pytest.approx(1e-4 * abs(ends[0] - ends[1]) / 2e-5, rel=1e-4)
    assert value == pytest.approx(np.mean(ends), rel=1e-6)


def test_a_pair_tells_what_the_outsole_does():
    longer = np.array([0.01, 0.002, 0.002, 0.0])
    with_it = fit("synthetic run 01", "with outsole", VALUES + longer)
    usual = Fitted("with outsole", DESIGN, [with_it], corrections(), VALUES)
    without = fit("synthetic bare run 01", "without outsole", VALUES)
    bare = Fitted("without outsole", DESIGN, [without], corrections(0.9 * BIAS), VALUES)
    (pair,) = pairs_of(usual, bare, NAMES, near())
    assert pair.name == "synthetic run 01"
    assert pair.longer == pytest.approx(0.002 - 0.1 * BIAS[1])
    assert pair.true_longer == pytest.approx(0.002)
    assert pair.longer_sd == pytest.approx(math.sqrt(8 * SD[1] ** 2 + (0.1 * BIAS[1]) ** 2))
    assert pair.heavier == pytest.approx(0.01 - 0.1 * BIAS[0])
    shared = np.diag(8 * SD**2) + 0.01 * np.outer(BIAS, BIAS)
    (with_it, sd), (without_it, _), (corrected, _) = (
        frequency(design_of(DESIGN, NAMES, each), NAMES, shared, near())
        for each in (VALUES + longer, VALUES, VALUES + 0.1 * BIAS))  # fmt: skip
    assert pair.true_slower == pytest.approx(with_it / without_it - 1, rel=1e-9)
    assert (pair.slower, pair.slower_sd) == pytest.approx((with_it / corrected - 1, sd / corrected), rel=1e-9)
    alone = Fitted("with outsole", DESIGN, [fit("synthetic run 09", "with outsole", VALUES)], corrections(), VALUES)
    assert pairs_of(alone, bare, NAMES, near()) == ()


def test_other_pairs_tell_how_far_a_pair_can_be_trusted():
    """Four pairs: what the other three miss between them is taken off the fourth, and scatters in its interval."""
    off = [{0: 2e-4, 1: 4e-4, 2: 3e-4, 3: 3e-4}[number] * np.array([0.0, 1.0, 0.0, 0.0]) for number in range(4)]
    usual = Fitted("with outsole", DESIGN, [fit(f"synthetic run 0{n}", "with outsole", VALUES, off=off[n])
                                            for n in range(4)], {}, VALUES)  # fmt: skip
    bare = Fitted("without outsole", DESIGN, [fit(f"synthetic bare run 0{n}", "without outsole", VALUES)
                                              for n in range(4)], {}, VALUES)  # fmt: skip
    first = pairs_of(usual, bare, NAMES, near())[0]
    assert first.longer == pytest.approx(2e-4 - np.mean([4e-4, 3e-4, 3e-4]))
    misses = np.array([off[n] for n in (1, 2, 3)])
    assert first.longer_sd == pytest.approx(np.sqrt(Discrepancy.of(misses).spread(np.ones(4))[1, 1]))


def test_the_gait_near_anothers_is_the_one_that_a_search_finds():
    other = design_of(DESIGN, NAMES, VALUES * 1.02)
    _, found = find_gait(other.biped, other.slope, 1e-9)
    for start in (near(), np.zeros(5), np.zeros(3)):  # from its neighbour's; from where nobody walks; of another walker
        assert gait_near(other, start, 1e-9)[1].z == pytest.approx(found.z, abs=1e-8)


def test_frames_belong_to_the_hip_as_table_1_counts_it():
    biped = dataclasses.replace(DESIGN.biped, hip_mass=0.016, frame_mass=0.15, frame_com=0.015, frame_inertia=2e-4)
    design = dataclasses.replace(DESIGN, biped=biped)
    names = ("biped.frame_mass",)
    one = dataclasses.replace(fit("run", "lab", VALUES, wider=1.0), design=np.array([0.151]), truth=np.array([0.15]),
                              covariance=np.array([[1e-8]]))  # fmt: skip
    (number,) = robot_of(Fitted("lab", design, [one], {}, one.design), names, near()).numbers
    assert number.name == "biped.hip_mass"
    assert (number.drawn, number.found, number.truth) == pytest.approx((0.316, 0.318, 0.316))
    assert number.sd == pytest.approx(2e-4)


def test_strikes_are_off_as_those_of_a_labs_runs_with_corrected_numbers():
    """A run is walked as found, and then corrected, if it can be; synthetic runs are of no robot."""
    def off(*checks):
        return Result((), (), tuple(Check(name, kind, "", late, 0.0, 0.0) for name, kind, late in checks), (), None
                      ).strikes_off  # fmt: skip

    assert off(("run 1", LAB, 0.08), ("run 1", LAB, 0.0051), ("run 2", LAB, 0.002), ("run 2", LAB, math.nan)) == 0.0051
    assert off() is None and off(("run 1", "with outsole", 0.004)) is None
