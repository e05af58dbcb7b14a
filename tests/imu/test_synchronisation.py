"""Hip and foot are brought together by their stamps first, then by cross-correlation within half a step.

Where each is dated by its own clock, by their motion alone."""

import dataclasses
import functools
import math
import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from hypothesis.extra.numpy import arrays
from scipy.ndimage import gaussian_filter1d

from stages.imu.result import Result, RunReport
from stages.imu.sources.databases import SqliteSource
from stages.imu.strikes.heel_strikes import turns
from stages.imu.trial.agreement import (
    agreement,
    bland_altman,
    envelope_share,
    frequency_difference,
    intraclass_correlation,
    multiple_correlation,
    nrmse,
    rmse,
)
from stages.imu.trial.trial import read_trials
from stages.imu.trial.two_clocks import brought_together, whole_lag
from tests.imu.damage import edited
from tests.imu.stand_in import PARAMETERS, make_database, make_run, result_of


@functools.cache
def database() -> bytes:
    return make_database([make_run(4, steps=9, rest_s=1.5)])


def on_own_clocks(lag: float, drift: float, folder) -> RunReport:
    """The report of a run with the sensors' own stamps alone, the foot's late by `lag` [s] and slow by `drift`."""
    own = f"device_stamp = (device_stamp + {lag}) * {1 + drift}"
    nothing = "packet = NULL, position = NULL, phone_stamp = NULL, server_stamp = NULL"
    content = edited(database(), f"UPDATE sample SET {nothing}", f"UPDATE sample SET {own} WHERE device_id = 2")
    (folder / "log.sqlite").write_bytes(content)
    with SqliteSource(folder / "log.sqlite") as source:
        ((experiment, recordings),) = source.runs()
    return next(read_trials(experiment, recordings, PARAMETERS)).report()


@pytest.mark.parametrize(("lag", "drift"), [
    (0.0, 0.0), pytest.param(7.3, 0.0, marks=pytest.mark.slow), pytest.param(-1234.5, 1e-3, marks=pytest.mark.slow),
    (86_400.0, -2e-3),
])  # fmt: skip
def test_clocks_without_a_common_beginning(lag: float, drift: float, tmp_path) -> None:
    found = on_own_clocks(lag, drift, tmp_path)
    assert found.accepted, found.reason
    assert found.overlap > 0.98 and found.evidence.agreement > 0.9995
    assert abs(found.foot_lag) < 0.01, "what is left when they lie over each other"
    assert {"foot lag", "clock", "step frequency"} <= set(found.not_trusted)
    assert any("by their motion alone" in remark for remark in found.remarks)


@functools.cache
def ingested(lag: float) -> Result:
    """A run whose foot sensor's stamps are late by `lag` [s]: another phone, another clock."""
    stamps = ", ".join(f"{name} = {name} + {lag}" for name in ("phone_stamp", "server_stamp"))
    content = edited(database(), f"UPDATE sample SET {stamps} WHERE device_id = 2")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "log.sqlite"
        path.write_bytes(content)
        return result_of(path)


@pytest.mark.parametrize("lag", [-0.2, -0.043, 0.0, 0.043, 0.2])
def test_a_lag_of_the_foot_is_found_and_taken_out(lag: float) -> None:
    """Half a step is 0.24 s. The rest is what the radio's smallest delays differ by."""
    (found,), (alone,) = ingested(lag).runs, ingested(0.0).runs
    assert found.report.foot_lag == pytest.approx(lag, abs=3e-3)
    ahead = found.foot.time[0] - found.hip.time[0]
    assert ahead == pytest.approx(alone.foot.time[0] - alone.hip.time[0], abs=2e-3)
    assert found.report.evidence.lever_arm == pytest.approx(0.233, abs=0.01)


@pytest.mark.parametrize("place", ["hip", "foot"])
def test_a_hole_of_one_sensor_does_not_move_the_lag(place: str, tmp_path) -> None:
    """A line drawn through it is not what the leg did: that made half a millisecond of a hole of 0.7 s."""
    (tmp_path / "log.sqlite").write_bytes(database())
    with SqliteSource(tmp_path / "log.sqlite") as source:
        ((experiment, recordings),) = source.runs()
    sensors = next(read_trials(experiment, recordings, PARAMETERS)).sensors
    whole = sensors[place]
    there = np.abs(whole.time - whole.time[0] - 3.35) > 0.35
    holed = dataclasses.replace(whole, time=whole.time[there], force=whole.force[there], rate=whole.rate[there])
    alone, found = (brought_together(each, PARAMETERS.settings, PARAMETERS.limits)
                    for each in (sensors, {**sensors, place: holed}))
    assert found.lag == pytest.approx(alone.lag, abs=1e-4) and found.lag_error < 2 * alone.lag_error


