"""Frames, units, resampling, registration and ensemble: what must hold for any motion."""

import dataclasses
import functools
import math

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy.spatial.transform import Rotation

from stages.imu.clock.clock import resample
from stages.imu.judgement.evidence import axis_turn_of, gain_of, lever_of, spacing_of
from stages.imu.judgement.sensor_evidence import flat_tops, wraps
from stages.imu.parameters import filter_delay
from stages.imu.sources.opening import SourceRefused
from stages.imu.sources.units import implied_acceleration_unit, implied_angular_rate_unit, scale_of, swept_angle
from stages.imu.strikes.heel_strikes import NO_STRIKES, find_heel_strikes, first_blow, lowest_between, refine
from stages.imu.strikes.step_times import HeelStrikes, step_frequency, stride_bounds
from stages.imu.trial.body import angle_between, find_frame, gravity_on_body, mounting
from stages.imu.trial.sensor import find_rest, mask_clipped
from stages.imu.trial.walk import ensemble_of, register
from tests.imu.made_logs import Log, replaced
from tests.imu.stand_in import SETTINGS, device

angles = st.floats(-0.12, 0.12)


@settings(max_examples=50)
@given(angles, angles, angles, st.sampled_from(["hip", "foot"]), st.floats(0, 0.2))
def test_frame_of_a_planar_motion_is_exact(a: float, b: float, c: float, place: str, slope: float) -> None:
    """Gravity and a pure swing leave no freedom: the rotation comes back to rounding."""
    to_sensor = Rotation.from_rotvec([a, b, c]).as_matrix() @ mounting(device(place)).T
    swing = np.sin(np.linspace(0, 20, 400))[:, None] * np.array([0.0, 0.0, 2.0])
    force = 9.81 * gravity_on_body(slope, 0.0)
    frame = find_frame(to_sensor @ force, swing @ to_sensor.T, device(place), slope, 0.0)
    assert angle_between(frame.rotation, to_sensor.T) < 1e-5
    assert frame.swing_share == pytest.approx(1)
    assert np.linalg.det(frame.rotation) == pytest.approx(1)


def test_without_a_declared_mounting_the_swing_tells_the_side() -> None:
    """A leg swings forward faster than it rolls back; so the frame comes back from any mounting."""
    unknown = dataclasses.replace(device("hip"), forward_axis=None, up_axis=None)
    phase = np.linspace(0, 1, 500)
    rate = np.where(phase < 0.6, -1.0, 1.5)[:, None] * np.array([0.0, 0.0, 1.0])
    for seed in range(10):
        to_sensor = Rotation.random(None, np.random.default_rng(seed)).as_matrix()
        frame = find_frame(to_sensor @ np.array([0, 9.81, 0]), rate @ to_sensor.T, unknown, 0.0, 0.0)
        assert angle_between(frame.rotation, to_sensor.T) < 1e-5


def test_a_recording_may_end_between_a_turn_and_its_strike() -> None:
    """Where a strike was expected beyond the end it ended with an IndexError, or noise was taken for the strike."""
    time = np.arange(0.0, 6.0, 0.005)
    rate = np.where(time > 1.0, np.sin(2 * np.pi * time), 0.0)
    force = np.random.default_rng(1).normal([0.0, 9.81], 0.02, (len(time), 2))
    for strike in np.arange(1.65, 6.0, 0.5):
        force[:, 1] += 25.0 * np.exp(-0.5 * ((time - strike) / 0.006) ** 2)
    for end in range(700, len(time)):
        found = find_heel_strikes(time[:end], force[:end], rate[:end], rate[:end, None], (0.8, 4.0)).time
        assert len(found) and np.abs((found - 1.65 + 0.25) % 0.5 - 0.25).max() < 0.02


@pytest.mark.parametrize(("rising", "falling", "count", "ends"), [
    (0.0, 0.0, 1e-9, 3.25), (0.0, 10.0, 1e-9, 2.75), (0.02, 0.0, 1e-9, 3.25), (0.0, 0.0, 0.4, 3.25)],
    ids=["noise", "a gentle fall", "a zero that drifts", "coarse counts"])
