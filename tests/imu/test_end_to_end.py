"""The whole ingest, blind, against the truth of stand-in runs, and recordings that go on."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pipeline.study import locate
from stages.campaign.parameters import SensorSettings
from stages.campaign.result import Result as Campaign, RunTruth
from stages.comparison.ingest_score import IngestScore, score_ingest
from stages.imu.judgement.verdict import REFUSED
from stages.imu.parameters import filter_delay
from stages.imu.result import Result
from stages.imu.run import frequency_of, trials
from stages.imu.sources.cells import recording_from_columns
from stages.imu.sources.databases import SqliteSource
from stages.imu.sources.schema import Experiment, Recording
from stages.imu.sources.units import implied_acceleration_unit, scale_of
from stages.imu.trial.body import BodySensor
from stages.imu.trial.trial import Trial, read_trials
from stages.imu.trial.walk import strikes_of
from tests.imu.made_logs import Log, TracedRecording
from tests.imu.stand_in import (
    CAMPAIGN,
    PARAMETERS,
    RADIO,
    REBOUND_S,
    ROUGH_RADIO,
    SETTINGS,
    device,
    make_database,
    make_run,
    result_of,
)
from tests.study import ROOT

#: Runs of a database, more of them in the slow tests, over the usual radio and over one that loses 5 % and stalls 10 %.
FEW, MANY = 3, 6
LOGS = [pytest.param((radio, runs), id=f"{name}, {runs} runs", marks=[pytest.mark.slow] if runs == MANY else [])
        for runs in (FEW, MANY) for name, radio in (("usual radio", RADIO), ("rough radio", ROUGH_RADIO))]  # fmt: skip


@pytest.fixture(scope="module", params=LOGS)
def ingested(request, tmp_path_factory) -> tuple[Result, tuple[RunTruth, ...]]:
    radio, count = request.param
    runs = [make_run(seed, radio) for seed in range(count)]
    path: Path = tmp_path_factory.mktemp("log") / "measurements.sqlite"
    path.write_bytes(make_database(runs))
    return result_of(path), tuple(truth for _, truth, _ in runs)


def scored(result: Result, *truth: RunTruth) -> IngestScore | None:
    return score_ingest(Campaign("synthetic", truth, (), (), {}), result, SETTINGS.skipped_steps, SETTINGS.gravity)


@pytest.fixture(scope="module")
def scores(ingested) -> IngestScore:
    result, truth = ingested
    found = scored(result, *truth)
    assert found is not None
    return found


def test_every_run_is_used_and_said_to_be_synthetic(ingested) -> None:
    result, truth = ingested
    assert len(result.runs) == len(truth) >= FEW
    assert (result.rejected, result.origin) == ((), "synthetic")
    assert all(report.accepted for report in result.reports)
    assert all("synthetic" in words for words in (result.summary(), *(title for title, _, _ in result.tables())))
    for _, columns, rows in result.tables():
        assert rows and {len(row) for row in rows} == {len(columns)}


def test_a_run_in_which_a_leg_lands_twice_has_no_part_in_the_mean_frequency(ingested) -> None:
    """A leg that bounces does: such runs were 30 % faster, and the mean with them."""
    runs = list(ingested[0].runs)
    report = dataclasses.replace(
        runs[0].report, step_frequency=9.0, evidence=dataclasses.replace(runs[0].report.evidence, spacing=0.97))
    twice = dataclasses.replace(runs[0], report=report)
    assert frequency_of([twice, *runs[1:]]) == frequency_of(runs[1:])
    assert frequency_of([twice])[0] == 9.0, "there is no other"
    assert "not to be trusted" in dataclasses.replace(ingested[0], runs=(twice,)).summary()
    assert "not to be trusted" not in ingested[0].summary()


def test_clocks_frames_strikes_and_frequency_are_as_near_as_was_asked(scores: IngestScore) -> None:
    """The clock after its constant delay."""
    assert np.sqrt(np.mean(scores.clock_error**2)) <= 1e-3
    assert max(scores.frame_angle) <= 0.5
    assert min(np.mean(scores.recall), np.mean(scores.precision)) >= 0.99
    assert all(scores.legs_right)
    assert np.abs(scores.frequency_error).max() <= 1e-3


@pytest.mark.parametrize("rate_hz", [100.0, 400.0])
def test_strikes_whose_blows_are_beyond_full_scale_are_as_near_as_others(tmp_path, rate_hz: float) -> None:
    """As those of rigid legs: they counted as hidden, and were up to 54 ms off. They rebound, and where both blows clip
    the second may look larger: half of all strikes were 60 ms late."""
    sensor = dataclasses.replace(CAMPAIGN.given_sensor, rate_hz=rate_hz, bandwidth_hz=0.4 * rate_hz)
    runs = [make_run(seed, blow=0.5, sensor=sensor) for seed in range(FEW)]
    (tmp_path / "log.sqlite").write_bytes(make_database(runs, sensor))
    result = result_of(tmp_path / "log.sqlite")
    found = scored(result, *(truth for _, truth, _ in runs))
    assert found is not None and found.recall.tolist() == [1.0] * FEW and found.strike_error.max() < 4e-3
    assert min(report.clipped_acceleration for report in result.reports if report.place == "hip") > 2


def hip_of(path: Path, run, sensor: SensorSettings) -> tuple[BodySensor, np.ndarray]:
    """The hip's sensor in a run, and the heel strikes [s]."""
    path.write_bytes(make_database([run], sensor))
    with SqliteSource(path) as source:
        trial = next(trials(source.runs(), PARAMETERS))
    return trial.sensors["hip"], trial.strikes.time


