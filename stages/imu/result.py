"""What the ingest hands on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stages.biped.quantity import quantity
from stages.imu.ensemble import Ensemble
from stages.imu.report import NOT_OBSERVABLE, SensorReport

Table = tuple[str, tuple[str, ...], list[tuple[str, ...]]]


@dataclass(frozen=True)
class SensorSignals:
    """One sensor on body axes; `segment` and `index` tell which of its samples each row is."""

    segment: np.ndarray = quantity("1", "restarts of the sensor before this sample, shape (n,)")
    index: np.ndarray = quantity("1", "sampling periods since the first packet of the segment, shape (n,)")
    packet: np.ndarray = quantity("1", "packet number as stored, shape (n,)")
    position: np.ndarray = quantity("1", "position in the packet, shape (n,)")
    time: np.ndarray = quantity("s", "repaired time since the run's first heel strike, shape (n,)", symbol="t")
    specific_force: np.ndarray = quantity("m/s^2", "specific force forward, up, lateral, shape (n, 3)", symbol="f")
    angular_velocity: np.ndarray = quantity("rad/s", "angular velocity on the same axes, shape (n, 3)", symbol="omega")
    rotation: np.ndarray = quantity("1", "rotation from sensor to body axes, shape (3, 3)", symbol="R")


@dataclass(frozen=True)
class Run:
    """One run that was accepted."""

    name: str = quantity("-", "experiment")
    origin: str = quantity("-", "measured or synthetic")
    slope_deg: float = quantity("deg", "inclination as read off")
    start: float = quantity("s", "clock of the stamps at the run's first heel strike")
    hip: SensorSignals = quantity("-", "hip sensor")
    foot: SensorSignals = quantity("-", "foot sensor")
    foot_lag: float = quantity("s", "lag of the foot's stamps, taken out")
    lever_arm: float = quantity("m", "distance of the sensors along the leg, from their signals")
    heel_strike_time: np.ndarray = quantity("s", "heel strikes since the first one, shape (s,)", symbol="t_HS")
    heel_strike_leg: np.ndarray = quantity("1", "leg that lands, 0 inner, 1 outer, shape (s,)")
    step_frequency: float = quantity("Hz", "steps per second after the transient", symbol="f")
    step_frequency_error: float = quantity("Hz", "standard error of the step frequency")
    strides: np.ndarray = quantity("SI", "registered strides, shape (strides, phases, signals)")


@dataclass(frozen=True)
class Result:
    """All runs, their report, and the ensemble of their strides."""

    origin: str = quantity("-", "measured, synthetic or mixed")
    signals: tuple[str, ...] = quantity("-", "names of the registered signals, in order")
    reports: tuple[SensorReport, ...] = quantity("-", "one report a run and sensor, rejected ones included")
    rejected: tuple[str, ...] = quantity("-", "runs not used, each with its reason")
    runs: tuple[Run, ...] = quantity("-", "accepted runs")
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
        """The report as tables: (title, columns, rows)."""
        return [_faults(self), _clocks(self), _sensors(self), _runs(self)]


def _faults(result: Result) -> Table:
    columns = ("run", "sensor", "rows", "duplicates", "same key", "out of order", "unusable", "lost packets", "resets")
    rows: list[tuple[str, ...]] = [
        (
            *(r.run, r.place, str(r.rows), str(r.exact_duplicates), str(r.key_duplicates), str(r.out_of_order)),
            str(r.unusable_rows),
            "can't be observed" if r.lost_packets == NOT_OBSERVABLE else str(r.lost_packets),
            str(r.resets),
        )
        for r in result.reports
    ]
    return f"Rows ({result.origin})", columns, rows


def _clocks(result: Result) -> Table:
    columns = ("run", "sensor", "stamp", "batch", "rate Hz", "rate ppm", "robust ppm", "jitter ms", "after ms")
    rows: list[tuple[str, ...]] = [
        (
            *(r.run, r.place, r.stamp, str(r.batch_size), f"{r.rate_hz:.3f}", f"{r.rate_ppm:.0f}"),
            *(f"{r.robust_ppm:.0f}", f"{r.jitter_before_s * 1e3:.2f}", f"{r.jitter_after_s * 1e3:.2f}"),
        )
        for r in result.reports
    ]
    return f"Clocks ({result.origin})", columns, rows


def _sensors(result: Result) -> Table:
    columns = (
        *("run", "sensor", "missing", "dead", "clipped a", "clipped w", "still s", "static", "gain"),
        *("unit a", "unit w", "off swing deg", "off mount deg", "verdict"),
    )
    rows: list[tuple[str, ...]] = [
        (
            *(r.run, r.place, str(r.missing_values), " ".join(r.dead_axes) or "none", str(r.clipped_acceleration)),
            *(str(r.clipped_angular_rate), f"{r.rest_s:.2f}", f"{r.static_reading:.5g}", f"{r.static_gain:.4f}"),
            *(r.acceleration_unit, r.angular_rate_unit, f"{r.swing_residual_deg:.2f}", f"{r.mounting_deg:.2f}"),
            ("accepted" if r.accepted else "rejected") + (": " + "; ".join(r.reasons) if r.reasons else ""),
        )
        for r in result.reports
    ]
    return f"Sensors ({result.origin})", columns, rows


def _runs(result: Result) -> Table:
    columns = ("run", "heel strikes", "strides", "step frequency Hz", "standard error Hz", "foot lag ms", "lever arm m")
    rows: list[tuple[str, ...]] = [
        (
            *(run.name, str(len(run.heel_strike_time)), str(len(run.strides)), f"{run.step_frequency:.4f}"),
            *(f"{run.step_frequency_error:.4f}", f"{run.foot_lag * 1e3:.2f}", f"{run.lever_arm:.3f}"),
        )
        for run in result.runs
    ]
    return f"Runs ({result.origin})", columns, rows
