"""Errors of an ingested run against the truth of the stand-in."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stages.imu.events import HeelStrikes, step_frequency
from stages.imu.frames import angle_between
from stages.imu.result import Run
from stages.imu.sensor import filter_delay
from tests.imu.stand_in import SENSOR, SETTINGS, Truth


@dataclass(frozen=True)
class Score:
    clock_rms: float
    delay: float
    frame_deg: float
    recall: float
    precision: float
    strike_error: float
    strike_bias: float
    legs_right: bool
    frequency_error: float


def score(run: Run, truth: Truth) -> Score:
    clock, frame, delay = [], [], []
    for which, signals in enumerate((run.hip, run.foot)):
        if not len(signals.time):
            continue
        sent = truth.sent[which]
        row = dict(zip(zip(sent.packet, sent.position), sent.row))
        rows = [row[key] for key in zip(signals.packet.astype(int), signals.position.astype(int))]
        # The time of a signal is that of its sample less the delay of the low pass.
        error = signals.time + filter_delay(SENSOR.bandwidth_hz) - truth.readings[which].time[rows]
        clock.append(np.std(error))
        delay.append(np.mean(error))
        frame.append(angle_between(signals.rotation, truth.errors[which].rotation.T))
    true = truth.strikes + delay[0]
    error = run.heel_strike_time - true[np.abs(run.heel_strike_time[:, None] - true).argmin(axis=1)]
    legs = truth.legs[np.abs(run.heel_strike_time[:, None] - true).argmin(axis=1)]
    hit = np.abs(error) <= 0.010
    matched = len(set(np.abs(run.heel_strike_time[hit, None] - true).argmin(axis=1)))
    exact = step_frequency(HeelStrikes(truth.strikes[SETTINGS.skipped_steps :], truth.legs[SETTINGS.skipped_steps :]))
    return Score(
        clock_rms=max(clock),
        delay=delay[0],
        frame_deg=max(frame),
        recall=matched / len(true),
        precision=matched / len(error),
        strike_error=float(np.abs(error[hit]).max(initial=0)),
        strike_bias=float(np.mean(error[hit])),
        legs_right=bool((legs == run.heel_strike_leg)[hit].all()),
        frequency_error=run.report.step_frequency / exact.value - 1,
    )
