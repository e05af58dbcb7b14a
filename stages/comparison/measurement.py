"""How far measurements agree with the twin and the simple model: signals, frequency, leg, hip path."""

import math
from dataclasses import dataclass

import numpy as np

from stages.biped.quantity import quantity
from stages.biped.walk import Walk
from stages.comparison.stride import NoEvidence, Stride, last_bounds, through_low_pass
from stages.imu.result import Result as Ingested, Run
from stages.imu.strikes.step_times import INNER, OUTER, HeelStrikes, stride_bounds
from stages.imu.trial.agreement import Agreement, FrequencyDifference, agreement, frequency_difference

RATE = "hip_lateral_rate"


@dataclass(frozen=True)
class LegCurves:
    """The inner leg over a stride, and the hip over its stance, which starts at x = 0."""

    angle: np.ndarray = quantity("rad", "leg angle over the stride, foot ahead positive, shape (p,)", symbol="phi")
    rate: np.ndarray = quantity("rad/s", "its rate, shape (p,)", symbol="dphi/dt")
    hip_path: np.ndarray = quantity("m", "hip along and above the slope over the stance, shape (q, 2)")
    step_length: float = quantity("m", "travel of the hip over the stance: the other leg's step")


@dataclass(frozen=True)
class LegAgreement:
    """Runs against models. Differences of the hip's height are less their mean: a sensor cannot see it."""

    runs: LegCurves = quantity("-", "means over all strides and stances of the runs")
    angles: np.ndarray = quantity("rad", "leg angle of every stride of the runs, shape (s, p)")
    rates: np.ndarray = quantity("rad/s", "its rate, shape (s, p)")
    hip_paths: np.ndarray = quantity("m", "hip over every stance of the runs, shape (m, q, 2)")
    step_length_spread: float = quantity("m", "standard deviation of the runs' mean step lengths")
    step_length_error: float = quantity("m", "standard error the ingest gives a step, mean")
    twin: LegCurves = quantity("-", "the twin's last stride")
    simple: LegCurves = quantity("-", "the simple model's last stride")
    twin_angle: float = quantity("rad", "rms difference of the leg angle, twin less runs, over the stride")
    simple_angle: float = quantity("rad", "rms difference of the leg angle, simple model less runs")
    twin_path: np.ndarray = quantity("m", "rms difference of the hip's path, twin less runs, shape (2,)")
    simple_path: np.ndarray = quantity("m", "rms difference of the hip's path, simple model less runs, shape (2,)")


def compare_leg(imu: Ingested, twin: Walk, simple: Walk, skipped: int) -> LegAgreement | None:
    """The runs' leg beside that of the models' last stride; None if no run has both strides and stances.

    `skipped` heel strikes of each run are left out, as the ingest leaves them out.
    """
    points = len(imu.ensemble.phase)
    runs = [run for run in imu.runs if len(run.leg.hip_path) and len(run.strides)]
    if not runs:
        return None
    angles = np.vstack([stride_angles(run, points, skipped) for run in runs])
    paths = np.concatenate([run.leg.hip_path for run in runs])
    means = np.array([run.leg.step_length.mean() for run in runs])
    seen = LegCurves(
        angle=angles.mean(axis=0),
        rate=imu.ensemble.mean[:, imu.signals.index(RATE)],
        hip_path=paths.mean(axis=0),
        step_length=float(np.concatenate([run.leg.step_length for run in runs]).mean()),
    )
    models = [of_walk(walk, points, paths.shape[1]) for walk in (twin, simple)]
    apart = [_path_difference(model.hip_path, seen.hip_path) for model in models]
    return LegAgreement(
        runs=seen,
        angles=angles,
        rates=np.concatenate([run.strides[:, :, imu.signals.index(RATE)] for run in runs]),
        hip_paths=paths,
        step_length_spread=float(means.std(ddof=1)) if len(means) > 1 else math.nan,
        step_length_error=float(np.concatenate([run.leg.step_length_error for run in runs]).mean()),
        twin=models[0],
        simple=models[1],
        twin_angle=_rms(models[0].angle - seen.angle),
        simple_angle=_rms(models[1].angle - seen.angle),
        twin_path=apart[0],
        simple_path=apart[1],
    )


def stride_angles(run: Run, points: int, skipped: int) -> np.ndarray:
    """The leg's angle (s, p) over each stride of a run that the ingest registered."""
    bounds = stride_bounds(HeelStrikes(run.heel_strike_time, run.heel_strike_leg), skipped)
    phase = np.linspace(0.0, 1.0, points)
    return np.array([np.interp(start + (end - start) * phase, run.leg.time, run.leg.angle) for start, end in bounds])


def of_walk(walk: Walk, points: int, path_points: int) -> LegCurves:
    """The inner leg and the hip of a model's last whole stride. Raises NoEvidence if it has none."""
    start, end = last_bounds(walk)
    landed = walk.heel_strike_time[(walk.heel_strike_leg == OUTER) & (walk.heel_strike_time > start)]
    stride, stance = np.linspace(start, end, points), np.linspace(start, float(landed[0]), path_points)

    path = np.column_stack([np.interp(stance, walk.time, axis) for axis in walk.hip_position.T])
    path[:, 0] -= path[0, 0]
    angle, rate = (np.interp(stride, walk.time, one[:, INNER]) for one in (walk.leg_angle, walk.leg_rate))
    return LegCurves(angle, rate, path, float(path[-1, 0]))


def _path_difference(path: np.ndarray, other: np.ndarray) -> np.ndarray:
    apart = path - other
    return np.array([_rms(apart[:, 0]), _rms(apart[:, 1] - apart[:, 1].mean())])


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


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
