"""One log written down in many ways gives one verdict and the same curves, within rounding of what is written."""

import dataclasses
import functools
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from stages.campaign.parameters import Parameters
from stages.campaign.twin_run import TwinRun
from stages.imu.judgement.verdict import ACCEPTED, REFUSED, WITH_REMARKS, Finding, Verdict
from stages.imu.sources.opening import SourceRefused
from stages.imu.sources.units import scale_of
from stages.imu.strikes.step_times import INNER
from stages.imu.trial.trial import Trial, read_trials
from tests.imu import wrong_logs
from tests.imu.conftest import RUNS
from tests.imu.damage import HARMFUL, NEVER_ACCEPTED, edited, flipped, overwritten_head, truncated
from tests.imu.made_logs import Log, TracedRecording, made_log, replaced, with_errors, wrong_quantities
from tests.imu.rewritings import REWRITINGS, differs, rewritten
from tests.imu.stand_in import PARAMETERS, make_database, make_run, result_of

QUICK = ("mg, mdps", "1000 s later", "clocks an hour apart", "decimal comma, exponents, quoted")


@pytest.fixture(scope="module")
def as_made(log: Log) -> Trial:
    return trial_of(log)


@pytest.mark.parametrize(
    "name", [one if one in QUICK else pytest.param(one, marks=pytest.mark.slow) for one in REWRITINGS])
def test_nothing_depends_on_how_a_log_is_written_down(name: str, log: Log, as_made: Trial, tmp_path: Path) -> None:
    """Stamps since 1970 are rounded to 2.4e-7 s, in which a strike's force changes by some 1e-4 of its size."""
    trial = rewritten(log, REWRITINGS[name], tmp_path, PARAMETERS)
    assert trial.verdict.findings == as_made.verdict.findings == ()
    assert differs(as_made, trial) < 3e-4


@pytest.mark.parametrize(("first", "last"), [pytest.param(0.5, 0.0, marks=pytest.mark.slow), (0.0, 0.15)])
def test_a_log_that_begins_late_or_ends_early_is_as_good(first: float, last: float, log: Log) -> None:
    """The still stand is longer than what is cut, and no step is needed."""
    at = [one.phone_stamp - log.recordings[0].phone_stamp.min() for one in log.recordings]
    end = min(one.max() for one in at)
    cut = tuple(one.take((t >= first) & (t <= end - last)) for one, t in zip(log.recordings, at))
    assert next(read_trials(log.experiment, cut, PARAMETERS)).verdict.findings == ()


@pytest.mark.parametrize(("place", "signal", "size", "after"), [
    ("hip", "acceleration", 1.0, 0.08), ("hip", "acceleration", 1.0, 0.12), ("hip", "acceleration", 10.0, 0.02),
    ("foot", "angular_rate", 0.5, 0.08),
])  # fmt: skip
def test_one_wrong_reading_changes_little(
    place: str, signal: str, size: float, after: float, log: Log, as_made: Trial
) -> None:
    """Of full scale or beyond, so long [s] after a strike: it was taken for another strike's blow, or for a turn."""

    def wrong(one: TracedRecording) -> TracedRecording:
        values, at = getattr(one, signal).copy(), log.strike_time[6] + after
        values[np.abs(one.true_time - at).argmin()] = size * 32767
        return replaced(one, **{signal: values})

    trial = trial_of(log.changed(place, wrong))
    found = size > 1.0 or signal == "angular_rate"
    assert trial.verdict.not_trusted == (f"{place} force",) * found
    np.testing.assert_allclose(trial.strikes.time, as_made.strikes.time, rtol=0, atol=5e-3)
    for of in ("step_frequency", "step_length"):
        assert getattr(trial.report(), of) == pytest.approx(getattr(as_made.report(), of), rel=0.02)


# --- Damaged logs: an answer or one clear sentence, never a traceback, never a wrong unit, never a changed source.


#: So many seeds are drawn by the quick test: two of each damage.
QUICK_SEEDS = 2 * len(HARMFUL)


