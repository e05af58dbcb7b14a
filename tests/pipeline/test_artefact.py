"""Results go to HDF5 and come back, with the same bytes every time."""

import contextlib
import importlib
import random
import time
import types
import typing
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, is_dataclass, make_dataclass, replace
from pathlib import Path

import h5py
import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from hypothesis.extra import numpy as arrays

from pipeline.cache import artefact, disk, hdf5
from pipeline.cache.hdf5 import ROWS
from pipeline.errors import StudyError
from pipeline.graph import read as read_graph
from stages.biped.quantity import quantity
from stages.model_error.measures import MEASURES
from stages.studies.result import EnginesDisagree
from tests.pipeline.strange_files import ARTEFACT
from tests.pipeline.test_numerical_errors import motions
from tests.pipeline.toy import flipped


@dataclass(frozen=True)
class Inner:
    value: float = quantity("m", "a length", symbol="L")
    samples: np.ndarray = quantity("N", "forces, shape (n, 2)")


@dataclass(frozen=True)
class Everything:
    word: str = quantity("-", "a word")
    names: tuple[str, ...] = quantity("-", "words")
    numbers: tuple[float, ...] = quantity("s", "numbers")
    count: int = quantity("1", "a count")
    yes: bool = quantity("1", "a truth")
    missing: float | None = quantity("1", "perhaps a number")
    masses: dict[str, float] = quantity("kg", "masses by name")
    inner: Inner = quantity("1", "nested")
    rows: tuple[Inner, ...] = quantity("1", "a table")
    flags: np.ndarray = quantity("1", "truths")
    files: dict[str, bytes] = field(default_factory=dict)


def inner(n=3):
    return Inner(float(n), np.arange(2.0 * n).reshape(n, 2))


def example(**changes):
    result = Everything(
        word="naïve",
        names=("a", "bcd"),
        numbers=(1.0, 2.5),
        count=3,
        yes=True,
        missing=None,
        masses={"z": 1.0, "a": 2.0},
        inner=inner(),
        rows=tuple(inner(n) for n in range(12)),
        flags=np.array([True, False]),
        files={"x": b"y"},
    )
    return replace(result, **changes)


def bits(value):
    """What a value is, to the last bit and the last type."""
    if is_dataclass(value):
        return type(value), [(field.name, bits(getattr(value, field.name))) for field in fields(value)]
    if isinstance(value, np.ndarray):
        return "array", value.dtype.str, value.shape, value.tobytes()
    if isinstance(value, tuple):
        return "tuple", [bits(part) for part in value]
    if isinstance(value, dict):
        return "dict", [(key, bits(part)) for key, part in value.items()]
    return type(value), np.float64(value).tobytes() if isinstance(value, float) else value


def round_trip(result):
    return artefact.decode(artefact.encode(result, {}), type(result), "x.h5")


@settings(max_examples=25, deadline=None)
@given(
    st.text(st.characters(exclude_characters="\0", exclude_categories=["Cs"])),
    arrays.arrays(np.float64, arrays.array_shapes(min_dims=2, max_dims=2, min_side=0)),
)
def test_any_text_and_any_array_come_back(word, samples):
    result = example(word=word, names=(word, "x"), inner=Inner(1.0, samples))
    assert bits(round_trip(result)) == bits(replace(result, files={}))


def test_the_bytes_do_not_depend_on_the_time():
    first = artefact.encode(example(), {"key": "k"})
    time.sleep(1.1)
    assert artefact.encode(example(), {"key": "k"}) == first


def test_what_a_result_says_alone_does_not_depend_on_how_it_was_made():
    """Keys of later stages stand on it."""
    plain, told = artefact.encoded(example(), {"key": "k"}, {"title": "t"}, "nobody knows")
    assert plain != told
    assert bits(artefact.decode(plain, Everything, "x.h5")) == bits(artefact.decode(told, Everything, "x.h5"))
    about = artefact.provenance(told, "x.h5")
    assert artefact.provenance(plain, "x.h5") == {} and about["key"] == "k" and about["content"] == disk.digest(plain)


