"""A lab's way: from a database to its own robot as a folder of parameters that the whole study takes."""

import dataclasses
import json
from functools import cache
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import yaml

from pipeline.cache import artefact
from pipeline.questions.asking import Asked
from pipeline.study import Study
from stages.analytic.gait.gait_search import find_gait
from stages.analytic.walk.sampling import walk_from_mid_stance
from stages.calibration import blind_score, recordings, run as stage
from stages.calibration.blind_score import draw, model_of
from stages.calibration.estimation.campaign import fit_campaign
from stages.calibration.estimation.least_squares import TOTAL_MASS, Known, NotIdentified
from stages.calibration.estimation.request import BIPED, PARTS, Request
from stages.calibration.estimation.run_fit import RunFit, begun, fit_near, run_equations
from stages.calibration.following.fitted import earlier_fits, earlier_runs, fitted_robot
from stages.calibration.following.robot_file import NAME, FittedRobot
from stages.calibration.information.identifiability import first_model
from stages.calibration.intervals.model_error import ALONE, Discrepancy, Judged, judged, widening
from stages.calibration.recordings import (
    WITH_OUTSOLE,
    WITHOUT,
    drawn_design,
    first_steps,
    looked_for,
    rate_sd,
    sources,
    table_value,
)
from stages.calibration.reports import sensor_report
from stages.calibration.result import HALF_WIDTH, Misses, Result
from stages.campaign.run import MOUNTING, database_bytes, device, sensed_run
from stages.campaign.twin_run import first_state, walk_twin
from tests import commands
from tests.calibration.runs import DESIGN, PARAMETERS, SHORT, drawn


@pytest.fixture(scope="module")
def lab(repository, tmp_path_factory):
    """The database of one run of one robot, what its scale showed, and the robot's numbers; and one of the same walk as
    other sensors show it."""
    folder = tmp_path_factory.mktemp("lab")
    every = Study(repository, repository / "params", repository / "results", ("campaign.steps=7",)).parameters(
        ["analytic", "campaign"])  # fmt: skip
    parameters, of_model = every["campaign"], every["analytic"]
    tolerance, rate = of_model.settings.tolerance, of_model.settings.sampling_rate_hz
    walker, point = find_gait(of_model.biped, of_model.slope, tolerance, None)
    walk, _ = walk_from_mid_stance(walker, point.z, 1, tolerance, rate)  # it is only begun with
    walked = walk_twin(1, *first_state(walk), parameters, bare=True)
    made = [sensed_run(number, walked, parameters, bare=True) for number in (1, 2)]
    for name, each in zip(("lab.sqlite", "more.sqlite"), made, strict=True):
        (folder / name).write_bytes(
            database_bytes([device(place, parameters) for place in MOUNTING], [(each[0], each[2])]))
    experiment, truth, _ = made[0]
    scale = {"value": truth.weighed, "uncertainty": 1e-3, "unit": "kg", "source": "kitchen scale"}
    known = {"total_mass": scale}
    about = {"known": known, "fixed": ["leg_inertia"], "fitted": [experiment.name]}
    (folder / "known.yaml").write_text(yaml.safe_dump(about))
    return folder, truth


@pytest.mark.slow
def test_a_lab_gets_its_robot_as_a_folder_that_the_study_takes(repository, lab):
    folder, truth = lab
    robot = folder / "robot"
    done = commands.run("calibrate", folder / "lab.sqlite", "--with", folder / "known.yaml", "--into", robot,
                        "--set", "biped.leg_inertia=8.576e-4", "--figure", folder / "fit.png", "--json",
                        cwd=repository)  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert (folder / "fit.png").read_bytes().startswith(b"\x89PNG")
    found = json.loads(done.stdout)["parameters"]
    written = yaml.safe_load((robot / "biped.yaml").read_text())
    for name, row in found.items():
        entry = written[name.partition(".")[2]]
        assert entry["value"] == pytest.approx(row["found"], rel=1e-12)
        assert entry["uncertainty"] == pytest.approx(HALF_WIDTH * row["sd"], rel=1e-12)
    assert abs(written["leg_length"]["value"] / truth.robot.leg_length - 1) < 0.03
    planned = commands.run("run-all", "--dry-run", "--params", robot, "--results", folder / "results", cwd=repository)
    assert planned.returncode == 0, planned.stderr
    assert "analytic" in planned.stdout + planned.stderr