def test_registered_foot_and_hip_turn_as_one() -> None:
    """They ride on one leg: their rates agree at every phase although the foot's clock is 43 ms late.

    Without the correlation they would be 43 ms apart, which at the swing's 20 rad/s^2 makes 0.5 rad/s.
    """
    result = ingested(0.043)
    hip, foot = (result.ensemble.mean[:, result.signals.index(f"{place}_lateral_rate")] for place in ("hip", "foot"))
    assert np.nanmax(np.abs(hip - foot)) < 0.15 * max(np.nanmax(np.abs(hip)), np.nanmax(np.abs(foot)))
    assert np.sqrt(np.nanmean((hip - foot) ** 2)) < 0.1


def test_tables_tell_the_reports_numbers_in_the_units_of_their_columns() -> None:
    result = ingested(0.043)
    sensor, run = result.reports[0], result.runs[0].report
    shown = {title.partition(" (")[0]: dict(zip(columns, rows[0], strict=False))
             for title, columns, rows in result.tables()}  # fmt: skip
    steps = run.times
    for table, heading, value, size in (
        ("Clocks", "rate Hz", sensor.rate_hz, 1e-3), ("Clocks", "jitter ms", 1e3 * sensor.jitter_before_s, 1e-2),
        ("Clocks", "error ms", 1e3 * sensor.clock_error_s, 1e-2), ("Sensors", "still s", sensor.rest_s, 1e-2),
        ("Runs", "foot lag ms", 1e3 * run.foot_lag, 1e-2), ("Runs", "step frequency Hz", run.step_frequency, 1e-4),
        ("Runs", "lever arm m", run.evidence.lever_arm, 1e-3),
        ("Legs, with standard errors", "step mm", 1e3 * run.step_length, 0.1),
        ("Legs, with standard errors", "inner step s", steps.inner_step, 1e-4),
        ("Legs, with standard errors", "double stance ms", 1e3 * steps.double_stance, 0.1),
        ("Legs, with standard errors", "asymmetry %", 100 * steps.asymmetry, 1e-2),
    ):  # fmt: skip
        if math.isnan(value):
            assert shown[table][heading] == "-"
        else:
            assert float(shown[table][heading]) == pytest.approx(value, abs=0.51 * size), heading


def walk(steps: int, rest: float) -> np.ndarray:
    """A rate at 200 Hz: rest, steps of 0.5 s that are all alike, rest."""
    time = np.arange(steps * 100) / 200
    moving = np.sin(2 * np.pi * time) + 0.4 * np.sin(4 * np.pi * time)
    return np.concatenate((np.zeros(round(200 * rest)), moving, np.zeros(round(200 * rest))))


@pytest.mark.parametrize(
    ("hip", "foot", "rows", "ambiguous"),
    [
        (slice(None), slice(None), 0, False),
        (slice(300, None), slice(None), -300, False),
        (slice(None), slice(150, 2000), 150, False),
        (slice(350, 1700), slice(None), -350, False),
        (slice(600, 2000), slice(900, 1900), 300, True),
    ],
    ids=["both", "hip later", "foot shorter", "hip shorter", "no rest in either"],
)
def test_the_whole_record_tells_the_lag(hip: slice, foot: slice, rows: int, ambiguous: bool) -> None:
    """What both saw of the stand tells one stride from the next; where neither did, it is said."""
    whole, rng = walk(24, 2.0), np.random.default_rng(1)
    a, b = (part + 0.02 * rng.normal(size=len(part)) for part in (whole[hip], whole[foot]))
    found, more = whole_lag(a, b, 1 / 200, (0.8, 4.0))
    assert (found - rows) % 200 in (0, 1, 199) if ambiguous else abs(found - rows) <= 1
    assert abs(more) % 200 in (0, 1, 199) and (more != 0) == ambiguous


