"""A lab's way: from a database to its own robot as a folder of parameters that the whole study takes."""

import json

import numpy as np
import pytest
import yaml

from pipeline.cache import artefact
from pipeline.study import Study
from stages.analytic.gait.gait_search import find_gait
from stages.analytic.walk.sampling import walk_from_mid_stance
from stages.calibration.information.identifiability import first_model
from stages.calibration.recordings import drawn_design, looked_for
from stages.calibration.result import HALF_WIDTH, Misses, Result
from stages.campaign.run import MOUNTING, database_bytes, device, sensed_run
from stages.campaign.twin_run import first_state, walk_twin
from tests import commands


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
        assert entry["uncertainty"] == pytest.approx(row["sd"], rel=1e-12)
    assert abs(written["leg_length"]["value"] / truth.robot.leg_length - 1) < 0.03
    planned = commands.run("run-all", "--dry-run", "--params", robot, "--results", folder / "results", cwd=repository)
    assert planned.returncode == 0, planned.stderr
    assert "analytic" in planned.stdout + planned.stderr


def test_the_run_of_a_robot_is_its_own_and_is_learned_from_once_more(repository, lab):
    folder, _ = lab
    robot, again, results = folder / "robot", folder / "robot_again", folder / "results"
    same = commands.run("same", folder / "lab.sqlite", "--as", robot, "--results", results, "--json", cwd=repository)
    assert same.returncode == 0, same.stderr
    answer = json.loads(same.stdout)
    assert answer["same"] and len(answer["runs"]) == 1 and answer["all_runs"]["probability"] > 0.05
    done = commands.run("calibrate", folder / "more.sqlite", "--continue", robot, "--into", again, "--results", results,
                        "--json", cwd=repository)  # fmt: skip
    assert done.returncode == 0, done.stderr
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
                   Misses(tuple(f"run {number}" for number in range(5)), shares, *np.zeros((2, 5, 0)), pulls), ())
    results = folder / "of_the_study"
    results.mkdir()
    (results / "calibration.h5").write_bytes(artefact.encode(study, {}))
    about = yaml.safe_load((folder / "known.yaml").read_text()) | {"design": "parts"}
    del about["fixed"]
    (folder / "parts.yaml").write_text(yaml.safe_dump(about))
    robot = folder / "robot_of_parts"
    done = commands.run("calibrate", folder / "lab.sqlite", "--with", folder / "parts.yaml", "--into", robot,
                        "--results", results, "--json", cwd=repository)  # fmt: skip
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
    assert written["hip_mass"]["uncertainty"] == pytest.approx(2 * frame["sd"])
    planned = commands.run("run-all", "--dry-run", "--params", robot, "--results", folder / "results_of_parts",
                           cwd=repository)  # fmt: skip
    assert planned.returncode == 0, planned.stderr
