"""Claims on the constraint model's gait: its frequency, its stability, and whether differences grow."""

import math

import numpy as np

from stages.comparison.claims.paper import FREQUENCY_HZ, LAST_DIGIT_HZ
from stages.comparison.claims.statement import Statement
from stages.comparison.evidence import NAN, Evidence
from stages.comparison.parameters import Settings
from stages.comparison.result import FAILS, HOLDS, OPEN, Judgement, percent, yes_or_no

SOLVER = ("analytic.tolerance", "analytic.transition")
PLANAR = ("ground.contact_stiffness", "ground.stiction_velocity", "multibody.tolerance")


def step_frequency(e: Evidence) -> tuple[float, float, str, float, tuple[float, float]]:
    analytic = e.results.analytic
    digits = next((one for one in analytic.uncertainties if one.name == "step_frequency_hz"), None)
    frequency = analytic.gait.step_frequency_hz
    if digits is None:  # all values are exact
        return frequency, 0.0, "", 0.0, (frequency, frequency)
    slopes = digits.slope_least, digits.slope_most
    return frequency, digits.worst, digits.decisive, digits.decisive_part, slopes


def judge_step_frequency(
    limits: Settings, frequency: float, rounding: float, decisive: str, part: float, slopes: tuple[float, float]
) -> Judgement:
    """The constraint model's step frequency [Hz], and by how much [Hz] rounding may move it.

    `rounding` in all digits of Table 1, at the worst; `part` of it in the last digit of the parameter `decisive`, which
    moves it most; on `slopes` that are rounded alike it lies between these.
    """
    off = frequency - FREQUENCY_HZ
    holds = abs(off / FREQUENCY_HZ) <= limits.frequency_tolerance
    allowed = rounding + LAST_DIGIT_HZ / 2
    needed, most = max(abs(off) - LAST_DIGIT_HZ / 2, 0.0), f"the last digit of {decisive}"
    enough = part >= needed
    digits = f"{allowed:.3f} Hz, the uncertainty from the last digits of Table 1 ({rounding:.4f} Hz) and of 2.08"
    return Judgement(
        f"{frequency:.4f} Hz, {percent(off / FREQUENCY_HZ)}",
        yes_or_no(holds),
        (
            (holds and abs(off) <= allowed, f"the {abs(off):.4f} Hz left are less than {digits}"),
            (
                holds and 0 < needed <= rounding,
                f"to be printed as {FREQUENCY_HZ} it needs {needed:.4f} Hz of these; {most} "
                + (f"decides: it alone contributes {part:.4f} Hz" if enough else f"has most, {part:.4f} Hz"),
            ),
            (
                slopes[0] < slopes[1],
                f"on slopes that round to the paper's it lies between {slopes[0]:.4f} and {slopes[1]:.4f} Hz",
            ),
            (
                holds and not abs(off) <= allowed,
                f"{abs(off):.4f} Hz is within {100 * limits.frequency_tolerance:g} %, though more than {digits}",
            ),
            (not holds, f"{abs(off):.4f} Hz is more than {100 * limits.frequency_tolerance:g} %"),
            (not holds and abs(off) > allowed, f"digits do not explain it: they are uncertain by {allowed:.4f} Hz"),
        ),
    )


def stable_gait(e: Evidence) -> tuple[float, float]:
    return e.results.analytic.gait.largest_multiplier, e.results.multibody.cycle.largest_multiplier


def judge_stable_gait(limits: Settings, constraint: float, multibody: float) -> Judgement:
    """Largest multipliers of the constraint model and of the planar multibody model; NaN where no gait was found."""
    worst = max(constraint, multibody)
    known = math.isfinite(constraint) and math.isfinite(multibody)
    verdict = yes_or_no(worst < 1) if known else (FAILS if constraint >= 1 else OPEN)
    return Judgement(
        f"largest multiplier {constraint:.4f} in the constraint model, "
        + (f"{multibody:.3f} in the multibody model" if known else "no multibody gait"),
        verdict,
        (
            (verdict == HOLDS, f"a disturbance shrinks to {worst:.2f} of its size with each step"),
            (verdict == FAILS, f"a disturbance grows {worst:.2f} times with each step"),
            (verdict == OPEN, "no fixed point of the multibody model was found, so it has no multipliers"),
        ),
    )


def multipliers_minimised(e: Evidence) -> tuple[float, float, str]:
    analytic = e.results.analytic
    options = [
        (value, f"{variation.name} {sign}{100 * variation.change:.0f} %")
        for variation in analytic.variations
        for value, sign in ((variation.multiplier_below, "-"), (variation.multiplier_above, "+"))
        if math.isfinite(value)
    ]
    return analytic.gait.largest_multiplier, *min(options, default=(NAN, ""))


