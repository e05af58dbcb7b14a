"""Whether steps of encoders are of a robot that was fitted: made steps, and a real robot's with faults put in."""

import dataclasses
from functools import cache

import pytest

from stages.biped.question import WrongOption
from stages.calibration.angles import same
from stages.calibration.angles.recording import read_steps
from stages.calibration.angles.robot import setup_of
from stages.calibration.angles.same import TURNED, FittedEncoders, judged, turned
from stages.calibration.following.robot_file import NAME
from stages.calibration.reports.angle_report import calibrated
from stages.calibration.reports.change_report import answered
from tests.calibration.test_angles import (
    AUTHORS,
    BIPED,
    LEVEL,
    NAMES,
    RECORDED,
    ROBOT,
    about,
    driven,
    fit_robot,
    needs_real,
    sizes,
)

NOISE, FITTED = 1e-3, 20


@cache
def robot():
    """A robot that is fitted to its own model's steps."""
    fit = fit_robot(ROBOT, driven(ROBOT, 1, FITTED, NOISE, 70), NAMES, sizes(ROBOT), {}, (), NOISE)
    assert fit.converged
    setup = dataclasses.replace(setup_of(about(AUTHORS), BIPED, LEVEL), robot=ROBOT, known=())
    return FittedEncoders.of(setup, fit)


def test_its_own_steps_are_its_own_and_a_changed_number_is_named():
    own = judged(robot(), driven(ROBOT, 2, FITTED, NOISE, 70))
    assert own.same and own.probability > 0.05, own.changes[:2]
    moved = ROBOT.with_values({"hip_zero": ROBOT.value("hip_zero") + 0.01})
    answer = answered(judged(robot(), driven(moved, 3, FITTED, NOISE, 70)), {})
    assert answer.no and answer.plain["named"] == ["hip_zero"], answer.lines
    one = answer.plain["parts"]["hip_zero"]
    assert abs(one["change"] - 0.01) < 4.0 * one["sd"] < 0.01


def test_the_file_gives_the_robot_back_and_another_folder_is_refused(tmp_path):
    (tmp_path / NAME).write_bytes(robot().content())
    again = same.read(tmp_path)
    assert again.content() == robot().content()
    with pytest.raises(WrongOption, match=r"has no robot\.json"):
        same.read(tmp_path / "none")


@needs_real
@pytest.mark.slow
def test_faults_of_a_real_robots_recording_are_named_and_its_own_steps_are_its_own():
    """Alternate pairs fitted, the others held to them."""
    others = [number for number in range(80) if (number // 2) % 2 == 1]
    done = calibrated(BIPED, LEVEL, about(AUTHORS + f"held_out: {others}"), RECORDED)
    fitted = FittedEncoders.of(done.setup, done.fit)
    steps = [step for step in read_steps(RECORDED, {}, 7) if step.number in others]
    assert judged(fitted, steps).same
    for words, how in TURNED.items():
        assert [one.part.name for one in judged(fitted, [turned(step, *how) for step in steps]).named] == [words]
    shifted = [dataclasses.replace(step, between=step.between + 0.01 * step.turn) for step in steps]
    assert "hip_zero" in [one.part.name for one in judged(fitted, shifted).named]
    shifted = [dataclasses.replace(step, stance=step.stance + 0.01) for step in steps]
    verdict = judged(fitted, shifted)
    assert not verdict.same and next(abs(one.change) for one in verdict.changes if one.part.name == "stance_zero_0") > 0
