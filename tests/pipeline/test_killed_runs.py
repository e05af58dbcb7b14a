"""Runs killed or interrupted at any moment leave valid results and no process behind."""

from __future__ import annotations

import contextlib
import os
import random
import signal
import sys
import time
from pathlib import Path

import pytest

from tests.pipeline.processes import started, workers

unix = pytest.mark.skipif(os.name != "posix", reason="uses POSIX signals")
proc = pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="needs /proc to find the workers")


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
@proc
def test_a_worker_ends_with_the_run_that_started_it(toy_with_commands):
    toy = toy_with_commands
    process = toy.start("run", "fall", "--set", "fall.behaviour=sleep")
    there = wait_for(lambda: workers(process.pid) and started(process.pid))
    process.kill()
    process.communicate()
    assert wait_for(lambda: not any(alive(pid) for pid in there))


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
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_run_keeps_what_it_has(ran, number):
    toy = ran
    before = toy.results()
    process = toy.start("run-all", "--set", "fall.behaviour=sleep")
    there = wait_for(lambda: workers(process.pid) and started(process.pid))
    process.send_signal(number)
    _, errors = process.communicate(timeout=50)
    assert process.returncode == 128 + number
    said = " ".join(errors.split())
    assert said.startswith("note: results of fall.behaviour = well give way to those of sleep; they are kept"), said
    assert said.endswith("error: stopped; everything computed before is kept") and said.count("error") == 1, said
    assert toy.results() == before
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
