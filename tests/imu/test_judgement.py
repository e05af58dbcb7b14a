"""Nothing wrong is accepted without a remark that names it, and nothing good is remarked on."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable

import numpy as np
import pytest

from stages.campaign.parameters import Parameters
from stages.campaign.twin_run import TwinRun
from stages.imu.judgement.verdict import ACCEPTED, REFUSED, WITH_REMARKS
from stages.imu.trial.trial import Trial, read_trial
from tests.imu import wrong_logs
from tests.imu.log_truth import wrong_quantities
from tests.imu.made_logs import Log, TracedRecording, made_log, replaced, with_errors
from tests.imu.made_walks import campaign_parameters, stand_in_walks
from tests.imu.stand_in import PARAMETERS

RUNS = 3
#: Of what is wrong the first run's log is read by the quick tests, those of the others by the slow ones.
NUMBERS = pytest.mark.parametrize("number", [0, *(pytest.param(one, marks=pytest.mark.slow) for one in range(1, RUNS))])
Judged = Callable[[wrong_logs.Family, int], tuple[Log, Trial]]


@pytest.fixture(scope="module")
def parameters() -> Parameters:
    return campaign_parameters()


@pytest.fixture(scope="module")
def walks(parameters: Parameters) -> list[TwinRun]:
    return stand_in_walks(RUNS, parameters)


def trial_of(log: Log) -> Trial:
    return read_trial(log.experiment, log.recordings, PARAMETERS)


@pytest.fixture(scope="module")
def judged(parameters: Parameters, walks: list[TwinRun]) -> Judged:
    """A run's log made wrong, and what is read of it: one for all tests that look at it."""
    logs = [made_log(number, walk, parameters) for number, walk in enumerate(walks)]

    @functools.cache
    def done(family: wrong_logs.Family, number: int) -> tuple[Log, Trial]:
        log = family(logs[number], walks, np.random.default_rng(number))
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


FAMILIES = (*wrong_logs.WRONG, *wrong_logs.LATER, *wrong_logs.CLOCKS, *wrong_logs.SILENT)
#: Like another one of them, but for one sensor instead of both, by more or less, or together with another.
LIKE_ANOTHER = (
    wrong_logs.forward_turned_at_one, wrong_logs.acceleration_turned_at_one, wrong_logs.foot_clock_1_s_off,
    wrong_logs.nothing_declared_and_gyroscope_columns_exchanged, wrong_logs.set_back, wrong_logs.set_twice,
    wrong_logs.no_counter_but_device_stamps, wrong_logs.foot_of_another_run_and_device_stamps_only,
    *wrong_logs.SILENT,
)  # fmt: skip


@NUMBERS
@pytest.mark.parametrize(
    "family",
    [pytest.param(one, marks=pytest.mark.slow) if one in LIKE_ANOTHER else one for one in FAMILIES],
    ids=lambda family: family.__name__,
)
def test_what_is_wrong_is_refused_or_named(family: wrong_logs.Family, number: int, judged: Judged) -> None:
    log, trial = judged(family, number)
    if trial.accepted:
        assert set(wrong_quantities(log, trial)) <= set(trial.verdict.not_trusted), trial.verdict.findings


@pytest.mark.parametrize(
    ("family", "words"),
    [
        (wrong_logs.forward_turned, "forward_axis points backward"),
        (wrong_logs.walked_backward, "forward_axis points backward"),
        (wrong_logs.up_turned, "from the declared mounting"),
        (wrong_logs.acceleration_turned, "from the declared mounting"),
        (wrong_logs.gyroscopes_turned, "turns against gravity"),
        (wrong_logs.foot_gyroscope_turned, "turns against gravity"),
        (wrong_logs.foot_on_outer_leg, "another leg"),
        (wrong_logs.foot_of_another_run, "logs of different runs"),
        (wrong_logs.gyroscope_range_halved, "times what gravity turns by"),
        (wrong_logs.foot_gyroscope_range_halved, "look at gyroscope_range_deg_s"),
        (wrong_logs.sensors_swapped, "hip and foot are swapped"),
    ],
    ids=lambda one: getattr(one, "__name__", ""),
)
def test_a_refusal_says_where_to_look(family: wrong_logs.Family, words: str, judged: Judged) -> None:
    _, trial = judged(family, 0)
    assert trial.verdict.outcome == REFUSED
    assert words in "; ".join(trial.verdict.sentences(refused=True))


