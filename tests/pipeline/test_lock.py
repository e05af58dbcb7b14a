"""One run at a time for each results folder."""

from __future__ import annotations

import errno
import os
import sys
import threading

import pytest

from pipeline.cache import disk
from pipeline.errors import StudyError


def hold(folder):
    return disk.locked(folder, str(folder), "bipedstudy run-all", False, pytest.fail)


def test_a_second_run_names_the_holder(tmp_path):
    with hold(tmp_path):
        with pytest.raises(StudyError) as caught, hold(tmp_path):
            pass
        (sentence,) = caught.value.sentences
        assert f"is in use by process {os.getpid()} (bipedstudy run-all, since 20" in sentence
        assert "wait for it with --wait" in sentence
        assert caught.value.exit_code == 2
    with hold(tmp_path):
        pass


def test_waiting_ends_with_the_holder(tmp_path):
    entered, waited_for = threading.Event(), threading.Event()
    told = []

    def first():
        with hold(tmp_path):
            entered.set()
            waited_for.wait(60)

    def waiting(sentence):
        told.append(sentence)
        waited_for.set()

    thread = threading.Thread(target=first)
    thread.start()
    entered.wait()
    with disk.locked(tmp_path, "results", "bipedstudy run-all", True, waiting):
        assert len(told) == 1 and told[0].endswith("; waiting")
    thread.join()


def test_a_lock_left_by_a_killed_process_is_harmless(tmp_path):
    path = tmp_path / ".cache/lock"
    path.parent.mkdir()
    path.write_text('{"pid": 1, "command": "bipedstudy run-all", "since": "2001-01-01 00:00:00"}')
    with hold(tmp_path):
        pass


@pytest.mark.parametrize("wait", [False, True])
@pytest.mark.parametrize("number", [errno.ENOLCK, errno.EBADF, errno.EINVAL, errno.EIO, errno.EOPNOTSUPP])
def test_a_system_that_gives_no_lock_says_why(tmp_path, monkeypatch, number, wait):
    """A disk of another machine may have none: that is not another run, and waiting for it has no end."""

    def refuse(file):
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(disk, "_try", refuse)
    with pytest.raises(StudyError) as caught, disk.locked(tmp_path, "results", "bipedstudy run", wait, pytest.fail):
        pass
    (sentence,) = caught.value.sentences
    assert sentence.startswith(f"results: the system gives no lock there ({os.strerror(number)}); ")


def test_a_results_folder_that_cannot_be_written_is_one_sentence(tmp_path):
    (tmp_path / "results").write_text("a file")
    sentence = r"results: cannot be written \(.*\); choose another folder with --results"
    with pytest.raises(StudyError, match=sentence), hold(tmp_path / "results"):
        pass


@pytest.mark.skipif(sys.platform != "linux", reason="limits the size of files")
def test_where_nothing_is_to_be_written_a_full_disk_is_no_failure(ran):
    assert ran.command("run-all")[0] == 0, "the report names the study's folder, which is a copy"
    full = "import resource; resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0)); "
    for command in ("status", "run fall", "run-all", "run-all --json", "clean --dry-run", "clean"):
        code, out, errors = ran.command(*command.split(), before=full)
        assert (code, errors) == (0, "") and out, command
    assert ran.command("run", "side", "--force", before=full)[0] == 1, "as no byte can be written there"
