"""Whatever goes wrong, no wrong result is taken for current and no valid one is lost."""

from __future__ import annotations

import errno
import json
import os
import random
import signal
import sys
import time
from pathlib import Path

import pytest

from pipeline import durable
from pipeline.errors import ArtefactError, StageFailed
from pipeline.planning import Planner

unix = pytest.mark.skipif(os.name != "posix", reason="uses POSIX signals")


def reasons(toy):
    study = toy.study()
    names = tuple(study.graph.stages)
    return {item.name: item.reasons for item in Planner(study, study.parameters(names)).survey(names)}


def entry_folder(toy, stage):
    record = json.loads((toy.root / f"results/.cache/current/{stage}.json").read_text())
    return toy.root / "results/.cache" / record["key"]


@pytest.mark.parametrize("damage", [lambda content: content[:-100], lambda content: b"", lambda content: content + b"x",
                                    lambda content: content.replace(b"Result", b"result") + b"\0"])  # fmt: skip
def test_a_damaged_artefact_is_seen_and_put_right(done, damage):
    before = done.results()
    path = done.root / "results/fall.h5"
    path.write_bytes(damage(path.read_bytes()))
    assert reasons(done)["fall"] == ("results/fall.h5 was edited or damaged",)
    assert done.run()["fall"] == "restored"
    assert done.results() == before


def test_one_flipped_bit_of_the_same_length_is_seen(done):
    path = done.root / "results/bounce.h5"
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)
    assert done.run()["bounce"] == "restored"


def test_a_damaged_store_is_computed_again_when_it_is_needed(done):
    before = done.results()
    stored = entry_folder(done, "fall") / "results/fall.h5"
    stored.write_bytes(stored.read_bytes()[:-10])
    assert set(done.run().values()) == {"current"}  # the good copy in the results folder is untouched
    (done.root / "results/fall.h5").unlink()
    assert done.run()["fall"] == "computed"
    assert done.results() == before


@pytest.mark.parametrize("text", ["", "{", "[]", '{"seal": "x", "entry": {}}'])
def test_a_damaged_manifest_is_not_believed(done, text):
    before = done.results()
    (entry_folder(done, "fall") / "manifest.json").write_text(text)
    assert done.run()["fall"] == "computed"
    assert done.results() == before


def test_a_manifest_that_vouches_for_other_bytes_is_not_believed(done):
    path = entry_folder(done, "fall") / "manifest.json"
    manifest = json.loads(path.read_text())
    forged = b"not what the stage made"
    manifest["entry"]["outs"]["results/fall.h5"].update(sha256=durable.digest(forged), size=len(forged))
    path.write_text(json.dumps(manifest))
    (done.root / "results/fall.h5").write_bytes(forged)
    assert done.run()["fall"] == "computed"


@pytest.mark.parametrize(
    "text", ["", "{", "[]", '{"key": "../../x", "complete": true}', '{"key": 3, "complete": true}']
)
def test_a_damaged_record_costs_nothing_but_a_copy(done, text):
    before = done.results()
    (done.root / "results/.cache/current/fall.json").write_text(text)
    (done.root / "results/.cache/syntax.json").write_text(text)
    assert done.run()["fall"] == "restored"
    assert done.results() == before


def test_a_record_cannot_make_the_pipeline_delete_other_files(done):
    record = done.root / "results/.cache/current/fall.json"
    stored = json.loads(record.read_text())
    stored["files"] += ["results/../dvc.yaml", "params/fall.yaml"]
    record.write_text(json.dumps({**stored, "complete": False}))
    assert done.run()["fall"] == "restored"
    assert (done.root / "dvc.yaml").exists() and (done.root / "params/fall.yaml").exists()


