"""A stage that fails, crashes, meets a full disk or is edited while it runs leaves one sentence and valid results."""

from __future__ import annotations

import errno
import os
import sys

import pytest

from pipeline.cache import disk
from pipeline.errors import StageFailed
from pipeline.execution.executor import Planner, State

unix = pytest.mark.skipif(os.name != "posix", reason="uses POSIX signals")


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
    assert {name for name in after if before[name] != after[name]} == {"side.h5", "side.bin"}
    gone = {"fall.h5", "bounce.h5", "picture.h5", "figures/one.svg", "claims.yaml"} if behaviour == "answer" else set()
    assert before.keys() - after.keys() == gone
    back = "restored" if gone else "current"
    assert done.run() == {"fall": back, "bounce": back, "side": "current", "picture": "computed"}


def test_what_stands_on_a_failed_stage_is_named(done, capsys):
    with pytest.raises(StageFailed):
        done.run("fall.behaviour=answer")
    assert "not computed, as they stand on what failed: bounce, picture" in capsys.readouterr().err


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
    from pipeline.execution import process

    original = process.Worker.__init__

    def edit_first(self, job, *arguments):
        if job.stages[-1].name == "fall":
            done.edit("PACKAGE/body/motion.py", "0.5 * gravity", "0.6 * gravity")
        original(self, job, *arguments)

    monkeypatch.setattr(process.Worker, "__init__", edit_first)
    with pytest.raises(StageFailed, match=r"body/motion.py was edited while it ran, so its result was not kept"):
        done.run("fall.height=3")
    monkeypatch.undo()
    done.edit("PACKAGE/body/motion.py", "0.6 * gravity", "0.5 * gravity")
    assert done.run("fall.height=3")["fall"] == "computed"


def test_an_input_edited_while_the_run_goes_on_is_not_used(done, monkeypatch):
    from pipeline.execution import process

    original = process.Worker.__init__

    def edit_first(self, job, *arguments):
        if job.stages[-1].name == "bounce":
            (done.root / "results/fall.h5").write_bytes(b"someone else")
        original(self, job, *arguments)

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


def test_a_full_disk_in_the_pipeline_is_one_sentence(done, monkeypatch):
    before = done.results()

    def full(path, content):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path))

    with monkeypatch.context() as patch:
        patch.setattr(disk, "write", full)
        with pytest.raises(StageFailed, match=r"stage fall: its result could not be stored: No space left on device"):
            done.run("fall.height=3", names=("fall",))
        assert done.results() == before
    assert done.run("fall.height=3", names=("fall",)) == {"fall": "computed"}


def test_files_half_replaced_are_not_called_current(done, monkeypatch):
    """The disk is full when the last file of four is put in place: a figure lies there that no record knows yet."""
    before, last, write = done.results(), done.root / "results/picture.h5", disk.write

    def full(path, content):
        if path == last:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path))
        write(path, content)

    with monkeypatch.context() as patch:
        patch.setattr(disk, "write", full)
        with pytest.raises(StageFailed, match=r"stage picture: its result could not be stored: No space left"):
            done.run("picture.extra=true")
    assert done.results().keys() - before.keys() == {"figures/two.svg"} and last.read_bytes() == before["picture.h5"]
    study = done.study()
    survey = Planner(study, study.parameters(tuple(study.graph.stages))).survey(study.graph.stages)
    assert survey[-1].state is State.RESTORABLE
    assert done.run()["picture"] == "restored"
    assert done.results() == before


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


@pytest.mark.skipif(os.name != "posix", reason="flushes folders")
def test_a_file_and_then_its_folder_are_flushed_to_the_disk(tmp_path, monkeypatch):
    flushed, fsync = [], os.fsync

    def told(handle):
        fsync(handle)
        flushed.append(os.fstat(handle).st_ino)

    monkeypatch.setattr(os, "fsync", told)
    disk.write(tmp_path / "one", b"content")
    assert flushed == [(tmp_path / "one").stat().st_ino, tmp_path.stat().st_ino]


def test_a_file_cut_off_while_it_is_written_leaves_the_old_one(tmp_path, monkeypatch):
    path = tmp_path / "x"
    disk.write(path, b"old")

    def fails(handle):
        raise OSError(errno.EIO, "input/output error")

    monkeypatch.setattr(os, "fsync", fails)
    with pytest.raises(OSError, match="input/output"):
        disk.write(path, b"new")
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]
