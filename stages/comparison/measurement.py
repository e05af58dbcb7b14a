"""How far measurements agree with the twin, and, for synthetic ones, how well the ingest recovered the truth."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from stages.biped.quantity import quantity
from stages.comparison.stride import Stride


@dataclass(frozen=True)
class MeasurementAgreement:
    """Measured (or synthetic) strides against the twin's."""

    origin: str = quantity("-", "measured, synthetic or mixed")
    runs: int = quantity("1", "runs accepted")
    step_frequency: float = quantity("Hz", "mean step frequency of the runs")
    step_frequency_spread: float = quantity("Hz", "standard deviation between runs")
    twin_step_frequency: float = quantity("Hz", "step frequency of the twin")
    enclosed_share: np.ndarray = quantity("1", "share of the stride where the envelope holds the twin, shape (6,)")


def compare_measurement(imu: Any, twin: Stride, twin_step_frequency: float) -> MeasurementAgreement:
    """Agreement of the ingest's result with the twin's last stride."""
    lower, upper, phase = imu.ensemble.lower, imu.ensemble.upper, imu.ensemble.phase
    curves = np.column_stack([np.interp(phase, twin.phase, column) for column in twin.signals.T])
    known = np.isfinite(lower) & np.isfinite(upper)
    inside = known & (curves >= lower) & (curves <= upper)
    return MeasurementAgreement(
        origin=imu.origin,
        runs=len(imu.runs),
        step_frequency=imu.step_frequency,
        step_frequency_spread=imu.step_frequency_spread,
        twin_step_frequency=twin_step_frequency,
        enclosed_share=inside.sum(axis=0) / np.maximum(known.sum(axis=0), 1),
    )
