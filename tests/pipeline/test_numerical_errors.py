"""What the package of stages says of the errors of numbers stands beside them, in the file and in `show`."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path

import h5py
import numpy as np
import pytest

from pipeline.cache import fingerprint
from pipeline.cache.artefact import encode
from pipeline.cache.differences import differences
from pipeline.parameters import loading
from pipeline.study import Study
from stages import about
from stages.biped.accuracy.tolerances import LEVELS
from stages.comparison.claims.judge import measured_errors

ROOT = Path(__file__).resolve().parents[2]

ABOUT = '''
ATTRIBUTES = {"title": "toy"}


def numerical_errors(stage, settings):
    assert len(settings) == 16
    return {"height": 0.25, "nothing": 1.0, "sample/time": 3.0} if stage == "fall" else {}
'''


def test_a_number_carries_its_error_and_show_prints_it(toy_with_commands):
    toy = toy_with_commands
    toy.path("PACKAGE/about.py").write_text(ABOUT)
    assert toy.command("run", "bounce")[0] == 0
    with h5py.File(toy.root / "results/fall.h5") as file:
        assert file["height"].attrs["numerical_error"] == 0.25 and "nothing" not in file
    lines = toy.command("show", "fall")[1].splitlines()
    assert " +- 2e-01 m" in next(line for line in lines if line.split()[:1] == ["height"])
    fields = {field["path"]: field for field in json.loads(toy.command("show", "fall", "--json")[1])["fields"]}
    assert fields["height"]["numerical_error"] == 0.25
    with h5py.File(toy.root / "results/bounce.h5") as file:
        assert not any("numerical_error" in item.attrs for item in file.values())
    toy.path("PACKAGE/about.py").write_text("ATTRIBUTES = {}")
    assert "+-" not in toy.command("show", "fall")[1], "what is carried and not known today is not shown"


def test_errors_are_of_the_parameters_of_the_stage_and_of_all_above_it_alone(toy_with_commands):
    toy = toy_with_commands

    def carried(*settings):
        assert toy.command("run", "bounce", *settings)[0] == 0
        with h5py.File(toy.root / "results/bounce.h5") as file:
            return file["force"].attrs.get("numerical_error"), file["provenance"].attrs["settings"]

    _, settings = carried()
    toy.path("PACKAGE/about.py").write_text(f"""
ATTRIBUTES = {{"title": "toy"}}


def numerical_errors(stage, settings):
    return {{"force": 0.5}} if (stage, settings) == ("bounce", "{settings}") else {{}}
