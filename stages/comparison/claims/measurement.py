"""Claims on sensors and measurements. Runs that are not measured test the method; they decide nothing here."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from stages.biped.walk import SENSOR_SIGNALS
from stages.comparison import studies
from stages.comparison.claims.measured import Measured
from stages.comparison.claims.paper import ACCELEROMETER_G, GYROSCOPE_DEG_S, STANDARD_GRAVITY
from stages.comparison.claims.verdict import (
    FAILS,
    HOLDS,
    HOLDS_IF,
    OPEN,
    Cause,
    Judgement,
    mm,
    percent,
    yes_or_no,
)
from stages.comparison.evidence import NAN, Evidence
from stages.comparison.parameters import Settings

MEASURED = "measured"
RUNS = ("imu.database", "campaign.outsole", "campaign.push_sd", "campaign.tolerance_sd")
TWIN = ("twin.inertia", "twin.parts")


def made_up(origin: str) -> Cause:
    """Why runs that are not measured decide nothing."""
    why = f"the runs are {origin}, made from the twin: they test the method, they cannot confirm a model"
    return Cause(origin != MEASURED, why)


@dataclass(frozen=True)
class SensorRange(Measured):
    """The twin's largest specific forces [g] and rate [deg/s], and the time [s] a step of `period` [s] above the range.

    `spread` and `times` are the least and the largest peak at the hip [g] and time above the range [s] over members of
    the contact set's family towards the rigid limit;
    `filtered` [g] is the peak at the hip behind the low pass of the campaign's sensors.
    """

    ID = "sensor_range"
    UNITS = (("g", "hip foot spread filtered"), ("deg/s", "rate"), ("s", "above period times"))
    RESTS_ON = (*TWIN, "ground.contact_stiffness", "ground.contact_damping", "campaign.bandwidth_hz")

    hip: float
    foot: float
    rate: float
    above: float
    period: float
    spread: tuple[float, float]
    times: tuple[float, float]
    filtered: float

    def judge(self, limits: Settings) -> Judgement:
        inside = self.above == 0 and self.rate <= GYROSCOPE_DEG_S
        brief = self.above <= limits.impact_share * self.period and self.rate <= GYROSCOPE_DEG_S
        verdict = HOLDS if inside else HOLDS_IF if brief else FAILS
        time, rest = f"{1e3 * self.above:.1f} ms a step", 1 - self.above / self.period
        return Judgement(
            f"{time} ({100 * self.above / self.period:.1f} %) lie above {ACCELEROMETER_G:g} g; the largest rate is "
            f"{self.rate:.0f} deg/s; peaks of {self.hip:.0f} g at the hip and {self.foot:.0f} g at the foot",
            verdict,
            (
                Cause(inside, f"no more than {max(self.hip, self.foot):.1f} g and {self.rate:.0f} deg/s occur"),
                Cause(
                    verdict == HOLDS_IF,
                    f"outside of the impact, in {100 * rest:.1f} % of a step, all stays in range",
                ),
                Cause(
                    self.above > 0 and self.spread[1] > 2 * self.spread[0],
                    "how high the spike is belongs to the contact set, not to the gait: "
                    f"{self.spread[0]:.0f} to {self.spread[1]:.0f} g at the hip over its family, for "
                    f"{1e3 * self.times[0]:.1f} to {1e3 * self.times[1]:.1f} ms a step above the range",
                ),
                Cause(
                    self.above > 0 and self.filtered <= ACCELEROMETER_G,
                    f"behind a sensor's low pass it is {self.filtered:.1f} g at the hip (synthetic)",
                ),
                Cause(verdict == FAILS and self.rate > GYROSCOPE_DEG_S, f"{self.rate:.0f} deg/s is beyond the range"),
                Cause(verdict == FAILS and not brief and self.rate <= GYROSCOPE_DEG_S,
                      f"{time} are more than the {100 * limits.impact_share:g} % allowed to impacts"),
            ),
            f"the {time} around heel strike are not counted" if verdict == HOLDS_IF else "",
        )  # fmt: skip


@dataclass(frozen=True)
class MeasurementEncloses(Measured):
    """Shares of the stride (1) in which the runs' envelope holds the twin: hip forward, hip up, angular velocity."""

    ID = "measurement_encloses"
    RESTS_ON = (*RUNS, *TWIN)

    origin: str
    runs: int
    shares: tuple[float, ...]

    def judge(self, limits: Settings) -> Judgement:
        real, worst = self.origin == MEASURED, min(self.shares)
        encloses = worst >= limits.enclosure_share
        return Judgement(
            f"the envelope of {self.runs} {self.origin} runs holds the twin over "
            + ", ".join(f"{100 * share:.0f} %" for share in self.shares)
            + " of the stride (hip forward, hip up, angular velocity)",
            yes_or_no(encloses) if real else OPEN,
            (
                made_up(self.origin),
                Cause(real and encloses, f"every signal lies inside for at least {100 * worst:.0f} % of the stride"),
                Cause(real and not encloses, f"one signal lies outside for {100 * (1 - worst):.0f} % of the stride"),
            ),
        )


