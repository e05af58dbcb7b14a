"""A lab's way: from a database to its own robot as a folder of parameters that the whole study takes."""

import json
import os

import pytest
import yaml

from pipeline.study import Study
from stages.analytic.run import run as run_analytic
from stages.campaign.database import database_bytes
from stages.campaign.run import MOUNTING, device, synthetic_run
from stages.campaign.twin_run import first_state
from tests import warm


@pytest.fixture(scope="module")
def lab(repository, tmp_path_factory):
    """The database of one run of one robot, what its scale showed, and the robot's numbers."""
    folder = tmp_path_factory.mktemp("lab")
    every = Study(repository, repository / "params", repository / "results", ("campaign.steps=9",)).parameters(
        ["analytic", "campaign"])  # fmt: skip
    parameters = every["campaign"]
    experiment, truth, sent = synthetic_run(
        (1, True), *first_state(run_analytic(every["analytic"]).walk), parameters)
    (folder / "lab.sqlite").write_bytes(
        database_bytes([device(place, parameters) for place in MOUNTING], [(experiment, sent)]))
    scale = {"value": truth.weighed, "uncertainty": 1e-3, "unit": "kg", "source": "kitchen scale"}
    known = {"total_mass": scale}
    about = {"known": known, "fixed": ["leg_inertia"], "fitted": [experiment.name]}
    (folder / "known.yaml").write_text(yaml.safe_dump(about))
    return folder, truth


def told(repository, *arguments):
    environment = {**os.environ, "PYTHONPATH": str(repository)}
    done = warm.run("from pipeline.cli import main; main()", *map(str, arguments), cwd=repository, env=environment)
    assert "Traceback" not in done.stderr
    return done


def test_a_lab_gets_its_robot_as_a_folder_that_the_study_takes(repository, lab):
    folder, truth = lab
    robot = folder / "robot"
    done = told(repository, "calibrate", folder / "lab.sqlite", "--with", folder / "known.yaml", "--into", robot,
                "--set", "biped.leg_inertia=8.576e-4", "--figure", folder / "fit.png", "--json")  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert (folder / "fit.png").read_bytes().startswith(b"\x89PNG")
    found = json.loads(done.stdout)["parameters"]
    written = yaml.safe_load((robot / "biped.yaml").read_text())
    for name, row in found.items():
        entry = written[name.partition(".")[2]]
        assert entry["value"] == pytest.approx(row["found"], rel=1e-12)
        assert entry["uncertainty"] == pytest.approx(row["sd"], rel=1e-12)
    assert abs(written["leg_length"]["value"] / truth.robot.leg_length - 1) < 0.03
    planned = told(repository, "run-all", "--dry-run", "--params", robot, "--results", folder / "results")
    assert planned.returncode == 0, planned.stderr
    assert "analytic" in planned.stdout + planned.stderr
