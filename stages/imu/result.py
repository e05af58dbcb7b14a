"""What the ingest hands on: what each sensor and run is worth, the leg's motion, the signals, and their ensemble."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, fields
from typing import Any

import numpy as np

from stages.biped.quantity import count_of, quantity
from stages.imu.judgement.verdict import REFUSED

Table = tuple[str, Sequence[str], Sequence[Sequence[str]]]
NOT_OBSERVABLE = -1
#: Why what was not computed has no numerical error.
STORED = "it is as stored"


@dataclass(frozen=True)
class RowCounts:
    """What became of a recording's rows when they were numbered."""

    exact_duplicates: int = quantity("1", "rows that repeat another in every column")
    sent_again: int = quantity("1", "rows of packets that arrived a second time")
    key_duplicates: int = quantity("1", "rows that repeat the packet and position of another with other content")
    out_of_order: int = quantity("1", "rows stored after a later one")
    unusable_rows: int = quantity("1", "rows without packet number or stamp")
    lost_packets: int = quantity("1", "packets missing in the numbering; -1: loss cannot be observed without a counter")
    gaps: int = quantity("1", "holes in the sequence of samples")
    resets: int = quantity("1", "restarts of the packet counter")
    batch_size: int = quantity("1", "samples in a packet")
    numbered_by: str = quantity("-", "what numbers the samples: counter, device stamp or rows")


@dataclass(frozen=True)
class ClockFit:
    """What the fit of a sensor's clock says about itself; NaN where the source has no stamps."""

    stamp: str = quantity("-", "stamp the clock was fitted to")
    rate_hz: float = quantity("Hz", "fitted sampling rate")
    rate_ppm: float = quantity("ppm", "fitted rate relative to the nominal one")
    clock_bend_s: float = quantity("s", "wander of the sensor's clock that was followed")
    robust_ppm: float = quantity("ppm", "rate of the robust cross-check relative to the fitted one")
    jitter_before_s: float = quantity("s", "rms of the stamps about a least-squares line")
    clock_error_s: float = quantity("s", "difference of the smallest delays in time: possible error of the clock")


@dataclass(frozen=True)
class FrameFit:
    """How well a sensor's frame was found; NaN where it was not."""

    swing_residual_deg: float = quantity("deg", "angle of the swing axis from normal to gravity")
    swing_share: float = quantity("1", "share of the angular motion about the swing axis")
    mounting_deg: float = quantity("deg", "angle of the frame found to the declared mounting")


@dataclass(frozen=True)
class SensorReport(FrameFit, ClockFit, RowCounts):
    """Faults and facts of one sensor in one run."""

    run: str = quantity("-", "experiment")
    place: str = quantity("-", "place of the sensor")
    bandwidth_hz: float = quantity(
        "Hz", "cut-off of the sensor's low pass as declared; NaN where it is not", without_error=STORED)
    rows: int = quantity("1", "rows stored")
    smallest_batch: int = quantity("1", "fewest samples of a packet that arrived")
    largest_batch: int = quantity("1", "most samples of a packet that arrived")
    clock_settings: int = quantity("1", "settings of the stamps' clock that were taken out")
    missing_values: int = quantity("1", "cells that are no number")
    dead_axes: tuple[str, ...] = quantity("-", "axes that never change")
    clipped_acceleration: int = quantity("1", "samples with an accelerometer axis at full scale")
    clipped_angular_rate: int = quantity("1", "samples with a gyroscope axis at full scale")
    acceleration_step: float = quantity("m/s^2", "quantisation step of the accelerometer")
    angular_rate_step: float = quantity("rad/s", "quantisation step of the gyroscope")
    rest_s: float = quantity("s", "length of the still stand")
    static_reading: float = quantity("1", "magnitude of the specific force at rest in the stored unit")
    static_gain: float = quantity("1", "magnitude of the specific force at rest over gravity, in the declared unit")
    acceleration_unit: str = quantity("-", "unit of acceleration the static reading implies")
    angular_rate_unit: str = quantity("-", "unit of angular rate in which a leg sweeps what it sweeps in a step")
    accepted: bool = quantity("1", "whether the recording is used")
    reasons: tuple[str, ...] = quantity("-", "why it is not, or what to bear in mind")

    @classmethod
    def of(cls, *found: RowCounts | ClockFit | FrameFit, **own: Any) -> SensorReport:
        """From what was found of the recording's rows, clock and frame, and the report's own fields by name."""
        said = {field.name: getattr(one, field.name) for part in cls.__bases__ for one in found if isinstance(one, part)
                for field in fields(part)}  # fmt: skip
        return cls(**said, **own)