@pytest.mark.parametrize(
    ("behaviour", "sentence"),
    [
        ("raise", "stage fall: ZeroDivisionError: a pendulum without length; the full account is in "),
        ("exit", "stage fall: SystemExit: enough; the full account is in "),
        ("extra", "stage fall: it returned the file results/secret.txt, which dvc.yaml does not list among its outs"),
        ("hidden", "in a way that cannot be seen in the text; import it by name"),
        ("disk", "stage fall: it did not finish: No space left on device; earlier results are unchanged"),
        ("answer", "stage fall: nothing falls upwards"),
    ],
)
def test_a_failing_stage_is_one_sentence_and_leaves_the_rest_valid(done, behaviour, sentence):
    before = done.results()
    done.edit("params/side.yaml", "seed: 3", "seed: 4")
    with pytest.raises(StageFailed) as failure:
        done.run(f"fall.behaviour={behaviour}")
    assert len(failure.value.sentences) == 1 and sentence in failure.value.sentences[0]
    assert "\n" not in failure.value.sentences[0]
    assert failure.value.exit_code == (3 if behaviour == "answer" else 1)
    after = done.results()
    assert {name for name in before if before[name] != after[name]} == {"side.h5", "side.bin"}
    assert done.run() == {"fall": "current", "bounce": "current", "side": "current", "picture": "computed"}


def test_the_full_account_holds_the_traceback(done):
    with pytest.raises(StageFailed):
        done.run("fall.behaviour=raise")
    assert "ZeroDivisionError" in (done.root / "results/log/fall.log").read_text()


@unix
def test_a_crash_in_native_code_is_one_sentence(done):
    before = done.results()
    with pytest.raises(StageFailed, match=r"stage fall: its process was ended by the system \(SIGSEGV\)"):
        done.run("fall.behaviour=crash")
    assert done.results() == before


def test_a_stage_that_lacks_an_out_is_refused(done):
    done.edit("PACKAGE/picture/run.py", '"claims.yaml": (CLAIM', '"figures/claims.yaml": (CLAIM')
    with pytest.raises(StageFailed, match=r"it did not return results/claims.yaml"):
        done.run()


def test_code_edited_while_it_runs_is_never_stored(done, monkeypatch):
    """The key is made from one text, the worker meets another."""
    from pipeline import process

    original = process.Worker.__init__

    def edit_first(self, order, *arguments):
        if order.stage == "fall":
            done.edit("PACKAGE/body/motion.py", "0.5 * gravity", "0.6 * gravity")
        original(self, order, *arguments)

    monkeypatch.setattr(process.Worker, "__init__", edit_first)
    with pytest.raises(StageFailed, match=r"body/motion.py was edited while it ran, so its result was not kept"):
        done.run("fall.height=3")
    monkeypatch.undo()
    done.edit("PACKAGE/body/motion.py", "0.6 * gravity", "0.5 * gravity")
    assert done.run("fall.height=3")["fall"] == "computed"


def test_an_input_edited_while_the_run_goes_on_is_not_used(done, monkeypatch):
    from pipeline import process

    original = process.Worker.__init__

    def edit_first(self, order, *arguments):
        if order.stage == "bounce":
            (done.root / "results/fall.h5").write_bytes(b"someone else")
        original(self, order, *arguments)

    monkeypatch.setattr(process.Worker, "__init__", edit_first)
    with pytest.raises(StageFailed, match=r"its input results/fall.h5 was changed by someone else meanwhile"):
        done.run("ground.contact_stiffness=7")


def test_the_compiled_file_of_an_older_source_is_not_used(done):
    """An edit of the same length within the same second fools the interpreter's own check."""
    path = done.path("PACKAGE/body/motion.py")
    before = path.stat()
    done.edit("PACKAGE/body/motion.py", "0.5 * gravity", "0.7 * gravity")
    os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))
    outcome = next(outcome for outcome in done.outcomes() if outcome.stage == "fall")
    assert outcome.summary == f"fell {0.7 * 9.81:.2f} m"


def test_the_clock_set_back_changes_nothing(done):
    for path in [*(done.root / "results").rglob("*"), *done.path("PACKAGE").rglob("*.py")]:
        os.utime(path, (0, 0))
    assert set(done.run().values()) == {"current"}
    done.edit("PACKAGE/body/motion.py", "0.5 * gravity", "0.8 * gravity")
    os.utime(done.path("PACKAGE/body/motion.py"), (0, 0))
    assert done.run()["fall"] == "computed"