def test_a_stand_ends_where_its_mean_moves(rising: float, falling: float, count: float, ends: float) -> None:
    """A giant on Mars fell so gently that each window was still, and .9 s of that were taken for the gyroscope's zero,
    .42 deg/s off. Here a stand of 2.5 s is before the fall, by as much; what drifts for all of it does not end it."""
    noise, time = np.random.default_rng(1), np.arange(350) / 100.0
    rate = noise.normal(0.0, 0.06, (350, 3)) + rising * (time - 1.5)[:, None]
    rate[:, 2] += falling * np.maximum(time - 2.5, 0.0) ** 2
    rate = count * np.round(rate / count)
    force = noise.normal(0.0, 0.02, (350, 3)) + [0.0, 3.71, 0.0]
    rest = find_rest(force, np.radians(rate), 100.0, SETTINGS)
    assert rest[25:250].all()
    assert not rest[time > ends].any()
    assert np.abs(rate[rest].mean(axis=0)).max() < 0.02


def test_gravity_at_rest_points_up_the_plumb_leg() -> None:
    np.testing.assert_allclose(gravity_on_body(math.radians(2), math.radians(2)), [0, 1, 0], atol=1e-15)
    assert gravity_on_body(math.radians(2), 0.0)[0] < 0  # leaning downhill, gravity pulls the hip forward


@pytest.mark.parametrize(
    ("reading", "unit"),
    [(1.0, "g"), (9.81, "m/s^2"), (1003.0, "mg"), (8192.0, "counts of 4 g full scale"), (3.3, "none"), (0.0, "none")],
)
def test_static_reading_tells_the_unit(reading: float, unit: str) -> None:
    assert implied_acceleration_unit(reading, device("hip")) == unit


TURN = math.pi / 180


@pytest.mark.parametrize(
    ("swept", "declared", "unit"),
    [(0.9, "deg/s", "deg/s"), (0.5 * TURN, "deg/s", "rad/s"), (0.5 / TURN, "rad/s", "deg/s"),
     (0.5e3 / TURN, "rad/s", "mdps"), (0.5e3, "deg/s", "mdps"), (math.nan, "rad/s", "unclear"),
     (0.0, "rad/s", "unclear"), (1e-4, "rad/s", "unclear"), (14.0, "deg/s", "unclear")],
)  # fmt: skip
def test_what_a_leg_sweeps_tells_the_unit(swept: float, declared: str, unit: str) -> None:
    assert implied_angular_rate_unit(swept, declared) == unit


@pytest.mark.parametrize(("step_over_leg", "step_hz"), [(0.3, 0.4), (0.5, 2.0), (1.2, 1.0), (0.5, 20.0)])
def test_a_swing_sweeps_its_angle_whatever_the_time_it_takes(step_over_leg: float, step_hz: float) -> None:
    """Legs swing to and fro once in two steps; the sensor has a bias, and was turned round slowly before."""
    swept, rate_hz = 2 * math.asin(step_over_leg / 2), 50 * step_hz
    time = np.arange(1500) / rate_hz
    lateral = np.pi * step_hz * 0.5 * swept * np.cos(np.pi * step_hz * time) * (time > 10 / step_hz)
    lateral += np.pi * 0.05 * step_hz * (time < 10 / step_hz) + 0.1 * step_hz
    found = swept_angle(np.column_stack((0 * lateral, lateral, 0 * lateral)), rate_hz, 0.2 * step_hz)
    assert found == pytest.approx(swept, rel=0.3)


@settings(max_examples=80)
@given(st.lists(st.floats(-100, 100), min_size=5, max_size=40), st.data())
def test_resampling_never_leaves_the_range_of_its_neighbours(values: list[float], data: st.DataObject) -> None:
    time = np.arange(len(values)) * 0.01
    grid = np.linspace(-0.02, time[-1] + 0.02, 97)
    grid = grid[np.abs(grid / 0.01 - np.rint(grid / 0.01)) > 1e-6]
    missing = data.draw(st.sets(st.integers(0, len(values) - 1), max_size=3))
    column = np.array(values)[:, None].copy()
    column[list(missing)] = np.nan
    result = resample(time, column, grid, 0.015)[:, 0]
    for t, value in zip(grid, result):
        left, right = int(np.floor(t / 0.01)), int(np.ceil(t / 0.01))
        outside = left < 0 or right > len(values) - 1
        if outside or {left, right} & missing:
            assert np.isnan(value)
        else:
            low, high = sorted((values[left], values[right]))
            assert low - 1e-9 <= value <= high + 1e-9


@pytest.mark.parametrize("rounded", [-2.4e-7, 2.4e-7])
def test_rounding_of_stamps_decides_over_no_hole(rounded: float) -> None:
    """Seconds since 1970 are rounded so; a grid that meets the samples on both edges of a hole still has them."""
    time, grid = 0.01 * np.arange(50), 0.005 * np.arange(99)
    value = np.sin(time)[:, None]
    value[20:23] = np.nan
    exact, moved = (resample(time, value, grid + by, 0.015)[:, 0] for by in (0.0, rounded))
    np.testing.assert_array_equal(np.isnan(exact), np.isnan(moved))
    np.testing.assert_allclose(moved, exact, atol=3e-7)


