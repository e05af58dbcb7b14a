"""`bipedstudy compare OTHER`: what changed between two results folders, as text, JSON, CSV and a page."""

import csv
import io
import json
import shutil
from dataclasses import dataclass, field

import h5py
import numpy as np
import pytest

from pipeline.cache import artefact, hdf5
from pipeline.changes.command import _change, changes, share


@dataclass(frozen=True)
class Row:
    width: float = field(metadata={"unit": "m"})
    name: str = field(metadata={"unit": "-"})


@dataclass(frozen=True)
class Whole:
    table: tuple[Row, ...]


@pytest.fixture
def before(ran):
    """The toy study's results, as they were before something changes."""
    shutil.copytree(ran.root / "results", ran.root / "before")
    return ran


def test_the_same_results_are_no_change(before):
    code, out, errors = before.command("compare", "before")
    assert (code, errors) == (0, "") and out == "nothing changed from before to results\n"
    assert json.loads(before.command("compare", "before", "--json")[1])["changed"] is False


def test_parameters_numbers_and_pictures_that_changed(before):
    assert before.command("run-all", "--set", "ground.gravity=9.7")[0] == 0
    code, out, errors = before.command("compare", "before")
    assert (code, errors) == (3, "") and "ground.gravity" in out and all(len(line) <= 80 for line in out.splitlines())
    _, out, _ = before.command("compare", "before", "--json")
    told = json.loads(out)
    (parameter,) = told["parameters"]
    assert (parameter["key"], parameter["after"]) == ("ground.gravity", "9.7") and "fall" in parameter["stages"]
    relative = {(row["stage"], row["path"]): row for row in told["numbers"]}
    for row in told["numbers"]:
        if isinstance(row["before"], float) and row["relative"] is not None and row["before"] > 0.0:
            assert row["relative"] == pytest.approx(row["after"] / row["before"] - 1.0)
    assert relative and told["changed"] is True
    rows = list(csv.DictReader(io.StringIO(before.command("compare", "before", "--csv")[1])))
    assert [row["path"] for row in rows] == [row["path"] for row in told["numbers"]]


def test_what_is_smaller_than_the_tolerance_is_counted_and_no_change_but_parameters_are(before):
    before.command("run-all", "--set", "ground.gravity=9.80001")
    _, out, _ = before.command("compare", "before", "--json", "--tolerance", "0.1")
    told = json.loads(out)
    assert told["numbers"] == [] or all(row["relative"] is None for row in told["numbers"])
    assert told["smaller"] > 0 and told["parameters"] and told["changed"]


def test_the_page_stands_alone(before):
    before.command("run-all", "--set", "ground.gravity=9.7")
    code, _, errors = before.command("compare", "before", "--page", "changes.html")
    page = (before.root / "changes.html").read_text(encoding="utf-8")
    assert code == 3 and errors == "written: changes.html\n"
    assert "ground.gravity" in page and "http" not in page.replace("http-equiv", "") and "<script" not in page


def test_a_stage_that_is_missing_or_damaged_is_said(before):
    (before.root / "before/fall.h5").write_bytes(b"no HDF5")
    (before.root / "before/bounce.h5").unlink()
    code, out, _ = before.command("compare", "before")
    words = " ".join(out.split())
    assert code == 3 and "before/fall.h5: is truncated or not an HDF5 file" in words
    assert "not compared, as before has no result of: bounce" in words


def test_results_of_some_stages_are_compared_without_a_row_for_all_that_is_missing(before):
    """A stage run with --results leaves no claims and no figures there; that it has none is one sentence."""
    (before.root / "before/claims.yaml").unlink()
    (before.root / "before/picture.h5").unlink()
    shutil.rmtree(before.root / "before/figures")
    before.command("run-all", "--set", "ground.gravity=9.7")
    told = json.loads(before.command("compare", "before", "--json")[1])
    assert (told["claims"], told["figures"]) == ([], []) and told["numbers"]
    assert "before has no result of: picture" in told["unread"][0]


def in_first_form(content: bytes, *gone: str, **units: str) -> bytes:
    """An artefact as 0.1.0 wrote it: other words, a group for each row, no closer result; without the fields `gone`."""

    def copy(group, into):
        for name in (name for name in hdf5.members_of(group) if name not in ("closer", "row")):
            item = group[name]
            if name in gone:
                continue
            if "rows" in item.attrs:
                rows = into.create_group(name, track_order=True)
                for row in range(item.attrs["rows"]):
                    cells = rows.create_group(str(row), track_order=True)
                    for column in (each for each in hdf5.members_of(item) if each != "row"):
                        cells.create_dataset(column, data=hdf5.read(item[column])[row]).attrs["unit"] = "m"
                continue
            if isinstance(item, h5py.Group):
                made = into.create_group(name, track_order=True)
                copy(item, made)
                made.attrs.update(item.attrs if name == "provenance" else {})
            else:
                words = h5py.check_string_dtype(item.dtype)
                made = into.create_dataset(name, data=item.asstr()[()].encode() if words else item[()])
            if unit := units.get(name, item.attrs.get("units", "")):
                made.attrs["unit"] = unit

    with h5py.File(io.BytesIO(content), "r") as file, artefact.in_memory() as old:
        old.attrs["format"] = "bipedstudy artefact 1"
        copy(file, old)
        return artefact.image(old)


