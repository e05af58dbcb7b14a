"""Keys see all that results follow from; what is copied or renamed is either whole or not called so."""

import os
import shutil
import types
from pathlib import Path

import pytest

from pipeline.cache import artefact, differences, disk, fingerprint, hdf5, untouched
from pipeline.parameters import loading


def key(toy):
    study = toy.study()
    values = study.parameters(["fall"])
    parts = fingerprint.ingredients(study.graph.stages["fall"], study.sources, loading.as_plain(values["fall"]), {})
    return fingerprint.key(parts)


@pytest.mark.parametrize("file", [Path(each.__file__) for each in (artefact, differences, hdf5)],
                         ids=lambda path: path.name)  # fmt: skip
def test_an_edit_of_any_file_that_writes_artefacts_is_in_the_key(done, monkeypatch, file):
    before, edited = key(done), file.read_bytes()
    meaning = type(done.study().sources.memo).meaning

    def another(memo, content):
        found = meaning(memo, content)
        return types.SimpleNamespace(tree="another", imports=found.imports) if content == edited else found

    monkeypatch.setattr(type(done.study().sources.memo), "meaning", another)
    assert key(done) != before


def test_another_h5py_is_in_the_key_of_every_stage(done, monkeypatch):
    before, version = key(done), fingerprint._version
    monkeypatch.setattr(fingerprint, "_version", lambda name: "0" if name == "h5py" else version(name))
    assert key(done) != before


def test_a_stored_file_that_changes_while_it_is_copied_is_not_put_in_place(done, monkeypatch):
    store, place = done.study().store, done.root / "results/fall.h5"
    entry = store.current("fall")
    stored, looked = store.folder / entry.key / "results/fall.h5", []
    place.write_bytes(b"an earlier result")
    whole = disk.blocks

    def changing(path):
        looked.append(path)
        yield from whole(path) if looked.count(stored) < 2 else (b"other bytes",)

    monkeypatch.setattr(disk, "blocks", changing)
    with pytest.raises(OSError, match="changed while it was copied"):
        store.put_in_place(entry)
    assert looked.count(stored) == 2 and place.read_bytes() == b"an earlier result"


def test_a_rename_is_flushed_with_its_folder_and_after_the_files_content(tmp_path, monkeypatch):
    """What a power cut leaves is what was flushed: first the content, then the folder that has the new name."""
    flushed, replace, fsync = [], Path.replace, os.fsync

    def sync(handle):
        fsync(handle)
        flushed.append(os.fstat(handle).st_ino)

    monkeypatch.setattr(os, "fsync", sync)
    monkeypatch.setattr(Path, "replace", lambda path, to: (flushed.append("renamed"), replace(path, to))[1])
    disk.write(tmp_path / "result", b"whole")
    assert flushed == [(tmp_path / "result").stat().st_ino, "renamed", tmp_path.stat().st_ino]


@pytest.mark.parametrize("replaced", [False, True])
def test_an_entry_that_a_killed_run_set_aside_is_found_again_unless_another_took_its_place(done, replaced):
    """It was killed between the two renames of `keep`, or after them."""
    store, before = done.study().store, done.results()
    folder = store.folder / store.current("fall").key
    aside = folder.with_name(f"making-{folder.name}-1-old")
    shutil.copytree(folder, aside) if replaced else folder.rename(aside)
    (done.root / "results/fall.h5").unlink()
    store.sweep()
    assert done.run()["fall"] == "restored" and done.results() == before
    assert not [*store.folder.glob("making-*")]


def test_a_stored_entry_is_flushed_with_its_folder(done, monkeypatch):
    store, flushed = done.study().store, []
    entry = store.current("fall")
    folder = store.new_folder(entry.key)
    monkeypatch.setattr(disk, "sync_folder", flushed.append)
    store.keep(folder, entry)
    assert flushed[-1] == store.folder


# --- What was noted to be current is believed only while every file lies as it lay.


SUMMARIES = {"fall": "fell", "bounce": "bounced"}


@pytest.fixture
def noted(done, monkeypatch):
    """A toy study that was noted to be current, however new its files are, and a folder of packages in it."""
    (done.root / "site").mkdir()
    monkeypatch.syspath_prepend(done.root / "site")
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
    lambda toy: (toy.root / "site/numpy-99.dist-info").mkdir(),
], ids=["parameter", "code", "graph", "result", "no result", "no record", "another module", "report",
        "package"])  # fmt: skip
def test_any_change_ends_it(noted, change):
    change(noted)
    assert untouched.recall(noted.study()) == {}


def test_it_holds_for_what_was_asked_alone_and_not_for_what_is_missing(noted):
    assert untouched.recall(noted.study("fall.height=3")) == {}
    for name in (".cache/current/fall.json", "fall.h5"):
        (noted.root / "results" / name).unlink()
    assert untouched.look(noted.study()) is None


def test_what_changed_just_now_is_not_relied_on(done):
    done.edit("params/fall.yaml", "height", "height")
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
