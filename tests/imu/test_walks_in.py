"""A recording that goes on: hands that carry the robot back, stands in another pose, and more walks than one."""

import dataclasses

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from stages.imu.judgement.verdict import REFUSED
from stages.imu.run import trials
from stages.imu.sources.cells import recording_from_columns
from stages.imu.sources.schema import Experiment, Recording
from stages.imu.sources.units import scale_of
from stages.imu.trial.trial import Trial, read_trials
from tests.imu.made_logs import Log, TracedRecording
from tests.imu.stand_in import PARAMETERS

STAMP, READINGS = 2, slice(5, 11)


def alone(recording: TracedRecording) -> np.ndarray:
    """The rows (n, 11) of a walk, numbered by the sensor's own stamps."""
    rows = np.full((recording.rows, 11), np.nan)
    rows[:, STAMP], rows[:, READINGS] = recording.true_time, recording.table()[:, READINGS]
    return rows[np.argsort(rows[:, STAMP])]


def carried(recording: TracedRecording, seconds: float) -> np.ndarray:
    """The rows of a hand that carries the robot: it turns about all axes."""
    time = np.arange(0.0, seconds, 1.0 / recording.device.rate_hz)
    rows, scale = np.full((len(time), 11), np.nan), scale_of(recording)
    swing = np.minimum(time, 1.0)[:, None] * np.sin(2 * np.pi * np.outer(time, [0.7, 1.1, 0.9, 0.5, 0.8, 1.3]))
    rows[:, STAMP] = time
    rows[:, READINGS] = alone(recording)[0, READINGS] + swing / np.repeat([scale.acceleration, scale.angular_rate], 3)
    return rows


def leaning(recording: TracedRecording, seconds: float, degrees: float) -> np.ndarray:
    """The rows of the robot as it stood before its walk, but turned, for longer than it stood there."""
    rows = np.resize(alone(recording)[20:150], (int(seconds * recording.device.rate_hz), 11))
    rows[:, STAMP] = np.arange(len(rows)) / recording.device.rate_hz
    rows[:, 5:8] = Rotation.from_rotvec([0.0, np.radians(degrees), np.radians(degrees)]).apply(rows[:, 5:8])
    return rows


def after_each_other(recording: TracedRecording, parts: list[np.ndarray]) -> Recording:
    end, rows = 0.0, list[np.ndarray]()
    for part in parts:
        begin = part[0, STAMP]
        rows.append(part.copy())
        rows[-1][:, STAMP] += end - begin
        end = rows[-1][-1, STAMP] + 1.0 / recording.device.rate_hz
    return recording_from_columns(recording.experiment, recording.device, np.concatenate(rows))


def read(log: Log, *parts: str, of_foot: tuple[str, ...] = ()) -> list[Trial]:
    made = {"walk": alone, "hand": lambda one: carried(one, 4.0), "stand": lambda one: leaning(one, 4.0, 0.0),
            "leaning": lambda one: leaning(one, 4.0, 40.0)}  # fmt: skip
    recordings = tuple(
        after_each_other(one, [made[part](one) for part in (of_foot if one.device.place == "foot" else ()) or parts])
        for one in log.recordings)
    return list(read_trials(log.experiment, recordings, PARAMETERS))


@pytest.mark.parametrize("parts", [
    ("walk", "hand"), ("hand", "stand", "walk"), ("walk", "leaning"), ("walk", "hand", "leaning"),
])  # fmt: skip
def test_what_is_not_of_the_walk_changes_nothing_of_it(log: Log, parts: tuple[str, ...]) -> None:
    """A hand's turning was "motion not in a plane", and the longest stand, whatever its pose, that before the walk."""
    (only,), (found,) = read(log, "walk"), read(log, *parts)
    assert found.accepted and found.experiment.name == log.experiment.name
    assert any("of the recording is left out" in one for one in found.verdict.sentences(refused=False))
    assert found.frequency[0] == pytest.approx(only.frequency[0], abs=only.frequency[1])
    np.testing.assert_allclose(np.diff(found.strikes.time), np.diff(only.strikes.time), atol=1e-3)
    for side, sensor in found.sensors.items():
        before = only.sensors[side].frame.rotation
        assert np.degrees(Rotation.from_matrix(sensor.frame.rotation.T @ before).magnitude()) < 0.3