def test_results_of_the_first_version_are_compared_and_kept(before):
    """Every number that both have, with its unit; what one alone has, or has in another unit, is named."""
    folder = before.root / "before"
    for name, gone, units in (("fall", ("height",), {}), ("bounce", (), {"force": "kgf"}), ("side", (), {})):
        path = folder / f"{name}.h5"
        path.write_bytes(in_first_form(path.read_bytes(), *gone, **units))
    (folder / "ladder.h5").write_bytes(b"of a stage that went")
    (folder / "claims.yaml").write_text("- {id: force, stated: one newton, found: 3 N, holds: true, why: it is}\n")
    kept = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    before.command("run", "fall", "--set", "ground.gravity=9.7")
    code, out, errors = before.command("compare", "before", "--json")
    told = json.loads(out)
    assert (code, errors) == (3, "") and {path: path.read_bytes() for path in kept} == kept
    rows = {(row["stage"], row["path"]): row for row in told["numbers"]}
    assert rows["side", "number"]["relative"] == 0.0 and rows["fall", "sample.distance"]["unit"] == "m"
    assert rows["fall", "sample.distance"]["relative"] > 0.0 and ("bounce", "force") not in rows
    assert "no such stage: ladder" in told["unread"][-1]
    assert "in results/fall.h5 alone or in another unit: height" in told["unread"][0]
    assert sum("alone or in another unit: force" in sentence for sentence in told["unread"]) == 1
    (claim,) = told["claims"]
    assert (claim["before"], claim["measured_before"], claim["after"]) == ("holds", "3 N", "does not hold")
    _, out, _ = before.command("compare", "before")
    assert "Numbers that both have:" in out and "anew" not in out


def test_rows_of_the_first_form_are_columns():
    new = artefact.encode(Whole((Row(1.0, "a"), Row(2.5, "b"))), {})
    old = in_first_form(artefact.encode(Whole((Row(1.0, "a"), Row(2.0, "b"))), {}))
    rows = {row["path"]: row for row in changes("stage", old, new, ("old", "new"), older=True)}
    assert rows["table.width"]["relative"] == pytest.approx(0.2) and rows["table.width"]["unit"] == "m"


@pytest.mark.parametrize(
    ("other", "said"),
    [
        ("results", "these are the results themselves"),
        ("params", "there are no results there"),
        ("nowhere", "does not exist"),
    ],
)
def test_what_cannot_be_compared_is_refused(before, other, said):
    code, out, errors = before.command("compare", other)
    assert (code, out) == (2, "") and said in errors and len(errors.splitlines()) == 1


@pytest.mark.parametrize(
    ("before", "after", "expected"),
    [
        (2.0, 3.0, (2.0, 3.0, 0.5)),
        (-3.0, -2.0, (-3.0, -2.0, 1 / 3)),
        (1.0, 1.0, None),
        (np.nan, np.nan, None),
        (0.0, 0.0, None),
        (0.0, 2.0, (0.0, 2.0, np.inf)),
        (1.0, np.nan, (1.0, np.nan, np.inf)),
        ([1.0, 4.0, np.nan], [1.0, 5.0, np.nan], ("array 3", "differs by 1 at most", 0.2)),
        ([np.inf, 2.0], [np.inf, 1.0], ("array 2", "differs by 1 at most", 0.5)),
        ([1.0, 2.0], [1.0], ("array 2", "array 1", None)),
        (None, 1.0, (None, 1.0, None)),
        (None, None, None),
        ("none", "some", ("none", "some", None)),
    ],
)
def test_a_change_is_a_share_of_what_was(before, after, expected):
    found = _change(*(None if value is None else np.asarray(value) for value in (before, after)))
    if expected is None:
        assert found is None
    else:
        assert found[0] is None or str(found[0]) == str(expected[0])
        assert str(found[1]) == str(expected[1])
        assert found[2] == (None if expected[2] is None else pytest.approx(expected[2]))


def test_a_share_is_read_as_per_cent():
    assert (share(0.0123), share(-2.0), share(np.inf), share(None)) == ("+1.23 %", "-200 %", "from zero", "")
