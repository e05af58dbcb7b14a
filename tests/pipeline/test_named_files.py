"""Files that a parameter names are inputs like any other: their content decides what is current."""

from __future__ import annotations

import pytest

from pipeline.errors import StudyError


def test_the_content_of_a_named_file_decides(toy):
    table, setting = toy.root / "lab.txt", "side.table=lab.txt"
    table.write_text("41")
    assert toy.outcomes(setting, names=("side",))[0].summary == "number 41"
    assert toy.run(setting, names=("side",)) == {"side": "current"}
    table.write_text("42")
    again = toy.outcomes(setting, names=("side",))[0]
    assert (again.how, again.summary, again.reasons) == ("computed", "number 42", ("input table changed",))
    table.write_text("41")
    assert toy.run(setting, names=("side",)) == {"side": "restored"}
    assert toy.run(names=("side",)) == {"side": "computed"}


def test_a_missing_named_file_is_named(toy):
    with pytest.raises(StudyError, match=r'side.yaml: table = "lab.txt": there is no such file'):
        toy.run("side.table=lab.txt", names=("side",))
    with pytest.raises(StudyError, match="there is no such file"):
        toy.run("side.table=.", names=("side",))