def test_each_walk_of_a_recording_is_a_run(log: Log) -> None:
    """Two walks were one of 24 steps, of a frequency that was off by twenty standard errors."""
    (only,), both = read(log, "walk"), read(log, "walk", "hand", "stand", "walk")
    assert [one.experiment.name for one in both] == [f"{log.experiment.name}, walk {k} of 2" for k in (1, 2)]
    for found in both:
        assert len(found.strikes.time) == len(only.strikes.time)
        assert found.frequency[0] == pytest.approx(only.frequency[0], abs=only.frequency[1])
        assert {one.run for one in found.reports} == {found.experiment.name}
    assert both[1].strikes.time[0] > both[0].strikes.time[-1] + 4.0


@pytest.mark.parametrize(("begin", "long"), [(1.4, 1.2), (2.2, 1.2), (2.6, 1.2), (3.1, 0.6)])
def test_a_hole_of_the_hip_in_which_the_foot_shows_the_swing_loses_no_step(log: Log, begin: float, long: float) -> None:
    """Of nine steps, on clocks of their own. A line through it had two turns less, and did not turn with the foot."""
    whole, holed = list[Recording](), list[Recording]()
    for one in log.recordings:
        rows = alone(one)
        since = rows[:, STAMP] - log.strike_time[0]
        hole = (since > begin) & (since < begin + long) & (one.device.place == "hip")
        for made, kept in ((whole, since < 4.3), (holed, (since < 4.3) & ~hole)):
            made.append(recording_from_columns(one.experiment, one.device, rows[kept]))
    (right,), (found,) = (list(read_trials(log.experiment, tuple(each), PARAMETERS)) for each in (whole, holed))
    assert found.accepted, found.report().reason
    assert len(found.strikes.time) == len(right.strikes.time)
    np.testing.assert_allclose(np.diff(found.strikes.time), np.diff(right.strikes.time), atol=15e-3)
    assert found.frequency[0] == pytest.approx(right.frequency[0], abs=3 * found.frequency[1])


def test_sensors_that_show_other_numbers_of_walks_are_refused(log: Log) -> None:
    (found,) = read(log, "walk", "stand", "walk", of_foot=("walk", "stand"))
    assert found.verdict.outcome == REFUSED
    assert "the sensors show 2 and 1 walks: give each walk a run of its own" in found.report().reason


def test_a_sensor_that_restarts_where_nothing_else_dates_it_is_said_so(log: Log) -> None:
    """It was "100% of the samples are lost"."""
    recordings = []
    for one in log.recordings:
        rows = alone(one)
        rows[len(rows) // 2 :, STAMP] -= rows[len(rows) // 2, STAMP] + 5.0
        recordings.append(recording_from_columns(one.experiment, one.device, rows))
    (found,) = read_trials(log.experiment, tuple(recordings), PARAMETERS)
    assert found.verdict.outcome == REFUSED and "lost" not in found.report().reason
    assert "the sensor's stamps begin anew within the recording" in found.report().reason


def test_a_walk_alone_is_taken_as_it_is(log: Log) -> None:
    (found,) = read(log, "walk")
    assert [one.rows for one in found.reports] == [one.rows for one in log.recordings]
    assert not any("left out" in one for one in found.verdict.sentences(refused=False))
    (without,) = read_trials(log.experiment, tuple(
        dataclasses.replace(one, angular_rate=np.zeros_like(one.angular_rate)) for one in log.recordings), PARAMETERS)
    assert without.verdict.outcome == REFUSED


def test_runs_of_one_name_keep_names_apart_by_which_each_is_found() -> None:
    """`same` and `follow` told of the last of them alone."""
    named = [Experiment("walk"), Experiment("walk (2)"), Experiment("walk"), Experiment("walk")]
    found = [trial.experiment.name for trial in trials([(one, ()) for one in named], PARAMETERS)]
    assert found == ["walk", "walk (2)", "walk (3)", "walk (4)"]