@dataclass(frozen=True)
class Evidence:
    """Numbers by which a trial is judged; NaN where the trial does not determine them."""

    agreement: float = quantity("1", "squared correlation of the foot's and the hip's lateral rate, after the lag")
    rate_ratio: float = quantity("1", "foot's over hip's lateral rate")
    lever_arm: float = quantity("m", "distance of the sensors along the leg, from their signals")
    lever_direction_deg: float = quantity("deg", "direction of the lever arm from the leg's line, in the frames found")
    forward_gain: float = quantity("1", "foot's over hip's forward gain, the nearest to 1 that the signals allow")
    hip_gain: float = quantity("1", "hip's gyroscope over how gravity turns while the leg stands")
    foot_gain: float = quantity("1", "foot's gyroscope over how gravity turns while the leg stands")
    hip_gain_error: float = quantity("1", "its standard error from the scatter")
    foot_gain_error: float = quantity("1", "its standard error from the scatter")
    hip_arm: float = quantity("1", "hip sensor's height above the sole, as it is accelerated, over the drawing's")
    foot_arm: float = quantity("1", "foot sensor's height above the sole, as it is accelerated, over the drawing's")
    hip_pitch_deg: float = quantity("deg", "largest departure in a stance of the hip's angle by rate from gravity's")
    foot_pitch_deg: float = quantity("deg", "largest departure in a stance of the foot's angle by rate from gravity's")
    hip_axis_deg: float = quantity("deg", "how far the swing axis turned on the hip's sensor within the walk")
    foot_axis_deg: float = quantity("deg", "how far the swing axis turned on the foot's sensor within the walk")
    rate_lag: float = quantity("s", "how much later the gyroscopes show the motion than the accelerometers, if that "
                               "explains how they differ; else 0")
    hidden_strikes: float = quantity("1", "share of the heel strikes that lie in a hole of the recording")
    third_moment: float = quantity("1", "skewness of the lateral rate, the hip's if there is one; positive in a swing")
    hip_turning: float = quantity("1", "signed R2 of forward force between the places and how the hip's rate changes")
    foot_turning: float = quantity("1", "signed R2 of forward force between the places and how the foot's rate changes")
    strike_symmetry_deg: float = quantity("deg", "mean of the leg's angles at its own and at the other leg's landing")
    hip_gravity: float = quantity("1", "mean specific force at the hip over whole strides, over gravity")
    foot_gravity: float = quantity("1", "mean specific force at the foot over whole strides, over gravity")
    hip_gravity_deg: float = quantity("deg", "direction of that mean from gravity's, at the hip")
    foot_gravity_deg: float = quantity("deg", "direction of that mean from gravity's, at the foot")
    spacing: float = quantity("1", "largest departure of a step's duration from the median, relative")
    alternating: float = quantity("1", "share of steps after which the other leg lands")

    def at(self, place: str) -> dict[str, float]:
        """The numbers of one place, by their names without it."""
        own = asdict(self)
        return {name.removeprefix(f"{place}_"): one for name, one in own.items() if name.startswith(f"{place}_")}


@dataclass(frozen=True)
class StepTimes:
    """Means over the run's own steps after the transient, standard errors beside them; NaN for what is not known.

    Nothing on the inner leg shows when the outer one leaves the ground: its double stance is taken to be the inner
    leg's, with an error as large as itself.
    """

    inner_step: float = quantity("s", "from the outer leg's landing to the inner one's")
    outer_step: float = quantity("s", "from the inner leg's landing to the outer one's")
    step_error: float = quantity("s", "standard error of both")
    double_stance: float = quantity("s", "from the outer leg's landing to the inner one's toe-off")
    double_stance_error: float = quantity("s", "its standard error")
    inner_stance: float = quantity("s", "from the inner leg's landing to its toe-off")
    inner_swing: float = quantity("s", "from the inner leg's toe-off to its landing")
    inner_error: float = quantity("s", "standard error of the inner leg's stance and swing")
    outer_stance: float = quantity("s", "from the outer leg's landing to its toe-off")
    outer_swing: float = quantity("s", "from the outer leg's toe-off to its landing")
    outer_error: float = quantity("s", "standard error of the outer leg's stance and swing")
    asymmetry: float = quantity("1", "inner less outer step over their mean")
    asymmetry_error: float = quantity("1", "its standard error")
    stance_asymmetry: float = quantity("1", "inner less outer stance over their mean")
    stance_asymmetry_error: float = quantity("1", "its standard error")