def reading(sensor: BodySensor, counts: np.ndarray) -> BodySensor:
    """The sensor with other readings of force."""
    recording = dataclasses.replace(sensor.trace.indexed.recording, acceleration=counts)
    indexed = dataclasses.replace(sensor.trace.indexed, recording=recording)
    return dataclasses.replace(sensor, trace=dataclasses.replace(sensor.trace, indexed=indexed))


def test_a_blow_in_one_sample_of_a_fast_sensor_is_a_strike(tmp_path) -> None:
    """At 400 Hz, with a rebound 60 ms later that fills three samples: between the points of a coarser grid such a blow
    was lost, and a strike 33 ms off."""
    sensor = dataclasses.replace(CAMPAIGN.given_sensor, rate_hz=400.0, bandwidth_hz=160.0)
    hip, usual = hip_of(tmp_path / "log.sqlite", make_run(0, sensor=sensor), sensor)
    counts = hip.trace.indexed.recording.acceleration.copy()
    for row in (np.searchsorted(hip.time, usual), *np.searchsorted(hip.time, usual + REBOUND_S) + [[0], [1], [2]]):
        counts[row] += 12000.0
    found, _ = strikes_of({"hip": reading(hip, counts)}, SETTINGS)
    assert np.abs(found.time - usual).max() < 0.01


def test_a_rebound_is_no_strike_where_the_blow_is_in_a_hole(tmp_path) -> None:
    hip, usual = hip_of(tmp_path / "log.sqlite", make_run(0, blow=0.5), CAMPAIGN.given_sensor)
    lost = np.abs(hip.time - usual[6]) < 0.025
    counts = np.where(lost[:, None], np.nan, hip.trace.indexed.recording.acceleration)
    found, _ = strikes_of({"hip": reading(hip, counts)}, SETTINGS)
    assert np.abs(found.time - usual).max() < 0.01


def test_the_score_sees_what_is_wrong(ingested, scores: IngestScore) -> None:
    """Each measure moves when the truth is moved by as much."""
    result, (first, *others) = ingested
    turned = dataclasses.replace(first.hip, rotation=Rotation.from_rotvec([0, 0, 0.1]).as_matrix() @ first.hip.rotation)
    stretched = dataclasses.replace(first.foot, sample_time=first.foot.sample_time * 1.01)
    late = first.heel_strike_time + 0.03 * (np.arange(len(first.heel_strike_time)) % 4 == 1)
    wrong = dataclasses.replace(first, hip=turned, foot=stretched, heel_strike_time=late * 1.001)
    after = scored(result, wrong, *others)
    assert after is not None
    assert after.frame_angle[0] == pytest.approx(np.degrees(0.1), abs=0.5)
    assert after.clock_error[0] > 0.02
    assert after.recall[0] == pytest.approx(scores.recall[0] - 3 / 12)
    assert after.frequency_error[0] > scores.frequency_error[0] + 5e-4
    assert after.frame_angle[1:].tolist() == scores.frame_angle[1:].tolist()
    assert after.leg.angle[0] == pytest.approx(scores.leg.angle[0], abs=1e-3)
    assert scored(result, dataclasses.replace(first, name="another"), *others) is None


