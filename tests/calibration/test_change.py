"""Whether runs are of a robot that was fitted: alarms by chance, and changed parts by their names."""

import dataclasses
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

from stages.analytic.errors import StepFailed
from stages.biped.question import WrongOption
from stages.calibration.angles import same
from stages.calibration.angles.recording import read_steps
from stages.calibration.angles.robot import setup_of
from stages.calibration.angles.same import TURNED, FittedEncoders, judged, turned
from stages.calibration.blind_score import _run, model_of
from stages.calibration.estimation.least_squares import TOTAL_MASS, Known
from stages.calibration.estimation.request import Request
from stages.calibration.estimation.run_fit import fit_run
from stages.calibration.following import change
from stages.calibration.following.change import Comparison, Evidence
from stages.calibration.following.fitted import _moderated
from stages.calibration.following.robot_file import FittedRobot
from stages.calibration.information.identifiability import first_model
from stages.calibration.observation.measured_run import SIDES
from stages.calibration.recordings import as_mounted
from stages.calibration.reports.angle_report import calibrated
from stages.calibration.reports.change_report import answered, by_chance, sentence
from stages.calibration.reports.sensor_report import _changed, _with_more
from tests.calibration.runs import DESIGN, SHORT
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

#: The foot sensor stays where it was mounted.
SETTING = as_mounted(dataclasses.replace(SHORT, given=dataclasses.replace(SHORT.settings, planned_steps=5)))


@cache
def comparison(setting=SETTING):
    """With a robot that is known to a tenth of a percent."""
    design, model = model_of(setting)
    values = np.array([design.value(name) for name in model.shared])
    covariance = np.diag((1e-3 * values) ** 2)
    mounting = np.array([[0.0, 1e-5], [0.0, 0.05]])
    robot = FittedRobot(design, model.shared, covariance, model.own, np.array([0.06]), mounting, 1.0, 1.0, 0.0, 1e-3,
                        np.linalg.inv(covariance), values, (), 9, 0.01, False, {}, design)  # fmt: skip
    return Comparison(robot, model)


def run_of(seed, setting=SETTING, **changed):
    """A run of that robot with some of its numbers times a share."""
    drawing, model = model_of(setting)
    there = drawing.with_values(
        {f"biped.{key}": share * drawing.value(f"biped.{key}") for key, share in changed.items()})
    return _run(there, drawing, model, setting, seed, np.random.default_rng([5, seed]))[0]


@cache
def unchanged():
    return comparison().held(run_of(1))


def test_a_run_of_the_robot_is_its_own():
    verdict = comparison().verdict(unchanged())
    assert verdict.same and verdict.probability > 0.05
    assert verdict.residuals == pytest.approx(1.0, abs=0.08)
    assert sentence(verdict).startswith("the same robot")


def test_further_runs_are_read_as_the_robots_own_were():
    """Also where parameters have the robot that was found: else its foot sensor would sit elsewhere than it was read.
    """
    robot = comparison().robot
    found = dataclasses.replace(SETTING, biped=dataclasses.replace(SETTING.biped, leg_length=0.345))
    assert found.ingest.limits.lever_arm == pytest.approx(0.245)
    assert robot.read_by(found).ingest == SETTING.ingest and robot.read_by(found).settings == SETTING.settings
    assert dataclasses.replace(robot, of_parts=True).read_by(found) is found


@pytest.mark.slow
def test_a_part_that_has_changed_is_named_with_its_change():
    """Of both legs, and of one: the other's foot, by its mass, where the first one's cannot be meant."""
    for changed, name in (({"stiffness": 1.02}, "stiffness of both legs"),
                          ({"other_foot_mass": 1.003}, "foot_mass of the other leg")):  # fmt: skip
        verdict = comparison().verdict(comparison().held(run_of(3, **changed)))
        best, share = verdict.changes[0], next(iter(changed.values())) - 1.0
        assert not verdict.same and best.part.name == name, (name, [one.part.name for one in verdict.changes[:3]])
        right = share * DESIGN.value(f"biped.{next(iter(changed))}")
        assert abs(best.change - right) < 4.0 * best.sd + 0.05 * right
        assert name in sentence(verdict)


