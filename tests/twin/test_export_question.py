"""`bipedstudy export twin`: the file, what is said of it, and what is refused."""

import json
import os
import re

import pytest

from stages.twin.exports.formats import FORMATS
from stages.twin.questions.export import FORMATS as OFFERED
from tests import commands


@pytest.fixture
def export(repository, tmp_path):
    def export(*arguments):
        environment = {**os.environ, "PYTHONPATH": str(repository)}
        code = "from pipeline.cli import main; main()"
        done = commands.python(code, "export", *map(str, arguments), cwd=repository, env=environment)
        assert "Traceback" not in done.stderr
        return done.returncode, done.stdout, done.stderr

    return export


def test_every_format_is_offered():
    assert tuple(FORMATS) == OFFERED


def test_it_writes_the_file_and_says_what_it_lacks(export, tmp_path, parameters):
    path = tmp_path / "twin.urdf"
    code, out, errors = export("twin", "--format", "urdf", "--out", path)
    assert (code, errors) == (0, "") and path.read_bytes().startswith(b"<?xml")
    words = " ".join(out.split())
    assert f"each leg {0.5 * parameters.biped.stiffness:g} N/m" in words
    assert all(len(line) <= 80 for line in out.splitlines() if path.name not in line)  # a path is not folded
    assert export("twin", "--format", "urdf", "--out", path)[0] == 2


def test_its_answer_as_json_with_other_parameters(export, tmp_path):
    path = tmp_path / "twin.xml"
    _, out, _ = export("twin", "--format", "mjcf", "--out", path, "--set", "ground.block_sets=5", "--json")
    told = json.loads(out)
    assert told["bytes"] == path.stat().st_size and told["carries"] == FORMATS["mjcf"].CARRIES
    assert told["start"]["hinge"]["rate"] > 0.0
    assert path.read_text().count('name="block') == 10


def test_of_a_walk_on_the_plane_the_ramp_has_its_sets_of_blocks_and_is_as_long_as_they_need(export, tmp_path):
    settings = ("--set", "twin.ramp_length=0.1", "--set", "ground.block_sets=4")
    assert export("twin", "--format", "mjcf", "--out", tmp_path / "twin.xml", *settings)[0] == 0
    assert (tmp_path / "twin.xml").read_text().count('name="block') == 2 * 4


@pytest.mark.parametrize(
    ("arguments", "code", "sentence"),
    [
        (("robot", "--format", "urdf"), 2, 'WHAT = "robot" is not allowed; allowed: twin'),
        (("twin",), 2, "Missing option '--format'"),
        (("twin", "--format", "usd"), 2, '--format = "usd" is not allowed; allowed: mjcf, urdf, sdf, gltf'),
        (("twin", "--format", "urdf", "--set", "twin.scene=ramp", "--set", "twin.ramp_length=1.5"), 3,
         "twin.ramp_length = 1.5 m is not allowed for steps of"),
        (("twin", "--format", "urdf", "--set", "ground.slope_deg=0"), 3, "no periodic gait: on level ground"),
    ],
)
def test_what_is_refused_leaves_no_file(export, tmp_path, arguments, code, sentence):
    done, out, errors = export(*arguments, "--out", tmp_path / "file")
    said = [line for line in errors.splitlines() if not re.match(r"warning: |\d+ %: ", line)]  # how far it is, if slow
    assert (done, out) == (code, "") and len(said) == 1 and sentence in said[0]
    assert not list(tmp_path.iterdir())