@pytest.mark.parametrize("stood_s", [2.0, 60.0, 600.0])
def test_a_leg_that_stands_for_long_lands_nowhere_meanwhile(stood_s: float) -> None:
    """A logger that was started early holds more of the stand's noise than of the walk."""
    rate = walk(12, stood_s)
    rate += 0.01 * gaussian_filter1d(np.random.default_rng(2).normal(size=len(rate)), 3)
    rows = [row for row, _ in turns(rate, 0.5, 1 / 200)]
    assert 8 <= len(rows) <= 13
    assert min(rows) > 200 * stood_s - 10 and max(rows) < len(rate) - 200 * stood_s + 10


# --- Agreement metrics against an independent library, closed forms and their own limits.


#: Tables of so many targets and raters, drawn from a seed, and what Pingouin 0.7 finds for them.
TABLES = pytest.mark.parametrize(("targets", "raters", "seed", "found"), [
    (6, 2, 1, 0.7019369110023882), (20, 3, 2, 0.7524591012541919), (101, 5, 3, 0.8344651268472303),
])  # fmt: skip


def rated(targets: int, raters: int, seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return rng.normal(size=(targets, 1)) + 0.5 * rng.normal(size=raters) + 0.4 * rng.normal(size=(targets, raters))


@TABLES
def test_icc_is_what_pingouin_found(targets: int, raters: int, seed: int, found: float) -> None:
    assert intraclass_correlation(rated(targets, raters, seed)) == pytest.approx(found, abs=1e-9)


@pytest.mark.slow
@TABLES
def test_icc_is_that_of_pingouin(targets: int, raters: int, seed: int, found: float) -> None:
    import pandas as pd  # here: loading both takes two seconds of every process that collects tests
    import pingouin

    ratings = rated(targets, raters, seed)
    target, rater = np.indices(ratings.shape)
    table = pd.DataFrame({"target": target.ravel(), "rater": rater.ravel(), "rating": ratings.ravel()})
    oracle = pingouin.intraclass_corr(table, "target", "rater", "rating")
    single = float(oracle.loc[oracle["Type"].isin(["ICC(A,1)", "ICC2"]), "ICC"].iloc[0])
    assert intraclass_correlation(ratings) == pytest.approx(single, abs=1e-9)
    assert single == pytest.approx(found, abs=1e-9)


curves = arrays(float, 20, elements=st.floats(-100, 100))


@settings(max_examples=50)
@given(curves, st.floats(-50, 50))
def test_a_shifted_curve_has_the_shift_as_rmse_and_bias(curve: np.ndarray, shift: float) -> None:
    assert rmse(curve + shift, curve) == pytest.approx(abs(shift), abs=1e-9)
    bias, lower, upper = bland_altman(curve + shift, curve)
    assert (bias, upper - lower) == pytest.approx((shift, 0), abs=1e-9)


def test_a_correlation_of_equal_waveforms_is_one_and_of_opposite_ones_undefined() -> None:
    wave = np.sin(np.linspace(0, 2 * np.pi, 50))
    assert multiple_correlation(np.stack([wave, wave, wave])) == pytest.approx(1)
    assert all(math.isnan(multiple_correlation(np.stack(both))) for both in ([wave, -wave], [0 * wave, 0 * wave]))
    found = agreement(-wave, wave, wave - 0.1, wave + 0.1)
    assert not found.correlation_defined and math.isnan(found.correlation)
    assert math.isnan(nrmse(np.ones(5), np.zeros(5))), "a flat measurement has no normalised error"


def test_envelope_share_counts_phases_inside() -> None:
    lower, upper, curve = np.zeros(10), np.ones(10), np.linspace(-0.45, 1.35, 10)
    half = np.where(np.arange(10) < 5, np.nan, upper)
    assert envelope_share(curve, lower, upper) == pytest.approx(np.mean((curve >= 0) & (curve <= 1)))
    assert envelope_share(np.full(10, 0.5), lower, half) == 1
    assert math.isnan(envelope_share(curve, lower, np.full(10, np.nan)))


def test_confidence_interval_covers_the_truth_as_often_as_it_says() -> None:
    rng = np.random.default_rng(5)
    found = [frequency_difference(rng.normal(2.05, 0.02, 30), 2.08) for _ in range(2000)]
    covered = np.mean([one.lower <= -0.03 <= one.upper for one in found])
    assert covered == pytest.approx(0.95, abs=0.015)
