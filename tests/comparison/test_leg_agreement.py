"""The measured leg beside a model's: runs made of a walk agree with that walk, and differ by what is added to them."""

from __future__ import annotations

import itertools
from types import SimpleNamespace

import numpy as np
import pytest

from stages.biped.walk import SENSOR_SIGNALS
from stages.comparison.measurement import compare_leg, of_walk
from stages.imu.strikes.step_times import INNER, OUTER
from tests.comparison.made_up import make_walk

POINTS, SKIPPED = 101, 0


def runs_of(walk, turned=0.0, longer=1.0):
    """One run as the ingest would give it of a walk, with its leg turned [rad] and its hip's way stretched."""
    strikes, legs = walk.heel_strike_time, walk.heel_strike_leg
    bounds = list(itertools.pairwise(strikes[legs == INNER]))
    phase = np.linspace(0, 1, POINTS)
    strides = np.zeros((len(bounds), POINTS, len(SENSOR_SIGNALS)))
    paths = np.zeros((len(bounds), 51, 2))
    for number, (begin, end) in enumerate(bounds):
        strides[number, :, 2] = np.interp(begin + (end - begin) * phase, walk.time, walk.leg_rate[:, INNER])
        at = np.linspace(begin, strikes[(strikes > begin) & (legs == OUTER)][0], 51)
        path = np.column_stack([np.interp(at, walk.time, axis) for axis in walk.hip_position.T])
        paths[number] = (path - [path[0, 0], 0.0]) * [longer, 1.0] + [0.0, 0.01]
    leg = SimpleNamespace(
        time=walk.time, angle=walk.leg_angle[:, INNER] + turned, hip_path=paths, step_length=paths[:, -1, 0],
        step_length_error=np.full(len(paths), 1e-3),
    )  # fmt: skip
    run = SimpleNamespace(heel_strike_time=strikes, heel_strike_leg=legs, strides=strides, leg=leg)
    ensemble = SimpleNamespace(phase=phase, mean=strides.mean(axis=0))
    return SimpleNamespace(runs=(run,), signals=SENSOR_SIGNALS, ensemble=ensemble)


def test_runs_made_of_a_walk_agree_with_it():
    walk = make_walk()
    found = compare_leg(runs_of(walk), walk, make_walk(period=0.55), SKIPPED)
    assert found.twin_angle == pytest.approx(0, abs=1e-4)  # samples of the walk between which lines are drawn
    assert found.runs.step_length == pytest.approx(found.twin.step_length, rel=1e-3)
    np.testing.assert_allclose(found.twin_path, 0, atol=1e-4)
    np.testing.assert_allclose(found.runs.rate, found.twin.rate, atol=1e-3)
    assert found.angles.shape == found.rates.shape
    assert found.simple.step_length > 1.05 * found.twin.step_length


def test_differences_are_those_that_were_made():
    walk = make_walk()
    found = compare_leg(runs_of(walk, turned=0.02, longer=1.1), walk, walk, SKIPPED)
    assert found.twin_angle == pytest.approx(0.02, abs=1e-4)
    assert found.runs.step_length == pytest.approx(1.1 * found.twin.step_length, rel=1e-3)
    assert found.twin_path[0] == pytest.approx(0.1 * found.twin.step_length / np.sqrt(3), rel=0.02)
    assert found.twin_path[1] < 1e-4, "a height that all runs have too much is no difference"


def test_runs_without_steps_have_no_leg_to_compare():
    walk = make_walk()
    imu = runs_of(walk)
    imu.runs[0].leg.hip_path = np.empty((0, 51, 2))
    assert compare_leg(imu, walk, walk, SKIPPED) is None
    with pytest.raises(ValueError, match="too short"):
        of_walk(make_walk(steps=2), POINTS, 51)
