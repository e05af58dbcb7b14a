"""A results folder that somebody else filled: whatever its files say, nothing outside of it is written or removed."""

import json
import os

import pytest

from pipeline.cache import disk
from pipeline.errors import StudyError
from pipeline.graph import is_inside
from pipeline.questions.asking import Asked

unix = pytest.mark.skipif(os.name != "posix", reason="uses links and pipes")
FORGED = b"forged"


@pytest.fixture
def victim(done):
    path = done.root / "victim.txt"
    path.write_bytes(b"mine")
    return path


def sealed(body):
    return disk.digest(json.dumps(body, sort_keys=True).encode())


def forge_manifest(done, stage, name):
    """Let the stored entry of a stage vouch for one more file, with a right seal; its bytes lie where it says."""
    folder = done.entry(stage)
    entry = json.loads((folder / "manifest.json").read_text())["entry"]
    sha = disk.digest(FORGED)
    entry["outs"][name] = {"sha256": sha, "size": len(FORGED), "content": sha}
    (folder / "manifest.json").write_text(json.dumps({"seal": sealed(entry), "entry": entry}))
    (folder / name).parent.mkdir(parents=True, exist_ok=True)
    (folder / name).write_bytes(FORGED)


def forge_record(done, stage, name, **changes):
    body = {**json.loads(done.record(stage).read_text()), **changes}
    body.pop("seal")
    body["files"] += [name]
    done.record(stage).write_text(json.dumps({**body, "seal": sealed(body)}))


@pytest.mark.parametrize(("forge", "name"), [
    *((forge_manifest, name) for name in (
        "results/../victim.txt", "results/figures/../../victim.txt", "../results/victim.txt", "results/mine.txt",
        "results/bounce.h5", "results/log.jsonl", "results/.cache/lock")),
    *((forge_record, name) for name in (
        "results/../victim.txt", "victim.txt", "results/mine.txt", "results/side.h5", "results/figures"))])
def test_what_is_forged_writes_and_removes_nothing_but_the_stages_own(done, victim, forge, name):
    before = {**done.results(), "mine.txt": b"mine"}
    (done.root / "results/mine.txt").write_bytes(b"mine")
    forge(done, "picture", name)
    (done.root / "results/picture.h5").unlink()
    assert done.run()["picture"] == ("computed" if forge is forge_manifest else "restored")
    assert victim.read_bytes() == b"mine" and done.results() == before
    assert FORGED not in (done.root / "results/log.jsonl").read_bytes()


def test_the_forged_key_of_a_record_reads_no_manifest_outside(done):
    folder = done.root / "elsewhere"
    folder.mkdir()
    (folder / "manifest.json").write_bytes((done.entry("fall") / "manifest.json").read_bytes())
    forge_record(done, "fall", "results/fall.h5", key="../../elsewhere")
    assert done.run()["fall"] == "current", "by what its artefact tells of itself"
    assert json.loads(done.record("fall").read_text())["key"] == done.entry("fall").name


@pytest.mark.parametrize("path", [
    "results/../x", "/results/x", "results/a/../../x", "C:results/x", "results\\..\\x", "results/.. /x",
    "results/.../x", "results/x.", "results/a\0b", "results/x:stream", "..", "results//x", "results/./x",
])  # fmt: skip
def test_paths_that_some_platform_reads_as_another_place_are_refused(path):
    assert not is_inside(path) and all(map(is_inside, ("results/fall.h5", "results/a b.svg", "stages/biped/.hidden")))


@unix
@pytest.mark.parametrize("name", [".cache", ".cache/current", ".cache/questions", "log", "sweeps", "drawn"])
def test_a_link_in_place_of_a_folder_is_refused(done, tmp_path, name):
    outside = tmp_path / "outside"
    outside.mkdir()
    place = done.root / "results" / name
    if place.exists():
        place.rename(outside / "moved")
    place.symlink_to(outside, target_is_directory=True)
    before = sorted(outside.rglob("*"))
    done.fails(force=True, said=f"{name}: is a link")
    assert sorted(outside.rglob("*")) == before


@unix
@pytest.mark.parametrize("there", [False, True])
def test_no_file_is_written_or_removed_through_a_link(done, tmp_path, there):
    done.run(f"picture.extra={there}".lower())
    outside = tmp_path / "outside"
    (done.root / "results/figures").rename(outside)
    (outside / "two.svg").write_bytes(b"mine")
    (done.root / "results/figures").symlink_to(outside, target_is_directory=True)
    done.fails(f"picture.extra={not there}".lower(), said=r"results/figures/two\.svg: a link leads out of")
    assert (outside / "two.svg").read_bytes() == b"mine"


