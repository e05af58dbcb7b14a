"""Runs of the ingest as the calibration takes them: from the mid-stance after an early heel strike to the last one."""

from __future__ import annotations

import math

import numpy as np

from stages.calibration.estimation.first_guess import MidStanceOf
from stages.calibration.information.plan import SLOPE
from stages.calibration.observation.measured_run import MeasuredRun, usable
from stages.calibration.observation.prediction import Sampling
from stages.calibration.observation.unknowns import SIDES
from stages.calibration.parameters import Settings
from stages.imu.trial.body import FORWARD, LATERAL, UP, BodySensor
from stages.imu.trial.sensor import filter_delay
from stages.imu.trial.trial import Trial

#: The walk is followed from this heel strike on: the hand has let go before the first.
FROM = 1
#: Where the low pass of a sensor cuts off that does not say it, in its rates, before a fit looks for it.
USUAL_BANDWIDTH = 0.4
FEWEST_STRIKES = 4


def run_of(
    trial: Trial, mid_stance_of: MidStanceOf, settings: Settings, below_hip: float | None = None
) -> MeasuredRun | str:
    """A run of the ingest from its first mid-stance on; or why it cannot be used.

    The foot sensor sits `below_hip` [m]; where that is not known, at the foot's mass centre.
    """
    name = trial.experiment.name
    if not trial.accepted:
        why = next(one.sentence for one in trial.verdict.findings if one.refused)
        return f"{name}: turned down by the ingest: {why}"
    if len(trial.sensors) < 2:
        return f"{name}: has not both sensors"
    strikes = trial.strikes.time[FROM:]
    if len(strikes) < FEWEST_STRIKES:
        return f"{name}: has {len(trial.strikes.time)} heel strikes, {FEWEST_STRIKES + FROM} are needed"
    begin, end = float(strikes[0]), float(strikes[-1])
    first_leg = int(trial.strikes.leg[FROM])
    first = mid_stance_of(strikes - begin, first_leg) + settings.settling_s
    times, samples, used = {}, {}, {}
    for side in SIDES:
        sensor = trial.sensors[side]
        since = sensor.time - begin
        kept = (since >= first) & (sensor.time <= end)
        order = np.argsort(since[kept], kind="stable")
        values = np.column_stack([sensor.force[:, FORWARD], sensor.force[:, UP], sensor.rate[:, LATERAL]])[kept][order]
        times[side] = since[kept][order]
        mask = usable(times[side], strikes - begin, first, settings.before_strike_s, settings.after_strike_s)
        samples[side], used[side] = np.nan_to_num(values), mask[:, None] & np.isfinite(values)
    bandwidth = _bandwidth(trial.sensors["hip"])
    usual = USUAL_BANDWIDTH * trial.sensors["hip"].trace.rate_hz
    sampling = Sampling(times["hip"], times["foot"], filter_delay(bandwidth), bandwidth or usual, first_leg,
                        below_hip=below_hip, declared=bandwidth is not None)
    slope = trial.experiment.slope_deg
    own = {} if slope is None or math.isnan(slope) else {SLOPE: (slope, settings.slope_reading_sd_deg)}
    return MeasuredRun(name, sampling, samples, used, strikes - begin, own)


def _bandwidth(sensor: BodySensor) -> float | None:
    return sensor.trace.indexed.recording.device.bandwidth_hz