@pytest.fixture(scope="module")
def sound() -> bytes:
    return make_database([make_run(1, steps=8, rest_s=1.5)])


def ingest(content: bytes, folder: Path) -> str:
    """What the ingest says; fails if it changes the source, warns, or says more than a sentence."""
    path = folder / "log.sqlite"
    path.write_bytes(content)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            said = result_of(path).summary()
    except SourceRefused as refusal:
        said = f"refused: {refusal}"
    assert path.read_bytes() == content
    assert sorted(child.name for child in folder.iterdir()) == ["log.sqlite"]
    assert said.isprintable() and len(said) < 500
    return said


@pytest.mark.parametrize("seeds", [range(QUICK_SEEDS), pytest.param(range(QUICK_SEEDS, 2210), marks=pytest.mark.slow)],
                         ids=["two of each", "two thousand"])  # fmt: skip
def test_a_damaged_log_gives_an_answer_or_one_sentence(seeds: range, sound: bytes, tmp_path: Path) -> None:
    for seed in seeds:
        rng = np.random.default_rng(seed)
        name = [*HARMFUL][seed % len(HARMFUL)]
        content = HARMFUL[name](sound, rng)
        if rng.random() < 0.2 and content.startswith(b"SQLite"):
            content = (truncated, flipped, overwritten_head)[rng.integers(3)](content, rng)
        try:
            ingest(content, tmp_path)
        except Exception as error:
            raise AssertionError(f"{name} with seed {seed}") from error


@pytest.mark.parametrize("damage", NEVER_ACCEPTED)
def test_wrong_units_and_swapped_sensors_are_refused(damage: str, sound: bytes, tmp_path: Path) -> None:
    assert ingest(NEVER_ACCEPTED[damage](sound, np.random.default_rng(0)), tmp_path).startswith("refused")


#: With a number of its own a row from another year reads as a life of the sensor before a restart.
STALE = "UPDATE sample SET packet = 60000, phone_stamp = 5, server_stamp = 5 WHERE sample_id = 10"


@pytest.mark.parametrize("change", [[], [STALE]], ids=["none", "a row from another year"])
def test_a_sound_log_is_accepted_and_a_stale_row_costs_no_run(change: list[str], sound: bytes, tmp_path: Path) -> None:
    assert ingest(edited(sound, *change), tmp_path).startswith("1 synthetic run,")


# --- Nothing wrong is accepted without a remark that names it, and nothing good is remarked on.


#: Of what is wrong the first run's log is read by the quick tests, those of the others by the slow ones.
NUMBERS = pytest.mark.parametrize("number", [0, *(pytest.param(one, marks=pytest.mark.slow) for one in range(1, RUNS))])
Judged = Callable[[str, int], tuple[Log, Trial]]
FAMILIES = {**wrong_logs.WRONG, **wrong_logs.LATER, **wrong_logs.CLOCKS, **wrong_logs.SILENT}


def trial_of(log: Log) -> Trial:
    return next(read_trials(log.experiment, log.recordings, PARAMETERS))


def remarks(trial: Trial) -> str:
    return "; ".join(trial.verdict.sentences(refused=False))


@pytest.fixture(scope="module")
def judged(parameters: Parameters, walks: list[TwinRun]) -> Judged:
    """A run's log made wrong, and what is read of it: one for all tests that look at it."""
    logs = [made_log(number, walk, parameters) for number, walk in enumerate(walks)]

    @functools.cache
    def done(family: str, number: int) -> tuple[Log, Trial]:
        log = FAMILIES[family](logs[number], walks, np.random.default_rng(number))
        return log, trial_of(log)

    return done


@pytest.mark.parametrize(
    ("number", "times"),
    [(0, 1.0), (1, 3.0)]
    + [pytest.param(*one, marks=pytest.mark.slow) for one in ((0, 3.0), (1, 1.0), (2, 1.0), (2, 3.0))],
)
def test_a_good_log_is_accepted_without_a_word(
    number: int, times: float, walks: list[TwinRun], parameters: Parameters
) -> None:
    log = made_log(number, walks[number], with_errors(parameters, times))
    trial = trial_of(log)
    assert trial.verdict.findings == ()
    assert trial.verdict.outcome == ACCEPTED
    assert wrong_quantities(log, trial) == {}, "and rightly so"