@pytest.mark.slow
def test_the_run_of_a_robot_is_its_own_and_is_learned_from_once_more(repository, lab):
    folder, _ = lab
    robot, again, results = folder / "robot", folder / "robot_again", folder / "results"
    same = commands.run("same", folder / "lab.sqlite", "--as", robot, "--results", results, "--json",
                        "--set", "biped.leg_length=0.36", cwd=repository)  # that of a study has no part in it
    assert same.returncode == 0, same.stderr
    answer = json.loads(same.stdout)
    assert answer["same"] and len(answer["runs"]) == 1 and answer["all_runs"]["probability"] > 0.05
    followed = commands.run("follow", folder / "lab.sqlite", "--as", robot, "--results", results, "--json",
                            cwd=repository)  # fmt: skip
    (run,), kept = json.loads(followed.stdout)["runs"].values(), json.loads((robot / "robot.json").read_text())
    assert run["innovation_in_sigmas"] == pytest.approx(kept["innovation"], rel=1e-9)
    done = commands.run("calibrate", folder / "more.sqlite", "--continue", robot, "--into", again, "--results", results,
                        "--json", cwd=repository)  # fmt: skip
    assert done.returncode == 0 and not json.loads(done.stdout)["changed"], done.stderr
    before, after = (json.loads((each / "robot.json").read_text()) for each in (robot, again))
    assert after["runs"] == 2 and after["known"] == before["known"]
    sd = np.sqrt(np.diag(before["covariance"]))
    assert np.abs((np.array(after["estimate"]) - before["estimate"]) / sd).max() < 4.0
    more = np.diag(after["information"]) / np.diag(before["information"])
    assert more.min() > 1.5 and more.max() < 5.0  # of a run alone, at another design
    twice = commands.run("calibrate", folder / "more.sqlite", "--continue", again, "--results", results, cwd=repository)
    assert twice.returncode == 3 and "the robot has learned from it" in twice.stderr
    refused = commands.run("calibrate", folder / "lab.sqlite", "--continue", robot, "--with", folder / "known.yaml",
                           "--results", results, cwd=repository)  # fmt: skip
    assert refused.returncode == 2 and "known is that of the robot" in refused.stderr
    older = folder / "older"
    older.mkdir()
    (older / "robot.json").write_text(json.dumps(before | {"kind": "bipedstudy fitted robot 1"}))
    refused = commands.run("same", folder / "lab.sqlite", "--as", older, cwd=repository)
    assert refused.returncode == 2 and "of another version; fit the robot again" in refused.stderr


@pytest.mark.slow
def test_from_the_bill_of_parts_the_studys_own_runs_widen_the_intervals(repository, lab):
    """What they miss is made up here: as much as fits of the twin did, so that the robot's numbers are held."""
    folder, truth = lab
    every = Study(repository, repository / "params", repository / "results", ()).parameters(["calibration"])
    drawn = drawn_design(every["calibration"])
    names = first_model(drawn, looked_for(drawn), every["calibration"]).shared
    pulls = 1e-3 * np.array([-1.0, 0.0, 1.0, 0.5, -0.5])
    shares = np.outer(pulls, np.full(len(names), 1.0)) + 0.02 * np.array([1.0, -1.0, 1.0, -1.0, 0.0])[:, None]
    values = np.array([drawn.value(name) for name in names])
    study = Result(30, (), (), names, tuple(drawn.unit(name) for name in names), values, (), (), (), (),
                   Misses(tuple(f"run {number}" for number in range(5)), shares, *np.zeros((2, 5, 0)), pulls), (),
                   lever_arm_sd=1e-5)
    results = folder / "of_the_study"
    results.mkdir()
    (results / "calibration.h5").write_bytes(artefact.encode(study, {}))
    about = yaml.safe_load((folder / "known.yaml").read_text()) | {"design": "parts"}
    del about["fixed"]
    (folder / "parts.yaml").write_text(yaml.safe_dump(about))
    robot = folder / "robot_of_parts"
    done = commands.run("calibrate", folder / "lab.sqlite", "--with", folder / "parts.yaml", "--into", robot, "--set",
                        "calibration.lever_arm_sd=1e-5", "--results", results, "--json", cwd=repository)  # fmt: skip
    assert done.returncode == 0, done.stderr
    answer = json.loads(done.stdout)
    assert answer["model_error_runs"] == 5, answer["model_error"]
    assert "made by the Exudyn twin" in answer["model_error"]
    row = answer["parameters"]["biped.leg_length"]
    assert abs(row["found"] - truth.robot.leg_length) < HALF_WIDTH * row["sd"]
    assert row["sd"] > 0.02 * row["found"]
    written = yaml.safe_load((robot / "biped.yaml").read_text())
    assert "frame_mass" not in written
    frame = answer["parameters"]["biped.frame_mass"]
    assert written["hip_mass"]["value"] == pytest.approx(drawn.biped.hip_mass + 2 * frame["found"])
    assert written["hip_mass"]["uncertainty"] == pytest.approx(2 * HALF_WIDTH * frame["sd"])
    planned = commands.run("run-all", "--dry-run", "--params", robot, "--results", folder / "results_of_parts",
                           cwd=repository)  # fmt: skip
    assert planned.returncode == 0, planned.stderr


