"""A point that dies or hangs costs itself alone, and a process that dies by itself costs no point."""

import errno
import multiprocessing
import os

import pytest

from stages.extremes import watchdog
from stages.extremes.parameters import CRASHED, HUNG, RIGHT
from stages.extremes.watchdog import MOST_FALSE_STARTS, NoProcess, compute
from tests.extremes.hands import behave

START = "multiprocessing.context.SpawnProcess.start"


@pytest.mark.slow
def test_a_dead_and_a_hung_process_are_told_and_replaced():
    points = ["first", "die", "second", "hang", "third"]
    told = []
    found = compute(behave, 0.5, points, processes=2, longest_s=4.0, done=told.append)
    assert [finding.status for finding in found] == [RIGHT, CRASHED, RIGHT, HUNG, RIGHT]
    assert [finding.reason for finding in found[::2]] == points[::2], "findings stand in the order of the points"
    assert found[0].error == 0.5 and told[-1] == len(points)


def test_a_process_that_dies_between_two_points_costs_none():
    killed = []

    def kill(count):
        if count == 1 and not killed:
            killed.append(count)
            for process in multiprocessing.active_children():
                process.kill()
                process.join()

    found = compute(behave, 0.5, ["first", "second", "third"], processes=1, longest_s=60.0, done=kill)
    assert [finding.reason for finding in found] == ["first", "second", "third"]


def test_processes_that_die_at_once_are_not_started_for_every_point(monkeypatch):
    monkeypatch.setenv("FIRST", str(os.getpid()))
    from tests.extremes import stillborn

    started, start = [], multiprocessing.context.SpawnProcess.start
    monkeypatch.setattr(START, lambda process: (started.append(process), start(process)))
    with pytest.raises(NoProcess, match=rf"^{MOST_FALSE_STARTS} processes in a row ended before they could compute a"):
        compute(stillborn.behave, 0.5, [str(number) for number in range(50)], processes=1, longest_s=60.0)
    assert len(started) == MOST_FALSE_STARTS and not multiprocessing.active_children()


def test_a_process_that_cannot_be_started_is_tried_again(monkeypatch):
    """The system may have no room for one at the moment."""
    tried, start = [], multiprocessing.context.SpawnProcess.start

    def refuse(process):
        tried.append(process)
        if len(tried) == 1 or point == "never":
            raise OSError(errno.EAGAIN, os.strerror(errno.EAGAIN))
        start(process)

    monkeypatch.setattr(START, refuse)
    monkeypatch.setattr(watchdog, "POLL_S", 0.01)
    point = "once"
    assert [finding.status for finding in compute(behave, 0.5, [point], processes=1, longest_s=60.0)] == [RIGHT]
    point = "never"
    with pytest.raises(NoProcess):
        compute(behave, 0.5, [point], processes=1, longest_s=60.0)
