"""What runs again and what does not."""

import dataclasses
import json
import os
import re
import shutil
import subprocess
import types
from pathlib import Path

import pytest

from pipeline.cache import artefact, differences, disk, fingerprint, hdf5, untouched
from pipeline.cache.sources import Sources, SyntaxMemo
from pipeline.execution.display import Display
from pipeline.execution.executor import bring_up_to_date
from pipeline.parameters import loading
from tests.pipeline.toy import HOME

ALL = {"fall", "bounce", "side", "picture"}


def how(outcome):
    return {name for name, state in outcome.items() if state == "computed"}


def test_what_a_stage_needs_is_computed_in_order_and_then_the_rest(toy):
    assert toy.run(names=("bounce",)) == {"fall": "computed", "bounce": "computed"}
    assert sorted(toy.results()) == ["bounce.h5", "fall.h5"]
    outcomes = toy.outcomes()
    assert {one.stage: one.how for one in outcomes} == {
        "fall": "current", "bounce": "current", "side": "computed", "picture": "computed"}  # fmt: skip
    assert outcomes[0].summary == "fell 4.91 m"
    assert sorted(toy.results()) == [
        "bounce.h5", "claims.yaml", "fall.h5", "figures/one.svg", "picture.h5", "side.bin", "side.h5"
    ]  # fmt: skip


def test_every_file_says_which_code_made_it(done, capsys):
    """The commit of the checkout, and a digest of engine and stages; both are part of no key and of no comparison."""
    place = done.root / "results/fall.h5"
    before = place.read_bytes()
    about = artefact.provenance(before, "fall.h5")
    said = r"bipedstudy \S+, code [0-9a-f]{16}"
    if (HOME / ".git").exists():
        commit = subprocess.run(["git", "rev-parse", "HEAD"], cwd=HOME, text=True, capture_output=True, check=True)
        said = said.replace(", code", f", commit {commit.stdout.strip()}, code")
    assert re.fullmatch(said, about["program"])
    run = next(done.root.glob(f"{done.package}/fall/run.py"))
    run.write_text(run.read_text() + "\n# a remark changes no key\n")
    assert set(done.run().values()) == {"current"} and place.read_bytes() == before
    assert how(done.run(force=True)) == ALL
    after = artefact.provenance(place.read_bytes(), "fall.h5")
    assert after["program"] != about["program"] and after["key"] == about["key"]
    assert "deterministic" not in capsys.readouterr().err


def test_computed_again_in_another_folder_all_has_the_same_bytes(done, finished):
    assert how(done.run(force=True, jobs=1)) == ALL
    assert done.results() == finished.results()


MOTION, PARAMETERS = "PACKAGE/body/motion.py", "params/ground.yaml"


@pytest.mark.parametrize(("edits", "again"), [
    ([(PARAMETERS, "value: 1e5", "value: 2e5")], {"bounce", "picture"}),
    ([(PARAMETERS, "9.81", "9.82")], {"fall", "bounce", "picture"}),
    ([("params/picture.yaml", "title: fall", "title: autumn")], {"picture"}),
    ([(PARAMETERS, "value: 1e5", "value: 100000"), (PARAMETERS, "standard value", "measured")], set()),
    ([(MOTION, "# Galileo", "# Galileo Galilei, Discorsi"), (MOTION, "Free fall.", "Way fallen from rest."),
      ("PACKAGE/fall/run.py", "settings = parameters.settings", "settings  =  ( parameters . settings )")], set()),
    ([(MOTION, "0.5 * gravity", "0.25 * gravity")], {"fall", "bounce", "picture"}),
    ([("PACKAGE/bounce/run.py", "distance[-1]", "distance[0]")], {"bounce", "picture"}),
    ([("PACKAGE/fall/run.py", "np.linspace(0, 1, settings.steps)", "np.linspace(0, 1, num=settings.steps)")], {"fall"}),
    ([("PACKAGE/picture/style.mplstyle", "width: 1", "width: 2")], {"picture"}),
    (["ground.contact_stiffness=3e5"], {"bounce", "picture"}), (["fall.parts.1.mass=0.5"], {"fall", "bounce"}),
], ids=["a parameter", "one of all", "of the last", "unit and form", "comments and layout", "code of all",
        "code of one", "code that gives the same result", "a style sheet beside the code", "--set",
        "--set of an entry"])  # fmt: skip
def test_an_edit_reruns_only_what_its_meaning_reaches_and_its_undoing_nothing(done, edits, again):
    settings = [edit for edit in edits if isinstance(edit, str)]
    files = edits[len(settings) :]
    before, texts = done.results(), {done.path(name): done.path(name).read_text() for name, _, _ in files}
    for edit in files:
        done.edit(*edit)
    assert how(done.run(*settings)) == again
    for path, text in texts.items():
        path.write_text(text)
    assert set(done.run().values()) <= {"current", "restored"} and done.results() == before


