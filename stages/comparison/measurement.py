"""How far measurements agree with the twin."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from stages.biped.quantity import quantity
from stages.biped.walk import Walk
from stages.comparison.stride import Stride


@dataclass(frozen=True)
class MeasurementAgreement:
    """Measured (or synthetic) strides against the twin's."""

    origin: str = quantity("-", "measured, synthetic or mixed")
    runs: int = quantity("1", "runs accepted")
    step_frequency: float = quantity("Hz", "mean step frequency of the runs")
    step_frequency_spread: float = quantity("Hz", "standard deviation between runs")
    twin_step_frequency: float = quantity("Hz", "step frequency of the twin over the same steps")
    enclosed_share: np.ndarray = quantity("1", "share of the stride where the envelope holds the twin, shape (6,)")


def same_steps_frequency(imu: Any, walk: Walk, skipped: int) -> float:
    """Step frequency [Hz] of a walk over the steps the runs are measured over: both carry the same transient."""
    count = int(np.median([len(run.heel_strike_time) for run in imu.runs]))
    strikes = walk.heel_strike_time[skipped:count]
    return float((len(strikes) - 1) / (strikes[-1] - strikes[0]))


def compare_measurement(imu: Any, walk: Walk, twin: Stride, skipped: int) -> MeasurementAgreement:
    """Agreement of the ingest's result with the twin's walk and its last stride; `skipped` heel strikes left out."""
    lower, upper, phase = imu.ensemble.lower, imu.ensemble.upper, imu.ensemble.phase
    curves = np.column_stack([np.interp(phase, twin.phase, column) for column in twin.signals.T])
    known = np.isfinite(lower) & np.isfinite(upper)
    inside = known & (curves >= lower) & (curves <= upper)
    return MeasurementAgreement(
        origin=imu.origin,
        runs=len(imu.runs),
        step_frequency=imu.step_frequency,
        step_frequency_spread=imu.step_frequency_spread,
        twin_step_frequency=same_steps_frequency(imu, walk, skipped),
        enclosed_share=inside.sum(axis=0) / np.maximum(known.sum(axis=0), 1),
    )