# --- The study's blind fit: the drawing it begins from, what it looks for, and how it is cut.


@pytest.mark.parametrize("legs", ["compliant", "rigid"])
def test_the_drawing_is_what_the_bill_of_parts_makes_seen_from_the_side(legs):
    """With legs that differ in length by each run: rigid ones too, of which a tenth of a millimetre shows as well."""
    plain = dataclasses.replace(PARAMETERS, biped=dataclasses.replace(PARAMETERS.biped, legs=legs, leg_inertia=0.0))
    design = drawn_design(plain)
    biped = design.biped
    assert biped.hip_mass == 0.0
    counted = [table_value(biped, f"biped.{name}") for name in ("hip_mass", "foot_com")]
    assert counted == pytest.approx([0.316, 0.1], abs=5e-5)
    assert min(biped.frame_inertia, biped.leg_inertia) > 0
    assert biped.other_leg_length == biped.leg_length
    names = {*looked_for(design)}
    assert not {"biped.hip_mass", "biped.frame_com", "biped.frame_inertia", "biped.leg_inertia",
                "ground.gravity"} & names  # fmt: skip
    assert {"biped.frame_mass", "biped.leg_length", "biped.other_leg_length", "ground.slope_deg"} <= names


def runs_of_a_lab(monkeypatch, runs):
    """What the stage reads of a lab that has these runs."""
    monkeypatch.setattr(recordings, "read_runs", lambda *_: iter(runs))
    nobody = SimpleNamespace(runs=(), bare=(), files={})
    return stage.Inputs(Path("synthetic.sqlite"), Path("bare.sqlite"), nobody, Path("lab.sqlite"))


def test_a_labs_foot_sensor_is_where_the_lab_put_it(monkeypatch):
    """Three sizes of `lever_arm_sd` off the drawing is leg_length off by as much where the drawing is believed."""
    monkeypatch.setattr(blind_score, "free_names", lambda design: [*looked_for(design)])
    biped = dataclasses.replace(DRAWN.biped, other_leg_length=None)
    settings = dataclasses.replace(SHORT.settings, lever_arm_sd=3e-3, fitted_runs=1, held_out_runs=0, planned_steps=5)
    detailed = dataclasses.replace(SHORT, biped=biped, given=settings)
    campaign = draw(4, 1, detailed)
    (fit,) = stage.run(detailed, runs_of_a_lab(monkeypatch, campaign.runs)).fits
    drawing = drawn_design(detailed)
    model = first_model(drawing, looked_for(drawing), detailed)
    names = model.layout.names
    truth, place = campaign.unknowns[0][names.index("foot_place")], fit.unknowns[names.index("foot_place")]
    assert abs(truth) > 1e-3 and abs(place - truth) < 0.5 * abs(truth)
    row = NAMES.index("biped.leg_length")
    assert abs(fit.design[row] - campaign.design.value("biped.leg_length")) < 4.0 * np.sqrt(fit.covariance[row, row])
    fit.covariance[row, row] = np.inf  # as of a number that the run does not show
    shown = stage.followed(drawing, campaign.runs[0], fit, model, settings, None)
    assert shown is not None and np.isfinite(shown.angle_sd).all() and np.isfinite(shown.next_strike).any()