#: Like another one of them, but for one sensor instead of both, by more or less, or together with another.
LIKE_ANOTHER = {
    "forward_turned_at_one", "acceleration_turned_at_one", "foot_clock_1_s_off",
    "nothing_declared_and_gyroscope_columns_exchanged", "set_back", "set_twice", "no_counter_but_device_stamps",
    "foot_of_another_run_and_device_stamps_only", *wrong_logs.SILENT,
}  # fmt: skip


@NUMBERS
@pytest.mark.parametrize(
    "family", [pytest.param(one, marks=pytest.mark.slow) if one in LIKE_ANOTHER else one for one in FAMILIES])
def test_what_is_wrong_is_refused_or_named(family: str, number: int, judged: Judged) -> None:
    log, trial = judged(family, number)
    if trial.accepted:
        assert set(wrong_quantities(log, trial)) <= set(trial.verdict.not_trusted), trial.verdict.findings


#: What a family's refusal says, where nothing is named that is not to be trusted, or its remarks, and about what.
SAID: dict[str, tuple[str, set[str]]] = {
    "forward_turned": ("forward_axis points backward", set()),
    "walked_backward": ("forward_axis points backward", set()),
    "up_turned": ("from the declared mounting", set()),
    "acceleration_turned": ("from the declared mounting", set()),
    "gyroscopes_turned": ("turns against gravity", set()),
    "foot_gyroscope_turned": ("turns against gravity", set()),
    "foot_on_outer_leg": ("another leg", set()),
    "foot_of_another_run": ("logs of different runs", set()),
    "gyroscope_range_halved": ("times what gravity turns by", set()),
    "foot_gyroscope_range_halved": ("look at gyroscope_range_deg_s", set()),
    "sensors_swapped": ("hip and foot are swapped", set()),
    "slope_unknown": ("slope_deg is unknown", {"hip frame", "foot force"}),
    "slope_of_another_day": ("look at slope_deg", {"hip frame", "foot frame"}),
    "no_stamps": ("has no stamps", {"clock", "step frequency"}),
    "accelerometer_range_narrow": ("its full scale is there", {"foot force"}),
    "put_on": ("was set by", {"clock"}),
    "gyroscopes_10_percent_off": ("times what gravity turns by", {"hip rate", "foot rate", "step length"}),
    "one_axis_twice_as_strong": ("an axis of its accelerometer", {"lever arm"}),
    "slope_in_radians": ("seems to be in radians", {"hip frame", "foot frame"}),
    "smoothed_at_5_hz": ("noise of the foot at rest ends", {"hip force", "foot force", "step length"}),
    "averaged_over_3_rows": ("noise of the hip at rest ends", {"hip force", "foot force", "step length"}),
    "set_an_hour_on": ("was set by +3600", {"clock"}),
    "gyroscopes_30_ms_late": ("ms after the accelerometers", {"foot rate", "leg angle"}),
    "knocked": ("turned on its leg", {"leg angle"}),
    "device_stamps_only": ("is dated by its own clock", {"clock", "step frequency"}),
}


@pytest.mark.parametrize(("family", "said"), SAID.items(), ids=SAID)
def test_a_refusal_says_where_to_look_and_a_remark_what_is_not_to_be_trusted(
    family: str, said: tuple[str, set[str]], judged: Judged
) -> None:
    (words, about), (_, trial) = said, judged(family, 0)
    assert trial.verdict.outcome == (WITH_REMARKS if about else REFUSED)
    assert words in "; ".join(trial.verdict.sentences(refused=not about))
    assert about <= set(trial.verdict.not_trusted)


