"""Step by step: how the twin settles from the simple model's fixed point."""

from __future__ import annotations

import numpy as np

from stages.biped.walk import Walk
from stages.twin.result import Settling
from stages.twin.walking.record import Record

#: Steps at the end of a walk over which the settled gait is averaged: two strides.
SETTLED_STEPS = 4
#: A step has settled when its period and its length are this close to the settled gait's.
SETTLED_WITHIN = 0.01


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