def test_a_clock_is_known_as_its_stamps_show_and_an_own_one_as_oscillators_scatter():
    settings = PARAMETERS.settings
    for error, right in ((0.0, settings.clock_sd), (0.01, 1e-3), (np.nan, settings.own_clock_sd)):
        clock = SimpleNamespace(clock_error_s=error)
        trace = SimpleNamespace(clock=clock, rate_error=np.nan_to_num(error) / 10.0)
        assert rate_sd(trace, settings) == pytest.approx(right)
    assert type(settings).own_clock_sd == settings.own_clock_sd, "files of a study from before do not have it"


def given(monkeypatch, request):
    """What a lab's fit is given at this request: names that are looked for, and parameters."""
    class Seen(Exception):
        """What the fit was given."""

    def seen(_design, names, parameters):
        raise Seen(names, parameters)

    monkeypatch.setattr(sensor_report, "first_model", seen)
    with pytest.raises(Seen) as found:
        sensor_report.calibrated(PARAMETERS, request, Path("lab.sqlite"), None)
    return found.value.args


def test_a_bill_of_parts_does_not_say_where_a_lab_put_its_foot_sensor(monkeypatch):
    """It was believed to 10 um, whatever `lever_arm_sd` said."""
    _, parameters = given(monkeypatch, Request(design=PARTS))
    assert parameters.settings.lever_arm_sd == pytest.approx(0.01 * PARAMETERS.biped.leg_length)


@pytest.mark.parametrize("design", [PARTS, BIPED])
def test_gravity_is_looked_for_where_a_lab_knows_its_error(design, monkeypatch):
    gravity = Known("ground.gravity", 9.78, 1e-3)
    assert gravity.name in given(monkeypatch, Request((gravity,), free=("biped.leg_length",), design=design))[0]
    assert gravity.name not in given(monkeypatch, Request(design=design))[0]


def test_a_lab_without_a_run_that_can_be_used_is_said_so_with_the_reasons(monkeypatch):
    why = [f"walk {number}: has not both sensors" for number in range(4)]
    with pytest.raises(NotIdentified, match="no run can be used: walk 0: has not both sensors; walk 1"):
        stage.run(SHORT, runs_of_a_lab(monkeypatch, why))


@pytest.mark.parametrize(("side", "left"), [("hip", True), ("foot", True), ("hip", False), ("foot", False)])
def test_a_run_of_which_no_sample_of_a_sensor_is_left_cannot_be_used(side, left, monkeypatch):
    """More left out around heel strikes than a step lasts ended in a division by zero."""
    run = drawn(1054).runs[0]
    run = dataclasses.replace(run, used={**run.used, side: run.used[side] & left})
    monkeypatch.setattr(recordings, "measured", lambda *_: run)
    strikes = SimpleNamespace(time=np.arange(9.0), leg=np.zeros(9))
    trial = SimpleNamespace(accepted=True, sensors="both", strikes=strikes,
                            experiment=SimpleNamespace(name="walk 1", slope_deg=2.0))  # fmt: skip
    found = recordings.run_of(trial, DESIGN, None, SHORT.settings)
    assert found is run if left else found.startswith("walk 1: no sample of a sensor is left between heel strikes")


def test_a_biped_that_says_its_details_is_taken_as_it_is():
    detailed = dataclasses.replace(PARAMETERS.biped, frame_mass=0.05, frame_com=0.03)
    biped = drawn_design(dataclasses.replace(PARAMETERS, biped=detailed)).biped
    assert dataclasses.replace(biped, other_leg_length=None) == detailed