def test_a_result_vouches_for_each_of_its_bytes():
    plain, told = artefact.encoded(example(), {"key": "k"})
    assert artefact.sealed(told) == told and artefact.sealed(plain) == b""
    for at in random.Random(1).sample(range(len(told)), 200):
        assert artefact.sealed(flipped(told, at)) != flipped(told, at), at


def test_the_tree_lists_fields_in_the_order_of_declaration():
    found = artefact.tree(artefact.encode(example(), {}), "x.h5")
    assert [item.path for item in found][:8] == [
        "word", "names", "numbers", "count", "yes", "missing", "masses", "masses/z"
    ]  # fmt: skip
    by_path = {item.path: item for item in found}
    assert by_path["word"].value == "naïve" and by_path["names"].value == ["a", "bcd"]
    assert by_path["inner/samples"].shape == (3, 2) and by_path["inner/samples"].unit == "N"
    assert by_path["inner"].shape is None


def test_what_cannot_be_stored_is_refused():
    with pytest.raises(TypeError, match="cannot be stored"):
        artefact.encode(example(flags=np.array([object()])), {})


@pytest.mark.parametrize(
    ("form", "sentence"),
    [
        ("bipedstudy artefact 4", "made by a newer version of this program (format 4); this one reads format 3"),
        ("bipedstudy artefact 1", "made by an earlier version of this program (format 1); this one reads format 3;"),
        ("bipedstudy artefact 0", "an HDF5 file, but not an artefact of this study"),
        ("bipedstudy artefact one", "an HDF5 file, but not an artefact of this study"),
        ("another program 1", "an HDF5 file, but not an artefact of this study"),
    ],
)
def test_an_artefact_of_another_format_is_refused_by_its_number(tmp_path, form, sentence):
    path = tmp_path / "x.h5"
    path.write_bytes(artefact.encode(example(), {}))
    assert artefact.decode(path.read_bytes(), Everything, path.name).count == 3
    with h5py.File(path, "r+") as file:
        assert file.attrs["format"] == "bipedstudy artefact 3"
        file.attrs["format"] = form
    with pytest.raises(StudyError) as refused:
        artefact.decode(path.read_bytes(), Everything, path.name)
    assert f"x.h5: {sentence}" in str(refused.value)


@pytest.mark.parametrize("other", [inner(), *(example(**changes) for changes in (
    {"inner": ()}, {"masses": (1.0, 2.0)}, {"rows": np.zeros(3)}, {"count": inner()}, {"flags": {"a": 1.0}}))])
def test_an_artefact_of_another_class_or_kind_is_one_sentence(other):
    """Values for a dataclass, a mapping or a table; a group for a number or an array. None of it in HDF5's words."""
    with pytest.raises(StudyError, match=r"x\.h5: its fields do not fit this version of the study") as refused:
        artefact.decode(artefact.encode(other, {}), Everything, "x.h5")
    assert "synchronously" not in str(refused.value)


@pytest.mark.parametrize("kind", [kind for kind in ARTEFACT if kind.startswith("HDF5")])
def test_a_strange_hdf5_file_is_one_sentence(tmp_path, kind):
    ARTEFACT[kind](tmp_path / "x.h5")
    with pytest.raises(StudyError, match=r"^x\.h5: "):
        artefact.decode((tmp_path / "x.h5").read_bytes(), Everything, "x.h5")


def test_an_artefact_cut_anywhere_is_never_a_traceback_and_never_taken_for_whole():
    content = artefact.encode(example(), {"key": "k"})
    for end in (*range(0, len(content), 997), len(content) - 1):
        for read in (artefact.tree, lambda cut, name: artefact.decode(cut, Everything, name)):
            with pytest.raises(StudyError, match=r"x\.h5: (is empty|is truncated or not an HDF5 file)"):
                read(content[:end], "x.h5")


# --- Other people's tools understand the files: xarray, h5py and pandas in three lines each.


ROOT = Path(__file__).resolve().parents[2]
STAGES = tuple(read_graph(ROOT).stages)


