"""What people import: every question with parameters by name, arrays with units, and examples that run as shown."""

import ast
import doctest
import importlib
import json
import math
import re
import subprocess
import sys
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

import bipedstudy as bs
from bipedstudy.questions import names
from pipeline.errors import StudyError
from pipeline.questions.command import questions
from pipeline.study import locate
from stages.analytic.questions import sensitivity
from stages.biped.quantity import quantity
from stages.biped.question import Answer
from tests import commands

BOX = {"count": 3, "vary": {"biped.hip_mass": {"low": 0.3, "high": 0.33}}}


def test_each_question_that_a_stage_declares_is_there_and_says_what_it_takes():
    declared = [question for _, _, question in questions(locate())[0]]
    assert len(declared) >= 11
    for question in declared:
        name = {"continue": "continue_"}.get(question.name, question.name.replace("-", "_"))
        assert name in dir(bs)
        if name != "gait":  # of which the report itself is given
            assert question.help.strip().splitlines()[0] in getattr(bs, name).__doc__


def test_an_answer_is_read_by_key_and_prints_as_the_command_does():
    found = bs.sensitivity(slope_deg=2.2)
    assert found.plain and repr(found).startswith("gait: ")
    assert bs.sensitivity(settings={"ground.slope_deg": 2.2}).plain == found.plain


def test_an_answer_holds_what_json_prints(monkeypatch):
    """None for an infinity: calibrations and walks over blocks saw to it themselves, other answers did not."""
    endless = replace(sensitivity.QUESTION, ask=lambda *given: Answer(plain={"steps": (math.inf, 8.0)}))
    monkeypatch.setattr(sensitivity, "QUESTION", endless)
    assert bs.sensitivity().plain == {"steps": [None, 8.0]}


def test_axes_of_a_plot_carry_units():
    height, angle = bs.plot(bs.walk(steps=1), "hip_position", "leg_angle").axes
    assert (height.get_ylabel(), angle.get_ylabel()) == ("hip position\n[m]", "leg angle\n[rad]")
    assert angle.get_xlabel() == "time [s]"


def test_a_mapping_stands_for_a_file_and_an_answer_draws_itself(tmp_path):
    found = bs.map(BOX, study=_study(tmp_path), jobs=1)
    assert found["designs"] == 3
    assert found.figure().axes


def test_parameters_by_name_are_those_of_a_setting():
    ways = bs.gait(hip_mass=0.4), bs.gait("biped.hip_mass=0.4"), bs.gait({"biped.hip_mass": 0.4})
    assert len({one.gait.period_s for one in ways}) == 1 and ways[0].gait.period_s != bs.gait().gait.period_s


@pytest.mark.parametrize(("ask", "said"), [
    (lambda: bs.gait(hip_mas=0.4), 'there is no parameter "hip_mas" of stage analytic; did you mean "hip_mass"'),
    (lambda: bs.sensitivity(tolerance=1e-9, foot=1), 'no parameter "foot"'),
    (lambda: bs.ask("period", within="1%", tolerance=1e-3), "several files; name one: analytic.tolerance"),
    (lambda: bs.ask("hop", within="1%"), "is not allowed; allowed: period"),
    (lambda: bs.ask(), "ask needs what"),
    (lambda: bs.sensitivity("x", "y"), "arguments without a name"),
    (lambda: bs.map("nowhere.yaml"), "nowhere.yaml"),
    (lambda: bs.gait(hip_mass={0.4}), "no value of a parameter"),
    (lambda: bs.gait(study="nowhere"), "no study in nowhere or above"),
    (lambda: bs.load(3), 'no stage "3"'),
    (lambda: bs.ask("speed", within=-0.01), "not a positive error"),
    (lambda: bs.design(vary={"biped.foot_radius": (0.07, 0.09)}), "{'biped.foot_radius': .*: not a number of the"),
    (lambda: bs.calibrate("a.csv", about=[1]), r"\[1\] is nothing that it takes"),
    (lambda: bs.calibrate(Path("nowhere.sqlite")), "'nowhere.sqlite' cannot be read"),
    (lambda: bs.basin(points=np.int64(1)), "--points = 1 is not allowed"),
    (lambda: bs.array(None, "time"), "None is no result"),
    (lambda: bs.array(bs.gait().gait, ["time"]), "no array \"\\['time'\\]\""),
    (lambda: bs.plot(bs.gait().gait, "period_s"), "period_s .* is no signal over time"),
])  # fmt: skip
def test_what_is_not_allowed_is_one_sentence(ask, said):
    with pytest.raises(StudyError, match=said):
        ask()