def test_the_campaigns_detailed_robot_is_drawn_as_the_twin_makes_it_with_the_other_leg_where_it_differs():
    """Frames of the bill and of the design; a hip counts once, and legs that have a number alike have it alike."""
    more = {"frame_mass": 0.05, "other_foot_mass": 0.34, "hip_stiffness": 0.02, "hip_friction": 1e-3}
    detailed = dataclasses.replace(PARAMETERS, biped=dataclasses.replace(PARAMETERS.biped, **more))
    plain = drawn_design(PARAMETERS).biped
    for kind, sole in ((WITHOUT, 0.0), (WITH_OUTSOLE, PARAMETERS.settings.outsole)):
        biped = drawn_design(detailed, kind).biped
        assert biped.leg_length == pytest.approx(plain.leg_length + sole)
        assert biped.frame_mass == pytest.approx(plain.frame_mass + 0.05)
        assert biped.leg(1).foot_mass - biped.foot_mass == pytest.approx(0.34 - PARAMETERS.biped.foot_mass)
        assert {key for key in biped.details if key.startswith("other_")} == {"other_foot_mass", "other_leg_length"}
        assert [table_value(biped, f"biped.{name}") for name in ("hip_stiffness", "hip_friction")] == [0.02, 1e-3]


def test_a_robot_that_has_no_runs_is_not_looked_for():
    one = SimpleNamespace(name="run 1", weighed=0.5)
    paths = Path("with.sqlite"), Path("without.sqlite")
    both, bare = (SimpleNamespace(runs=(one,), bare=bare, files={"with.sqlite": b"closer"}) for bare in ((one,), ()))
    found = [(source, anew) for _, source, _, anew in sources(*paths, both, None)]
    assert found == [(paths[0], b"closer"), (paths[1], b"")]
    assert sources(*paths, bare, None) == [(WITH_OUTSOLE, paths[0], {"run 1": 0.5}, b"closer")]


@pytest.fixture(scope="module")
def run():
    return drawn(1001).runs[0]


def test_a_run_is_cut_at_a_heel_strike(run):
    cut = first_steps(run, 5)
    assert (len(cut.strikes), len(first_steps(run, 1).strikes)) == (6, 4)  # fewer cannot be used
    assert cut.duration <= cut.strikes[-1] < run.duration and first_steps(run, 99) is run
    assert len(cut.samples["hip"]) == len(cut.sampling.hip) == len(cut.used["hip"])


def test_intervals_widen_by_size_and_by_neighbours_that_hang_together(run):
    run = first_steps(run, 5)
    _, model = model_of(PARAMETERS)
    at = run_equations(DESIGN, np.array([2.0]), model.layout.middle, run, model)
    rng = np.random.default_rng(1)
    noise = {side: np.where(np.isfinite(one), rng.normal(size=one.shape), np.nan) for side, one in at.residuals.items()}
    white = dataclasses.replace(at, residuals=noise, chi2=sum(float(np.nansum(one**2)) for one in noise.values()))
    smooth = {side: np.repeat(one[::5], 5, axis=0)[: len(one)] for side, one in noise.items()}
    rough = dataclasses.replace(at, residuals=smooth, chi2=4.0 * white.count)
    (size, wider), (larger, widest) = widening([white]), widening([rough])
    assert (size, larger) == (pytest.approx(1.0, abs=0.05), pytest.approx(2.0))
    assert wider < 1.5 and 3.0 < widest < 8.0


# --- A lab's intervals: with what the study's own runs tell of the model's error, or with the reason why not.


DRAWN = drawn_design(PARAMETERS)
NAMES = first_model(DRAWN, looked_for(DRAWN), PARAMETERS).shared
VALUES = np.array([DRAWN.value(name) for name in NAMES])
WEIGHED = (Known(TOTAL_MASS, 0.986, 1e-3),)
SD = 1e-3 * VALUES


def study(count=8):
    """A calibration whose other runs miss each parameter by another share, and by more where clocks are pulled."""
    rng = np.random.default_rng(3)
    pulls = 1e-3 * rng.normal(size=count)
    shares = 0.01 * np.arange(len(NAMES)) + np.outer(pulls, np.arange(len(NAMES))) + 1e-3 * rng.normal(
        size=(count, len(NAMES)))  # fmt: skip
    misses = Misses(tuple(f"run {number:02d}" for number in range(count)), shares, *np.zeros((2, count, 0)), pulls)
    return Result(30, (), (), NAMES, tuple(DRAWN.unit(name) for name in NAMES), VALUES, ("ground.slope_deg",),
                  ("hip_clock",), (), (), misses, (), lever_arm_sd=1e-5)


