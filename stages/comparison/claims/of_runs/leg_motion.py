"""The claim on what two integrations of a measured acceleration would leave of the hip's path."""

from __future__ import annotations

import math
from dataclasses import dataclass

from stages.comparison.claims.measured import Measured
from stages.comparison.claims.of_runs.measurement import RUNS
from stages.comparison.claims.verdict import FAILS, HOLDS, HOLDS_IF, OPEN, Cause, Judgement, mm
from stages.comparison.parameters import Settings


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