def made(kind, chance):
    """Any value of a type that a field of a result declares."""
    if typing.get_origin(kind) in (typing.Union, types.UnionType) and chance.random() < chance.missing:
        return None
    kind = hdf5.present(kind)
    origin, arguments = typing.get_origin(kind), typing.get_args(kind)
    if is_dataclass(kind):
        hints = typing.get_type_hints(kind)
        for _ in range(100):
            with contextlib.suppress(EnginesDisagree, ValueError):  # numbers that it does not take
                return kind(**{field.name: {} if field.name == "files" else made(hints[field.name], chance)
                               for field in fields(kind)})  # fmt: skip
        raise AssertionError(f"no {kind.__name__} was found that may be")
    if typing.get_origin(kind) in (dict, Mapping):
        return {key: made(arguments[1], chance) for key in chance.choice(((), ("b", "a"), ("b", "a"), ("c",)))}
    if origin is tuple:
        count = chance.randint(0, 3) if arguments[-1] is Ellipsis else len(arguments)
        return tuple(made(arguments[0], chance) for _ in range(count))
    if kind is np.ndarray:
        shape = chance.choice(((2,), (2, 3), (2, 3), (0, 2), (4, 2, 2), (2, len(MEASURES))))
        return np.full(shape, chance.choice((np.nan, -0.0, 3.5, 7, True)))
    return {float: chance.choice((float("nan"), float("inf"), -0.0, 0.1)), int: chance.randint(-(2**53), 2**53),
            bool: chance.random() < 0.5, str: chance.choice(("", "x", "é", "two words"))}[kind]  # fmt: skip


def assert_all_tools_open(path):
    """Every group in xarray with names for all dimensions, tables in pandas too."""
    xarray, _ = pytest.importorskip("xarray"), pytest.importorskip("h5netcdf")
    groups = {"": None}
    with h5py.File(path) as file:
        file.visititems(lambda name, item: groups.update({name: item.attrs.get(ROWS)})
                        if isinstance(item, h5py.Group) and name != "provenance" else None)  # fmt: skip
    for group, count in groups.items():
        with xarray.open_dataset(path, engine="h5netcdf", group=group) as opened:
            assert not [name for name in opened.dims if name.startswith("phony")], group
            opened.load()
            if count is not None:
                frame = opened.drop_dims(set(opened.dims) - {"row"}).to_dataframe()
                assert len(frame) == count and frame.index.name == "row"


@pytest.mark.parametrize("seeds", [(3, 4), pytest.param(range(20), marks=pytest.mark.slow)], ids=["two", "twenty"])
@pytest.mark.parametrize("stage", STAGES)
def test_any_result_of_a_stage_comes_back_to_the_last_bit_and_opens_elsewhere(stage, tmp_path, seeds):
    cls = importlib.import_module(f"stages.{stage}.result").Result
    for seed in seeds:
        chance = random.Random(f"{stage} {seed}")
        chance.missing = 0.3 if seed < seeds[-1] else 0.0  # the last is whole, and is opened
        result = made(cls, chance)
        content = artefact.encode(result, {"key": "k"})
        assert seed > seeds[0] or content == artefact.encode(result, {"key": "k"})
        assert bits(artefact.decode(content, cls, stage)) == bits(result)
    (tmp_path / "made.h5").write_bytes(content)
    assert_all_tools_open(tmp_path / "made.h5")


def test_files_of_a_closer_result_open_elsewhere(tmp_path):
    _, content = artefact.encoded(motions(1.0), {}, {}, motions(1.5, **{"claims.yaml": b"x\0y", "log": b"abc"}))
    (tmp_path / "made.h5").write_bytes(content)
    assert_all_tools_open(tmp_path / "made.h5")


@pytest.mark.slow
@pytest.mark.parametrize("stage", STAGES)
def test_every_artefact_that_is_there_opens_elsewhere(stage):
    path = ROOT / "results" / f"{stage}.h5"
    if not path.exists():
        pytest.skip(f"results/{stage}.h5 is not there; make it with: bipedstudy run {stage}")
    with h5py.File(path) as file:
        if file.attrs["format"] != artefact.FORMAT:
            pytest.skip(f"results/{stage}.h5 is of an earlier format; run its stage anew")
    assert_all_tools_open(path)