""")
    assert carried("--force") == (0.5, settings)
    error, other = carried("--set", "fall.height=3.0")
    assert error is None and other != settings, "a parameter of the stage above, which this one does not read"
    assert "+-" not in toy.command("show", "bounce")[1]


def settings_of(level, *settings):
    """Of each stage the digest of all parameters that its result follows from."""
    study = Study(ROOT, ROOT / "params", ROOT / "results", settings, asked=(("accuracy", level),))
    parts = {name: {"stage": name, "parameters": loading.as_plain(one), "versions": {}, "inputs": {}, "code": {}}
             for name, one in study.parameters(study.graph.stages).items()}  # fmt: skip
    above = {name: [parts[each] for each in study.graph.needed_for((name,)) if each != name] for name in parts}
    return {name: fingerprint.attributes(parts[name], (), above[name])["settings"] for name in parts}


def test_an_error_is_twice_what_was_measured_and_of_another_robot_or_ground_none_is_known(tmp_path, monkeypatch):
    own = settings_of("paper")
    table = {name: {settings: {"a/number": 3e-9}} for name, settings in own.items()}
    (tmp_path / "table.json").write_text(json.dumps(table))
    monkeypatch.setattr(about, "MEASURED", tmp_path / "table.json")

    def known(*settings, level="paper"):
        return {name for name, each in settings_of(level, *settings).items() if about.numerical_errors(name, each)}

    assert all(about.numerical_errors(name, settings) == {"a/number": 6e-9} for name, settings in own.items())
    assert known("biped.stiffness=2801") == known("ground.slope_deg=2.001") == known(level="draft") == set()
    moved = set(own) - known("multibody.tolerance=3e-8")
    assert moved > {"multibody", "twin_ladder", "comparison"} and moved.isdisjoint({"analytic", "twin", "imu"})


@pytest.mark.slow
@pytest.mark.parametrize("level", LEVELS[:-1])
def test_the_kept_errors_are_of_the_parameters_that_the_study_has(level):
    """After a change of them benchmarks/levels.py is due, which takes minutes."""
    own = settings_of(level)
    assert {name for name in own if about.numerical_errors(name, own[name])} >= {"analytic", "multibody", "comparison"}
    study = Study(ROOT, ROOT / "params", ROOT / "results", asked=(("accuracy", level),))
    assert measured_errors(study.parameters(("comparison",))["comparison"], "stable_gait")


def test_show_knows_errors_that_were_measured_later(toy_with_commands):
    """They are no part of a result's key, so the artefact stays, and does not carry them."""
    toy = toy_with_commands
    assert toy.command("run", "fall")[0] == 0
    before = (toy.root / "results/fall.h5").read_bytes()
    assert "+-" not in toy.command("show", "fall")[1]
    toy.path("PACKAGE/about.py").write_text(ABOUT)
    lines = toy.command("show", "fall")[1].splitlines()
    assert " +- 2e-01 m" in next(line for line in lines if line.split()[:1] == ["height"])
    assert " +- 3e+00 s" in "".join(line for line in lines if "+- 2e-01" not in line)
    assert (toy.root / "results/fall.h5").read_bytes() == before


@dataclass(frozen=True)
class Row:
    name: str
    value: float
    part: np.ndarray


@dataclass(frozen=True)
class Computed:
    number: float
    count: int
    time: np.ndarray
    height: np.ndarray = field(metadata={"dimensions": ("time",)})
    pair: np.ndarray
    rows: tuple[Row, ...]


def computed(
    number=1.0, time=(0.0, 1.0, 2.0), height=(0.0, 5.0, 7.0), pair=(1.0, 2.0), rows=("a", "b"), values=(1.0, 2.0)
):
    made = tuple(Row(name, value, np.array([value, 2 * value])) for name, value in zip(rows, values, strict=True))
    return encode(Computed(number, len(rows), np.array(time), np.array(height), np.array(pair), made), {})


def test_differences_are_the_largest_over_rows_that_both_have():
    exact = computed()
    assert differences(exact, exact) == {}
    assert differences(computed(number=1.25, pair=(1.0, 1.5)), exact) == {"number": 0.25, "pair": 0.5}
    finer = computed(time=(0.0, 0.5, 1.0, 1.5, 2.0), height=(0.0, 9.0, 5.0, 9.0, 7.5))
    assert differences(exact, finer) == {"height": 0.5}
    assert differences(computed(values=(1.5, 2.0)), exact) == {"rows/value": 0.5, "rows/part": 1.0}
    assert differences(computed(values=(np.nan, 2.125)), exact) == {"rows/value": 0.12, "rows/part": 0.25}


def test_rows_are_the_same_where_their_words_are():
    exact = computed()
    assert differences(computed(rows=("b", "a")), exact) == {}
    more = computed(rows=("b", "c", "a"), values=(2.5, 9.0, 1.0))
    assert differences(more, exact) == {"rows/value": 0.5, "rows/part": 1.0}
    twice = computed(rows=("b", "b", "a"), values=(2.5, 9.0, 1.0))
    assert differences(twice, exact) == {}


def test_sizes_that_differ_are_not_compared():
    assert differences(computed(pair=(5.0, 6.0, 7.0)), computed()) == {}