def test_a_robot_that_is_not_its_drawings_is_said_and_its_step_has_an_error_that_covers(log: Log) -> None:
    """The drawing's leg is a tenth shorter, and so is every step."""
    drawing = dataclasses.replace(PARAMETERS.drawing, leg_length=PARAMETERS.drawing.leg_length / 1.1)
    limits = dataclasses.replace(PARAMETERS.limits, lever_arm=PARAMETERS.limits.lever_arm / 1.1)
    parameters = dataclasses.replace(PARAMETERS, drawing=drawing, limits=limits)
    trial = next(read_trials(log.experiment, log.recordings, parameters))
    assert "times as high above the sole as it should be" in remarks(trial)
    report = trial.report()
    assert report.step_length_drawing_error / report.step_length == pytest.approx(0.1, abs=0.02)
    assert report.step_length_error > report.step_length_drawing_error


def test_what_follows_from_a_frame_is_not_trusted_where_it_is_not() -> None:
    """Exchanged columns of a gyroscope left 2 of 30 recordings with a wrong frame named, and its force not."""
    assert Verdict((Finding(False, ("foot frame",), ""),)).not_trusted == (
        "foot frame", "foot force", "leg angle", "step length")


def test_strikes_in_holes_are_not_trusted(log: Log) -> None:
    """A row or two are missing at each of the later strikes."""

    def lost(one: TracedRecording) -> TracedRecording:
        return one.take(np.abs(one.true_time[:, None] - log.strike_time[4:]).min(axis=1) > 0.008)

    trial = trial_of(log.changed("both", lost))
    assert "of the heel strikes lie in holes" in remarks(trial)
    assert {"heel strikes", "step frequency", "leg angle", "step length"} <= set(trial.verdict.not_trusted)


@pytest.mark.parametrize("mounting", [{}, {"forward_axis": None, "up_axis": None}], ids=["declared", "not declared"])
def test_a_swing_beyond_full_scale_is_said_to_be_that(mounting: dict[str, None], log: Log) -> None:
    """Without its swing a leg rolls back only: the gyroscope was said to be turned round, or the legs changed names."""

    def narrow(one: TracedRecording) -> TracedRecording:
        largest = 0.6 * np.abs(one.angular_rate).max()
        range_deg_s = largest * scale_of(one).angular_rate * 180 / np.pi
        return replaced(one, angular_rate=np.clip(one.angular_rate, -largest, largest),
                        device=dataclasses.replace(one.device, **mounting, gyroscope_unit="deg/s",
                                                   gyroscope_range_deg_s=range_deg_s))  # fmt: skip

    in_degrees = log.changed("both", lambda one: replaced(
        one, angular_rate=one.angular_rate * scale_of(one).angular_rate * 180 / np.pi,
        device=dataclasses.replace(one.device, gyroscope_unit="deg/s")))  # fmt: skip
    trial = trial_of(in_degrees.changed("both", narrow))
    assert trial.accepted and "samples are at full scale" in remarks(trial)
    np.testing.assert_array_equal(trial.strikes.leg, trial_of(log).strikes.leg)


def test_gravity_is_looked_at_while_both_sensors_record(log: Log) -> None:
    """The foot's sensor ended steps before the hip's: gravity was said to lie up to 9 degrees off."""
    end = log.strike_time[-3]
    trial = trial_of(log.changed("foot", lambda one: one.take(one.true_time < end)))
    assert max(abs(trial.evidence.hip_gravity_deg), abs(trial.evidence.foot_gravity_deg)) < 1.0


def test_a_rate_that_changed_within_the_recording_is_said(log: Log) -> None:
    """By the sensors' own stamps every second row is missing from then on; steps of 165 mm came out as 70 +- 2."""

    def slower(one: TracedRecording) -> TracedRecording:
        none = np.full(one.rows, np.nan)
        own = replaced(one, packet=none, position=none, phone_stamp=none, server_stamp=none)
        return own.take((own.true_time < 1.0) | (np.arange(own.rows) % 2 == 0))

    trial = trial_of(log.changed("both", slower))
    assert trial.verdict.outcome == REFUSED
    assert "come at a lower rate than the others" in trial.report().reason


