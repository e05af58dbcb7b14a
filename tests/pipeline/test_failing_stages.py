"""A stage that fails, crashes, meets a full disk or is edited while it runs leaves one sentence and valid results."""

import contextlib
import errno
import os
import signal
import sys
import time
from pathlib import Path

import pytest

from pipeline.cache import disk
from pipeline.errors import STOPPING, StudyError
from pipeline.execution import process
from pipeline.execution.executor import RESTORABLE
from tests.pipeline.processes import started, workers

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
        pytest.param("crash", "stage fall: its process was ended by the system (SIGSEGV)", marks=unix),
    ],
)
def test_a_failing_stage_is_one_sentence_and_leaves_the_rest_valid(done, capsys, behaviour, sentence):
    before = done.results()
    done.edit("params/side.yaml", "seed: 3", "seed: 4")
    failure = done.fails(f"fall.behaviour={behaviour}")
    (said,) = failure.sentences
    assert sentence in said and "\n" not in said
    assert failure.exit_code == (3 if behaviour == "answer" else 1)
    assert "not computed, as they stand on what failed: bounce, picture" in capsys.readouterr().err
    assert behaviour != "raise" or "ZeroDivisionError" in (done.root / "results/log/fall.log").read_text()
    after = done.results()
    assert {name for name in after if before[name] != after[name]} == {"side.h5", "side.bin"}
    gone = {"fall.h5", "bounce.h5", "picture.h5", "figures/one.svg", "claims.yaml"} if behaviour == "answer" else set()
    assert before.keys() - after.keys() == gone
    back = "restored" if gone else "current"
    assert done.run() == {"fall": back, "bounce": back, "side": "current", "picture": "computed"}


def before_a_worker(monkeypatch, stage, edit, *arguments):
    """Do something when the worker of a stage is about to start."""
    original = process.Worker.__init__

    def edit_first(self, job, *others):
        if job.stages[-1].name == stage:
            edit(*arguments)
        original(self, job, *others)

    monkeypatch.setattr(process.Worker, "__init__", edit_first)


def test_code_edited_while_it_runs_is_never_stored(done, monkeypatch):
    """The key is made from one text, the worker meets another."""
    before_a_worker(monkeypatch, "fall", done.edit, "PACKAGE/body/motion.py", "0.5 * gravity", "0.6 * gravity")
    done.fails("fall.height=3", said=r"body/motion.py was edited while it ran, so its result was not kept")
    monkeypatch.undo()
    done.edit("PACKAGE/body/motion.py", "0.6 * gravity", "0.5 * gravity")
    assert done.run("fall.height=3")["fall"] == "computed"


def test_an_input_edited_while_the_run_goes_on_is_not_used(done, monkeypatch):
    before_a_worker(monkeypatch, "bounce", (done.root / "results/fall.h5").write_bytes, b"someone else")
    done.fails("ground.contact_stiffness=7", said=r"its input results/fall.h5 was changed by someone else meanwhile")


def test_files_half_replaced_are_not_called_current(done, monkeypatch):
    """The disk is full when the last file of four is put in place: a figure lies there that no record knows yet."""
    before, last, write = done.results(), done.root / "results/picture.h5", disk.write

    def refuse(path, content):
        if path == last:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path))
        write(path, content)

    monkeypatch.setattr(disk, "write", refuse)
    done.fails("picture.extra=true", said=r"stage picture: its result could not be stored: No space left")
    monkeypatch.undo()
    assert done.results().keys() - before.keys() == {"figures/two.svg"} and last.read_bytes() == before["picture.h5"]
    assert done.survey()["picture"].state == RESTORABLE
    assert done.run()["picture"] == "restored"
    assert done.results() == before


@pytest.mark.skipif(sys.platform != "linux", reason="limits the size of files")
def test_a_full_disk_in_the_worker_is_one_sentence(done):
    import resource

    before = done.results()
    old = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, old[1]))
    try:
        said = r"stage fall: it did not finish: \S+/results/fall\.h5: File too large"
        done.fails("fall.steps=5000", names=("fall",), said=said)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, old)
    assert done.results() == before
    assert done.run("fall.steps=5000", names=("fall",)) == {"fall": "computed"}


