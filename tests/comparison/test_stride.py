"""Strides of walks, and the hip and the measured leg over them beside a model's."""

import dataclasses
import itertools
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.signal import butter, freqs

from stages.biped.walk import SENSOR_SIGNALS
from stages.comparison.agreement import between_cycles, creep_velocity, from_same_start, overlay
from stages.comparison.ingest_score import TIMES, IngestScore, true_times
from stages.comparison.measurement import compare_leg, of_walk, same_steps_frequency
from stages.comparison.stride import NoEvidence, Stride, last_stride, means, normalised_rms, through_low_pass
from stages.imu.strikes.step_times import INNER, OUTER
from tests.comparison.made_up import make_walk, resampled


@pytest.mark.parametrize("period", [0.4, 0.5, 0.6])
def test_a_stride_runs_between_heel_strikes_of_the_inner_leg(period):
    stride = last_stride(make_walk(period=period, steps=8), 101)
    assert stride.period == pytest.approx(2.0 * period)
    assert stride.hip_position[[0, -1], 0] == pytest.approx([0.0, 0.6 * period], rel=1e-9)
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


def test_a_mean_is_over_what_of_its_span_lies_in_the_record():
    time = np.linspace(0.0, 1.0, 11)
    found = means(time, 3.0 * time[:, None], np.array([-0.5, 0.32, 0.9]), np.array([0.25, 0.48, 2.0]))
    assert found[:, 0] == pytest.approx([3.0 * 0.125, 3.0 * 0.4, 3.0 * 0.95])


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
    stride = Stride(phase, 1.0, wave, wave, wave, wave[0])
    shown = through_low_pass(stride, 40.0)
    _, response = freqs(*butter(2, 2 * np.pi * 40, analog=True), worN=[2 * np.pi * hz])
    gain, lag = np.abs(response[0]), np.angle(response[0]) + np.sqrt(2) * hz / 40
    np.testing.assert_allclose(shown[:, 0], gain * np.sin(2 * np.pi * cycles * phase + lag), atol=1e-9)
    assert lag == pytest.approx(0, abs=(hz / 40) ** 3)
    assert through_low_pass(stride, float("nan")) is wave, "none is declared"


def test_a_known_offset_is_found_with_its_sign_and_axis_and_none_from_itself():
    walk = make_walk()
    for position, velocity in (((0.0, 0.0), (0.0, 0.0)), ((-2e-3, 1e-3), (0.01, -0.02))):
        other = dataclasses.replace(
            walk, hip_position=walk.hip_position + position, hip_velocity=walk.hip_velocity + velocity)
        (_, *laid), found = overlay(walk, other, 1.0), from_same_start(walk, other, 1.0)
        for signed, largest, added in zip(laid, (found.position, found.velocity), (position, velocity), strict=True):
            assert signed == pytest.approx(np.broadcast_to(added, signed.shape), abs=1e-15)
            assert largest == pytest.approx(np.abs(added), abs=1e-15)


def test_velocities_between_the_two_heel_strikes_are_not_compared():
    """A walk that strikes 5 ms earlier has had its jump while the other has not."""
    walk = make_walk()
    strikes = walk.heel_strike_time - 5e-3
    velocity = walk.hip_velocity.copy()
    for early, late in zip(strikes, walk.heel_strike_time):
        velocity[(walk.time >= early) & (walk.time <= late), 0] += 0.03
    other = dataclasses.replace(walk, heel_strike_time=strikes, hip_velocity=velocity)
    assert overlay(walk, other, 1.0)[2][:, 0].max() > 0.029
    assert from_same_start(walk, other, 1.0).velocity[0] < 1e-9


def test_only_the_asked_duration_counts():
    walk = make_walk()
    late = walk.hip_position.copy()
    late[:, 0] += np.maximum(2.0 * (walk.time - 1.0), 0.0)
    other = dataclasses.replace(walk, hip_position=late)
    assert from_same_start(walk, other, 0.9).position[0] == pytest.approx(0.0, abs=1e-12)
    assert from_same_start(walk, other, 1.5).position[0] == pytest.approx(1.0)