@dataclass(frozen=True)
class MeasurementSlower(Measured):
    """Step frequencies [Hz] of the runs and of the twin over the same steps, and the interval of their difference."""

    ID = "measurement_slower"
    UNITS = (("Hz", "frequency twin lower upper"),)
    RESTS_ON = (*RUNS, *TWIN)

    origin: str
    frequency: float
    twin: float
    lower: float
    upper: float

    def judge(self, limits: Settings) -> Judgement:
        real, change = self.origin == MEASURED, self.frequency / self.twin - 1
        slower, sure = change < 0, not self.lower <= 0 <= self.upper
        interval = f"{1e3 * self.lower:+.1f} to {1e3 * self.upper:+.1f} mHz"
        return Judgement(
            f"{self.origin} runs {self.frequency:.4f} Hz, twin {self.twin:.4f} Hz over the same steps, "
            f"{percent(change)}",
            (yes_or_no(slower) if sure else OPEN) if real else OPEN,
            (
                made_up(self.origin),
                Cause(real and slower and sure, f"the whole interval of the difference is below zero: {interval}"),
                Cause(real and not slower and sure, f"the runs are quicker: {interval}"),
                Cause(real and not sure, f"the interval of the difference holds zero: {interval}"),
            ),
        )


@dataclass(frozen=True)
class PushSlows(Measured):
    """Correlation of step frequency with the push over the runs, the smallest magnitude that would be significant at
    5 %, and the part of the frequencies' variance that the pushes explain; NaN if the pushes are not known."""

    ID = "push_slows"
    RESTS_ON = (*RUNS, "campaign.seed", "imu.skipped_steps")

    origin: str
    runs: int
    correlation: float
    significant: float
    explained: float

    def judge(self, limits: Settings) -> Judgement:
        known, real = math.isfinite(self.correlation), self.origin == MEASURED
        tied = abs(self.correlation) > self.significant
        return Judgement(
            f"over {self.runs} {self.origin} runs frequency and push correlate by {self.correlation:+.2f} "
            f"(significant beyond {self.significant:.2f}); pushes explain {100 * self.explained:.0f} % of its variance"
            if known
            else f"the pushes of the {self.origin} runs are not known",
            yes_or_no(tied) if known and real else OPEN,
            (
                made_up(self.origin),
                Cause(
                    known and not tied,
                    f"{abs(self.correlation):.2f} is no more than chance gives {self.runs} runs, transient left out",
                ),
                Cause(known and real and tied, f"pushes explain {100 * self.explained:.0f} % of the variance"),
                Cause(known and not real and tied, "among these runs the frequency does go with the push"),
                Cause(real and not known, "the database holds no pushes"),
            ),
        )