def test_closer_fits_of_further_robots_begin_at_what_theirs_found(monkeypatch):
    """A miss is what was found less the truth, in shares of the values as drawn."""
    told = study(2)
    exact = dataclasses.replace(told, misses=dataclasses.replace(told.misses, shares=0.0 * told.misses.shares))
    robots = [SimpleNamespace(name=name, robot=DRAWN.biped) for name in told.misses.runs]
    inputs = SimpleNamespace(campaign=SimpleNamespace(runs=robots))
    monkeypatch.setattr(stage, "run", lambda *_, near: np.array([near[each.name][0] for each in robots]))
    found, true = (stage.again(PARAMETERS, inputs, each) for each in (told, exact))
    np.testing.assert_allclose((found - true) / VALUES, told.misses.shares, atol=1e-12)


def asked(told, names=NAMES, known=WEIGHED, design=DRAWN, lever_arm_sd=1e-5, pull=1e-3):
    order = [NAMES.index(name) for name in names if name in NAMES]
    return judged(names, VALUES[order], SD[order], known, design, lever_arm_sd, pull, told)


def test_what_other_runs_miss_is_taken_off_and_widens_the_interval():
    told = study()
    term = Discrepancy.of(told.misses.shares, told.misses.pulls)
    backwards = NAMES[::-1]
    found = asked((told, "results/calibration.h5"), backwards)
    assert found.values[::-1] == pytest.approx(VALUES - term.expected(VALUES, 1e-3))
    assert found.sd[::-1] == pytest.approx(np.hypot(SD, np.sqrt(np.diag(term.spread(VALUES, 1e-3)))))
    assert found.other_runs == 8
    for said in ("8 runs", "results/calibration.h5", "run 00 to run 07"):
        assert said in found.words


@pytest.mark.parametrize(("change", "said"), [
    ({"told": (None, "results/calibration.h5 is not there")}, "is not there"),
    ({"told": (study(0), "it")}, "no fits of other robots"),
    ({"told": (study(3), "it")}, "3 fits of other robots' runs, too few"),
    ({"told": (study(), "it"), "names": NAMES[1:]}, "design: parts"),
    ({"told": (study(), "it"), "known": ()}, "the mass is known and nothing else"),
    ({"told": (study(), "it"), "known": (*WEIGHED, Known("biped.leg_length", 0.333, 1e-4))}, "nothing else"),
    ({"told": (study(), "it"), "design": DRAWN.with_value("biped.leg_length", 0.34)}, "another leg_length"),
    ({"told": (study(), "it"), "lever_arm_sd": 3e-3}, "is said to be within 1e-05 m, here within 0.003 m"),
])  # fmt: skip
def test_where_the_studys_runs_do_not_tell_it_the_answer_says_so_and_stays_as_it_is(change, said):
    found = asked(**change)
    kept = VALUES[[NAMES.index(name) for name in change.get("names", NAMES)]]
    np.testing.assert_array_equal(found.values, kept)
    assert found.sd == pytest.approx(1e-3 * kept)
    assert found.words.startswith(ALONE)
    assert said in found.words


def test_a_question_is_given_its_stages_result_or_the_reason_why_not(repository, tmp_path):
    place = Study(repository, repository / "params", tmp_path)
    asking = Asked(place, "calibration", None, PARAMETERS, 1)
    result, why = asking.result()
    assert result is None
    assert "calibration.h5 is not there" in why
    (tmp_path / "calibration.h5").write_bytes(artefact.encode(study(), {}))
    result, file = asking.result()
    assert file.endswith("calibration.h5")
    np.testing.assert_array_equal(result.misses.shares, study().misses.shares)
    other = artefact.encode(dataclasses.replace(study(), misses=()), {})
    for content, said in ((other, "do not fit this version"), (b"no such file", "is truncated or not an HDF5 file")):
        (tmp_path / "calibration.h5").write_bytes(content)
        result, why = asking.result()
        assert result is None and said in why