def test_clipped_readings_are_masked() -> None:
    value = np.array([[0.0, 32767.0, 5.0], [1.0, 2.0, -32768.0], [3.0, 3.0, 3.0]])
    masked, count = mask_clipped(value, 32768.0)
    assert (count, np.isnan(masked).sum()) == (2, 2)


def test_filter_delay_is_that_of_the_low_pass() -> None:
    """Group delay of the analogue filter at zero frequency, against its phase."""
    f = 1e-3
    phase = np.angle(1 / ((1j * f / 40) ** 2 + math.sqrt(2) * 1j * f / 40 + 1))
    assert filter_delay(40.0) == pytest.approx(-phase / (2 * math.pi * f), rel=1e-6)
    assert filter_delay(None) == 0


@settings(max_examples=50)
@given(st.floats(0.3, 0.8), st.floats(-0.05, 0.05), st.integers(6, 30))
def test_step_frequency_of_a_limping_walk(period: float, limp: float, count: int) -> None:
    number = np.arange(count)
    leg = (number + 1) % 2
    found = step_frequency(HeelStrikes(3.0 + period * number + limp * leg, leg))
    assert found[0] == pytest.approx(1 / period, rel=1e-9)


def test_the_error_of_a_frequency_is_how_frequencies_scatter() -> None:
    rng, number = np.random.default_rng(8), np.arange(15)
    found = np.array([step_frequency(HeelStrikes(0.48 * number + 2e-3 * rng.normal(size=15), (number + 1) % 2))
                      for _ in range(400)])
    assert np.sqrt(np.mean(found[:, 1] ** 2)) == pytest.approx(found[:, 0].std(), rel=0.1)


def test_counts_without_a_scale_are_refused_by_run_place_and_key(log: Log) -> None:
    hip = replaced(log.recordings[0], device=dataclasses.replace(log.recordings[0].device, bits=None))
    said = "run 'synthetic run 01': the sensor at 'hip' gives counts, so its device needs accelerometer_range_g and bit"
    with pytest.raises(SourceRefused, match=said):
        scale_of(hip)


def test_a_missed_strike_is_no_long_step_and_pulses_of_one_time_have_no_frequency() -> None:
    """A gyroscope that wraps turns round many times at one pulse."""
    number = np.delete(np.arange(12), 5)
    assert step_frequency(HeelStrikes(0.48 * number, (number + 1) % 2))[0] == pytest.approx(1 / 0.48)
    together = HeelStrikes(np.array([1.0, 1.0, 1.0, 1.0, 1.0, 1.5]), np.array([0, 1, 0, 1, 0, 1]))
    assert np.isnan(step_frequency(together)[0])
    assert spacing_of(HeelStrikes(together.time[2:], together.leg[2:])) == (np.inf, 0.0)


def test_registration_stretches_each_stride() -> None:
    """A signal that is a function of phase alone looks the same in strides of different length."""
    strikes = np.array([0.0, 0.9, 1.9, 3.1])
    time = np.arange(0, 3.1, 0.001)
    phase = np.interp(time, strikes, np.arange(4)) % 1
    signal = np.column_stack((np.sin(2 * np.pi * phase), np.cos(2 * np.pi * phase)))
    bounds = stride_bounds(HeelStrikes(strikes, np.zeros(4, dtype=int)))
    strides = register(time, signal, bounds, 101, 0.0015)
    expected = np.sin(2 * np.pi * np.linspace(0, 1, 101))
    np.testing.assert_allclose(strides[:2, :, 0], np.stack([expected] * 2), atol=1e-4)
    ensemble = ensemble_of(strides[:2])
    np.testing.assert_allclose(ensemble.mean[:, 0], expected, atol=1e-4)
    assert np.nanmax(ensemble.spread) < 1e-4


def test_an_ensemble_leaves_holes_out() -> None:
    strides = np.zeros((3, 4, 1))
    strides[:, :, 0] = [[1, 1, np.nan, np.nan], [2, np.nan, np.nan, 5], [3, 3, np.nan, np.nan]]
    found = ensemble_of(strides)
    rows = [getattr(found, name)[:, 0] for name in ("mean", "lower", "upper", "spread", "count")]
    np.testing.assert_allclose(rows, [[2, 2, np.nan, 5], [1, 1, np.nan, 5], [3, 3, np.nan, 5],
                                      [1, math.sqrt(2), np.nan, np.nan], [3, 2, 0, 1]])  # fmt: skip


