"""What the ingest hands on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stages.biped.quantity import quantity
from stages.imu.reports.run_report import RunReport, StepTimes, Table, tables
from stages.imu.reports.sensor_report import SensorReport
from stages.imu.trial.ensemble import Ensemble


@dataclass(frozen=True)
class LegMotion:
    """What the leg with the sensors did; standard errors beside the values. Empty where there is no rate."""

    time: np.ndarray = quantity("s", "even times, shape (m,)", symbol="t")
    angle: np.ndarray = quantity("rad", "leg's angle from the slope normal, foot ahead positive, (m,)", symbol="phi")
    angle_error: np.ndarray = quantity("rad", "standard error of the angle, shape (m,)")
    stance_start: np.ndarray = quantity("s", "landings of this leg, shape (k,)", dimensions=("step",))
    stance_end: np.ndarray = quantity("s", "the other leg's landings that follow, shape (k,)", dimensions=("step",))
    step_length: np.ndarray = quantity(
        "m", "travel of the hip in between: the other leg's step, shape (k,)", dimensions=("step",)
    )
    step_length_error: np.ndarray = quantity("m", "standard error of each, shape (k,)", dimensions=("step",))
    step_length_drawing_error: np.ndarray = quantity(
        "m", "part of that error that the drawing's leg length leaves, shape (k,)", dimensions=("step",))
    hip_path: np.ndarray = quantity(
        "m", "hip along and above the slope over each of these steps, shape (k, p, 2)",
        dimensions=("step", "phase", "direction")
    )
    times: StepTimes = quantity("-", "step, stance and swing of both legs")


@dataclass(frozen=True)
class SensorSignals:
    """One sensor on body axes; `segment` and `index` tell which of its samples each row is."""

    segment: np.ndarray = quantity("1", "restarts of the sensor before this sample, shape (n,)", dimensions=("time",))
    index: np.ndarray = quantity(
        "1", "sampling periods since the first packet of the segment, shape (n,)", dimensions=("time",)
    )
    packet: np.ndarray = quantity("1", "packet number as stored, shape (n,)", dimensions=("time",))
    position: np.ndarray = quantity("1", "position in the packet, shape (n,)", dimensions=("time",))
    time: np.ndarray = quantity("s", "repaired time since the run's first heel strike, shape (n,)", symbol="t")
    specific_force: np.ndarray = quantity(
        "m/s^2", "specific force forward, up, lateral, shape (n, 3)", symbol="f", dimensions=("time", "body_axis")
    )
    angular_velocity: np.ndarray = quantity(
        "rad/s", "angular velocity on the same axes, shape (n, 3)", symbol="omega", dimensions=("time", "body_axis")
    )
    rotation: np.ndarray = quantity(
        "1", "rotation from sensor to body axes, shape (3, 3)", symbol="R", dimensions=("body_axis", "sensor_axis")
    )


@dataclass(frozen=True)
class Run:
    """One run that was accepted."""

    report: RunReport = quantity("-", "what the run is worth")
    start: float = quantity("s", "clock of the stamps at the run's first heel strike")
    hip: SensorSignals = quantity("-", "hip sensor")
    foot: SensorSignals = quantity("-", "foot sensor")
    heel_strike_time: np.ndarray = quantity(
        "s", "heel strikes since the first one, shape (s,)", symbol="t_HS", dimensions=("heel_strike",)
    )
    heel_strike_leg: np.ndarray = quantity(
        "1", "leg that lands, 0 inner, 1 outer, shape (s,)", dimensions=("heel_strike",)
    )
    strides: np.ndarray = quantity(
        "SI", "registered strides, shape (strides, phases, signals)", dimensions=("stride", "phase", "signal")
    )
    leg: LegMotion = quantity("-", "angle, steps and hip path of the leg with the sensors; times as above")


@dataclass(frozen=True)
class Result:
    """All runs, their report, and the ensemble of their strides."""

    origin: str = quantity("-", "measured, synthetic or mixed")
    signals: tuple[str, ...] = quantity("-", "names of the registered signals, in order")
    reports: tuple[SensorReport, ...] = quantity("-", "one report a run and sensor, rejected ones included")
    runs: tuple[Run, ...] = quantity("-", "accepted runs")
    rejected: tuple[RunReport, ...] = quantity("-", "runs not used, each with its reason")
    ensemble: Ensemble = quantity("-", "all strides of all runs")
    step_frequency: float = quantity("Hz", "mean step frequency of the runs", symbol="f")
    step_frequency_spread: float = quantity("Hz", "standard deviation between runs")

    def summary(self) -> str:
        """What was found, in one line."""
        strides = sum(len(run.strides) for run in self.runs)
        turned_down = f", {len(self.rejected)} rejected" if self.rejected else ""
        runs = "run" if len(self.runs) == 1 else "runs"
        spread = f" +- {self.step_frequency_spread:.3f}" if len(self.runs) > 1 else ""
        return (
            f"{len(self.runs)} {self.origin} {runs}{turned_down}, {strides} strides, "
            f"step frequency {self.step_frequency:.3f}{spread} Hz"
        )

    def tables(self) -> list[Table]:
        """The reports as tables: (title, columns, rows)."""
        return tables(self.reports, [*(run.report for run in self.runs), *self.rejected], self.origin)