def test_cells_without_a_number_end_no_still_stand(log: Log) -> None:
    """With an eighth of the rows without one no half second was whole, and no still stand was said to be there."""
    lacking = np.random.default_rng(8)

    def holed(one: TracedRecording) -> TracedRecording:
        rate = np.where(lacking.random((one.rows, 1)) < 0.12, np.nan, one.angular_rate.astype(float))
        return replaced(one, angular_rate=rate)

    trial, whole = trial_of(log.changed("both", holed)), trial_of(log)
    assert trial.accepted and trial.frequency[0] == pytest.approx(whole.frequency[0], abs=1e-3)


def test_a_walk_that_is_too_short_for_a_frequency_is_said_to_be_short(log: Log) -> None:
    """Three of its six strikes are left after the transient: it was said that no two steps are alike."""
    trial = trial_of(log.changed("both", lambda one: one.take(one.true_time < log.strike_time[6] - 0.05)))
    assert trial.report().reason.startswith("only 6 heel strikes, 7 are needed")


@pytest.mark.parametrize("seen", [2, 1])
def test_of_a_leg_two_strikes_place_those_in_holes_and_one_does_not(log: Log, seen: int) -> None:
    """Of two strikes steps were up to 7 ms off where 0.9 were stated, and of one 43 ms."""
    hidden = log.strike_time[log.strike_leg == INNER][seen:]

    def lost(one: TracedRecording) -> TracedRecording:
        return one.take(np.abs(one.true_time[:, None] - hidden).min(axis=1) > 0.02)

    trial, whole = trial_of(log.changed("both", lost)), trial_of(log)
    assert trial.accepted == (seen == 2)
    if seen == 1:
        assert "of one leg only 1 heel strikes are seen, 2 are needed" in trial.report().reason
        return
    times, usual = trial.leg.times, whole.leg.times
    assert times.step_error > 1.1 * usual.step_error
    assert abs(times.inner_step - usual.inner_step) < 1.96 * times.step_error
    assert len(trial.strikes.time) == len(log.strike_time)


@pytest.mark.parametrize(("others", "said"), [
    ([], "only the hip's sensor"), ([{"place": " Foot"}], ""),
    ([{"place": "knee"}], "the sensor at 'knee' is not used"),
    ([{"forward_axis": None, "up_axis": None}], "the foot's mounting is not declared"),
    ([{}, {}], "a second sensor at the foot is not used"),
])  # fmt: skip
def test_what_cannot_be_known_is_said(others: list[dict[str, object]], said: str, log: Log) -> None:
    """One sensor, a place that is only written otherwise, another one, no declared mounting, a second sensor."""
    hip, foot = log.recordings
    beside = [replaced(foot, device=dataclasses.replace(foot.device, **one)) for one in others]
    trial = trial_of(dataclasses.replace(log, recordings=(hip, *beside)))
    assert trial.verdict.outcome == (WITH_REMARKS if said else ACCEPTED) and said in remarks(trial)


@pytest.mark.parametrize("late", [-0.4, *(pytest.param(one, marks=pytest.mark.slow) for one in (0.4, 3600.0, -17.3))])
def test_clocks_any_time_apart_are_brought_together(late: float, log: Log) -> None:
    """Half a step is 0.24 s; two loggers that were started by hand are further apart."""
    near = trial_of(log)
    trial = trial_of(log.changed("foot", lambda one: replaced(one, phone_stamp=one.phone_stamp + late)))
    spacing = np.spacing(log.recordings[0].phone_stamp[0])  # of stamps since 1970: .24 microseconds
    assert trial.together.lag - late == pytest.approx(near.together.lag, abs=8 * spacing)
    assert trial.verdict == near.verdict and trial.overlap == pytest.approx(near.overlap, abs=1e-6)
    assert 0 < trial.together.lag_error < 3e-4


def test_what_cannot_be_one_walk_is_not_brought_together(judged: Judged) -> None:
    """Another run's foot, minutes away: no lag makes it turn as the hip does."""
    assert judged("foot_of_another_run", 0)[1].overlap == 0