def test_runs_that_a_robot_goes_on_with_are_named_where_they_are_anothers():
    """They were fitted together: a spring between the old and the new one, with an interval that held neither."""
    lines = _changed(comparison().robot, [run_of(1), run_of(3, stiffness=1.02)], SETTING)
    assert len(lines) == 1 and "not the same robot: what has changed is stiffness of both legs" in lines[0]


def test_the_part_that_has_changed_costs_least_by_what_the_others_would_contradict():
    """Another part, once it is free, explains as much where the others may leave the values they had."""
    found = comparison()
    run = found._read(run_of(3, stiffness=1.02))
    fit = found._near(run)
    there = found.model.robot(found.robot.design, fit.design, fit.own)
    costs = {part.name: found._changed(part, run, there, fit.unknowns)[0] for part in found.parts
             if part.name in {f"{key} of both legs" for key in ("stiffness", "damping", "foot_mass")}}  # fmt: skip
    first, second, _ = sorted(costs.values())
    assert costs["stiffness of both legs"] == first < second - 50.0


@pytest.mark.parametrize("share", [0.9, 1.1])
def test_a_hip_that_rubs_less_or_more_than_it_did_is_named(share):
    """Only a hip that did not rub cannot rub less."""
    rubbing = dataclasses.replace(SETTING, biped=dataclasses.replace(SETTING.biped, hip_friction=0.003))
    verdict = comparison(rubbing).verdict(comparison(rubbing).held(run_of(3, rubbing, hip_friction=share)))
    best = verdict.changes[0]
    assert not verdict.same and best.part.name == "hip_friction" and verdict.explained
    assert best.change == pytest.approx(0.003 * (share - 1.0), rel=0.1)


def test_a_length_that_looks_changed_is_no_surer_than_the_clocks():
    found, run = comparison(), run_of(1)
    sampling = dataclasses.replace(run.sampling, rate_sd=dict.fromkeys(SIDES, 2e-3))
    place = [part.name for part in found.parts].index("leg_length of both legs")
    sd = [found.shifts(found.alike(one))[place, 1] for one in (run, dataclasses.replace(run, sampling=sampling))]
    assert sd[1] > 1.1 * sd[0]


def test_a_run_that_is_taken_for_the_robots_looks_changed_by_what_has_changed():
    found = comparison()
    shift, sd = dict(zip((part.name for part in found.parts), found.shifts(found.alike(run_of(3, stiffness=1.02))),
                         strict=True))["stiffness of both legs"]  # fmt: skip
    right = 0.02 * DESIGN.value("biped.stiffness")
    assert abs(shift - right) < 4.0 * sd + 0.05 * right < 0.5 * right


def test_a_run_that_the_robot_falls_in_is_told_from_where_a_free_robot_walks_it(monkeypatch):
    def falls(*_):
        raise StepFailed("it falls")

    monkeypatch.setattr(change, "begun", falls)
    there = dataclasses.replace(comparison().robot, known=(Known(TOTAL_MASS, DESIGN.biped.total_mass, 1e-4),))
    free = Comparison(there, model_of(SETTING)[1])
    verdict = free.verdict(free.held(run_of(3, stiffness=1.02)))
    assert not verdict.same and verdict.changes[0].part.name == "stiffness of both legs"


def test_one_run_in_a_hundred_is_no_more_than_told_another():
    """Scores as noise and the robot's covariance make them, with the information of a run."""
    told, d = unchanged(), len(comparison().robot.names)
    spread = np.zeros_like(told.matrix)
    spread[:d, :d] = comparison().robot.covariance
    values, vectors = np.linalg.eigh(told.matrix @ spread @ told.matrix + told.matrix)
    half = vectors * np.sqrt(np.maximum(values, 0.0))
    rng = np.random.default_rng(7)
    scores = rng.normal(size=(2000, len(values))) @ half.T
    alarms = sum(not comparison().verdict(Evidence(told.matrix, right, told.count, told.count)).same
                 for right in scores)  # fmt: skip
    assert 2 <= alarms <= 30


