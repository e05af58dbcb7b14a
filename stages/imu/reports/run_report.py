"""What a run is worth: its sensors together, its steps, and whether it is used."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from stages.biped.quantity import quantity
from stages.imu.judgement.verdict import REFUSED
from stages.imu.reports.sensor_report import NOT_OBSERVABLE, SensorReport

Table = tuple[str, tuple[str, ...], list[tuple[str, ...]]]


@dataclass(frozen=True)
class Evidence:
    """Numbers by which a trial is judged; NaN where the trial cannot tell."""

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


@dataclass(frozen=True)
class StepTimes:
    """Means over the run's own steps after the transient, standard errors beside them; NaN for what is not known.

    Nothing on the inner leg tells when the outer one leaves the ground: its double stance is taken to be the inner
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
    slope_deg: float = quantity("deg", "inclination as read off")
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


def tables(sensors: Iterable[SensorReport], runs: Iterable[RunReport], origin: str) -> list[Table]:
    """The reports as tables: (title, columns, rows); `origin` stands in every title."""
    reports = list(sensors)
    judged = list(runs)
    made = (_faults(reports), _clocks(reports), _sensors(reports), _runs(judged), _legs(judged))
    return [(f"{title} ({origin})", columns, rows) for title, columns, rows in made]


def origin_of(runs: Iterable[RunReport]) -> str:
    """Measured, synthetic, or mixed."""
    origins = {one.origin for one in runs}
    return origins.pop() if len(origins) == 1 else "mixed"


def _faults(reports: list[SensorReport]) -> Table:
    columns = (
        *("run", "sensor", "rows", "duplicates", "sent again", "same key", "out of order", "unusable"),
        *("lost packets", "gaps", "batch", "smallest", "largest"),
    )
    rows: list[tuple[str, ...]] = [
        (
            *(r.run, r.place, str(r.rows), str(r.exact_duplicates), str(r.sent_again), str(r.key_duplicates)),
            str(r.out_of_order),
            str(r.unusable_rows),
            "can't be observed" if r.lost_packets == NOT_OBSERVABLE else str(r.lost_packets),
            *(str(r.gaps), str(r.batch_size), str(r.smallest_batch), str(r.largest_batch)),
        )
        for r in reports
    ]
    return "Rows", columns, rows


def _clocks(reports: list[SensorReport]) -> Table:
    columns = ("run", "sensor", "stamp", "resets", "rate Hz", "rate ppm", "robust ppm", "jitter ms", "error ms")
    rows: list[tuple[str, ...]] = [
        (
            *(r.run, r.place, r.stamp, str(r.resets), f"{r.rate_hz:.3f}", f"{r.rate_ppm:.0f}"),
            *(f"{r.robust_ppm:.0f}", f"{r.jitter_before_s * 1e3:.2f}", f"{r.clock_error_s * 1e3:.2f}"),
        )
        for r in reports
    ]
    return "Clocks", columns, rows


def _sensors(reports: list[SensorReport]) -> Table:
    columns = (
        *("run", "sensor", "NaN", "dead", "clipped a", "clipped w", "step a m/s^2", "step w rad/s", "still s"),
        *("static", "gain", "unit a", "unit w", "off swing deg", "off mount deg", "verdict"),
    )
    rows: list[tuple[str, ...]] = [
        (
            *(r.run, r.place, str(r.missing_values), " ".join(r.dead_axes) or "none", str(r.clipped_acceleration)),
            *(str(r.clipped_angular_rate), f"{r.acceleration_step:.2g}", f"{r.angular_rate_step:.2g}"),
            *(f"{r.rest_s:.2f}", f"{r.static_reading:.5g}", f"{r.static_gain:.4f}"),
            *(r.acceleration_unit, r.angular_rate_unit, f"{r.swing_residual_deg:.2f}", f"{r.mounting_deg:.2f}"),
            ": ".join(part for part in ("accepted" if r.accepted else REFUSED, "; ".join(r.reasons)) if part),
        )
        for r in reports
    ]
    return "Sensors", columns, rows


def _legs(runs: list[RunReport]) -> Table:
    columns = (
        *("run", "step mm", "+-", "of the drawing", "inner step s", "outer step s", "+-", "double stance ms", "+-"),
        *("inner stance s", "inner swing s", "+-", "outer stance s", "outer swing s", "+-", "asymmetry %", "+-"),
    )
    rows: list[tuple[str, ...]] = []
    for r in runs:
        t = r.times
        cells = [*_said(r.step_length, r.step_length_error, 1e3, 1), _number(r.step_length_drawing_error, 1e3, 1)]
        cells += [_number(t.inner_step, 1, 4)]
        cells += [*_said(t.outer_step, t.step_error, 1, 4), *_said(t.double_stance, t.double_stance_error, 1e3, 1)]
        cells += [_number(t.inner_stance, 1, 4), *_said(t.inner_swing, t.inner_error, 1, 4)]
        cells += [_number(t.outer_stance, 1, 4), *_said(t.outer_swing, t.outer_error, 1, 4)]
        rows.append((r.name, *cells, *_said(t.asymmetry, t.asymmetry_error, 100, 2)))
    return "Legs, with standard errors", columns, rows


def _number(value: float, scale: float, digits: int) -> str:
    return "-" if math.isnan(value) else f"{scale * value:.{digits}f}"


def _said(value: float, error: float, scale: float, digits: int) -> tuple[str, str]:
    return _number(value, scale, digits), _number(error, scale, digits)


def _runs(runs: list[RunReport]) -> Table:
    columns = (
        *("run", "overlap", "foot lag ms", "+-", "lever arm m", "heel strikes", "strides"),
        *("step frequency Hz", "standard error Hz", "R2 of places", "verdict"),
    )
    rows: list[tuple[str, ...]] = [
        (
            *(r.name, "can't be observed" if math.isnan(r.overlap) else f"{r.overlap:.3f}"),
            *_said(r.foot_lag, r.foot_lag_error, 1e3, 2), f"{r.evidence.lever_arm:.3f}",
            *(str(r.heel_strikes), str(r.strides)),
            *(f"{r.step_frequency:.4f}", f"{r.step_frequency_error:.4f}", f"{r.evidence.agreement:.4f}"),
            ": ".join(part for part in (r.verdict, r.reason or "; ".join(r.remarks)) if part),
        )
        for r in runs
    ]
    return "Runs", columns, rows
