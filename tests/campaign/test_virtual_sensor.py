"""The synthetic sensor and radio: each part does what it is said to do, and nothing else."""

import dataclasses

import numpy as np
import pytest

from stages.campaign.parameters import RadioSettings, SensorSettings
from stages.campaign.virtual_sensor import (
    STANDARD_GRAVITY,
    Readings,
    SensorMotion,
    draw_errors,
    low_pass,
    read,
    transmit,
)
from stages.imu.sources.schema import Device
from stages.imu.trial.body import mounting

PERFECT = SensorSettings(100.0, 0.0, 40.0, 4.0, 2000.0, 16, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
RADIO = RadioSettings(3, 65536, 0.0, 0.008, 0.015, 0.1, 0.2, 0.05, 0.25)
DEVICE = Device("hip", 100.0, "counts", "counts", forward_axis="+y", up_axis="-x")
GRID = 1 / 5000
COUNT_A, COUNT_W = 4 * STANDARD_GRAVITY / 2**15, np.deg2rad(2000) / 2**15


def motion(force: np.ndarray, rate: np.ndarray | None = None) -> SensorMotion:
    return SensorMotion(np.arange(len(force)) * GRID, force, np.zeros_like(force) if rate is None else rate)


def sensed(force: np.ndarray, rate: np.ndarray | None = None, seed: int = 0, **errors: float) -> Readings:
    """What a sensor, perfect but for these errors, reads of a motion."""
    settings, rng = dataclasses.replace(PERFECT, **errors), np.random.default_rng(seed)
    return read(motion(force, rate), draw_errors(settings, DEVICE, rng), settings, rng)


def test_low_pass_halves_the_power_at_its_cut_off() -> None:
    time = np.arange(0, 2, GRID)
    for frequency, gain in ((1.0, 1.0), (40.0, 1 / np.sqrt(2)), (120.0, 1 / np.sqrt(82))):
        wave = low_pass(np.sin(2 * np.pi * frequency * time), 5000, 40.0)[len(time) // 2 :]
        assert wave.max() == pytest.approx(gain, rel=0.02)


def test_low_pass_keeps_the_momentum_of_an_impact() -> None:
    force = np.zeros(5000)
    force[1000:1005] = 500.0
    assert low_pass(force, 5000, 40.0).sum() == pytest.approx(force.sum(), rel=1e-9)


def test_a_perfect_sensor_reports_the_motion_on_its_own_axes() -> None:
    force = np.tile([1.0, 9.81, -2.0], (5000, 1))
    rate = np.tile([0.1, -0.2, 3.0], (5000, 1))
    readings = sensed(force, rate)
    to_body = mounting(DEVICE)
    np.testing.assert_allclose(readings.acceleration * COUNT_A @ to_body.T, np.tile(force[0], (100, 1)), atol=COUNT_A)
    np.testing.assert_allclose(readings.angular_rate * COUNT_W @ to_body.T, np.tile(rate[0], (100, 1)), atol=COUNT_W)
    assert readings.acceleration[0, 0] < 0  # "-x" points up, so gravity shows as a negative reading on x


def test_readings_saturate_at_full_scale() -> None:
    assert sensed(np.tile([0.0, 100.0, 0.0], (5000, 1))).acceleration.min() == -(2**15)


def test_noise_has_its_density() -> None:
    readings = sensed(np.zeros((500_000, 3)), seed=4, acceleration_noise_density=0.01)
    # White noise of density n behind a second-order low pass: n sqrt(pi / (2 sqrt 2) f_c)
    assert readings.acceleration.std() * COUNT_A == pytest.approx(0.01 * np.sqrt(1.1107 * 40), rel=0.02)


def test_the_clock_runs_at_its_own_rate_from_a_random_phase() -> None:
    times = [sensed(np.zeros((1000, 3)), seed=seed, rate_error_sd_ppm=2000.0).time for seed in range(150)]
    assert np.std([np.diff(time).mean() for time in times]) / 0.01 == pytest.approx(2e-3, rel=0.15)
    assert np.histogram([time[0] for time in times], 5, (0, 0.01))[0].min() > 15


@pytest.fixture(scope="module")
def sent():
    readings = sensed(np.zeros((300_000, 3)), seed=2)
    return readings, transmit(readings, 1000.0, 100.0, RADIO, np.random.default_rng(3))


def test_a_packet_is_late_and_never_early_and_stalls_hold_it_back(sent) -> None:
    """By when its last sample was taken; stamps are rounded to a millisecond."""
    readings, got = sent
    late = got.phone_stamp - 1000.0 - readings.time[got.row // 3 * 3 + 2]
    assert 0.008 - 0.0005 <= late.min() < 0.010
    assert (got.server_stamp > got.phone_stamp).all() and (np.diff(got.phone_stamp) >= 0).all()
    assert np.median(late) < 0.15 and np.quantile(late, 0.99) > 0.3


def test_losses_are_whole_packets_and_as_many_as_asked_for(sent) -> None:
    readings, got = sent
    packets = np.unique(got.row // 3, return_counts=True)
    assert set(packets[1]) == {3}
    assert 1 - len(packets[0]) / (len(readings.time) // 3) == pytest.approx(0.05, abs=0.015)
    assert (np.diff(got.packet.astype(int))[got.position[1:] == 0] % 65536 >= 1).all()