@pytest.mark.parametrize(
    ("family", "words", "about"),
    [
        (wrong_logs.slope_unknown, "slope_deg is unknown", {"hip frame", "foot force"}),
        (wrong_logs.slope_of_another_day, "look at slope_deg", {"hip frame", "foot frame"}),
        (wrong_logs.no_stamps, "has no stamps", {"clock", "step frequency"}),
        (wrong_logs.accelerometer_range_narrow, "its full scale is there", {"foot force"}),
        (wrong_logs.put_on, "was set by", {"clock"}),
        (wrong_logs.gyroscopes_10_percent_off, "times what gravity turns by", {"hip rate", "foot rate", "step length"}),
        (wrong_logs.one_axis_twice_as_strong, "an axis of its accelerometer", {"lever arm"}),
        (wrong_logs.slope_in_radians, "seems to be in radians", {"hip frame", "foot frame"}),
        (wrong_logs.smoothed_at_5_hz, "noise of the foot at rest ends", {"hip force", "foot force", "step length"}),
        (wrong_logs.averaged_over_3_rows, "noise of the hip at rest ends", {"hip force", "foot force", "step length"}),
        (wrong_logs.set_an_hour_on, "was set by +3600", {"clock"}),
        (wrong_logs.gyroscopes_30_ms_late, "ms after the accelerometers", {"foot rate", "leg angle"}),
        (wrong_logs.knocked, "turned on its leg", {"leg angle"}),
        (wrong_logs.device_stamps_only, "is dated by its own clock", {"clock", "step frequency"}),
    ],
    ids=lambda one: getattr(one, "__name__", ""),
)
def test_a_remark_names_what_is_not_to_be_trusted(
    family: wrong_logs.Family, words: str, about: set[str], judged: Judged
) -> None:
    _, trial = judged(family, 0)
    assert trial.verdict.outcome == WITH_REMARKS
    assert words in "; ".join(trial.verdict.sentences(refused=False))
    assert about <= set(trial.verdict.not_trusted)


def test_a_robot_that_is_not_its_drawings_is_said_and_its_step_has_an_error_that_covers(
    walks: list[TwinRun], parameters: Parameters
) -> None:
    """The drawing's leg is a tenth shorter, and so is every step."""
    drawing = dataclasses.replace(PARAMETERS.drawing, leg_length=PARAMETERS.drawing.leg_length / 1.1)
    limits = dataclasses.replace(PARAMETERS.limits, lever_arm=PARAMETERS.limits.lever_arm / 1.1)
    log = made_log(0, walks[0], parameters)
    trial = read_trial(log.experiment, log.recordings, dataclasses.replace(PARAMETERS, drawing=drawing, limits=limits))
    assert "times as long as by the drawing" in "; ".join(trial.verdict.sentences(refused=False))
    report = trial.report()
    assert report.step_length_drawing_error / report.step_length == pytest.approx(0.1, abs=0.02)
    assert report.step_length_error > report.step_length_drawing_error


def test_strikes_in_holes_are_not_trusted(walks: list[TwinRun], parameters: Parameters) -> None:
    """A row or two are missing at each of the later strikes."""

    def lost(one: TracedRecording) -> TracedRecording:
        kept = one.take(np.abs(one.true_time[:, None] - walks[0].heel_strike_time[4:]).min(axis=1) > 0.008)
        assert isinstance(kept, TracedRecording)
        return kept

    trial = trial_of(made_log(0, walks[0], parameters).changed("both", lost))
    assert "of the heel strikes lie in holes" in "; ".join(trial.verdict.sentences(refused=False))
    assert {"heel strikes", "step frequency", "step length"} <= set(trial.verdict.not_trusted)


def test_what_cannot_be_known_is_said(walks: list[TwinRun], parameters: Parameters) -> None:
    """One sensor, another place, a second sensor at a place, no declared mounting."""
    log = made_log(0, walks[0], parameters)
    hip, foot = log.recordings

    def said(*recordings: object) -> str:
        trial = trial_of(dataclasses.replace(log, recordings=recordings))
        assert trial.verdict.outcome == WITH_REMARKS
        return "; ".join(trial.verdict.sentences(refused=False))

    assert "only the hip's sensor" in said(hip)
    shouting = replaced(foot, device=dataclasses.replace(foot.device, place=" Foot"))
    assert trial_of(dataclasses.replace(log, recordings=(hip, shouting))).verdict.outcome == ACCEPTED
    knee = replaced(foot, device=dataclasses.replace(foot.device, place="knee"))
    assert "the sensor at 'knee' is not used" in said(hip, knee)
    assert "a second sensor at the foot is not used" in said(hip, foot, foot)
    bare = dataclasses.replace(foot.device, forward_axis=None, up_axis=None)
    assert "the foot's mounting is not declared" in said(hip, replaced(foot, device=bare))


@pytest.mark.parametrize("late", [-0.4, *(pytest.param(one, marks=pytest.mark.slow) for one in (0.4, 3600.0, -17.3))])
def test_clocks_any_time_apart_are_brought_together(late: float, walks: list[TwinRun], parameters: Parameters) -> None:
    """Half a step is 0.24 s; two loggers that were started by hand are further apart."""
    log = made_log(0, walks[0], parameters)
    near = trial_of(log)
    trial = trial_of(log.changed("foot", lambda one: replaced(one, phone_stamp=one.phone_stamp + late)))
    assert trial.foot_lag - late == pytest.approx(near.foot_lag, abs=1e-6)
    assert trial.verdict == near.verdict and trial.overlap == pytest.approx(near.overlap, abs=1e-6)
    assert 0 < trial.foot_lag_error < 3e-4


def test_what_cannot_be_one_walk_is_not_brought_together(walks: list[TwinRun], parameters: Parameters) -> None:
    """Another run's foot, minutes away: no lag makes it turn as the hip does."""
    log = wrong_logs.foot_of_another_run(made_log(0, walks[0], parameters), walks, np.random.default_rng(0))
    trial = trial_of(log)
    assert trial.verdict.outcome == REFUSED and trial.overlap == 0