def test_a_full_disk_in_the_pipeline_is_one_sentence(done, monkeypatch):
    before = done.results()

    def full(path, content):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path))

    with monkeypatch.context() as patch:
        patch.setattr(durable, "write", full)
        with pytest.raises(StageFailed, match=r"stage fall: its result could not be stored: No space left on device"):
            done.run("fall.height=3", names=("fall",))
        assert done.results() == before
    assert done.run("fall.height=3", names=("fall",)) == {"fall": "computed"}


@pytest.mark.skipif(sys.platform != "linux", reason="limits the size of files")
def test_a_full_disk_in_the_worker_is_one_sentence(done):
    import resource

    before = done.results()
    old = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, old[1]))
    try:
        with pytest.raises(StageFailed, match=r"stage fall: it did not finish: File too large"):
            done.run("fall.steps=5000", names=("fall",))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, old)
    assert done.results() == before
    assert done.run("fall.steps=5000", names=("fall",)) == {"fall": "computed"}


def test_a_file_cut_off_while_it_is_written_leaves_the_old_one(tmp_path, monkeypatch):
    path = tmp_path / "x"
    durable.write(path, b"old")

    def fails(handle):
        raise OSError(errno.EIO, "input/output error")

    monkeypatch.setattr(os, "fsync", fails)
    with pytest.raises(OSError, match="input/output"):
        durable.write(path, b"new")
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]


def test_reading_a_foreign_or_truncated_file_is_one_sentence(done, tmp_path):
    from pipeline import artefact

    content = (done.root / "results/fall.h5").read_bytes()
    for damaged in (b"", b"hello", content[:2000], content[:-1]):
        with pytest.raises(ArtefactError, match=r"x\.h5: (is empty|is truncated or not an HDF5 file)"):
            artefact.tree(damaged, "x.h5")


def kill_at_a_random_moment(toy, seconds):
    process = toy.start("run-all", "--force", "--wait")
    time.sleep(seconds)
    process.kill()
    process.communicate()


def survives(toy, chance, count):
    """Kill `count` runs; after each, every file is valid and the next run is right."""
    code, _, errors = toy.command("run-all")
    assert code == 0, errors
    right = toy.results()
    for _ in range(count):
        kill_at_a_random_moment(toy, chance.uniform(0.05, 1.6))
        for name, content in toy.results().items():
            assert content == right[name] or name.endswith(".part")
    code, _, errors = toy.command("run-all", "--wait")
    assert code == 0, errors
    assert toy.results() == right
    assert not list((toy.root / "results/.cache").glob("making-*"))


@unix
def test_killed_runs_leave_valid_results(toy_with_commands):
    survives(toy_with_commands, random.Random(1), 4)


@unix
@pytest.mark.slow
def test_two_hundred_killed_runs_leave_valid_results(toy_with_commands):
    survives(toy_with_commands, random.Random(2), 200)


@unix
def test_a_worker_ends_with_the_run_that_started_it(toy_with_commands):
    toy = toy_with_commands
    process = toy.start("run", "fall", "--set", "fall.behaviour=sleep")
    workers = wait_for(lambda: children(process.pid))
    process.kill()
    process.communicate()
    assert wait_for(lambda: not any(alive(pid) for pid in workers))


@unix
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_run_keeps_what_it_has(toy_with_commands, number):
    toy = toy_with_commands
    assert toy.command("run-all")[0] == 0
    before = toy.results()
    process = toy.start("run-all", "--set", "fall.behaviour=sleep")
    workers = wait_for(lambda: children(process.pid))
    process.send_signal(number)
    _, errors = process.communicate(timeout=20)
    assert process.returncode == 130
    assert errors.strip() == "error: stopped; everything computed before is kept"
    assert toy.results() == before
    assert wait_for(lambda: not any(alive(pid) for pid in workers))


def children(pid):
    task = Path(f"/proc/{pid}/task/{pid}/children")
    if not task.exists():
        pytest.skip("needs /proc to find a process's children")
    return [int(word) for word in task.read_text().split()]


def alive(pid):
    try:
        with open(f"/proc/{pid}/stat") as file:
            return file.read().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False


def wait_for(condition, seconds=15.0):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        found = condition()
        if found:
            return found
        time.sleep(0.02)
    return None