def test_the_legs_score_sees_what_is_wrong(ingested, scores: IngestScore) -> None:
    """Steps, angle and times of the first run are off by what its truth is changed by."""
    result, (first, *others) = ingested
    leg = dataclasses.replace(
        first.leg, hip_at_strike=1.02 * first.leg.hip_at_strike, angle=first.leg.angle + 0.05,
        toe_off_time=first.leg.toe_off_time + 0.004,
    )  # fmt: skip
    after = scored(result, dataclasses.replace(first, leg=leg), *others)
    assert after is not None
    before, after_leg = scores.leg, after.leg
    mine = before.step_run == 0
    assert np.abs(before.step).max() < 0.03 and mine.sum() >= 3
    assert (after_leg.step - before.step)[mine] == pytest.approx(-0.02, abs=1e-3)
    assert (after_leg.step == before.step)[~mine].all()
    assert after_leg.angle[0] == pytest.approx(0.05, abs=5e-3) and before.angle[0] < 5e-3
    shift = (after_leg.times - before.times)[0]
    known = np.isfinite(shift)
    assert shift[known] == pytest.approx(np.array([0.0, -0.004, -0.004, 0.004, -0.004])[known], abs=1e-9)
    assert known[0] and {name: held for name, _, _, held in before.rows()}["step length %"] > 0.8


def test_registered_strides_are_the_motion(ingested) -> None:
    """At phase 0 and 1 the inner leg lands; in between it stands for about half the stride, turning backward."""
    result, _ = ingested
    mean, lower, upper = result.ensemble.mean, result.ensemble.lower, result.ensemble.upper
    rate, up = (mean[:, result.signals.index(name)] for name in ("hip_lateral_rate", "hip_up_force"))
    assert (rate[10:40] < 0).all() and (rate[60:90] > 0).all()
    assert np.nanmean(up) == pytest.approx(9.81, abs=0.5)
    inside = np.isfinite(mean)
    assert (lower[inside] <= mean[inside] + 1e-12).all() and (mean[inside] <= upper[inside] + 1e-12).all()


def test_same_database_same_bits(tmp_path: Path) -> None:
    path = tmp_path / "again.sqlite"
    path.write_bytes(make_database([make_run(3)]))
    first, second = (result_of(path) for _ in range(2))
    assert first.ensemble.mean.tobytes() == second.ensemble.mean.tobytes()
    assert first.step_frequency == second.step_frequency


# --- What is null in imu.yaml and campaign.yaml follows the robot: Table 1's to the bit, others' by their own time.


SENSOR = ("rate_hz", "bandwidth_hz", "accelerometer_range_g", "gyroscope_range_deg_s")


def values(*settings):
    found = locate(start=ROOT, settings=settings).parameters(("campaign", "imu", "calibration"))
    sensor, read = found["campaign"].sensor, found["imu"]
    assert found["calibration"].sensor == sensor and found["calibration"].ingest == read
    return ([getattr(sensor, name) for name in SENSOR], found["campaign"].push_s,
            [read.settings.gravity, read.settings.grid_rate_hz, read.settings.slowest_step_hz,
             read.settings.fastest_step_hz, read.settings.rest_rate_deg_s, read.settings.rest_acceleration],
            [read.limits.lever_arm, read.drawing.leg_length, read.drawing.foot_radius])  # fmt: skip