def judge_multipliers_minimised(limits: Settings, now: float, best: float, change: str) -> Judgement:
    """The largest multiplier, and the lowest with one design parameter changed (NaN if none has a gait), and which."""
    known, unstable = math.isfinite(best), now >= 1
    improves = known and best < (1 - limits.multiplier_gain) * now
    gain = f"{100 * (1 - best / now):.1f} %"
    return Judgement(
        f"largest multiplier {now:.3f}" + (f"; {best:.3f} with {change}" if known else ""),
        FAILS if unstable else OPEN if improves or not known else HOLDS,
        (
            (unstable, f"a design tuned for stability has a multiplier below 1; this one has {now:.2f}"),
            (
                improves and not unstable,
                f"{change} alone lowers it by {gain}, so Table 1 is no minimum; but the sentence is about "
                "the optimum before it was fine-tuned to the robot, which is not printed",
            ),
            (
                known and not improves and not unstable,
                f"no parameter changed alone lowers it by {100 * limits.multiplier_gain:g} %",
            ),
            (not known and not unstable, "no neighbouring design has a gait to compare it with"),
        ),
    )


def chaos_amplifies(e: Evidence) -> tuple[float, float, float, int]:
    analytic = e.results.analytic
    matrix, of = analytic.monodromy_matrix, analytic.gait.steps
    cycles = max(len(analytic.walk.heel_strike_time) // of, 1)
    sizes = [float(np.linalg.norm(np.linalg.matrix_power(matrix, n), 2)) for n in range(1, cycles + 1)]
    return analytic.gait.largest_multiplier, max(sizes), sizes[-1], of * cycles


def judge_chaos_amplifies(limits: Settings, multiplier: float, most: float, left: float, steps: int) -> Judgement:
    """Growth of the most unlucky small disturbance: the most in any step of the walk, and what is left at its end.

    Factors on its size in leg lengths and pendulum times; `steps` of the walk; `multiplier` the largest.
    """
    grows = left > 1
    return Judgement(
        f"the disturbance that grows most is {most:.2g} times its size at its largest and {left:.2g} "
        f"times after the walk's {steps} steps",
        yes_or_no(grows),
        (
            (
                not grows,
                f"the gait is stable: in the long run a step leaves {multiplier:.2f} of a difference. The "
                "statement is about systems that can be chaotic; near this gait the walker is not",
            ),
            (not grows and most > 1, f"a step can first enlarge a difference, {most:.2g} times"),
            (grows, f"a step multiplies a difference by {multiplier:.2f} in the long run"),
        ),
    )


STATEMENTS = (
    Statement(
        "multipliers_minimised",
        "2.2",
        "A Newton-Raphson method was used to reach an optimal parameter set, for which the eigenvalues are minimum in "
        "magnitude [...] finally, their values were fine-tuned to measurements obtained from the robot.",
        "at the theoretical optimum, which is not printed, no change of a parameter lowers the largest multiplier; "
        "Table 1 is that optimum after fine-tuning",
        multipliers_minimised,
        judge_multipliers_minimised,
        SOLVER,
        plain="The design was chosen to be as stable as it can be.",
    ),
    Statement(
        "stable_gait",
        "2.2, 3.5",
        "The simplified biped model achieves stable walking in a negative slope of 2°.",
        "every multiplier of the step map is smaller than 1, in the constraint model and in the multibody model",
        stable_gait,
        judge_stable_gait,
        (*SOLVER, *PLANAR),
        plain="The robot walks down a slope of 2 degrees and recovers from small disturbances.",
    ),
    Statement(
        "chaos_amplifies",
        "3.2",
        "The dynamic divergence introduced by these factors, albeit small, can be amplified in systems capable of "
        "chaotic behaviours, as is the double pendulum, and lead to completely different simulation outcomes.",
        "along this walk a small difference between two computations grows",
        chaos_amplifies,
        judge_chaos_amplifies,
        ("analytic.steps", *SOLVER),
        plain="A tiny difference between two computations can grow until they describe different walks.",
    ),
    Statement(
        "step_frequency",
        "7.2",
        "This sampling rate is almost 50 times larger than the simulated walking frequency of 2.08 Hz.",
        "the constraint model with Table 1 takes 2.08 steps a second on a slope of 2 degrees",
        step_frequency,
        judge_step_frequency,
        SOLVER,
        units={"Hz": "frequency rounding part", "deg": "slopes"},
        plain="The robot takes 2.08 steps a second.",
    ),
)