@dataclass(frozen=True)
class RunReport:
    """One run, used or not."""

    name: str = quantity("-", "experiment")
    origin: str = quantity("-", "measured or synthetic")
    slope_deg: float = quantity("deg", "inclination as read off", without_error=STORED)
    overlap: float = quantity("1", "share of the longer motion that hip and foot both cover; NaN where unknown")
    foot_lag: float = quantity("s", "lag of the foot's stamps, taken out; NaN without both sensors")
    foot_lag_error: float = quantity("s", "standard error of that lag where the leg moves; NaN where it was not found")
    heel_strikes: int = quantity("1", "heel strikes found")
    strides: int = quantity("1", "strides after the transient")
    step_frequency: float = quantity("Hz", "steps per second after the transient", symbol="f")
    step_frequency_error: float = quantity("Hz", "standard error of the step frequency")
    step_length: float = quantity("m", "mean travel of the hip over the inner leg's stances; NaN without any")
    step_length_error: float = quantity("m", "standard error of one step's length")
    step_length_drawing_error: float = quantity("m", "part of that error that the drawing's leg length leaves")
    times: StepTimes = quantity("-", "step, stance and swing of both legs")
    evidence: Evidence = quantity("-", "numbers by which the run was judged")
    verdict: str = quantity("-", "accepted, accepted with remarks, or refused")
    reason: str = quantity("-", "why it is refused")
    remarks: tuple[str, ...] = quantity("-", "what to bear in mind, a sentence each")
    not_trusted: tuple[str, ...] = quantity("-", "quantities the remarks are about: not to be trusted")
    accepted: bool = quantity("1", "whether the run is used, with or without remarks")


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
class Ensemble:
    """Registered strides of all runs, phase by phase, for k signals at p phases; holes left out where they are."""

    phase: np.ndarray = quantity(
        "1", "phase of the stride, 0 and 1 at heel strikes of the inner leg, shape (p,)", dimensions=("phase",)
    )
    mean: np.ndarray = quantity("SI", "mean over strides, shape (p, k)", dimensions=("phase", "signal"))
    spread: np.ndarray = quantity("SI", "standard deviation over strides, shape (p, k)", dimensions=("phase", "signal"))
    lower: np.ndarray = quantity("SI", "lower edge of the envelope, shape (p, k)", dimensions=("phase", "signal"))
    upper: np.ndarray = quantity("SI", "upper edge of the envelope, shape (p, k)", dimensions=("phase", "signal"))
    count: np.ndarray = quantity("1", "strides seen at each phase, shape (p, k)", dimensions=("phase", "signal"))


@dataclass(frozen=True)
class SensorSignals:
    """One sensor on body axes; `segment` and `index` show which of its samples each row is."""

    segment: np.ndarray = quantity("1", "restarts of the sensor before this sample, shape (n,)", dimensions=("time",))
    index: np.ndarray = quantity(
        "1", "sampling periods since the first packet of the segment, shape (n,)", dimensions=("time",)
    )
    packet: np.ndarray = quantity(
        "1", "packet number as stored, shape (n,)", dimensions=("time",), without_error=STORED)
    position: np.ndarray = quantity(
        "1", "position in the packet, shape (n,)", dimensions=("time",), without_error=STORED)
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
    step_frequency: float = quantity(
        "Hz", "mean of the runs whose legs land in turn, step by step; of all, if there is none such", symbol="f")
    step_frequency_spread: float = quantity("Hz", "standard deviation between these; NaN of one")

    def summary(self) -> str:
        """What was found, in one line."""
        strides = sum(len(run.strides) for run in self.runs)
        turned_down = f", {len(self.rejected)} rejected" if self.rejected else ""
        apart = self.step_frequency_spread
        least = f"{apart:.3f}" if apart >= 5e-4 else "less than 0.001"
        spread = f", standard deviation {least} between runs" if math.isfinite(apart) else ""
        doubt = "" if stepping(self.runs) else ", not to be trusted: see the remarks of bipedstudy show imu"
        return (
            f"{count_of(len(self.runs), f'{self.origin} run')}{turned_down}, {strides} strides, "
            f"step frequency {self.step_frequency:.3f} Hz{spread}{doubt}"
        )

    def tables(self) -> list[Table]:
        """The reports as tables: (title, columns, rows)."""
        return tables(self.reports, [*(run.report for run in self.runs), *self.rejected], self.origin)


def stepping(runs: Iterable[Run]) -> list[Run]:
    """The runs whose legs land in turn, each step within half of the median: in others a leg may have landed twice."""
    every = [(run, run.report.evidence) for run in runs]
    return [run for run, one in every if not (one.alternating < 1.0 or one.spacing > 0.5)]


