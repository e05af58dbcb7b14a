"""Steps per second from the times of heel strikes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stages.imu.strikes.landings import HeelStrikes


@dataclass(frozen=True)
class StepFrequency:
    """Steps per second [Hz] with its standard error [Hz] and the number of heel strikes behind it."""

    value: float
    standard_error: float
    strikes: int


def step_frequency(strikes: HeelStrikes) -> StepFrequency:
    """Frequency from a straight line through the strike times, with an offset of its own for each leg.

    Strikes are numbered by whole steps, so a strike that was missed does not count as a long step.
    """
    step = np.diff(strikes.time)
    if len(step) < 3 or not np.median(step) > 0:  # pulses of one and the same time are no walk
        return StepFrequency(float("nan"), float("nan"), len(strikes.time))
    number = np.append(0, np.cumsum(np.maximum(1, np.rint(step / np.median(step)))))
    columns = np.column_stack((np.ones(len(number)), number, strikes.leg))
    if len(set(strikes.leg.tolist())) == 1:
        columns = columns[:, :2]
    solution, _, _, _ = np.linalg.lstsq(columns, strikes.time, rcond=None)
    residual = strikes.time - columns @ solution
    variance = residual @ residual / max(1, len(number) - columns.shape[1])
    period_error = np.sqrt(variance * np.linalg.pinv(columns.T @ columns)[1, 1])
    return StepFrequency(1 / solution[1], float(period_error / solution[1] ** 2), len(number))
