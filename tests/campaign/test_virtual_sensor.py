"""The synthetic sensor and radio part by part, the still stand and push before a walk, and the spike at heel strike."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, strategies as st

from stages.biped.walk import StanceState
from stages.campaign.parameters import RadioSettings, SensorSettings
from stages.campaign.run import spike
from stages.campaign.twin_run import first_motion, quintic, rolling_leg, stand_and_push
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
from tests.imu.stand_in import EVERY
from tests.planar_start import ROUGH
from tests.study import SLOPE, TABLE_1

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
        wave = low_pass(np.cos(2 * np.pi * frequency * time), 5000, 40.0)
        assert wave[len(time) // 2 :].max() == pytest.approx(gain, rel=0.02)
        assert wave[0] == pytest.approx(1.0, abs=1e-12), "it is at rest in its first value"


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


def test_a_longer_walk_is_sensed_and_sent_as_a_shorter_one_to_its_end() -> None:
    """Closer solvers change a walk's length: with another noise and other losses from there on, these were compared."""
    settings = dataclasses.replace(PERFECT, acceleration_noise_density=2000.0, angular_rate_noise_density_deg_s=0.05)

    def seen(steps: int) -> np.ndarray:
        rng, still = np.random.default_rng(4), motion(np.zeros((steps, 3)))
        readings = read(still, draw_errors(settings, DEVICE, rng), settings, rng)
        return transmit(readings, 1000.0, 100.0, RADIO, rng).table().astype(float)

    one, other = seen(50_000), seen(50_200)
    assert len(other) - len(one) in (0, 3) and len(one) > 900
    np.testing.assert_array_equal(one, other[: len(one)])


# --- The still stand and the push: continuous into the walk, and true to mechanics.


@given(st.floats(-0.3, 0.3), st.floats(-3, 3), st.floats(-20, 20), st.floats(0.2, 1.0))
def test_quintic_goes_from_rest_to_its_end(value: float, rate: float, acceleration: float, duration: float) -> None:
    at = quintic(duration, (value, rate, acceleration), np.array([0.0, duration]))
    np.testing.assert_allclose(at[:, 0], 0, atol=1e-12)
    np.testing.assert_allclose(at[:, 1], [value, rate, acceleration], atol=1e-8)


def test_rates_are_the_derivatives() -> None:
    time, leg = stand_and_push(0.01, (0.0, -0.7, 1.5), 0.5, 0.4, 1e-4)
    np.testing.assert_allclose(np.gradient(leg[0], 1e-4)[5:-5], leg[1][5:-5], atol=1e-4)
    np.testing.assert_allclose(np.gradient(leg[1], 1e-4)[5:-5], leg[2][5:-5], atol=1e-2)
    assert time[-1] == pytest.approx(-1e-4)
    assert (leg[0][time < -0.41] == 0.01).all()


def test_at_rest_both_sensors_feel_gravity() -> None:
    time, leg = stand_and_push(np.deg2rad(2.0), (np.deg2rad(2.0), 0.0, 0.0), 0.5, 0.4, 1e-3)
    for sensor in rolling_leg((leg[0], leg[1], leg[2]), TABLE_1, SLOPE, time):
        np.testing.assert_allclose(sensor.specific_force, np.tile([0, 9.81, 0], (len(time), 1)), atol=1e-12)


def test_specific_force_is_the_second_derivative_of_the_rolling_motion() -> None:
    time = np.arange(0, 0.5, 1e-4)
    phi = 0.2 * np.cos(4 * time)
    leg = (phi, -0.8 * np.sin(4 * time), -3.2 * np.cos(4 * time))
    r, length = TABLE_1.foot_radius, TABLE_1.leg_length
    hip = np.stack([-r * phi - (length - r) * np.sin(phi), r + (length - r) * np.cos(phi)], axis=1)
    foot = hip + (length - TABLE_1.foot_com) * np.stack([np.sin(phi), -np.cos(phi)], axis=1)
    for place, sensor in zip((hip, foot), rolling_leg(leg, TABLE_1, SLOPE, time)):
        force = np.gradient(np.gradient(place, 1e-4, axis=0), 1e-4, axis=0) - np.array(SLOPE.gravity_vector)
        forward = np.stack([np.cos(phi), np.sin(phi)], axis=1)
        up = np.stack([-np.sin(phi), np.cos(phi)], axis=1)
        expected = np.stack([(force * forward).sum(axis=1), (force * up).sum(axis=1)], axis=1)
        np.testing.assert_allclose(sensor.specific_force[5:-5, :2], expected[5:-5], atol=1e-3)


def test_a_push_does_not_follow_the_blow_in_which_a_rigid_leg_takes_its_load() -> None:
    """The rate jumps by 0.04 rad/s in the first 0.2 ms and falls by 13 rad/s2 from there on."""
    grid, duration = 2e-4, 0.4
    rate = -1.1 - 13.0 * grid * np.arange(200) - 0.04 * (np.arange(200) > 0)
    for blow in (0.0, 0.02):
        end = first_motion(np.full(200, 0.3), rate, grid, blow)
        _, leg = stand_and_push(0.0, end, 0.5, duration, grid)
        assert (np.abs(leg[1]).max() > 3 * abs(end[1])) == (blow == 0.0)
        assert leg[:, -1] == pytest.approx(end, rel=0.2)


# --- The spike at heel strike follows the contact set; the time above the sensor's range hardly does.


def test_softer_ground_lowers_the_spike_and_not_the_time_above_range():
    own, soft = (spike(share, ROUGH, 9.4, EVERY["campaign"]) for share in (1.0, 4.0))
    assert own.contact_stiffness == EVERY["campaign"].contact.contact_stiffness > soft.contact_stiffness
    assert own.hip_peak > 3.0 * soft.hip_peak and own.foot_peak > 2.0 * soft.foot_peak
    assert 0.5e-3 < own.time_above_range < 2.0 * soft.time_above_range < 8e-3


def test_a_fall_is_told_by_nan():
    slow = StanceState(0.0, 0.331, 0.27, 0.334, -0.4, 0.0, 0.0, 0.0)
    found = spike(1.0, slow, 9.4, EVERY["campaign"])
    assert found.hip_peak != found.hip_peak and found.time_above_range != found.time_above_range
