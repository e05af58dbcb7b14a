"""What the package of stages says of the errors of numbers stands beside them, in the file and in `show`."""

from __future__ import annotations

import json
from dataclasses import dataclass, field

import h5py
import numpy as np

from pipeline.cache.artefact import encode
from pipeline.cache.hdf5.differences import differences
from stages.about import computed_how

ABOUT = '''
ATTRIBUTES = {"title": "toy"}


def numerical_errors(stage, parameters):
    assert "ground.gravity = " in parameters
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


def test_how_a_stage_computed_does_not_depend_on_the_machine():
    one = "biped.hip_mass = 1\nground.gravity = 9.81\nanalytic.tolerance = 1e-10"
    assert computed_how(one) == computed_how(one.replace("9.81", "1.62")) != computed_how(one.replace("1e-10", "1e-9"))


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
