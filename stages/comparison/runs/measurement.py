"""How far measurements agree with the twin and the simple model."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from stages.biped.quantity import quantity
from stages.biped.walk import Walk
from stages.comparison.runs.leg_agreement import LegAgreement, compare_leg
from stages.comparison.stride import NoEvidence, Stride, through_low_pass
from stages.imu.result import Result as Ingested
from stages.imu.trial.agreement import Agreement, FrequencyDifference, agreement, frequency_difference


@dataclass(frozen=True)
class MeasurementAgreement:
    """Measured (or synthetic) strides against the models' last stride, signal by signal."""

    origin: str = quantity("-", "measured, synthetic or mixed")
    runs: int = quantity("1", "runs accepted")
    step_frequency: float = quantity("Hz", "mean step frequency of the runs")
    step_frequency_spread: float = quantity("Hz", "standard deviation between runs")
    twin_step_frequency: float = quantity("Hz", "step frequency of the twin over the same steps")
    twin_frequency: FrequencyDifference = quantity("-", "runs against the twin over the same steps")
    simple_frequency: FrequencyDifference = quantity("-", "runs against the settled simple model")
    bandwidth: float = quantity("Hz", "low pass of the sensors, which the models' curves pass too; NaN: none declared")
    twin: dict[str, Agreement] = quantity("-", "agreement with the twin, by signal")
    simple: dict[str, Agreement] = quantity("-", "agreement with the simple model, by signal")
    leg: LegAgreement | None = quantity("-", "leg angle, hip path and step length; empty if no run has them")


def same_steps_frequency(imu: Ingested, walk: Walk, skipped: int) -> float:
    """Step frequency [Hz] of a walk over the steps the runs are measured over: both carry the same transient.

    Raises NoEvidence for a walk that ends before them.
    """
    count = int(np.median([len(run.heel_strike_time) for run in imu.runs]))
    strikes = walk.heel_strike_time[skipped:count]
    if len(strikes) < 2:
        raise NoEvidence(f"the twin's walk ends within the first {skipped + 1} steps, which the runs leave out")
    return float((len(strikes) - 1) / (strikes[-1] - strikes[0]))


def compare_measurement(
    imu: Ingested, walk: Walk, twin: Stride, simple: Stride, simple_walk: Walk, skipped: int
) -> MeasurementAgreement:
    """Agreement of the ingest's result with the last stride of twin and simple model.

    `walk` is the twin's, whose step frequency is taken over the runs' own steps; `skipped` heel strikes left out.
    """
    runs = np.array([run.report.step_frequency for run in imu.runs])
    frequency, bandwidth = same_steps_frequency(imu, walk, skipped), bandwidth_of(imu)
    return MeasurementAgreement(
        origin=imu.origin,
        runs=len(imu.runs),
        step_frequency=imu.step_frequency,
        step_frequency_spread=imu.step_frequency_spread,
        twin_step_frequency=frequency,
        twin_frequency=frequency_difference(runs, frequency),
        simple_frequency=frequency_difference(runs, 2 / simple.period),
        bandwidth=bandwidth,
        twin=stride_agreement(imu, twin, bandwidth),
        simple=stride_agreement(imu, simple, bandwidth),
        leg=compare_leg(imu, walk, simple_walk, skipped),
    )


def bandwidth_of(imu: Ingested) -> float:
    """The one cut-off [Hz] all sensors in use declare; NaN if they declare none or differ."""
    declared = {report.bandwidth_hz for report in imu.reports if report.accepted}
    return declared.pop() if len(declared) == 1 else math.nan


def stride_agreement(imu: Ingested, stride: Stride, bandwidth: float) -> dict[str, Agreement]:
    """Agreement of a model's stride with the ensemble, by the signals' names, at the ensemble's phases.

    The model's curves pass the sensor's low pass first: the spike of a heel strike lasts less than a sample, and where
    it falls between two phases would decide everything else.
    """
    known, signals = imu.ensemble, through_low_pass(stride, bandwidth)
    return {
        name: agreement(
            np.interp(known.phase, stride.phase, signals[:, column]),
            known.mean[:, column],
            known.lower[:, column],
            known.upper[:, column],
        )
        for column, name in enumerate(imu.signals)
    }
