"""Step by step: how the twin settles from the simple model's fixed point."""

from __future__ import annotations

from dataclasses import dataclass
from math import nan

import numpy as np

from stages.biped.quantity import quantity
from stages.biped.walk import Walk
from stages.twin.walking.record import Record

#: Steps at the end of a walk over which the settled gait is averaged: two strides.
SETTLED_STEPS = 4
#: A step has settled when its period and its length are this close to the settled gait's.
SETTLED_WITHIN = 0.01


@dataclass(frozen=True)
class Settling:
    """Measures of each step, from heel strike to heel strike, and of the settled gait; NaN if the walk is too short."""

    step_period: np.ndarray = quantity("s", "duration of each step, shape (s - 1,)", symbol="T", dimensions=("step",))
    step_length: np.ndarray = quantity(
        "m", "advance of the hip in each step, shape (s - 1,)", symbol="s", dimensions=("step",)
    )
    steps_to_settle: int = quantity("1", "steps until period and length stay within 1% of the settled gait; -1: never")
    period_s: float = quantity("s", "settled duration of a step", symbol="T", default=nan)
    step_frequency_hz: float = quantity("Hz", "settled steps per second", symbol="f", default=nan)
    step_length_m: float = quantity("m", "settled advance of the hip in a step", symbol="s", default=nan)
    speed_m_s: float = quantity("m/s", "settled mean speed", symbol="v", default=nan)
    double_stance_s: float = quantity(
        "s", "settled time with both pairs on the ground in a step", symbol="t_DSP", default=nan
    )
    inner_outer_difference: float = quantity(
        "1", "limp: settled duration of inner pair's less outer pair's stance step, over the mean", default=nan
    )
    largest_roll: float = quantity("rad", "largest roll in the settled steps", default=nan)
    yaw_change: float = quantity("rad", "change of yaw over the walk", default=nan)
    lateral_drift: float = quantity("m", "sideways drift of the hip over the walk", default=nan)


def settling(record: Record, walk: Walk) -> Settling:
    """Measures of the walk's steps; steps are counted from the first heel strike."""
    strikes = walk.heel_strike_time
    if len(strikes) < 2:
        nothing = np.zeros(0)
        return Settling(nothing, nothing, -1)
    position = record.at(strikes)[0]
    periods, lengths = np.diff(strikes), np.diff(position[:, 0])
    yaw, sideways = (float(record.position[-1, i] - record.position[0, i]) for i in (3, 2))
    if len(periods) < SETTLED_STEPS:
        return Settling(periods, lengths, -1, yaw_change=yaw, lateral_drift=sideways)
    period, length = float(periods[-SETTLED_STEPS:].mean()), float(lengths[-SETTLED_STEPS:].mean())
    settled = (abs(periods / period - 1.0) < SETTLED_WITHIN) & (abs(lengths / length - 1.0) < SETTLED_WITHIN)
    unsettled = np.flatnonzero(~settled)
    needed = int(unsettled[-1]) + 1 if len(unsettled) else 0
    late = record.time >= strikes[-1 - SETTLED_STEPS]
    return Settling(
        step_period=periods,
        step_length=lengths,
        steps_to_settle=needed if needed <= len(periods) - SETTLED_STEPS else -1,
        period_s=period,
        step_frequency_hz=1.0 / period,
        step_length_m=length,
        speed_m_s=length / period,
        double_stance_s=walk.double_stance(strikes[-1 - SETTLED_STEPS : -1]),
        inner_outer_difference=_limp(periods[-SETTLED_STEPS:], walk.heel_strike_leg[-1 - SETTLED_STEPS : -1]) / period,
        largest_roll=float(abs(record.position[late, 4]).max()),
        yaw_change=yaw,
        lateral_drift=sideways,
    )


def _limp(periods: np.ndarray, landing: np.ndarray) -> float:
    """Mean period of the steps that the inner pair's landing begins, less that of the outer pair's [s]."""
    if len(set(landing.tolist())) < 2:
        return float("nan")
    return float(periods[landing == 0].mean() - periods[landing == 1].mean())
