from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from scipy.signal import butter, freqs

from stages.comparison.stride import Stride, last_stride, normalised_rms, through_low_pass
from tests.comparison.made_up import make_walk, resampled


def test_a_stride_runs_between_heel_strikes_of_the_inner_leg():
    walk = make_walk(period=0.5, steps=8)
    stride = last_stride(walk, 101)
    assert stride.period == pytest.approx(1.0)
    assert stride.hip_position[[0, -1], 0] == pytest.approx([0.0, 0.3], rel=1e-9)
    # the made-up signals are sines of the stride's phase, and these their means over a hundredth of it
    assert stride.signals[:, 0] == pytest.approx(np.sinc(0.01) * np.sin(2 * np.pi * stride.phase), abs=1e-5)


@pytest.mark.parametrize("place", [0.0, 0.13, 0.5, 0.77])
def test_a_spike_between_two_phases_keeps_its_impulse(place):
    """A triangle of 4 us by 50 between phases 10 ms apart, wherever it falls among them."""
    walk, points = make_walk(period=0.5), 101
    middle = walk.heel_strike_time[4] + 0.25 + 0.01 * place
    time = np.union1d(walk.time, middle + np.array([-4e-6, 0.0, 4e-6]))
    spike = np.interp(time, middle + np.array([-4e-6, 0.0, 4e-6]), [0.0, 50.0, 0.0])
    forces = np.column_stack([spike, np.zeros(len(time))])
    stride = last_stride(dataclasses.replace(resampled(walk, time), hip_specific_force=forces), points)
    assert stride.signals[:, 0].sum() * stride.period / (points - 1) == pytest.approx(50.0 * 4e-6, rel=1e-6)
    assert stride.peaks[0] == pytest.approx(50.0)


def test_strides_of_different_period_lie_on_each_other():
    slow, fast = last_stride(make_walk(period=0.6), 101), last_stride(make_walk(period=0.4), 101)
    assert slow.signals == pytest.approx(fast.signals, abs=1e-4)


def test_a_walk_without_a_stride_is_refused():
    walk = make_walk(steps=3)
    with pytest.raises(ValueError, match="too short"):
        last_stride(dataclasses.replace(walk, heel_strike_leg=np.array([1, 0, 1])), 101)


def test_rms_over_range_of_a_shifted_sine_is_known():
    phase = np.linspace(0, 2 * np.pi, 100_001)
    reference = np.column_stack([np.sin(phase), np.ones_like(phase)])
    assert normalised_rms(reference + 0.1, reference) == pytest.approx([0.05, np.nan], rel=1e-9, nan_ok=True)


@pytest.mark.parametrize("hz", [2.0, 10.0, 40.0])
def test_the_low_pass_is_that_of_the_sensor(hz):
    """A sine comes out with the Butterworth filter's gain, and slow ones where they were: the delay is taken out."""
    phase = np.linspace(0, 1, 4001)
    cycles = round(hz)
    wave = np.repeat(np.sin(2 * np.pi * cycles * phase)[:, None], 6, axis=1)
    shown = through_low_pass(Stride(phase, 1.0, wave, wave, wave, wave[0]), 40.0)
    _, response = freqs(*butter(2, 2 * np.pi * 40, analog=True), worN=[2 * np.pi * hz])
    gain, lag = np.abs(response[0]), np.angle(response[0]) + np.sqrt(2) * hz / 40
    np.testing.assert_allclose(shown[:, 0], gain * np.sin(2 * np.pi * cycles * phase + lag), atol=1e-9)
    assert lag == pytest.approx(0, abs=(hz / 40) ** 3)


def test_without_a_declared_low_pass_the_curves_stay():
    stride = last_stride(make_walk(), 101)
    assert through_low_pass(stride, float("nan")) is stride.signals