@dataclass(frozen=True)
class HipPathDrifts(Measured):
    """Errors of the hip's path against the truth of synthetic runs: rms of where two integrations of the acceleration
    put the last strike [m], over a way of `way` [m]; rms of a step's length by one integration of the rate and the foot
    that rolls, relative; rms of the leg angle [rad]. NaN where there is no truth. Then the runs' step length and that
    of twin and simple model [m], and the standard error the ingest gives a step [m]; NaN where no run has any.
    """

    ID = "hip_path_drifts"
    UNITS = (("m", "way twice step_length said twin simple"), ("rad", "angle"))
    METHOD = True
    RESTS_ON = (*RUNS, "campaign.acceleration_bias_sd", "campaign.angular_rate_gain_sd", "imu.foot_radius")

    origin: str
    way: float
    twice: float
    once: float
    angle: float
    step_length: float
    said: float
    twin: float
    simple: float

    def judge(self, limits: Settings) -> Judgement:
        known, seen = math.isfinite(self.twice) and math.isfinite(self.once), math.isfinite(self.step_length)
        drifts, enough = self.twice > limits.hip_path_share * self.way, self.once <= limits.hip_path_share
        verdict = OPEN if not known else FAILS if not drifts else HOLDS_IF if enough else HOLDS
        errors = f"the true path of the {self.origin} runs is not known"
        if known:
            errors = (
                f"against the truth of {self.origin} runs two integrations of the acceleration put the hip "
                f"{mm(self.twice)} off after {self.way:.2f} m ({100 * self.twice / self.way:.0f} %); one of the rate "
                f"and the foot that rolls leave {100 * self.once:.2f} % of a step's length, and "
                f"{math.degrees(self.angle):.2f} degrees of the leg's angle"
            )
        lengths = (
            f"; their steps are {mm(self.step_length)} long, each ± {mm(self.said)}, the twin's {mm(self.twin)}, the "
            f"simple model's {mm(self.simple)}"
            if seen
            else ""
        )
        return Judgement(
            errors + lengths,
            verdict,
            (
                Cause(known and drifts, "an accelerometer's bias grows with the square of time"),
                Cause(known and not drifts, "the accelerometers' biases are too small to matter over such a walk"),
                Cause(
                    known and drifts and enough,
                    "the second integration is not needed: while a foot rolls, the leg's angle tells where the hip is",
                ),
                Cause(known and drifts and not enough, "nor does one integration do with these gyroscopes"),
                Cause(not known, "only runs whose truth is known can tell how far a path drifts"),
            ),
            "it is the acceleration that is integrated; one integration of the rate is enough"
            if verdict == HOLDS_IF
            else "",
        )


def sensor_range(e: Evidence) -> SensorRange:
    known = [one for one in e.results.campaign.spikes if math.isfinite(one.hip_peak)]
    peaks = tuple(one.hip_peak / STANDARD_GRAVITY for one in known)
    behind = [run.hip.peak_filtered for run in e.results.campaign.runs]
    return SensorRange(
        e.twin.peak_specific_force / STANDARD_GRAVITY,
        e.twin.peak_foot_specific_force / STANDARD_GRAVITY,
        math.degrees(e.twin.peak_rate),
        e.twin.time_above_range,
        1 / e.twin.step_frequency,
        (min(peaks, default=NAN), max(peaks, default=NAN)),
        (min((one.time_above_range for one in known), default=NAN),
         max((one.time_above_range for one in known), default=NAN)),
        float(np.median(behind)) / STANDARD_GRAVITY if behind else NAN,
    )  # fmt: skip


def hip_path_drifts(e: Evidence) -> HipPathDrifts:
    legs, seen = e.ingest.leg if e.ingest is not None else None, e.measured.leg
    lengths = (NAN,) * 4
    if seen is not None:
        lengths = seen.runs.step_length, seen.step_length_error, seen.twin.step_length, seen.simple.step_length
    truth = (NAN,) * 4
    if legs is not None:
        truth = (float(np.mean(legs.way)), _rms(legs.twice), _rms(legs.step), _rms(legs.angle))
    return HipPathDrifts(e.measured.origin, *truth, *lengths)


def _rms(errors: np.ndarray) -> float:
    known = errors[np.isfinite(errors)]
    return float(np.sqrt(np.mean(known**2))) if len(known) else NAN


def encloses(e: Evidence) -> MeasurementEncloses:
    measured = e.measured
    shares = tuple(measured.twin[name].envelope_share for name in SENSOR_SIGNALS[:3])
    return MeasurementEncloses(measured.origin, measured.runs, shares)


def slower(e: Evidence) -> MeasurementSlower:
    measured = e.measured
    interval = measured.twin_frequency
    return MeasurementSlower(
        measured.origin, measured.step_frequency, measured.twin_step_frequency, interval.lower, interval.upper
    )


def push_slows(e: Evidence) -> PushSlows:
    frequencies = {run.report.name: run.report.step_frequency for run in e.results.imu.runs}
    found = studies.pushes_and_frequency(e.results.campaign.runs, frequencies)
    return PushSlows(e.measured.origin, len(frequencies), *found)