def _study(folder):
    """A new study there."""
    assert commands.run("init", "mine", cwd=folder).returncode == 0
    return folder / "mine"


# --- Arrays of a result carry names, units and dimensions.


@dataclass(frozen=True)
class Fall:
    time: np.ndarray = quantity("s", "time", symbol="t")
    place: np.ndarray = quantity("m", "place x, y", symbol="x")
    mass: float = quantity("kg", "mass", symbol="m")
    stable: bool = quantity("1", "whether it stands")


FALL = Fall(np.arange(3.0), np.ones((3, 2)), 2.0, True)


def test_an_array_knows_what_it_is():
    place = bs.array(FALL, "place")
    assert (place.unit, place.symbol, place.dimensions) == ("m", "x", ("time", "place_1"))
    assert repr(place) == "place [m] (time 3 x place_1 2): place x, y"
    assert np.array_equal(np.asarray(place), FALL.place)
    assert list(bs.arrays(FALL)) == ["time", "place", "mass"]


def test_an_unknown_array_is_told_with_the_nearest():
    with pytest.raises(StudyError, match=r'no array "plaice".*did you mean "place"'):
        bs.array(FALL, "plaice")


def test_a_dataset_has_units_and_a_time_axis():
    pytest.importorskip("xarray")
    found = bs.dataset(FALL)
    assert found.place.attrs["units"] == "m" and float(found.place.sel(time=1.0)[0]) == 1.0


# --- The examples page and the docstrings of the package that people import run as they stand.


BLOCK = re.compile(r"```python\n(.*?)```", re.S)