def test_many_runs_know_a_sensors_usual_place_no_better_than_the_robots_own_runs_did():
    """Nine of these against 900: of the mean of the nine a third of a run's error is left."""
    found = comparison()
    usual = {part.name: (0.0, 0.0, 8.0) for part in found.parts}
    found = Comparison(dataclasses.replace(found.robot, usual=usual, compared=9), found.model)
    alone, many = (found.verdict(told) for told in (unchanged(), sum([unchanged()] * 899, unchanged())))
    sd = [{one.part.name: one.sd for one in verdict.changes}["tilt of the hip sensor"] for verdict in (alone, many)]
    assert sd[1] / sd[0] == pytest.approx(np.sqrt((1 / 900 + 1 / 9) / (1 + 1 / 9)), rel=0.05)


def test_a_scatter_of_which_half_is_chance_is_no_surer_than_the_runs_that_show_it():
    """Of five runs it has four degrees of freedom, and a change no more: it had 13."""
    parts = [part.name for part in comparison().parts]
    name = "stiffness of both legs"
    sd = float(comparison().shifts(unchanged())[parts.index(name), 1])
    robot = dataclasses.replace(comparison().robot, usual={name: (0.0, sd, 4.0)}, compared=5)
    found = Comparison(robot, comparison().model).verdict(unchanged())
    one = next(one for one in found.changes if one.part.name == name)
    assert one.sd == pytest.approx(sd * 2.2**0.5) and one.freedom == pytest.approx(4.0 * (2.2 / 2.4) ** 2)


def test_scatters_of_few_runs_are_drawn_together_as_far_as_they_are_alike():
    alike = np.random.default_rng(3).chisquare(8, 25) / 8
    drawn, freedom = _moderated(alike, 8, np.ones(25, dtype=bool))
    assert freedom.min() > 2 * 8 and np.ptp(drawn) < 0.5 * np.ptp(alike)
    unlike = alike * np.geomspace(0.01, 100.0, 25)
    drawn, freedom = _moderated(unlike, 8, np.ones(25, dtype=bool))
    assert freedom.min() > 8.0 and freedom.max() < 9.0
    np.testing.assert_allclose(drawn[unlike > 1.0], unlike[unlike > 1.0], rtol=0.2)


def test_scatters_of_sensors_are_not_drawn_up_to_those_of_the_design():
    """Those of a twin are tens of times chance; sensors that stay where they are scatter by less than chance."""
    ratios = np.append(30.0 * np.random.default_rng(3).chisquare(8, 20) / 8, [0.01, 0.5, 80.0])
    drawn, freedom = _moderated(ratios, 8, np.arange(23) < 20)
    np.testing.assert_allclose(drawn[20:22], ratios[20:22])
    assert freedom[20:22].tolist() == [8.0, 8.0] and np.delete(freedom, [20, 21]).min() > 8.0 and drawn[22] < 70.0


def test_a_shift_of_a_part_is_found_with_its_size():
    """In a model that is linear, from scores without noise; what it explains is chi-square with one freedom."""
    told, d = unchanged(), len(comparison().robot.names)
    for place, part in enumerate(comparison().parts):
        right = 3.0 * told.matrix[:, d + place]
        found = next(one for one in comparison().verdict(dataclasses.replace(told, right=right)).changes
                     if one.part == part)  # fmt: skip
        assert found.change == pytest.approx(3.0, rel=1e-6), part.name
        assert found.explains == pytest.approx((3.0 / found.sd) ** 2, rel=1e-6), part.name


def test_runs_are_added_and_parts_that_explain_as_much_are_named_together():
    told = unchanged()
    both = told + told
    assert both.runs == 2 and both.count == 2 * told.count
    np.testing.assert_array_equal(both.matrix, 2.0 * told.matrix)
    verdict = comparison().verdict(both)
    best = verdict.changes[0].explains
    assert best == max(one.explains for one in verdict.changes)
    assert [one.explains > best - 2.0 for one in verdict.changes] == [one in verdict.named for one in verdict.changes]


