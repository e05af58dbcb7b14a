"""What is told of calibrated robots: errors, gaits and what an outsole does, from fits that are made up."""

import dataclasses
import math
from types import SimpleNamespace

import numpy as np
import pytest

from stages.analytic.gait.gait_search import find_gait, gait_near
from stages.calibrated_twin.told import Fitted, Left, design_of, frequency, pairs_of, robot_of
from stages.calibration.result import FittedRun, Trace
from tests.calibration.runs import DESIGN

NAMES = ("biped.foot_mass", "biped.leg_length", "biped.foot_radius", "biped.foot_com")
VALUES = np.array([DESIGN.value(name) for name in NAMES])
NEAR = find_gait(DESIGN.biped, DESIGN.slope, 1e-6)[1].z
NONE = Trace(np.zeros(0), np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 3)))
SD = np.array([3e-4, 2e-4, 1e-4, 1e-4])
BIAS = np.array([3e-3, 1e-3, -2e-3, 5e-4])


def fit(name, kind, truth, off=0.0, wider=2.0):
    return FittedRun(name, kind, truth + BIAS + off, np.array([2.0, 0.333]), np.zeros(25), np.diag((wider * SD) ** 2),
                     truth, 1.5, wider, 30, True, "", NONE, NONE, np.arange(8.0))


def corrections(bias=BIAS):
    return {0: SimpleNamespace(bias=bias)}


def test_a_correction_takes_the_bias_off_and_leaves_its_share_in_the_interval():
    fitted = Fitted("with outsole", DESIGN, [fit("run 01", "with outsole", VALUES)], corrections())
    robot = robot_of(fitted, NAMES, Left(0.5, 0.1), NEAR)
    for row, number in enumerate(robot.numbers):
        assert number.corrected == pytest.approx(number.truth, rel=1e-12)
        assert number.found == pytest.approx(number.truth + BIAS[row])
        assert number.sd == pytest.approx(math.hypot(2.0 * SD[row], 0.5 * BIAS[row]))
        lower, upper = number.interval(2.0)
        assert upper - lower == pytest.approx(4.0 * number.sd)
    assert robot.frequency == pytest.approx(robot.true_frequency, rel=1e-9)
    assert (robot.runs, robot.corrected_runs) == (1, 1)
    np.testing.assert_allclose(robot.correlations, np.eye(4))


def test_without_a_correction_intervals_stay_widened():
    fitted = Fitted("lab", DESIGN, [fit("run 01", "lab", np.full(4, math.nan))], {})
    found = dataclasses.replace(fitted.fits[0], design=VALUES)
    robot = robot_of(Fitted("lab", DESIGN, [found], {}), NAMES, Left(0.5, 0.1), NEAR)
    for row, number in enumerate(robot.numbers):
        assert number.corrected == number.found
        assert number.sd == pytest.approx(2.0 * SD[row])
        assert math.isnan(number.truth)
    assert math.isnan(robot.true_frequency)


def test_more_runs_tell_more_but_for_the_bias():
    one = Fitted("lab", DESIGN, [fit("run 01", "lab", VALUES)], corrections())
    four = Fitted("lab", DESIGN, [fit(f"run 0{number}", "lab", VALUES) for number in range(1, 5)], corrections())
    noise = np.diag(four.covariance(0.0)) / np.diag(one.covariance(0.0))
    np.testing.assert_allclose(noise, 0.25)
    assert (np.diag(four.covariance(0.5)) > (0.5 * BIAS) ** 2).all()


def test_a_frequencys_error_is_that_of_differences():
    """Along one parameter alone: the slope that carries its error is the gait's own."""
    covariance = np.zeros((4, 4))
    covariance[1, 1] = 1e-8
    value, sd = frequency(design_of(DESIGN, NAMES, VALUES), NAMES, covariance, NEAR)
    step = np.array([0.0, 1e-5, 0.0, 0.0])
    ends = [frequency(design_of(DESIGN, NAMES, VALUES + part * step), NAMES, covariance, NEAR)[0] for part in (1, -1)]
    assert sd == pytest.approx(1e-4 * abs(ends[0] - ends[1]) / 2e-5, rel=1e-4)
    assert value == pytest.approx(np.mean(ends), rel=1e-6)


def test_a_pair_tells_what_the_outsole_does():
    longer = np.array([0.01, 0.002, 0.002, 0.0])
    usual = Fitted("with outsole", DESIGN, [fit("synthetic run 01", "with outsole", VALUES + longer)], corrections())
    without = fit("synthetic bare run 01", "without outsole", VALUES)
    bare = Fitted("without outsole", DESIGN, [without], corrections(0.9 * BIAS))
    (pair,) = pairs_of(usual, bare, NAMES, Left(0.5, 0.1), NEAR)
    assert pair.name == "synthetic run 01"
    assert pair.longer == pytest.approx(0.002 - 0.1 * BIAS[1])
    assert pair.true_longer == pytest.approx(0.002)
    assert pair.longer_sd == pytest.approx(math.sqrt(8 * SD[1] ** 2 + (0.1 * 0.95 * BIAS[1]) ** 2))
    assert pair.heavier == pytest.approx(0.01 - 0.1 * BIAS[0])
    ends = [frequency(design_of(DESIGN, NAMES, each), NAMES, np.eye(4), NEAR)[0] for each in (VALUES + longer, VALUES)]
    assert pair.true_slower == pytest.approx(ends[0] / ends[1] - 1, rel=1e-9)
    assert pair.slower == pytest.approx(pair.true_slower, abs=2 * pair.slower_sd)
    assert pair.slower_sd < 5e-3
    alone = Fitted("with outsole", DESIGN, [fit("synthetic run 09", "with outsole", VALUES)], corrections())
    assert pairs_of(alone, bare, NAMES, Left(0.5, 0.1), NEAR) == ()


def test_the_gait_near_anothers_is_the_one_that_a_search_finds():
    other = design_of(DESIGN, NAMES, VALUES * 1.02)
    _, found = find_gait(other.biped, other.slope, 1e-9)
    for near in (NEAR, np.zeros(5), np.zeros(3)):  # from its neighbour's; from where nobody walks; of another walker
        assert gait_near(other, near, 1e-9)[1].z == pytest.approx(found.z, abs=1e-8)


def test_frames_belong_to_the_hip_as_table_1_counts_it():
    biped = dataclasses.replace(DESIGN.biped, hip_mass=0.016, frame_mass=0.15, frame_com=0.015, frame_inertia=2e-4)
    design = dataclasses.replace(DESIGN, biped=biped)
    names = ("biped.frame_mass",)
    one = dataclasses.replace(fit("run", "lab", VALUES, wider=1.0), design=np.array([0.151]), truth=np.array([0.15]),
                              covariance=np.array([[1e-8]]))  # fmt: skip
    (number,) = robot_of(Fitted("lab", design, [one], {}), names, Left(0.5, 0.1), NEAR).numbers
    assert number.name == "biped.hip_mass"
    assert (number.drawn, number.found, number.truth) == pytest.approx((0.316, 0.318, 0.316))
    assert number.sd == pytest.approx(2e-4)
