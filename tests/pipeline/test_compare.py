"""`bipedstudy compare OTHER`: what changed between two results folders, as text, JSON, CSV and a page."""

import csv
import io
import json
import shutil
from dataclasses import field, make_dataclass

import h5py
import numpy as np
import pytest

from pipeline.cache import artefact, hdf5
from pipeline.changes.command import _change, _claims, _lines, _numbers, changes, share
from tests.pipeline.toy import copied

Row = make_dataclass("Row", [("width", float, field(metadata={"unit": "m"})), ("name", str)])
Whole = make_dataclass("Whole", [("table", tuple[Row, ...])])
Bare = make_dataclass("Bare", [("name", str)])


@pytest.fixture(scope="module")
def changed(finished_with_commands, tmp_path_factory):
    """A study whose results were others before its gravity was changed; tests compare them, and change neither."""
    toy = copied(finished_with_commands, tmp_path_factory.mktemp("changed"))
    shutil.copytree(toy.root / "results", toy.root / "before")
    toy.says("run-all --set ground.gravity=9.7")
    return toy


def earlier(toy, name):
    """The results of before in another folder, to be spoilt."""
    return shutil.copytree(toy.root / "before", toy.root / name)


def test_the_same_results_are_no_change(changed):
    earlier(changed, "again")
    told = changed.answers(words := "compare before --results again", f"{words} --json")
    assert told[words] == (0, "nothing changed from before to again\n", "")
    assert json.loads(told[f"{words} --json"][1])["changed"] is False


def test_parameters_numbers_and_pictures_that_changed(changed):
    """Numbers beyond the tolerance; the page with them stands alone."""
    code, out, errors = changed.command("compare", "before")
    assert (code, errors) == (3, "") and "ground.gravity" in out and all(len(line) <= 80 for line in out.splitlines())
    words = ("compare before --json", "compare before --csv", "compare before --json --tolerance 0.1",
             "compare before --page changes.html")  # fmt: skip
    told, rows, rough, page = (said[0:3] for said in changed.answers(*words).values())
    told, rows, rough = json.loads(told[1]), [*csv.DictReader(io.StringIO(rows[1]))], json.loads(rough[1])
    (parameter,) = told["parameters"]
    assert (parameter["key"], parameter["after"]) == ("ground.gravity", "9.7") and "fall" in parameter["stages"]
    for row in told["numbers"]:
        if isinstance(row["before"], float) and row["relative"] is not None and row["before"] > 0.0:
            assert row["relative"] == pytest.approx(row["after"] / row["before"] - 1.0)
    assert told["numbers"] and told["changed"] is True
    assert [row["path"] for row in rows] == [row["path"] for row in told["numbers"]]
    assert all(row["relative"] is None for row in rough["numbers"])
    assert rough["smaller"] > 0 and rough["parameters"] and rough["changed"]
    shown = (changed.root / "changes.html").read_text(encoding="utf-8")
    assert page[0] == 3 and page[2] == "written: changes.html\n"
    assert "ground.gravity" in shown and "http" not in shown.replace("http-equiv", "") and "<script" not in shown


def test_a_key_that_was_not_there_is_not_told_as_the_word_none():
    """A law of friction is named none."""
    row = {"key": "ground.friction", "before": None, "after": "none", "stages": ["analytic"]}
    empty = dict.fromkeys(("unread", "claims", "numbers", "figures"), ())
    *_, told = _lines({**empty, "changed": True, "smaller": 0, "parameters": [row]})
    assert told.split() == ["ground.friction", "not", "there", "none"]


def test_a_stage_that_is_missing_or_damaged_is_said(changed):
    folder = earlier(changed, "damaged")
    (folder / "fall.h5").write_bytes(b"no HDF5")
    (folder / "bounce.h5").unlink()
    changed.says("compare damaged", "damaged/fall.h5: is truncated or not an HDF5 file",
                 "not compared, as damaged has no result of: bounce", code=3)  # fmt: skip


def test_results_of_some_stages_are_compared_without_a_row_for_all_that_is_missing(changed):
    """A stage run with --results leaves no claims and no figures there; that it has none is one sentence."""
    folder = earlier(changed, "some")
    (folder / "claims.yaml").unlink()
    (folder / "picture.h5").unlink()
    shutil.rmtree(folder / "figures")
    told = json.loads(changed.says("compare some --json", code=3))
    assert (told["claims"], told["figures"]) == ([], []) and told["numbers"]
    assert "some has no result of: picture" in told["unread"][0]


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


