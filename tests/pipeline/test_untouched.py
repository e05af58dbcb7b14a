"""What was noted to be current is believed only while every file lies as it lay."""

from __future__ import annotations

import os

import pytest

from pipeline.cache import untouched

SUMMARIES = {"fall": "fell", "bounce": "bounced"}


@pytest.fixture
def noted(done, monkeypatch):
    """A toy study that was noted to be current, however new its files are."""
    monkeypatch.setattr(untouched, "_IN_DOUBT_NS", -(10**12))
    study = done.study()
    untouched.note(study, untouched.look(study), SUMMARIES)
    assert untouched.recall(done.study()) == SUMMARIES
    return done


def rewritten(path, old, new):
    """Put other text of the same length into a file, which keeps the time of its text."""
    found, text = path.stat(), path.read_bytes()
    assert old in text and len(old) == len(new)
    with open(path, "r+b") as file:
        file.write(text.replace(old, new))
    os.utime(path, ns=(found.st_atime_ns, found.st_mtime_ns))
    assert path.stat().st_mtime_ns == found.st_mtime_ns and path.stat().st_size == found.st_size


@pytest.mark.parametrize("change", [
    lambda toy: rewritten(toy.path("params/fall.yaml"), b"2", b"3"),
    lambda toy: rewritten(toy.path("PACKAGE/fall/run.py"), b"import", b"IMPORT"),
    lambda toy: rewritten(toy.root / "dvc.yaml", b"static_friction, dynamic", b"dynamic_friction, static"),
    lambda toy: rewritten(toy.root / "results/fall.h5", b"HDF", b"hdf"),
    lambda toy: (toy.root / "results/fall.h5").unlink(),
    lambda toy: (toy.root / "results/.cache/current/fall.json").unlink(),
    lambda toy: toy.path("PACKAGE/fall/late.py").write_text(""),
    lambda toy: (toy.root / "results/report.html").write_text("a page"),
], ids=["parameter", "code", "graph", "result", "no result", "no record", "another module", "report"])  # fmt: skip
def test_any_change_ends_it(noted, change):
    change(noted)
    assert untouched.recall(noted.study()) == {}


def test_it_holds_for_what_was_asked_alone(noted):
    assert untouched.recall(noted.study("fall.height=3")) == {}


def test_what_changed_just_now_is_not_relied_on(done):
    done.edit("params/fall.yaml", "height", "height")
    assert untouched.look(done.study()) is None


def test_a_result_that_is_missing_is_not_noted(done):
    for name in (".cache/current/fall.json", "fall.h5"):
        (done.root / "results" / name).unlink()
    assert untouched.look(done.study()) is None


def test_the_command_believes_the_note_and_says_the_same(ran):
    """It looks up no stored result then: that would fail."""
    sure = "from pipeline.cache import untouched; untouched._IN_DOUBT_NS = -(10**12); "
    unread = "from pipeline.cache.store import Store; Store.current = None; "
    assert "unexpected TypeError" in ran.command("run-all", before=sure + unread)[2]
    ran.command("run-all", before=sure)  # the page has the folder's name, and this is a copy
    found = ran.command("run-all", before=sure)
    assert found[0] == 0 and found[1].count("current") == 4
    assert ran.command("run-all", before=sure + unread) == found
    assert "bounce        computed" in ran.command("run-all", "--set", "ground.contact_stiffness=2e5", before=sure)[1]
    assert "bounce        restored" in ran.command("run-all", before=sure)[1]