def test_residuals_that_no_part_explains_are_another_robots():
    told = unchanged()
    verdict = comparison().verdict(dataclasses.replace(told, misfit=2.0 * told.misfit))
    assert not verdict.same and verdict.residuals > 1.3


def test_one_legs_own_number_is_fitted_where_it_is_named():
    """A spring that is 3 % stiffer than the first leg's."""
    design = _with_more(DESIGN, Request(also=("biped.other_stiffness",)))
    names = ("biped.hip_mass", "biped.foot_mass", "biped.stiffness", "biped.damping", "biped.other_stiffness")
    model = first_model(design, (*names, "ground.slope_deg"), SETTING)
    fit = fit_run(design, run_of(3, other_stiffness=1.03), model,
                  [Known(TOTAL_MASS, DESIGN.biped.total_mass, 1e-4, "scale")])  # fmt: skip
    assert fit.converged
    assert fit.design[4] / fit.design[2] == pytest.approx(1.03, abs=2e-3)
    with pytest.raises(WrongOption, match="also: hip_damping is not looked for; known are other_foot_radius"):
        _with_more(DESIGN, Request(also=("biped.hip_damping",)))
    assert _with_more(DESIGN, Request(also=("biped.hip_friction",))).biped.hip_friction > 0.0


# --- Whether steps of encoders are of a robot that was fitted: made steps, and a real robot's with faults put in.


NOISE, FITTED = 1e-3, 20


@cache
def robot():
    """A robot that is fitted to its own model's steps."""
    fit = fit_robot(ROBOT, driven(ROBOT, 1, FITTED, NOISE, 70), NAMES, sizes(ROBOT), {}, (), NOISE)
    assert fit.converged
    setup = dataclasses.replace(setup_of(about(AUTHORS), BIPED, LEVEL), robot=ROBOT, known=())
    return FittedEncoders.of(setup, fit)


def test_one_recording_in_a_hundred_has_residuals_that_are_said_to_be_too_large(monkeypatch):
    """Of robots whose steps scatter alike, of which eight were fitted and five are held to them."""
    setup = dataclasses.replace(setup_of(about(AUTHORS), BIPED, LEVEL), robot=ROBOT, known=(), free=("hip_zero",))
    rng, alarms = np.random.default_rng(2), 0
    for _ in range(2000):
        before, after = 0.3 * rng.normal(size=8), 0.3 * rng.normal(size=5)
        fit = SimpleNamespace(robot=ROBOT, residuals=dict(enumerate(np.exp(after)[:, None])), converged=True,
                              covariance=lambda scales: np.diag(scales**2))  # fmt: skip
        monkeypatch.setattr(same, "fit_robot", lambda *_, fit=fit: fit)
        log_size = before.mean(), before.std(ddof=1)
        known = FittedEncoders(setup, np.eye(1), NOISE, len(before), log_size, {"hip_zero": 1.0})
        alarms += not same.held(known, [None] * len(after))[0].explained
    assert 10 <= alarms <= 30


@pytest.mark.slow
def test_its_own_steps_are_its_own_and_a_changed_number_is_named():
    own = judged(robot(), driven(ROBOT, 2, FITTED, NOISE, 70))
    assert own.same and own.probability > 0.05, own.changes[:2]
    moved = ROBOT.with_values({"hip_zero": ROBOT.value("hip_zero") + 0.01})
    answer = answered(judged(robot(), driven(moved, 3, FITTED, NOISE, 70)), {})
    assert answer.no and answer.plain["named"] == ["hip_zero"], answer.lines
    one = answer.plain["parts"]["hip_zero"]
    assert abs(one["change"] - 0.01) < 4.0 * one["sd"] < 0.01


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


def test_the_run_that_differs_most_counts_as_one_of_so_many():
    assert by_chance(0.004, 0.004, 1) == 0.004
    assert by_chance(0.3, 0.001, 5) == pytest.approx(0.01)
    assert by_chance(0.002, 0.3, 5) == pytest.approx(0.004)
    assert by_chance(0.9, 0.4, 5) == 1.0