# --- A robot that goes on learning: runs one after another against all of them at once.


#: Two steps less.
SHORTER = dataclasses.replace(SHORT, given=dataclasses.replace(SHORT.settings, planned_steps=5))


def fitted(runs, known, before=None, fits=None, parameters=SHORT, held_out=()):
    """The robot of runs, after one that was fitted before; of `fits` where the runs' own are known."""
    design, model = model_of(parameters)
    had = [one.run for one in before.learned] if before else []
    if before:
        there, told = before.uncorrected, (*known, *earlier_runs(before))
        fits = fits or [fit_near(there, begun(there, run, model).unknowns, run, model, told) for run in runs]
        fits = [*earlier_fits(before, model), *fits]
    fit = fit_campaign(design, [*had, *runs], model, known, fits and enumerate(fits))
    assert fit.converged and not fit.left_out, (fit.why, fit.left_out)
    sigmas, wider = widening(fit.equations)
    told = Judged(fit.design, wider * np.sqrt(np.diag(fit.covariance)), "")
    return fitted_robot(design, model, fit, told, (sigmas, wider), tuple(known), False, held_out)


def off(one, other):
    """What two robots differ by, in the standard errors of the second."""
    return (one.estimate - other.estimate) / np.sqrt(np.diag(other.covariance))


@cache
def three():
    """A campaign of three runs, with the truth for the runs' own fits."""
    campaign = draw(11, 3, SHORTER)
    _, model = model_of(SHORTER)
    values = np.array([campaign.design.value(name) for name in model.shared])
    return campaign, [
        RunFit(values, own, unknowns, run_equations(campaign.design, own, unknowns, run, model), 0, True, "")
        for run, own, unknowns in zip(campaign.runs, campaign.slopes[:, None], campaign.unknowns, strict=True)]


@cache
def learned():
    """The robot of three runs one after another, and of all at once."""
    (campaign, fits), robot = three(), None
    for run, fit in zip(campaign.runs, fits, strict=True):
        robot = fitted([run], campaign.known, robot, [fit], SHORTER)
    return robot, fitted(campaign.runs, campaign.known, None, fits, SHORTER)


def test_runs_one_after_another_tell_what_all_do_at_once():
    last, both = learned()
    assert np.abs(off(last, both)).max() < 0.1
    np.testing.assert_allclose(np.diag(last.covariance), np.diag(both.covariance), rtol=0.02)
    np.testing.assert_allclose(last.own_sd, both.own_sd, rtol=0.02)
    np.testing.assert_allclose(last.mounting, both.mounting, rtol=0.02, atol=1e-5)
    assert (last.runs, last.sigmas) == pytest.approx((3, both.sigmas), rel=0.01)


def test_runs_held_out_show_how_parts_usually_look_changed():
    campaign, fits = three()
    robot = fitted(campaign.runs[:2], campaign.known, None, fits[:2], SHORTER, campaign.runs[2:])
    assert (robot.runs, len(robot.learned), robot.compared) == (2, 2, 3)
    assert min(freedom for _, _, freedom in robot.usual.values()) >= 2.0


def test_a_robots_file_has_its_runs_and_how_far_they_were_fitted(tmp_path):
    robot, _ = learned()
    (tmp_path / NAME).write_bytes(robot.content())
    again = FittedRobot.read(tmp_path)
    assert again.content() == robot.content()
    _, model = model_of(SHORTER)
    for one, other, fit in zip(robot.learned, again.learned, earlier_fits(again, model), strict=True):
        np.testing.assert_array_equal(one.run.samples["hip"], other.run.samples["hip"])
        assert fit.equations.chi2 / fit.equations.count == pytest.approx(1.0, abs=0.15)


@pytest.mark.slow
def test_runs_one_by_one_after_nine_are_within_a_tenth_of_a_standard_error_of_all_at_once():
    campaign = draw(12, 30, SHORT)
    robot = fitted(campaign.runs[:9], campaign.known)
    for run in campaign.runs[9:]:
        robot = fitted([run], campaign.known, robot)
    assert np.abs(off(robot, fitted(campaign.runs, campaign.known))).max() < 0.1
