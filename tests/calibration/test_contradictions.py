"""What a recording of angles says against the file that came with it is said, and ends with 3 where it settles it."""

import dataclasses
import math

import numpy as np
import pytest

from stages.biped.question import WrongOption
from stages.calibration.angles.fit import HeldOut, fit_robot
from stages.calibration.angles.recording import bridged, read_steps
from stages.calibration.angles.robot import FARTHEST_ZERO, setup_of
from stages.calibration.estimation.least_squares import Known, NotIdentified
from stages.calibration.intervals.model_error import correlation_length
from stages.calibration.reports.angle_report import (
    Calibrated,
    answered,
    calibrated,
    contradictions,
    refuted,
)
from tests.calibration.runs import BIPED
from tests.calibration.test_angles import LEVEL, ROBOT, about, driven, sizes

LOOKED_FOR = ("biped.foot_com", "torque_constant", "hip_zero")
HEAD = "time_s,stance_angle_rad,hip_angle_rad,motor_signal,outer_pair_stands"


def setup(text="", known=()):
    plain = setup_of(about(text), BIPED, LEVEL)
    return dataclasses.replace(plain, robot=ROBOT, free=LOOKED_FOR, known=(*plain.known, *known))


def said(truth, known=(), turned=1.0, text=""):
    """Contradictions of a robot's steps, fitted from `ROBOT`."""
    steps = [dataclasses.replace(one, between=turned * one.between) for one in driven(truth, 5, 4, 1e-3, 60)]
    asked = setup(text, known)
    fit = fit_robot(ROBOT, steps, LOOKED_FOR, sizes(ROBOT), {}, asked.known, 1e-3)
    sd = dict(zip(LOOKED_FOR, np.sqrt(np.diag(fit.covariance(np.array([sizes(ROBOT)[n] for n in LOOKED_FOR])))),
                  strict=True))  # fmt: skip
    return contradictions(asked, fit, sd, steps)


def test_a_robot_as_described_is_not_contradicted():
    assert said(ROBOT, (Known("torque_constant", 0.018, 1e-3),)) == []
    assert not refuted([])


def test_a_known_value_is_tested_against_all_else_by_its_own_error():
    """A known value that pulls the fit to itself is tested as if it had not: z is the difference of two estimates."""
    (one,) = said(ROBOT, (Known("torque_constant", 0.018 + 5e-4, 1e-4),))
    assert "torque_constant is known as" in one[0] and one[1] == pytest.approx(5.0, abs=1.0)
    assert not refuted([one]) and refuted([one, one])
    assert refuted([("", 10.1)])


def test_zeros_beyond_two_degrees_and_turned_signs_are_said():
    (far,) = said(ROBOT.with_values({"hip_zero": math.radians(3.0)}))
    assert far[0].startswith("hip_zero comes out +3.0 degrees off")
    assert said(ROBOT.with_values({"hip_zero": math.radians(1.5)})) == []
    (turned,) = said(ROBOT.with_values({"torque_constant": -0.018}))
    assert "torque_constant comes out with the other sign" in turned[0]
    assert refuted([turned])


def test_a_zero_that_the_file_gives_counts_as_known_and_is_tested_like_one():
    given = "robot: {hip_zero: {value: 0.0, unit: rad}}"
    assert setup(given).known == (Known("hip_zero", 0.0, FARTHEST_ZERO / 3),)
    (far,) = said(ROBOT.with_values({"hip_zero": math.radians(3.0)}), text=given)
    assert "hip_zero is known as 0" in far[0] and far[1] == pytest.approx(4.5, abs=0.1)


def test_a_column_that_is_turned_shows_where_both_feet_are_on_the_ground():
    assert any("one of the columns" in one[0] and "is turned" in one[0] for one in said(ROBOT, turned=-1.0))


def written(path, steps, turn=1.0):
    """Steps as a recording; `turn` its angles' unit."""
    rows, time = [HEAD], 0.0
    for one in steps:
        for stance, between, signal in zip(one.stance, one.between, one.signal, strict=True):
            rows.append(f"{time:.4f},{-turn * stance!r},{-turn * one.turn * between!r},{-one.turn * signal!r},"
                        f"{int(one.leg == 0)}")  # fmt: skip
            time += one.interval
    path.write_text("\n".join(rows).replace("np.float64(", "").replace(")", "") + "\n")
    return path


def test_angles_in_degrees_are_refused_by_column_and_unit(tmp_path):
    steps = driven(ROBOT, 3, 2, 0.0, 40)
    with pytest.raises(WrongOption, match=r"column stance_angle_rad reaches .* degrees, so multiply it by pi / 180"):
        read_steps(written(tmp_path / "steps.csv", steps, 180 / math.pi), {}, 2)
    with pytest.raises(NotIdentified, match="columns' units"):
        fit_robot(ROBOT.with_values({"stance_zero_0": math.inf}), steps, (), {}, {}, (), 1e-3)


def test_outliers_are_bridged_and_a_curve_without_any_is_left_alone():
    time = np.arange(100) * 0.005
    clean = 0.3 * np.sin(6.0 * time) + 0.2 * time**2
    noisy = clean + 1e-4 * np.random.default_rng(2).normal(size=100)
    same, none = bridged(noisy)
    np.testing.assert_array_equal(same, noisy)
    spoiled = noisy.copy()
    spoiled[[0, 17, 18, 60, 99]] += np.array([0.2, -0.3, 0.1, 0.05, -0.2])
    mended, count = bridged(spoiled)
    assert (none, count) == (0, 5)
    np.testing.assert_allclose(mended, clean, atol=2e-3)


def test_samples_count_as_what_they_are_worth(tmp_path):
    """With residuals that hang together a known value weighs against as many samples as are worth one."""
    rng, steps = np.random.default_rng(4), driven(ROBOT, 3, 4, 0.0, 60)
    drifts = [np.convolve(rng.normal(size=79), np.full(20, 1e-3), mode="valid") for _ in steps]
    recorded = [dataclasses.replace(one, between=one.between + drift)
                for one, drift in zip(steps, drifts, strict=True)]  # fmt: skip
    path = written(tmp_path / "steps.csv", recorded)
    text = "held_out: []\nfree: [torque_constant]\nrecording: {left_out_samples: 0}\ndesign: {legs: rigid}"
    told = calibrated(ROBOT.design.biped, LEVEL, about(text), path)
    residuals = list(told.fit.residuals.values())
    length, rms = correlation_length(residuals), math.sqrt(np.mean(np.concatenate(residuals) ** 2))
    assert length > 2.0
    assert told.fit.noise == pytest.approx(rms * math.sqrt(length), rel=0.05)


@pytest.mark.parametrize("converged", [True, False])
def test_a_fit_that_is_not_at_rest_has_no_intervals_and_ends_with_3(converged):
    steps = driven(ROBOT, 5, 4, 1e-3, 60)
    fit = dataclasses.replace(fit_robot(ROBOT, steps, LOOKED_FOR, sizes(ROBOT), {}, (), 1e-3), converged=converged)
    tell = HeldOut(1, 0.1, (1e-3, 1e-3), (1e-3, 1e-3), fit.residuals)
    answer = answered(Calibrated(setup(), fit, tell, tell, dict.fromkeys(LOOKED_FOR, 1e-3), [], not converged))
    assert answer.no is not converged
    assert any("intervals" in title for title, _, _ in answer.tables) is converged
    assert all((row["sd"] is not None) is converged for row in answer.plain["numbers"].values())
    assert bool(answer.parameters) is converged