def origin_of(runs: Iterable[RunReport]) -> str:
    """Measured, synthetic, or mixed."""
    origins = {one.origin for one in runs}
    return origins.pop() if len(origins) == 1 else "mixed"


def tables(sensors: Iterable[SensorReport], runs: Iterable[RunReport], origin: str) -> list[Table]:
    """The reports as tables: (title, columns, rows); `origin` stands in every title."""
    reports, judged = list(sensors), list(runs)
    rows = [
        (r.run, r.place, *map(str, (
            r.rows, r.exact_duplicates, r.sent_again, r.key_duplicates, r.out_of_order, r.unusable_rows,
            "can't be observed" if r.lost_packets == NOT_OBSERVABLE else r.lost_packets, r.gaps, r.batch_size,
            r.smallest_batch, r.largest_batch))) for r in reports]  # fmt: skip
    clocks = [
        (r.run, r.place, r.stamp, str(r.resets), *_numbers(1, 3, r.rate_hz), *_numbers(1, 0, r.rate_ppm, r.robust_ppm),
         *_numbers(1e3, 2, r.jitter_before_s, r.clock_error_s)) for r in reports]  # fmt: skip
    signals = [
        (r.run, r.place, str(r.missing_values), " ".join(r.dead_axes) or "none", str(r.clipped_acceleration),
         str(r.clipped_angular_rate), _known(r.acceleration_step, ".2g"), _known(r.angular_rate_step, ".2g"),
         *_numbers(1, 2, r.rest_s), _known(r.static_reading, ".5g"), *_numbers(1, 4, r.static_gain),
         r.acceleration_unit, r.angular_rate_unit, *_numbers(1, 2, r.swing_residual_deg, r.mounting_deg),
         _verdict("accepted" if r.accepted else REFUSED, r.reasons)) for r in reports]  # fmt: skip
    walks = [
        (r.name, "can't be observed" if math.isnan(r.overlap) else f"{r.overlap:.3f}",
         *_numbers(1e3, 2, r.foot_lag, r.foot_lag_error), *_numbers(1, 3, r.evidence.lever_arm), str(r.heel_strikes),
         str(r.strides), *_numbers(1, 4, r.step_frequency, r.step_frequency_error, r.evidence.agreement),
         _verdict(r.verdict, (r.reason,) if r.reason else r.remarks)) for r in judged]  # fmt: skip
    legs = [
        (r.name, *_numbers(1e3, 1, r.step_length, r.step_length_error, r.step_length_drawing_error),
         *_numbers(1, 4, t.inner_step, t.outer_step, t.step_error),
         *_numbers(1e3, 1, t.double_stance, t.double_stance_error),
         *_numbers(1, 4, t.inner_stance, t.inner_swing, t.inner_error, t.outer_stance, t.outer_swing, t.outer_error),
         *_numbers(100, 2, t.asymmetry, t.asymmetry_error)) for r in judged for t in (r.times,)]  # fmt: skip
    return [
        (f"Rows ({origin})",
         ("run", "sensor", "rows", "duplicates", "sent again", "same key", "out of order", "unusable", "lost packets",
          "gaps", "batch", "smallest", "largest"), rows),
        (f"Clocks ({origin})",
         ("run", "sensor", "stamp", "resets", "rate Hz", "rate ppm", "robust ppm", "jitter ms", "error ms"), clocks),
        (f"Sensors ({origin})",
         ("run", "sensor", "NaN", "dead", "clipped a", "clipped w", "step a m/s^2", "step w rad/s", "still s",
          "static", "gain", "unit a", "unit w", "off swing deg", "off mount deg", "verdict"), signals),
        (f"Runs ({origin})",
         ("run", "overlap", "foot lag ms", "+-", "lever arm m", "heel strikes", "strides", "step frequency Hz",
          "standard error Hz", "R2 of places", "verdict"), walks),
        (f"Legs, with standard errors ({origin})",
         ("run", "step mm", "+-", "of the nominal leg", "inner step s", "outer step s", "+-", "double stance ms", "+-",
          "inner stance s", "inner swing s", "+-", "outer stance s", "outer swing s", "+-", "asymmetry %", "+-"), legs),
    ]  # fmt: skip


def _verdict(word: str, sentences: Iterable[str]) -> str:
    return ": ".join(part for part in (word, "; ".join(sentences)) if part)


def _numbers(scale: float, digits: int, *values: float) -> tuple[str, ...]:
    """Values in other units with so many digits; a dash for what is not known."""
    return tuple(_known(scale * value, f".{digits}f") for value in values)


def _known(value: float, form: str) -> str:
    return "-" if math.isnan(value) else format(value, form)