def test_a_file_cut_off_while_it_is_written_leaves_the_old_one(tmp_path, monkeypatch):
    path = tmp_path / "x"
    disk.write(path, b"old")

    def fails(handle):
        raise OSError(errno.EIO, "input/output error")

    monkeypatch.setattr(os, "fsync", fails)
    with pytest.raises(OSError, match="input/output") as said:
        disk.write(path, b"new")
    assert said.value.filename == str(path)
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is full")
@pytest.mark.parametrize(("opened", "named"), [("/dev/full", ""), ("PART/inner/one.txt", "/inner/one.txt")])
def test_an_error_of_what_is_being_written_names_the_place_that_was_meant(tmp_path, opened, named):
    place = tmp_path / "results.zip"
    with pytest.raises(OSError) as met, disk.whole(place) as unfinished, \
            open(opened.replace("PART", str(unfinished)), "wb", buffering=0) as file:  # fmt: skip
        file.write(b"text")
    assert met.value.filename == f"{place}{named}" and list(tmp_path.iterdir()) == []


# --- Runs killed or interrupted at any moment leave valid results and no process behind.


proc = pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="needs /proc to find the workers")


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere a stopped process cannot notice")
def test_a_stopped_worker_ends_with_the_run_that_started_it(toy_with_commands):
    toy = toy_with_commands
    process = toy.start("run", "fall", "--set", "fall.behaviour=sleep")
    logs = "results/.cache/making-*/stage.log"
    assert wait_for(lambda: [path for path in toy.root.glob(logs) if path.stat().st_size])  # it sleeps
    (worker,) = wait_for(lambda: workers(process.pid))  # by now the one that it is going to be
    os.kill(worker, signal.SIGSTOP)
    process.kill()
    process.communicate()
    try:
        assert wait_for(lambda: not alive(worker), 10.0)
    finally:
        with contextlib.suppress(OSError):
            os.kill(worker, signal.SIGKILL)


@unix
@proc
@pytest.mark.parametrize("number", [*STOPPING, signal.SIGKILL])
def test_a_run_that_is_ended_keeps_what_it_has_and_its_workers_end_with_it(ran, number):
    toy, before = ran, ran.results()
    process = toy.start("run-all", "--set", "fall.behaviour=sleep")
    there = wait_for(lambda: workers(process.pid) and started(process.pid))
    process.send_signal(number)
    _, errors = process.communicate(timeout=50)
    said, killed = " ".join(errors.split()), number == signal.SIGKILL
    assert process.returncode == (-number if killed else 128 + number)
    assert said.startswith("note: results of fall.behaviour = well give way to those of sleep; they are kept"), said
    assert killed or said.endswith("error: stopped; everything computed before is kept"), said
    assert said.count("error") == (not killed) and toy.results() == before
    assert wait_for(lambda: not any(alive(pid) for pid in there))


def alive(pid):
    try:
        with open(f"/proc/{pid}/stat") as file:
            return file.read().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False


def wait_for(condition, seconds=45.0):
    """What `condition` gives once it is true; None after less time than a sleeping stage takes to end by itself."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        found = condition()
        if found:
            return found
        time.sleep(0.02)
    return None


@pytest.mark.parametrize("wait", [False, True])
@pytest.mark.parametrize("number", [errno.ENOLCK, errno.EBADF, errno.EINVAL, errno.EIO, errno.EOPNOTSUPP])
def test_a_system_that_gives_no_lock_says_why(tmp_path, monkeypatch, number, wait):
    """A disk of another machine may have none: that is not another run, and waiting for it has no end."""

    def refuse(file):
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(disk, "_try", refuse)
    said = rf"^results: the system gives no lock there \({os.strerror(number)}\); "
    with pytest.raises(StudyError, match=said), disk.locked(tmp_path, "results", "run", wait, pytest.fail):
        pass


@pytest.mark.skipif(sys.platform != "linux", reason="limits the size of files")
def test_where_nothing_is_to_be_written_a_full_disk_is_no_failure(ran):
    ran.says("run-all")  # the report names the study's folder, which is a copy
    full = "import resource; resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0)); "
    for command in ("status", "run-all", "clean"):
        code, out, errors = ran.command(*command.split(), before=full)
        assert (code, errors) == (0, "") and out, command
    ran.says("run side --force", code=1, before=full)  # as no byte can be written there