def hanging_leg() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Time and signals of hip and foot of a leg that swings as a pendulum from a shaken hip, 0.3 m long.

    The foot at its end feels nothing forward, however fast it swings: in its own axes gravity does not turn.
    """
    time = np.arange(0.0, 6.0, 0.005)
    phi, rate = 0.5 * np.sin(5.7 * time), 2.85 * np.cos(5.7 * time)
    turning = -0.5 * 5.7**2 * np.sin(5.7 * time)
    hip, foot = np.zeros((2, len(time), 6))
    hip[:, 0], hip[:, 1] = -0.3 * turning, 9.81 * np.cos(phi)
    foot[:, 1] = hip[:, 1] + 0.3 * rate**2
    hip[:, 5] = foot[:, 5] = rate
    return time, hip, foot


def test_two_places_tell_which_way_a_gyroscope_turns_where_gravity_does_not() -> None:
    time, hip, foot = hanging_leg()
    said = functools.partial(lever_of, time, strikes=NO_STRIKES, rate_hz=200.0)
    turned = np.array([1, 1, 1, -1, -1, -1])
    arm, direction, _, *turns, late = said(hip, foot)
    assert arm == pytest.approx(0.3, rel=0.01) == -said(foot, hip)[0]
    assert direction == pytest.approx(0.0, abs=0.02) and turns == pytest.approx([1, 1], abs=1e-3)
    assert said(hip, foot * turned)[3:5] == pytest.approx([1, -1], abs=1e-3)
    assert said(hip * turned, foot * turned)[3:5] == pytest.approx([-1, -1], abs=1e-3)
    beside = np.column_stack((np.zeros((len(time), 5)), 2.0 * np.sin(3.1 * time)))
    assert np.abs(said(hip * [1, 1, 1, 0, 0, 0] + beside, foot * [1, 1, 1, 0, 0, 0] + beside)[3:5]).max() < 0.3
    behind = [np.column_stack((one[6:, :3], one[:-6, 3:])) for one in (hip, foot)]
    assert late == pytest.approx(0.0, abs=1e-3), "and six rows of 5 ms:"
    assert lever_of(time[6:], *behind, NO_STRIKES, 200.0)[5] == pytest.approx(0.03, abs=1e-3)


def test_blows_of_the_push_and_of_the_catch_say_nothing_of_the_sensors() -> None:
    """A strike that is not found, between the push and the first that is: good sensors were said to differ by 1.4."""
    time, hip, foot = hanging_leg()
    strikes = HeelStrikes(np.arange(1.0, 5.5, 0.5), np.arange(9) % 2)
    for one in (hip, foot):
        one[:, 0] += 0.5 * np.sin(3.1 * time)
    hip[[120, 1160], 0] += 60.0
    foot[[125, 1165], 0] -= 40.0
    arm, direction, gain = lever_of(time, hip, foot, strikes, 200.0)[:3]
    assert arm == pytest.approx(0.3, rel=0.01) and direction == pytest.approx(0.0, abs=0.1)
    assert gain == pytest.approx(1.0, abs=0.03)


def test_a_sensor_that_turns_on_its_leg_moves_the_swing_axis() -> None:
    rng = np.random.default_rng(3)
    rate = np.column_stack((*rng.normal(scale=1e-3, size=(2, 900)), np.sin(np.arange(900) / 15)))
    assert axis_turn_of(rate) < 0.05
    turn = np.radians(5.0)
    late = rate @ np.array([[1, 0, 0], [0, np.cos(turn), np.sin(turn)], [0, -np.sin(turn), np.cos(turn)]])
    assert axis_turn_of(np.where(np.arange(900)[:, None] < 450, rate, -late)) == pytest.approx(5.0, abs=0.05)


def test_counts_that_begin_again_leap_and_blows_do_not() -> None:
    blow = np.exp(-0.5 * ((np.arange(400)[:, None] % 48 - 20) / [1.0, 1.5, 2.0]) ** 2) * [3.0, 2.0, 1.5] + 0.3
    assert wraps(blow, np.inf) == 0 and wraps(blow * np.cos(np.arange(400)[:, None]), np.inf) == 0
    assert wraps((blow + 2) % 4 - 2, 2.1) >= 2
    assert wraps(np.where(np.arange(400)[:, None] == 7, -3.3, blow), np.inf) == 0, "a spike is no range"
    assert wraps(np.clip(3 * blow * np.where(np.arange(400) % 2, 1, -1)[:, None], -2, 2), 2.0) == 0, "it clips"


def test_a_full_scale_that_is_half_the_declared_one_shows_in_two_samples() -> None:
    rng = np.random.default_rng(4)
    values = rng.normal(size=(300, 3)) * [2000, 2000, 3000]
    values[[10, 20], 2] = 17000, 18000
    assert flat_tops(np.clip(values, -16384, 16384), 32768) == (2, 16384.0)
    assert flat_tops(np.clip(values, -15000, 15000), 32768)[0] == flat_tops(values, 32768)[0] == 0


@pytest.mark.parametrize("width", [1.0, 6.0])
def test_of_two_blows_the_first_is_the_strike_at_its_top(width: float) -> None:
    """Also where a slow sensor draws the pulse out, as long as it is not faint."""
    row = np.arange(100)
    first, second = (np.exp(-0.5 * ((row - at) / width) ** 2) for at in (30, 55))
    assert first_blow(0.8 * first + second, 10, 90, 3) == 30
    assert first_blow(0.5 * first + second, 10, 90, 3) == 55


def test_a_turn_that_a_fast_sensor_reads_often_is_no_full_scale() -> None:
    """Of a sensor of 1 kHz the swing's fastest readings, one step apart, were each there again and again."""
    swing = np.sin(2 * np.pi * np.arange(0.0, 8.0, 1e-3))[:, None] * [1400, 0, 0]
    for seed in range(20):
        values = np.rint(swing + 2.0 * np.random.default_rng(seed).normal(size=swing.shape))
        assert flat_tops(values, 32768)[0] == 0
        beyond = len(swing) * np.arccos(1100 / 1400) / np.pi
        assert flat_tops(np.clip(values, -1100, 1100), 32768) == (pytest.approx(beyond, rel=0.03), 1100.0)


