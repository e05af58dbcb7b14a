"""Real recordings with their own faults; the numbers come from the note beside them."""

import dataclasses
import functools
import json
from typing import Any

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d
from scipy.signal import find_peaks

from stages.imu.clock.packet_index import index_samples
from stages.imu.judgement.verdict import REFUSED
from stages.imu.result import SensorReport
from stages.imu.sources.column_map import CsvSource
from stages.imu.sources.schema import Experiment, Recording
from stages.imu.strikes.step_times import INNER
from stages.imu.trial.body import BodySensor
from stages.imu.trial.sensor import trace_sensor
from stages.imu.trial.trial import read_sensor, read_trials
from stages.imu.trial.walk import strikes_of
from tests.imu.real_recordings import FOLDER, ipol, xio
from tests.imu.stand_in import LIMITS, PARAMETERS, SETTINGS

pytestmark = pytest.mark.skipif(not FOLDER.is_dir(), reason=f"the real recordings are not at {FOLDER.name}")


@functools.cache
def recorded(name: str) -> tuple[Experiment, tuple[Recording, ...]]:
    """What was measured on a person, read once for all tests that look at it."""
    ((experiment, recordings),) = CsvSource(ipol(name), FOLDER).runs()
    return experiment, tuple(recordings)


def at(name: str, place: str) -> Recording:
    """The recording of one of a person's sensors."""
    return next(one for one in recorded(name)[1] if one.device.place == place)


def marked(name: str, side: str) -> np.ndarray:
    """Swings (m, 2) of a foot that were marked by hand, as packet counters."""
    return np.array(json.loads((FOLDER / f"ipol_{name}.json").read_text())[f"{side}FootEvents"])


@functools.cache
def sensed(name: str, place: str) -> tuple[BodySensor | None, SensorReport]:
    """What one of a person's sensors showed, and the report on it."""
    sensor, report, _ = read_sensor(trace_sensor(at(name, place), SETTINGS), SETTINGS, LIMITS)
    return sensor, report


def reports(description: dict[str, Any], **said: str) -> list[SensorReport]:
    """Of the sensors of a description, of which something else is said."""
    for file in description["files"]:
        file["device"] = file["device"] | said
    ((_, recordings),) = CsvSource(description, FOLDER).runs()
    return [read_sensor(trace_sensor(one, SETTINGS), SETTINGS, LIMITS)[1] for one in recordings]


@pytest.mark.parametrize(("name", "fewest", "most"), [("8-5", 572, 783), ("3-3", 532, 651), ("7-4", 0, 0)])
def test_lost_packets_units_and_gain_of_xsens(name: str, fewest: int, most: int) -> None:
    found = [sensed(name, one.device.place)[1] for one in recorded(name)[1]]
    lost = [report.lost_packets for report in found]
    assert (min(lost), max(lost)) == (fewest, most)
    assert all(9.9 <= report.static_reading <= 10.4 for report in found)
    assert {(report.acceleration_unit, report.angular_rate_unit) for report in found} == {("m/s^2", "rad/s")}


NGIMU, XIMU = ("ngimu_foot_short_walk.csv", 400.0), ("ximu_sensor_data.csv", 100.0)


@pytest.mark.parametrize(("which", "gaps", "rate_hz", "found"), [
    (NGIMU, 165, pytest.approx(398, abs=1), {"exact_duplicates": 205, "lost_packets": -1}),
    (XIMU, 10, pytest.approx(99.9, abs=0.3), {}),
])  # fmt: skip
def test_faults_of_loggers(which: tuple[str, float], gaps: int, rate_hz: object, found: dict[str, int]) -> None:
    (report,) = reports(xio(*which))
    assert (report.gaps, report.rate_hz) == (gaps, rate_hz)
    assert (report.acceleration_unit, report.angular_rate_unit) == ("g", "deg/s")
    assert {name: getattr(report, name) for name in found} == found


@pytest.mark.parametrize(("description", "said", "reason"), [
    (ipol("7-4"), {"accelerometer_unit": "g"}, ""), (ipol("7-4"), {"accelerometer_unit": "mg"}, ""),
    (ipol("7-4"), {"gyroscope_unit": "deg/s"}, "the leg would sweep"),
    (xio(*NGIMU), {"gyroscope_unit": "rad/s"}, "the leg would sweep"),
])  # fmt: skip
def test_a_wrong_unit_is_refused(description: dict[str, Any], said: dict[str, str], reason: str) -> None:
    for report in reports(description, **said):
        assert not report.accepted and any(reason in one for one in report.reasons)