def sources(root, **texts):
    """The sources of a package with these files."""
    for name, text in texts.items():
        path = root / "package" / f"{name.replace('.', '/')}.py"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return Sources(root, "package", SyntaxMemo(root / "kept.json"))


def test_a_package_that_lists_its_folder_reaches_every_module_of_it(tmp_path):
    found = sources(tmp_path, **{
        "register.one": "import json", "other.one": "import json", "other.__init__": "",
        "register.__init__": "import pkgutil\nALL = list(pkgutil.iter_modules(__path__))",
        "run": "from package.register import ALL\nfrom package.other import x"})  # fmt: skip
    expected = {f"package/{name}.py" for name in ("run", "register/__init__", "register/one", "other/__init__")}
    assert set(found.closure(["package.run"]).files) == expected
    (tmp_path / "package/register/_two.py").touch()
    assert set(found.closure(["package.run"]).files) == {*expected, "package/register/_two.py"}


def test_what_type_checkers_alone_import_is_no_part_of_a_key(tmp_path):
    found = sources(tmp_path, seen="import json", other="import json", run=(
        "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    import elsewhere\n    from package.other import x\n"
        "    def f():\n        import nowhere\nelse:\n    from package.seen import x\n"
        "if not TYPE_CHECKING:\n    import here")).closure(["package.run"])  # fmt: skip
    assert set(found.files) == {"package/run.py", "package/seen.py"}
    assert {*found.foreign} == {"typing", "json", "here"}


@pytest.mark.parametrize(("package", "users"), [("numpy", {"fall"}), ("h5py", ALL)])
def test_another_version_of_a_package_reruns_its_users_and_that_of_artefacts_every_stage(
    done, monkeypatch, package, users
):
    version = fingerprint._version
    monkeypatch.setattr(fingerprint, "_version", lambda name: "0.0.1" if name == package else version(name))
    said = [(one.stage, reason) for one in done.outcomes() for reason in one.reasons]
    assert users <= {name for name, reason in said if reason.startswith(f"{package} ") and "-> 0.0.1" in reason}


def test_times_go_to_the_side_log(done):
    done.run(force=True, names=("fall",))
    lines = [json.loads(line) for line in (done.root / "results/log.jsonl").read_text().splitlines()]
    assert lines[-1]["stage"] == "fall" and lines[-1]["how"] == "computed" and lines[-1]["seconds"] > 0
    assert 0.0 < lines[-1]["processor_seconds"] < 60.0


# --- One cache for many: `--cache` takes from another results folder what was computed there, and only reads it.


def lay(folder):
    """How all lies in a folder: names, times, modes and content."""
    return {path.relative_to(folder): (path.lstat().st_mtime_ns, path.stat().st_mode, disk.read(path))
            for path in folder.rglob("*")}  # fmt: skip


def test_many_users_find_all_in_a_cache_that_is_only_read(done, tmp_path):
    before, lab = done.results(), tmp_path / "lab"
    shutil.move(done.root / "results", lab)
    for path in [*lab.rglob("*"), lab]:
        path.chmod(0o555 if path.is_dir() else 0o444)
    first = lay(lab)
    for user in range(3):
        study = dataclasses.replace(done.study(), results=tmp_path / f"user{user}", cache=lab / ".cache")
        values = study.parameters(tuple(study.graph.stages))
        with disk.locked(study.results, "results", "run-all", False, print):
            outcomes = bring_up_to_date(study, values, Display())
        assert {outcome.how for outcome in outcomes} == {"restored"}
        for name, content in before.items():
            place = study.results / name
            assert place.read_bytes() == content and os.access(place, os.W_OK) and place.stat().st_nlink == 1
    again = dataclasses.replace(study, cache=None)
    assert {outcome.how for outcome in bring_up_to_date(again, values, Display())} == {"current"}
    assert lay(lab) == first
    for path in [lab, *lab.rglob("*")]:
        path.chmod(0o755)


def test_what_the_shared_cache_lacks_or_holds_damaged_is_computed_into_the_own_one(ran):
    shutil.move(ran.root / "results", ran.root / "lab")
    (ran.root / "lab/fall.h5").unlink()
    for path in (ran.root / "lab/.cache").glob("*/results/side.bin"):
        path.write_bytes(b"damaged")
    first = lay(ran.root / "lab")
    assert ran.says("status --cache lab").count("in cache") == 4
    hows = dict(line.split()[:2] for line in ran.says("run-all --cache lab/.cache").splitlines() if line[:1].isalpha())
    assert hows["fall"] == hows["bounce"] == "restored" and hows["side"] == "computed"
    assert lay(ran.root / "lab") == first
    ran.says("run-all --cache nowhere", "nowhere", code=2)
    said = "note: params has no stored results: what is not in results is computed"
    assert ran.says("run-all --cache params", said).count(" current ") == 4


# --- Keys see all that results follow from; what is copied or renamed is either whole or not called so.


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
