"""Claims on the constraint model's gait: its frequency, its stability, and whether differences grow."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from stages.comparison.claims.measured import Measured
from stages.comparison.claims.paper import FREQUENCY_HZ, LAST_DIGIT_HZ
from stages.comparison.claims.verdict import FAILS, HOLDS, OPEN, Cause, Judgement, percent, yes_or_no
from stages.comparison.evidence import NAN, Evidence, largest
from stages.comparison.parameters import Settings

SOLVER = ("analytic.tolerance", "analytic.transition")
PLANAR = ("ground.contact_stiffness", "ground.stiction_velocity", "multibody.tolerance")


@dataclass(frozen=True)
class StepFrequency(Measured):
    """The constraint model's step frequency [Hz], and by how much [Hz] rounding may move it.

    `rounding` in all digits of Table 1, at the worst; `part` of it in the last digit of the parameter `decisive`, which
    moves it most; on `slopes` that are rounded alike it lies between these.
    """

    ID = "step_frequency"
    UNITS = (("Hz", "frequency rounding part"), ("deg", "slopes"))
    RESTS_ON = SOLVER

    frequency: float
    rounding: float
    decisive: str
    part: float
    slopes: tuple[float, float]

    def judge(self, limits: Settings) -> Judgement:
        off = self.frequency - FREQUENCY_HZ
        holds = abs(off / FREQUENCY_HZ) <= limits.frequency_tolerance
        allowed = self.rounding + LAST_DIGIT_HZ / 2
        needed, most = max(abs(off) - LAST_DIGIT_HZ / 2, 0.0), f"the last digit of {self.decisive}"
        enough = self.part >= needed
        digits = f"{allowed:.3f} Hz, which the last digits of Table 1 ({self.rounding:.4f} Hz) and of 2.08 leave open"
        return Judgement(
            f"{self.frequency:.4f} Hz, {percent(off / FREQUENCY_HZ)}",
            yes_or_no(holds),
            (
                Cause(holds and abs(off) <= allowed, f"the {abs(off):.4f} Hz left are less than {digits}"),
                Cause(
                    holds and 0 < needed <= self.rounding,
                    f"to be printed as {FREQUENCY_HZ} it needs {needed:.4f} Hz of these; {most} "
                    + (f"decides: alone it leaves {self.part:.4f} Hz" if enough else f"has most, {self.part:.4f} Hz"),
                ),
                Cause(
                    self.slopes[0] < self.slopes[1],
                    f"on slopes that round to the paper's it lies between {self.slopes[0]:.4f} and "
                    f"{self.slopes[1]:.4f} Hz",
                ),
                Cause(
                    holds and not abs(off) <= allowed,
                    f"{abs(off):.4f} Hz is within {100 * limits.frequency_tolerance:g} %, though more than {digits}",
                ),
                Cause(not holds, f"{abs(off):.4f} Hz is more than {100 * limits.frequency_tolerance:g} %"),
                Cause(not holds and abs(off) > allowed, f"digits do not explain it: they leave {allowed:.4f} Hz open"),
            ),
        )


@dataclass(frozen=True)
class StableGait(Measured):
    """Largest multipliers of the constraint model and of the planar multibody model; NaN where no gait was found."""

    ID = "stable_gait"
    RESTS_ON = (*SOLVER, *PLANAR)

    constraint: float
    multibody: float

    def judge(self, limits: Settings) -> Judgement:
        worst = max(self.constraint, self.multibody)
        known = math.isfinite(self.constraint) and math.isfinite(self.multibody)
        verdict = yes_or_no(worst < 1) if known else (FAILS if self.constraint >= 1 else OPEN)
        return Judgement(
            f"largest multiplier {self.constraint:.4f} in the constraint model, "
            + (f"{self.multibody:.3f} in the multibody model" if known else "no multibody gait"),
            verdict,
            (
                Cause(verdict == HOLDS, f"a disturbance shrinks to {worst:.2f} of its size with each step"),
                Cause(verdict == FAILS, f"a disturbance grows {worst:.2f} times with each step"),
                Cause(verdict == OPEN, "no fixed point of the multibody model was found, so it has no multipliers"),
            ),
        )


@dataclass(frozen=True)
class MultipliersMinimised(Measured):
    """The largest multiplier, and the lowest with one design parameter changed (NaN if none has a gait), and which."""

    ID = "multipliers_minimised"
    RESTS_ON = SOLVER

    now: float
    best: float
    change: str

    def judge(self, limits: Settings) -> Judgement:
        known, unstable = math.isfinite(self.best), self.now >= 1
        improves = known and self.best < (1 - limits.multiplier_gain) * self.now
        gain = f"{100 * (1 - self.best / self.now):.1f} %"
        return Judgement(
            f"largest multiplier {self.now:.3f}" + (f"; {self.best:.3f} with {self.change}" if known else ""),
            FAILS if unstable else OPEN if improves or not known else HOLDS,
            (
                Cause(unstable, f"a design tuned for stability has a multiplier below 1; this one has {self.now:.2f}"),
                Cause(
                    improves and not unstable,
                    f"{self.change} alone lowers it by {gain}, so Table 1 is no minimum; but the sentence is about "
                    "the optimum before it was fine-tuned to the robot, which is not printed",
                ),
                Cause(
                    known and not improves and not unstable,
                    f"no parameter changed alone lowers it by {100 * limits.multiplier_gain:g} %",
                ),
                Cause(not known and not unstable, "no neighbouring design has a gait to compare it with"),
            ),
        )


@dataclass(frozen=True)
class ChaosAmplifies(Measured):
    """Growth of the most unlucky small disturbance: the most in any step of the walk, and what is left at its end.

    Factors on its size in leg lengths and pendulum times; `steps` of the walk; `multiplier` the largest.
    """

    ID = "chaos_amplifies"
    RESTS_ON = ("analytic.steps", *SOLVER)

    multiplier: float
    most: float
    left: float
    steps: int

    def judge(self, limits: Settings) -> Judgement:
        grows = self.left > 1
        return Judgement(
            f"the disturbance that grows most is {self.most:.2g} times its size at its largest and {self.left:.2g} "
            f"times after the walk's {self.steps} steps",
            yes_or_no(grows),
            (
                Cause(
                    not grows,
                    f"the gait is stable: in the long run a step leaves {self.multiplier:.2f} of a difference. The "
                    "statement is about systems that can be chaotic; near this gait the walker is not",
                ),
                Cause(not grows and self.most > 1, f"a step can first enlarge a difference, {self.most:.2g} times"),
                Cause(grows, f"a step multiplies a difference by {self.multiplier:.2f} in the long run"),
            ),
        )


def step_frequency(e: Evidence) -> StepFrequency:
    analytic = e.results.analytic
    digits = next((one for one in analytic.uncertainties if one.name == "step_frequency_hz"), None)
    frequency = analytic.gait.step_frequency_hz
    if digits is None:  # all values are exact
        return StepFrequency(frequency, 0.0, "", 0.0, (frequency, frequency))
    slopes = digits.slope_least, digits.slope_most
    return StepFrequency(frequency, digits.worst, digits.decisive, digits.decisive_part, slopes)


def stable_gait(e: Evidence) -> StableGait:
    planar = e.results.multibody.cycle.largest_multiplier
    return StableGait(largest(e.results.analytic.gait.floquet_multipliers), planar)


def multipliers_minimised(e: Evidence) -> MultipliersMinimised:
    analytic = e.results.analytic
    options = [
        (value, f"{variation.name} {sign}{100 * variation.change:.0f} %")
        for variation in analytic.variations
        for value, sign in ((variation.multiplier_below, "-"), (variation.multiplier_above, "+"))
        if math.isfinite(value)
    ]
    return MultipliersMinimised(largest(analytic.gait.floquet_multipliers), *min(options, default=(NAN, "")))


def chaos_amplifies(e: Evidence) -> ChaosAmplifies:
    analytic = e.results.analytic
    steps, matrix = len(analytic.walk.heel_strike_time), analytic.monodromy_matrix
    sizes = [float(np.linalg.norm(np.linalg.matrix_power(matrix, n), 2)) for n in range(1, max(steps, 1) + 1)]
    return ChaosAmplifies(largest(analytic.gait.floquet_multipliers), max(sizes), sizes[-1], len(sizes))
