"""Onsets of impacts and times by leg, against signals that are known exactly."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import butter, sosfilt

from stages.imu.strikes.impact_onset import STRIKE, Samples, at_onsets, lift_after, responses
from stages.imu.strikes.step_times import HeelStrikes, step_times
from tests.imu.stand_in import DRAWING

FINE = 1e-5
CORNER_HZ, RATE_HZ = 40.0, 100.0


def test_responses_are_those_of_the_low_pass() -> None:
    time = np.arange(0.0, 0.05, FINE)
    sections = butter(2, CORNER_HZ, fs=1 / FINE, output="sos")
    k = np.sqrt(2) * np.pi * CORNER_HZ
    blow, jump, bend = np.zeros(len(time)), np.ones(len(time)), k * time
    blow[0] = 1 / (k * FINE)
    expected = np.column_stack([sosfilt(sections, one) for one in (blow, jump, bend)])
    np.testing.assert_allclose(responses(time, CORNER_HZ), expected, atol=2e-3)


def sampled(strikes: np.ndarray, sizes: np.ndarray, seed: int, delay: float = 0.0) -> Samples:
    """A force that jumps and is struck at each strike, at a sensor's samples, with noise."""
    rng = np.random.default_rng(seed)
    time = np.arange(0.0, strikes[-1] + 0.5, 1 / RATE_HZ) + rng.uniform(0, 1 / RATE_HZ)
    since = time - strikes[:, None]
    shapes = sum((responses(one, CORNER_HZ) @ size) * (one < 0.2) for one, size in zip(since, sizes))
    return Samples(time - delay, (shapes + rng.normal(scale=0.05, size=len(time)))[:, None], RATE_HZ, delay)


@pytest.mark.parametrize("seeds", [8, pytest.param(20, marks=pytest.mark.slow)])
@pytest.mark.parametrize("delay", [0.0, 0.0056])
def test_strikes_move_to_where_the_impacts_begin(delay: float, seeds: int) -> None:
    """Whatever was found within some milliseconds, each leg off by its own: within a twentieth of a sample."""
    true = 0.3 + 0.4937 * np.arange(12)
    legs = np.arange(12) % 2
    sizes = np.where(legs[:, None] == 0, [8.0, 5.0, 1.0], [-6.0, 7.0, 0.0])
    off = []
    for seed in range(seeds):
        rng = np.random.default_rng(100 + seed)
        shift = rng.uniform(-0.006, 0.006, 2)
        found, corner = at_onsets(HeelStrikes(true + shift[legs], legs), sampled(true, sizes, seed, delay), 0)
        off.append([(found.time - true)[legs == leg].mean() for leg in (0, 1)])
    assert np.abs(off).max() < 5e-4
    assert corner == pytest.approx(CORNER_HZ, abs=10)


def test_strikes_without_impacts_stay() -> None:
    strikes = HeelStrikes(0.3 + 0.5 * np.arange(6), np.arange(6) % 2)
    moved, corner = at_onsets(strikes, Samples(np.empty(0), np.empty((0, 2)), RATE_HZ, 0.0), 0)
    np.testing.assert_array_equal(moved.time, strikes.time)
    assert np.isnan(corner) and len(STRIKE) == 3


def test_the_foot_is_let_go_where_its_force_bends() -> None:
    true = 0.3 + 0.987 * np.arange(6)
    lifts = [lift_after(true, sampled(true + 0.0066, np.array([[0.0, 3.0, 2.0]] * 6), seed), CORNER_HZ)
             for seed in range(20)]  # fmt: skip
    assert np.abs(np.array(lifts) - 0.0066).max() < 1e-3
    assert np.isnan(lift_after(true, sampled(true, np.zeros((6, 3)), 0), CORNER_HZ))


def test_step_times_by_leg() -> None:
    strikes = HeelStrikes(np.array([0.0, 0.4, 0.9, 1.3, 2.2, 2.7]), np.array([0, 1, 0, 1, 1, 0]))
    times = step_times(strikes, 0.01, DRAWING)
    assert (times.inner_step, times.outer_step, times.asymmetry) == pytest.approx((0.5, 0.4, 0.1 / 0.45))
    of_feet = (times.inner_stance, times.inner_swing, times.outer_stance, times.outer_swing)
    assert of_feet == pytest.approx((0.41, 0.49, 0.51, 0.39))
    assert times.outer_error > times.double_stance > times.inner_error
    unknown = step_times(strikes, float("nan"), DRAWING)
    assert np.isnan([unknown.inner_stance, unknown.inner_error, unknown.stance_asymmetry]).all()
    assert np.isfinite(unknown.step_error)