@unix
@pytest.mark.parametrize("dangling", [False, True])
def test_an_entry_that_is_a_link_is_replaced_and_what_it_names_is_left(done, tmp_path, dangling):
    before, folder, outside = done.results(), done.entry("fall"), tmp_path / "outside"
    folder.rename(outside)
    (outside / "manifest.json").write_bytes(b"mine")
    folder.symlink_to(tmp_path / "nowhere" if dangling else outside, target_is_directory=True)
    assert done.run()["fall"] == "current", "by what its artefact tells of itself"
    assert (outside / "manifest.json").read_bytes() == b"mine" and not folder.is_symlink()
    assert done.results() == before and set(done.run().values()) == {"current"}
    assert not list((done.root / "results/.cache").glob("making-*"))


@unix
def test_a_link_in_place_of_a_result_is_replaced_and_what_it_names_is_left(done, victim):
    before, place = done.results(), done.root / "results/fall.h5"
    place.unlink()
    place.symlink_to(victim)
    assert done.run()["fall"] == "restored"
    assert victim.read_bytes() == b"mine" and done.results() == before


@unix
def test_a_lock_that_is_a_link_or_a_pipe_is_refused(done, victim):
    lock = done.root / "results/.cache/lock"
    for make in (lambda: lock.symlink_to(victim), lambda: os.mkfifo(lock)):
        lock.unlink(missing_ok=True)
        make()
        with (
            pytest.raises(StudyError, match="cannot be written"),
            disk.locked(done.root / "results", "results", "x", False, pytest.fail),
        ):
            pytest.fail("was taken")
        assert victim.read_bytes() == b"mine"


@unix
@pytest.mark.parametrize(("name", "said"), [("log.jsonl", "log.jsonl: is a link"), ("log/fall.log", "ZeroDivisionE")])
def test_logs_that_are_links_are_not_written_through(done, victim, name, said):
    path = done.root / "results" / name
    path.parent.mkdir(exist_ok=True)
    path.unlink(missing_ok=True)
    path.symlink_to(victim)
    done.fails("fall.behaviour=raise", said=said)
    assert victim.read_bytes() == b"mine"


@unix
def test_a_journal_that_is_a_link_is_not_written_through(done, victim, monkeypatch):
    study = done.study()
    parameters = study.parameters(["side"])["side"]
    question = study.module("side", "questions.tally").QUESTION
    asked = Asked(study, "side", question, parameters, 1)
    monkeypatch.setattr(asked, "_key", lambda *of: "key")
    path = study.store.folder / "questions/key.jsonl"
    path.parent.mkdir(exist_ok=True)
    path.symlink_to(victim)
    with pytest.raises(StudyError, match="cannot be written"):
        list(asked.each(int, ["1"]))
    assert victim.read_bytes() == b"mine"


@unix
@pytest.mark.parametrize("name", ["log.jsonl", ".cache/lock", "sweeps/.cache/key.jsonl"])
def test_a_second_name_of_a_file_is_left_as_it_is(done, victim, name):
    """A hard link made by who filled the folder: what is appended here must not be appended there."""
    path = done.root / "results" / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.unlink(missing_ok=True)
    path.hardlink_to(victim)
    with disk.opened_at_end(path) as file:
        assert file.seek(0) == 0 and file.read() == b"mine"
        file.write(b"more")
    assert victim.read_bytes() == b"mine" and path.read_bytes() == b"minemore"
    done.run(names=("side",), force=True)
    with disk.locked(done.root / "results", "results", "x", False, pytest.fail):
        pass
    assert victim.read_bytes() == b"mine"


@unix
def test_nothing_unfinished_is_removed_through_a_link(done, tmp_path):
    outside = tmp_path / "outside"
    outside.mkdir()
    (outside / ".x.part").write_bytes(b"mine")
    (done.root / "results/theirs").symlink_to(outside, target_is_directory=True)
    done.study().store.sweep()
    assert (outside / ".x.part").exists()


@unix
@pytest.mark.parametrize(("name", "make"), [
    ("results/fall.h5", os.mkfifo), ("results/.cache/current/fall.json", os.mkfifo), ("SYNTAX", os.mkfifo),
    ("results/.cache/KEY/manifest.json", os.mkfifo), ("results/.cache/KEY/manifest.json", os.mkdir),
    ("results/.cache/KEY/results/fall.h5", os.mkfifo),
])  # fmt: skip
def test_a_pipe_or_a_folder_in_place_of_a_file_stops_nothing(done, name, make):
    before = done.results()
    path = done.kept_syntax() if name == "SYNTAX" else done.root / name.replace("KEY", done.entry("fall").name)
    path.unlink()
    make(path)
    if name.endswith("KEY/results/fall.h5"):
        (done.root / "results/fall.h5").unlink()  # so that it is looked for
    done.survey()
    done.run()
    assert done.results() == before