def test_different_sampling_does_not_make_a_difference_of_straight_motion():
    walk = make_walk()
    rows = np.union1d(np.random.default_rng(0).choice(len(walk.time), 3000, replace=False), [0, len(walk.time) - 1])
    thin = dataclasses.replace(
        walk, time=walk.time[rows], hip_position=walk.hip_position[rows], hip_velocity=walk.hip_velocity[rows]
    )
    assert from_same_start(walk, thin, 1.0).position[0] < 1e-12


def test_cycles_are_compared_at_equal_phase_and_from_equal_start():
    fast, slow = make_walk(period=0.5, speed=0.3), make_walk(period=0.5, speed=0.31)
    difference = between_cycles(last_stride(fast, 101), last_stride(slow, 101))
    assert difference.position[0] == pytest.approx(0.01, rel=1e-6), "0.01 m/s over a stride of 1 s"


def test_creep_is_the_slip_of_the_one_loaded_foot():
    walk = make_walk()
    slip = np.full((len(walk.time), 2), 0.005)
    assert creep_velocity(walk, slip) == pytest.approx(0.005)
    both = dataclasses.replace(walk, ground_reaction=np.ones_like(walk.ground_reaction))
    assert creep_velocity(both, slip) == 0.0, "double stance is not counted"


# --- The measured leg beside a model's: runs made of a walk agree with that walk, and differ by what is added to
# them.


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


def test_the_true_times_of_a_limping_walk_are_those_between_its_landings_and_liftings():
    """A stride of 1.1 s; the outer foot lands .5 s after the inner one, and each is let go .05 s or .03 s later."""
    landed, strides = {INNER: 0.0, OUTER: 0.5}, 1.1 * np.arange(4)
    lifted = {INNER: 0.5 + 0.05, OUTER: 0.03}
    strikes = np.ravel([[at + landed[INNER], at + landed[OUTER]] for at in strides])
    truth = SimpleNamespace(
        heel_strike_time=strikes, heel_strike_leg=np.tile([INNER, OUTER], len(strides)),
        leg=SimpleNamespace(toe_off_time=np.ravel([[at + lifted[OUTER], at + lifted[INNER]] for at in strides]),
                            toe_off_leg=np.tile([OUTER, INNER], len(strides))))  # fmt: skip
    expected = {
        "outer step": landed[OUTER] - landed[INNER],
        "double stance": lifted[INNER] - landed[OUTER],
        "inner stance": lifted[INNER] - landed[INNER],
        "inner swing": landed[INNER] + 1.1 - lifted[INNER],
        "outer stance": lifted[OUTER] + 1.1 - landed[OUTER],
    }
    for skipped in (0, 1, 2):
        assert dict(zip(TIMES, true_times(truth, skipped), strict=True)) == pytest.approx(expected), skipped


def test_what_no_error_is_stated_of_is_left_blank():
    rows = [("leg angle", 0.1, np.nan, np.nan), ("step length", 0.2, 0.3, 0.95)]
    score = IngestScore(*[np.ones(2)] * 8, SimpleNamespace(rows=lambda: rows))
    assert score.leg_table()[2] == [("leg angle", "0.1", "", ""), ("step length", "0.2", "0.3", "95")]


def test_a_walk_s_frequency_is_that_of_the_steps_of_which_the_runs_have_theirs():
    """From heel strike 3 to 6 where runs have 7, 7 and 20 of them and 3 are left out; a walk of 4 has no such step."""
    runs = SimpleNamespace(runs=[SimpleNamespace(heel_strike_time=np.arange(float(count))) for count in (7, 7, 20)])
    walk = make_walk(0.5, first_periods=(0.7, 0.6, 0.55, 0.52))
    assert same_steps_frequency(runs, walk, 3) == pytest.approx(3 / (0.52 + 0.5 + 0.5))
    with pytest.raises(NoEvidence, match="within the first 4 steps"):
        same_steps_frequency(runs, make_walk(steps=4), 3)
