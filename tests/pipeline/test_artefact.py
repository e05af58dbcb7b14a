"""Results go to HDF5 and come back, with the same bytes every time."""

import random
import time
from dataclasses import dataclass, field, fields, is_dataclass, replace

import h5py
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from pipeline.cache import artefact, disk
from pipeline.errors import StudyError
from stages.biped.quantity import quantity
from tests.pipeline.strange_files import ARTEFACT


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


def test_every_kind_of_field_comes_back():
    """Also where they are empty; not the files, which lie beside it."""
    empty = example(word="", names=(), numbers=(), masses={}, rows=(), inner=inner(0), missing=1.5)
    for result in (example(), empty):
        assert bits(round_trip(result)) == bits(replace(result, files={}))


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
        spoilt = told[:at] + bytes([told[at] ^ 1]) + told[at + 1 :]
        assert artefact.sealed(spoilt) != spoilt, at


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
    """Values for a dataclass, a mapping or a table; a group for a number or an array."""
    with pytest.raises(StudyError, match=r"x\.h5: its fields do not fit this version of the study"):
        artefact.decode(artefact.encode(other, {}), Everything, "x.h5")


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
