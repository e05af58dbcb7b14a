"""Claims on sensors and measurements. Runs that are not measured test the method; they decide nothing here."""

from __future__ import annotations

import math
from dataclasses import dataclass

from stages.comparison.claims.measured import Measured
from stages.comparison.claims.paper import ACCELEROMETER_G, GYROSCOPE_DEG_S
from stages.comparison.claims.verdict import (
    FAILS,
    HOLDS,
    HOLDS_IF,
    OPEN,
    Cause,
    Judgement,
    percent,
    yes_or_no,
)
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
