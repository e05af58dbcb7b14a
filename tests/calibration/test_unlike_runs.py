"""Runs that a twin does not fit: what it never explains is no push, and what is unlike its own runs is said."""

import contextlib
import itertools
import math
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from stages.analytic.errors import StepFailed
from stages.calibration.following import report
from stages.calibration.following.fitted import unexplained
from stages.calibration.following.robot_file import FittedRobot
from stages.calibration.following.track import Track, follow
from stages.calibration.observation.measured_run import SIDES
from tests.calibration.runs import PARAMETERS
from tests.calibration.test_following import follower, made, model


def landed_twice(run, noise, size=40.0):
    """A run whose readings are so many standard deviations off a while after each heel strike, as where a pair's second
    foot lands, and these readings by side, (times, off in standard deviations)."""
    samples, off = {}, {}
    for side in SIDES:
        times = run.sampling.of(side)
        since = times - run.strikes[np.searchsorted(run.strikes, times, "right") - 1]
        off[side] = np.repeat(np.where((since > 0.04) & (since < 0.08), size, 0.0)[:, None], 3, axis=1)
        samples[side] = run.samples[side] + off[side] * noise
    return replace(run, samples=samples), [(run.sampling.of(side), off[side]) for side in SIDES]


def test_what_a_robots_own_runs_have_in_each_step_is_no_push(monkeypatch):
    run, _, _ = made(1, 4)
    struck, off = landed_twice(run, model()[1].noise)
    usual, pushes = replace(follower(), unexplained=unexplained(off)), []
    taken = Track._push
    monkeypatch.setattr(Track, "_push", lambda self, time: pushes.append(time) or taken(self, time))
    assert usual.unexplained == pytest.approx(1600.0)
    list(follow(usual, struck))
    assert not pushes
    with contextlib.suppress(StepFailed):
        list(follow(follower(), struck))
    assert pushes
    pushes.clear()
    with contextlib.suppress(StepFailed):
        list(follow(usual, landed_twice(run, model()[1].noise, 200.0)[0]))
    assert pushes


def test_unexplained_is_what_samples_in_a_row_of_both_sides_have():
    times = np.arange(10.0)
    hip, foot = np.zeros((10, 3)), np.zeros((10, 3))
    hip[4:6], foot[4:6] = [3.0, np.nan, 3.0], 2.0
    assert unexplained([(times, hip), (times + 0.1, foot)]) == 4.0
    assert unexplained([(times, hip), (times + 0.1, 0.0 * foot)]) == 0.0
    assert unexplained([(times[:2], hip[:2]), (times[:1], foot[:1])]) == 0.0


@pytest.mark.parametrize(("noise", "since", "fits"), [(0.0, 0.0, True), (3.0, 0.0, False), (3.0, 0.8, False)],
                         ids=["as it is", "another", "changed at last"])  # fmt: skip
def test_a_run_that_the_twin_does_not_fit_is_said_to_be_so(noise, since, fits, monkeypatch):
    """Its readings scatter more than those of the robot's own runs, or at last."""
    run, _, _ = made(1, 6)
    robot, fitted = model()
    rng = np.random.default_rng(3)
    more = {side: noise * (run.sampling.of(side) > since * run.duration) for side in SIDES}
    samples = {side: run.samples[side] + more[side][:, None] * fitted.noise * rng.normal(size=run.samples[side].shape)
               for side in SIDES}  # fmt: skip
    monkeypatch.setattr(FittedRobot, "read", lambda _: robot)
    monkeypatch.setattr(report, "named_runs", lambda *_: ({"a": replace(run, samples=samples)}, []))
    asking = SimpleNamespace(progress=lambda *_: None)
    found = report.followed(PARAMETERS, Path("lab.sqlite"), Path("robot"), (), asking)
    assert found.no is not fits and found.plain["unlike"] == ([] if fits else ["a"])
    assert [line.startswith("a: the twin does not fit: readings are typically") for line in found.lines] == [True] * (
        not fits)
    limp = replace(robot, innovation=3.0)  # so large are those of its own runs
    monkeypatch.setattr(FittedRobot, "read", lambda _: limp)
    assert not report.followed(PARAMETERS, Path("lab.sqlite"), Path("robot"), (), asking).no


def test_a_run_that_the_twin_loses_is_said_to_be_lost_and_a_no(monkeypatch):
    """As of a stream; of a database the command ended with 0."""
    def lost(by, run):
        yield from itertools.islice(follow(by, run), 60)
        raise StepFailed("the robot fell")

    monkeypatch.setattr(FittedRobot, "read", lambda _: model()[0])
    monkeypatch.setattr(report, "named_runs", lambda *_: ({"a": made(1, 6)[0]}, []))
    monkeypatch.setattr(report, "follow", lost)
    found = report.followed(PARAMETERS, Path("lab.sqlite"), Path("robot"), (),
                            SimpleNamespace(progress=lambda *_: None))  # fmt: skip
    assert found.no and found.plain["unlike"] == ["a"] and found.lines[0].startswith("a: lost after ")


def test_readings_after_a_push_count_among_innovations():
    run, _, _ = made(1, 6)
    struck, _ = landed_twice(run, model()[1].noise)
    found = []
    with contextlib.suppress(StepFailed):
        found.extend(follow(follower(), struck))
    known = np.mean([math.isfinite(one.innovation) for one in found])
    assert len(found) > 50 and known > 0.7


@pytest.mark.parametrize("far", [1.0, 9.0])
def test_a_stream_that_the_twin_does_not_fit_is_said_to_be_so_while_it_comes(far, monkeypatch):
    """And at its end, which a program reads."""
    run, _, _ = made(1, 5)
    instants = [replace(one, innovation=far) for one in follow(follower(), run)][:130]
    robot, _ = model()
    monkeypatch.setattr(FittedRobot, "read", lambda _: robot)
    monkeypatch.setattr(report, "rows_of", lambda *_: iter(()))
    monkeypatch.setattr(report.Stream, "follow", lambda *_: iter(instants))
    said, notes = [], []
    asking = SimpleNamespace(say=said.append, note=notes.append, lines=lambda: ())
    found = report.streamed(PARAMETERS, Path("robot"), {}, asking)
    strange = "the twin does not fit: readings are typically 3.4 standard deviations from it"
    assert len(said) == 1 + len(instants) == 131 and found.no is (far > 1.0)
    assert [note.startswith(f"note: at {instants[99].time:.2f} s {strange}") for note in notes] == [True] * (far > 1.0)
    assert (strange in found.remark) is (far > 1.0) and found.remark.endswith("130 states were written")