def test_the_files_of_a_run_say_what_they_are(done):
    for path in (done.root / "results").glob("*.h5"):
        assert_all_tools_open(path)
        with h5py.File(path) as file:
            assert file.attrs["stage"] == path.stem and file.attrs["source"].startswith("bipedstudy")


def test_a_table_is_a_dataset_for_each_column(tmp_path):
    path = tmp_path / "x.h5"
    path.write_bytes(artefact.encode(example(rows=(inner(3), inner(3))), {}))
    with h5py.File(path) as file:
        assert list(file["rows"]) == ["row", "value", "samples", "samples_1", "samples_2"]
        assert file["rows/samples"].shape == (2, 3, 2) and file["rows/value"].attrs["units"] == "m"
        assert file["rows/value"].dims[0][0] == file["rows/row"]
    path.write_bytes(artefact.encode(example(rows=(inner(3), inner(2))), {}))
    with h5py.File(path) as file:  # no column for what has another shape in each row
        assert list(file["rows"]) == ["row", "value", "0", "1"] and file["rows/1/samples"].shape == (2, 2)


#: A row whose heights lie along its times, and a table of them.
Step = make_dataclass("Step", [("time", np.ndarray, quantity("s", "time")), (
    "height", np.ndarray, quantity("m", "height", dimensions=("time",)))])  # fmt: skip
Steps = make_dataclass("Steps", [("steps", tuple[Step, ...])])


def test_a_field_without_a_column_gives_no_dimension_its_name():
    result = Steps((Step(np.ones(2), np.zeros(2)), Step(np.ones(3), np.zeros(2))))
    assert bits(artefact.decode(artefact.encode(result, {}), Steps, "x")) == bits(result)


def test_rows_of_several_classes_are_no_table():
    other = make_dataclass("Other", [("value", float)], frozen=True)
    with pytest.raises(TypeError, match="rows of several classes"):
        artefact.encode(example(rows=(inner(3), other(1.0))), {})


def test_a_table_that_lost_a_row_is_one_sentence(tmp_path):
    path = tmp_path / "x.h5"
    path.write_bytes(artefact.encode(example(rows=(inner(3), inner(3))), {}))
    with h5py.File(path, "r+") as file:
        file["rows"].attrs[ROWS] = 3
    with pytest.raises(StudyError, match="value has 2 rows, not 3"):
        artefact.decode(path.read_bytes(), Everything, path.name)


@pytest.mark.parametrize(
    ("cells", "column"),
    [
        ((1.0, None, -0.0), [1.0, np.nan, -0.0]),
        ((None, None), [np.nan, np.nan]),
        ((True, None), [True, False]),
        ((1, 2.5), [1.0, 2.5]),
        ((2**60 + 1, 2.5), None),  # no one type holds both
        (("a", None), ["a", ""]),
        (((1, 2), (3, 4)), [[1, 2], [3, 4]]),
        (((1, 2), (3,)), None),
        (((), ()), [[], []]),
    ],
)
def test_cells_make_a_column_or_none(cells, column):
    found = hdf5.stacked(cells)
    assert (found is None) if column is None else np.array_equal(found, column, equal_nan=found.dtype.kind == "f")


def test_dimensions_are_named_as_declared_where_that_is_consistent():
    shapes = {"time": (5,), "place": (5, 2), "legs": (0, 2), "square": (2, 2), "count": (), "count_0": (4,),
              "sub": None}  # fmt: skip
    declared = {"place": ("time", "axis"), "legs": ("time", "axis"), "square": ("axis", "axis"), "count_0": ("sub",)}
    assert hdf5.names(shapes, declared) == {
        "time": ("time",), "place": ("time", "axis"), "legs": ("legs_0", "axis"), "square": ("axis", "square_1"),
        "count": (), "count_0": ("count_0_0",), "sub": (),
    }  # fmt: skip
    assert hdf5.names({"x": (3, 2), "x_1": (7, 7)}, {}, "row")["x"] == ("row", "x_1_")