@pytest.mark.slow
def test_the_examples_page_runs_from_top_to_bottom(repository, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    known: dict[str, object] = {}
    blocks = BLOCK.findall((repository / "docs/examples.md").read_text(encoding="utf-8"))
    assert len(blocks) >= 6
    first = BLOCK.findall((repository / "README.md").read_text(encoding="utf-8"))
    assert len(first) == 1
    for block in [*first, *blocks]:
        exec(compile(block, "docs/examples.md", "exec"), known)
    said = capsys.readouterr().out
    assert known["gait"].stable and "foot_radius = -1 m is not allowed" in said
    assert (tmp_path / "walk.png").stat().st_size > 10_000
    slower = known["frequencies"]
    assert len(set(slower)) == len(slower), "another mass is another gait"


def test_the_docstrings_show_what_is_so():
    done = doctest.testmod(importlib.import_module("bipedstudy.results"))
    assert done.attempted > 10 and done.failed == 0


def test_every_name_that_is_offered_is_there():
    assert all(callable(getattr(bs, name)) for name in bs.__all__)
    assert {*dir(bs)} > {*bs.__all__} and "ask" in dir(bs)
    with pytest.raises(AttributeError, match=r"no attribute 'gaits'; it has Array, StudyError.*ask"):
        bs.gaits  # noqa: B018


def test_settings_are_texts_or_mappings_of_values():
    given = {"biped.hip_mass": np.float64(0.4), "biped.strike_time": None, "analytic.steps": np.int64(5)}
    one, other = (bs.parameters("analytic", *settings) for settings in (
        [given], ["biped.hip_mass=0.4", "analytic.steps=5"]))  # fmt: skip
    assert one == other and one.biped.hip_mass == 0.4
    for wrong, words in ((3, "3 is no setting"), ({"biped.hip_mass": -1}, "hip_mass = -1 kg is not allowed")):
        with pytest.raises(bs.StudyError, match=words):
            bs.parameters("analytic", wrong)


# --- Whole studies of robots that are not Table 1's come to an end: every stage, every figure, the report.


def draft(folder, *changes):
    """A new study of another robot, run as a draft from nothing."""
    program = [sys.executable, "-m", "bipedstudy"]
    subprocess.run([*program, "init", "study"], cwd=folder, check=True)
    settings = [word for change in changes for word in ("--set", change)]
    return subprocess.run([*program, "run-all", "--accuracy", "draft", *settings], cwd=folder / "study", text=True,
                          capture_output=True)


@pytest.mark.slow
@pytest.mark.parametrize(("changes", "without_blocks"), [
    (["biped.legs=rigid", "ground.slope_deg=0.8"], ""),
    (["biped.stiffness=9000", "biped.damping=120"], ""),
    (["ground.normal_force=restitution"], ""),
    (["analytic.transition=coulomb", "biped.foot_radius=0.05"], "on blocks of drawn heights feet roll"),
    (["twin.inertia=planar", "biped.hip_mass=1.0", "biped.foot_com=0.06"], "the gait is unstable"),
    (["ground.slope_deg=4.5"], "error: stage rough_ground: the gait is unstable"),
], ids=["rigid legs", "stiff legs", "restitution", "a foot that slips", "planar inertia", "steep"])
def test_a_study_of_another_robot_comes_to_its_end(tmp_path, changes, without_blocks):
    done = draft(tmp_path, *changes)
    refused = [line.split()[0] for line in done.stdout.splitlines() if line.split()[1:2] == ["refused"]]
    expected = (3, ["rough_ground"]) if without_blocks else (0, [])
    assert (done.returncode, refused) == expected and without_blocks in done.stderr, done.stdout + done.stderr
    assert (tmp_path / "study/results/report.html").stat().st_size > 100_000


@pytest.mark.slow
def test_a_ramp_too_flat_to_walk_on_is_an_honest_no(tmp_path):
    done = draft(tmp_path, "ground.slope_deg=0.2")
    assert done.returncode == 3
    assert "no periodic gait" in done.stderr and "Traceback" not in done.stderr


@pytest.mark.slow
def test_no_compiled_line_reads_beyond_an_array(tmp_path, monkeypatch, repository):
    """The whole draft study of Table 1 with numba's check of bounds, all compiled anew."""
    monkeypatch.setenv("NUMBA_BOUNDSCHECK", "1")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    command = [sys.executable, "-m", "bipedstudy", "run-all", "--accuracy", "draft", "--results", tmp_path / "results"]
    done = subprocess.run(command, cwd=repository, text=True, capture_output=True)
    assert done.returncode == 0, done.stdout + done.stderr


# --- The notebook that asks every question runs from top to bottom, and leaves no declared question out.


def test_the_notebook_asks_every_question(notebook):
    called = {node.func.attr for cell in notebook for node in ast.walk(ast.parse(cell))
              if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute)
              and getattr(node.func.value, "id", "") == "bs"}  # fmt: skip
    assert [name for name in names() if name not in called] == []


@pytest.mark.slow
def test_the_notebook_runs_from_top_to_bottom(notebook, tmp_path, monkeypatch, capsys):
    """A cell shows its last expression, as Jupyter does."""
    monkeypatch.chdir(tmp_path)
    known: dict[str, object] = {}
    shown = []
    for number, cell in enumerate(notebook):
        tree = ast.parse(cell, f"cell {number}")
        last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
        exec(compile(tree, f"cell {number}", "exec"), known)
        if isinstance(last, ast.Expr):
            shown.append(repr(eval(compile(ast.Expression(last.value), f"cell {number}", "eval"), known)))
    shown = [text for text in shown if text != "None"]  # of the cells that run a command of the shell
    assert len(shown) == len(names()) and all(len(text) > 10 for text in shown), shown
    assert "0.64034 ->" in shown[7] and "of the twin's (2 % requested)" in shown[8], shown[7:9]
    assert "synthetic" in shown[9] and (tmp_path / "lab/twin.urdf").read_text().startswith("<?xml")


@pytest.fixture(scope="module")
def notebook(repository):
    """The code of each cell, without outputs: they are made where it is run."""
    found = json.loads((repository / "docs/questions.ipynb").read_text(encoding="utf-8"))
    cells = [cell for cell in found["cells"] if cell["cell_type"] == "code"]
    assert found["nbformat"] == 4 and not any(cell["outputs"] for cell in cells)
    return ["".join(cell["source"]) for cell in cells]