def test_results_of_the_first_version_are_compared_and_kept(changed):
    """Every number that both have, with its unit; what one alone has, or has in another unit, is named."""
    folder = earlier(changed, "first")
    for name, gone, units in (("fall", ("height",), {}), ("bounce", (), {"force": "kgf"}), ("side", (), {})):
        path = folder / f"{name}.h5"
        path.write_bytes(in_first_form(path.read_bytes(), *gone, **units))
    (folder / "ladder.h5").write_bytes(b"of a stage that went")
    (folder / "claims.yaml").write_text("- {id: force, stated: one newton, found: 3 N, holds: true, why: it is}\n")
    kept = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    told = json.loads(changed.says("compare first --json", code=3))
    assert {path: path.read_bytes() for path in kept} == kept
    rows = {(row["stage"], row["path"]): row for row in told["numbers"]}
    assert rows["side", "number"]["relative"] == 0.0 and rows["fall", "sample.distance"]["unit"] == "m"
    assert rows["fall", "sample.distance"]["relative"] > 0.0 and ("bounce", "force") not in rows
    assert "no such stage: ladder" in told["unread"][-1]
    assert "in results/fall.h5 alone or in another unit: height" in told["unread"][0]
    assert sum("alone or in another unit: force" in sentence for sentence in told["unread"]) == 1
    (claim,) = told["claims"]
    assert (claim["before"], claim["measured_before"], claim["after"]) == ("holds", "3 N", "does not hold")
    assert "anew" not in changed.says("compare first", "Numbers that both have:", code=3)


def test_claims_with_another_verdict_go_before_those_with_other_numbers(tmp_path):
    folders = [tmp_path / name for name in ("before", "after")]
    for folder, measured, verdict in zip(folders, ("1 N", "2 N"), ("holds", "does not hold"), strict=True):
        folder.mkdir()
        (folder / "claims.yaml").write_text("claims:\n" + "".join(
            f"- {{id: {name}, verdict: {said}, measured: {words}}}\n" for name, said, words in (
                ("same", "holds", "3 N"), ("measured", "holds", measured), ("turned", verdict, "3 N"))))  # fmt: skip
    assert [row["id"] for row in _claims(*folders, [])] == ["turned", "measured"]


def test_rows_of_the_first_form_are_columns():
    new = artefact.encode(Whole((Row(1.0, "a"), Row(2.5, "b"))), {})
    old = in_first_form(artefact.encode(Whole((Row(1.0, "a"), Row(2.0, "b"))), {}))
    rows = {row["path"]: row for row in changes("stage", old, new, ("old", "new"), older=True)}
    assert rows["table.width"]["relative"] == pytest.approx(0.2) and rows["table.width"]["unit"] == "m"


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


def test_a_number_that_one_side_alone_has_is_told_with_its_unit():
    there, bare = artefact.encode(Row(1.0, "a"), {}), artefact.encode(Bare("a"), {})
    for sides, alone in (((bare, there), "after"), ((there, bare), "before")):
        (row,) = changes("stage", *sides, ("old", "new"))
        assert (row["path"], row["unit"], row["alone"]) == ("width", "m", alone)


def test_single_numbers_are_listed_that_changed_by_more_than_round_off():
    """Not arrays nor words, which have no one value before and after. What is yes or no goes first: a gait that was no
    longer stable was not listed, nor a count."""
    found = (("curve", "array 3", "differs by 1 at most", 0.2), ("outcome", "fell", "walked", None),
             ("drift", 0.0, 1e-12, np.inf), ("height", 2.0, 3.0, 0.5), ("stable", True, False, -1.0),
             ("steps", 4, 5, 0.25), ("rigid", True, True, 0.0))  # fmt: skip
    rows = [{"stage": "fall", "path": path, "unit": "m", "before": before, "after": after, "relative": relative}
            for path, before, after, relative in found]  # fmt: skip
    assert [*_numbers(rows, 0)][3:] == [
        "  fall stable", "    true -> false m", "  fall height", "    2 -> 3 m (+50 %)", "  fall steps",
        "    4 -> 5 m (+25 %)"]  # fmt: skip


def test_a_share_is_read_as_per_cent():
    assert (share(0.0123, 1.0), share(-2.0, 1.0), share(None, 1.0)) == ("+1.23 %", "-200 %", "")
    assert (share(np.inf, 0.0), share(np.inf, 1.0)) == ("from zero", "not finite in one of them")