def test_strikes_move_to_where_they_lie_on_each_other_and_one_with_little_left_to_where_they_expect_it() -> None:
    """Where the record ends before the last strike's pulse, less than a quarter of its window is left."""
    time, true = 0.002 * np.arange(1500), 0.3 * np.arange(1, 10) + 0.0005
    signals = np.exp(-(((time[:, None, None] - true) / [[0.004], [0.012]]) ** 2)).sum(axis=2)
    guessed = true + np.array([4, -6, 0, 8, -3, 5, -7, 2, -3]) * 1e-3
    found = refine(time, signals, guessed, np.zeros(9, dtype=bool), 0.15)
    assert np.ptp(found - true) < 2e-4 and abs((found - guessed).mean()) < 1e-9
    for end in np.arange(true[-1] - 0.06, true[-1] + 0.06, 0.004):
        seen = time < end
        cut = refine(time[seen], signals[seen], guessed, np.arange(9) == 8, 0.15)
        assert np.ptp((cut - true)[:8]) < 2e-4 and abs((cut - guessed)[:8].mean()) < 1e-9
        assert abs(cut[8] - true[8] - (cut - true)[:8].mean()) < 2e-4
    two = refine(time, signals, guessed, np.arange(9) > 1, 0.15)
    assert np.ptp(two - true) < 2e-4, "two strikes place the rest"
    np.testing.assert_array_equal(refine(time, signals, guessed, np.arange(9) > 0, 0.15), guessed)


def test_a_parabola_has_its_lowest_point_where_it_is() -> None:
    row = np.arange(5.0)
    for lowest in (1.6, 2.0, 2.4):
        assert 2 + lowest_between(3.0 * (row - lowest) ** 2 + 1.0, 2) == pytest.approx(lowest)
    assert lowest_between(-((row - 2.4) ** 2), 2) == lowest_between(row, 2) == 0.0


def test_a_gain_is_told_from_errors_of_either_signal() -> None:
    """It is 1 where errors may explain what differs, and nothing where the signals have too little in common."""
    rng = np.random.default_rng(5)
    felt, first, second = rng.normal(size=(3, 4000))
    assert gain_of(felt + 0.4 * first, felt + 0.4 * second) == 1.0
    assert gain_of(felt, felt + 0.4 * second) == 1.0
    for gain in (2.0, 0.5, -1.0):
        assert gain_of(felt + 0.2 * first, gain * (felt + 0.2 * second)) == pytest.approx(gain, rel=0.08)
    assert math.isnan(gain_of(0.5 * felt + first, felt + second))