LONGER = ("biped.leg_length=1.332", "biped.foot_radius=0.332", "biped.foot_com=0.4", "biped.foot_mass=1.34")
#: What is set, and by it rate, cut-off and ranges of a sensor, push, windows and drawing; None: whatever it is.
FOLLOWING = {
    "Table 1": ((), [100.0, 40.0, 4.0, 2000.0], 0.4, [9.81, 200.0, 0.8, 4.0, 3.0, 0.3], [0.233, 0.335, 0.085]),
    # four times as long takes twice as long; the outsole is part of the robot
    "longer": (LONGER, [50.0, 20.0, 4.0, 1000.0], 0.8, [9.81, 100.0, 0.4, 2.0, 1.5, 0.3], [0.932, 1.34, 0.34]),
    "lighter": (("ground.gravity=2.4525",), [50.0, 20.0, 1.0, 1000.0], None,
                [2.4525, None, None, None, None, 0.075], [None] * 3),
    "given": (("ground.gravity=1.62", "campaign.rate_hz=200", "campaign.accelerometer_range_g=8", "campaign.push_s=0.3",
               "imu.gravity=9.81", "imu.lever_arm=0.2"),
              [200.0, 80.0, 8.0, None], 0.3, [9.81, *[None] * 5], [0.2, None, None]),
}  # fmt: skip


@pytest.mark.parametrize("robot", FOLLOWING)
def test_what_is_null_follows_the_robot_and_what_a_file_gives_stays(robot):
    settings, *expected = FOLLOWING[robot]
    for found, want in zip(np.hstack(values(*settings)), np.hstack(expected), strict=True):
        assert want is None or found == (want if not settings else pytest.approx(want, rel=1e-14))


@pytest.mark.parametrize(("settings", "outsole"), [
    ((), (2e-3, 2e-4, 1e-4)), (("biped.leg_length=0.4902", "biped.foot_mass=0.0335"), (2e-4, 2e-5, None))])
def test_rubber_weighs_no_larger_share_of_a_light_leg(settings, outsole):
    runs = locate(start=ROOT, settings=settings).parameters(("campaign",))["campaign"]
    own = runs.runs.of(runs.biped)
    assert (own.outsole, own.outsole_sd) == pytest.approx(outsole[:2], rel=1e-14)
    assert outsole[2] in (None, own.length_sd)


def test_so_do_the_calibration_and_the_ladder():
    names = ("settling_s", "before_strike_s", "after_strike_s", "foot_lag_sd_s", "mid_stance_sd_s", "begun_s",
             "start_length_sd", "start_length_rate_sd")  # fmt: skip

    def of(*settings):
        found = locate(start=ROOT, settings=settings).parameters(("calibration", "calibrated_twin", "twin_ladder"))
        assert found["calibrated_twin"].settings == found["calibration"].settings
        return [getattr(found["calibration"].settings, name) for name in names], found["twin_ladder"].settings.outsole

    delay = filter_delay(40.0)
    assert of() == ([0.05, 0.01 + delay, 0.03, 0.002, 0.06, 0.15, 1e-3, 0.02], 2e-3)
    times, outsole = of("biped.leg_length=1.332", "biped.foot_radius=0.332", "biped.foot_com=0.4",
                        "biped.foot_mass=21.44", "calibration.begun_s=0.2")
    assert times == pytest.approx([0.1, 0.02 + 2 * delay, 0.06, 0.004, 0.12, 0.2, 4e-3, 0.04], rel=1e-14)
    assert outsole == pytest.approx(8e-3, rel=1e-14)


@pytest.mark.parametrize("gravity", [1.62, 9.81, 15.0])
def test_a_reading_at_rest_is_gravity_where_the_robot_walks(gravity):
    """Counts of a full scale that is no usual one, off by a gain's error."""
    sensor = dataclasses.replace(device("hip"), accelerometer_range_g=4.0 * gravity / 9.81)
    counts = 1.02 * gravity / 9.80665 * 2**15 / sensor.accelerometer_range_g
    said = f"counts of {sensor.accelerometer_range_g:g} g full scale"
    assert implied_acceleration_unit(counts, sensor, gravity) == said


# --- A recording that goes on: hands that carry the robot back, stands in another pose, and more walks than one.


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
