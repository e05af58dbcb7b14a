"""`bipedstudy compare OTHER`: what changed between two results folders, as text, JSON, CSV and a page."""

from __future__ import annotations

import csv
import io
import json
import shutil

import numpy as np
import pytest

from pipeline.changes.command import _change, share


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