def push_offs(index: np.ndarray, rate: np.ndarray) -> np.ndarray:
    """Samples (s,) at which a foot turns fastest, from its turning speed (n,) at sample numbers (n,)."""
    grid = np.arange(index[0], index[-1] + 1)
    smooth = gaussian_filter1d(np.interp(grid, index, rate), 5)
    return grid[find_peaks(smooth, height=2.5, distance=60)[0]]


def recall_and_precision(found: np.ndarray, swings: np.ndarray) -> tuple[float, float]:
    """Share of the marked swings (m, 2) that begin within 0.15 s of one found, and of those found near a marked one."""
    near = np.abs(found[:, None] - swings[:, 0]) <= 15
    return float(near.any(axis=0).mean()), float(near.any(axis=1).mean())


@pytest.mark.parametrize(("name", "lossy"), [("8-5", True), ("3-3", True), ("7-4", False)])
@pytest.mark.parametrize("side", ["Left", "Right"])
def test_reading_by_packet_finds_swings_that_reading_by_row_misses(name: str, lossy: bool, side: str) -> None:
    """One plain detector on the same foot, its samples numbered by row or by our index, against marks by hand."""
    foot, swings = at(name, f"{side.lower()} foot"), marked(name, side)
    indexed = index_samples(foot)
    by_row = push_offs(np.arange(foot.rows), np.linalg.norm(foot.angular_rate, axis=1))
    turning = np.linalg.norm(indexed.recording.angular_rate, axis=1)
    by_packet = push_offs(indexed.index, turning) + indexed.recording.packet[0]
    naive, ours = recall_and_precision(by_row, swings), recall_and_precision(by_packet, swings)
    if lossy:
        assert ours[0] > naive[0] + 0.05 and ours[1] > naive[1] + 0.05
        assert min(ours) > 0.65
    else:
        assert ours == naive


#: Recall and precision of the shipped detector on each foot, of strikes that are marked by hand, within 0.15 s.
FOUND = {("8-5", "Left"): (0.69, 0.94), ("8-5", "Right"): (0.77, 0.84), ("3-3", "Left"): (0.81, 0.99),
         ("3-3", "Right"): (0.85, 0.99), ("7-4", "Left"): (0.99, 0.99), ("7-4", "Right"): (0.82, 0.99)}  # fmt: skip


@pytest.mark.parametrize(("name", "side"), FOUND)
def test_the_shipped_detector_finds_a_persons_heel_strikes(name: str, side: str) -> None:
    """The one that the ingest uses, on a foot whose mounting is declared; benchmarks/event_detectors.py compares it."""
    sensor, _ = sensed(name, f"{side.lower()} foot")
    assert sensor is not None
    strikes, _ = strikes_of({"foot": sensor}, SETTINGS)
    own = np.interp(strikes.time[strikes.leg == INNER], sensor.time, sensor.trace.indexed.recording.packet)
    apart = np.abs(own[:, None] - marked(name, side)[:, 1])
    recall, precision = np.mean(apart.min(axis=0) <= 15), np.mean(apart.min(axis=1) <= 15)
    assert (recall, precision) >= FOUND[name, side] and precision >= FOUND[name, side][1]
    assert np.median(apart.min(axis=1)) <= 7


@pytest.mark.parametrize("name", ["8-5", "3-3", "7-4"])
@pytest.mark.parametrize(("hip", "foot"), [("low back", "left foot"), ("left foot", "right foot"),
                                          ("right foot", "left foot")])  # fmt: skip
def test_a_persons_log_is_not_taken_for_the_robots(name: str, hip: str, foot: str) -> None:
    """A person's sensors are not on one rigid leg in a plane, whatever they are called."""
    experiment, recordings = recorded(name)
    renamed = {hip: "hip", foot: "foot"}
    chosen = tuple(
        dataclasses.replace(one, device=dataclasses.replace(one.device, place=renamed[one.device.place],
                                                            forward_axis=None, up_axis=None))
        for one in recordings if one.device.place in renamed
    )  # fmt: skip
    trial = next(read_trials(dataclasses.replace(experiment, slope_deg=0.0), chosen, PARAMETERS))
    assert trial.verdict.outcome == REFUSED
