"""Claims that a calibration decides. Where the runs are not measured it decides as a method, and says so."""

import math
from collections.abc import Iterable

import numpy as np

from stages.biped.design import Biped
from stages.biped.quantity import count_of
from stages.calibrated_twin.result import Number
from stages.calibration.result import HALF_WIDTH
from stages.campaign.result import RunTruth
from stages.comparison.claims.measurement import MEASURED, RUNS, made_up
from stages.comparison.claims.statement import OF_ITS_ROW, Statement
from stages.comparison.evidence import NAN, Evidence
from stages.comparison.parameters import Settings
from stages.comparison.result import FAILS, HOLDS, HOLDS_IF, OPEN, Cause, Judgement, percent, yes_or_no

CALIBRATION = ("calibration.fitted_runs", "calibration.discrepancy_runs")
#: Fewer runs show no correlation of two numbers.
FEWEST_RUNS = 5


def as_a_method(origin: str) -> Cause:
    """What a verdict by runs that are not measured is about."""
    why = f"the runs are {origin}, made by the Exudyn twin: a verdict on that robot alone, fitted without its truth"
    return origin != MEASURED, why


def outsole_slows(e: Evidence) -> tuple[float, float, float, float, float, str, int, float, float, float, float, float]:
    """What the constraint model says of an outsole, and what pairs of runs do."""
    layer, usual = e.results.analytic.outsole, e.results.analytic.gait.step_frequency_hz
    pairs = [one for one in e.results.calibrated_twin.pairs if math.isfinite(one.slower + one.slower_sd)]

    def mean(field: str) -> float:
        return float(np.mean([getattr(one, field) for one in pairs])) if pairs else NAN

    return (
        layer.thickness,
        layer.frequency_without_mass / usual - 1,
        layer.frequency_with_mass / usual - 1,
        layer.mass,
        layer.turning_mass,
        e.measured.origin,
        len(pairs),
        mean("longer"),
        HALF_WIDTH * mean("longer_sd"),
        mean("slower"),
        HALF_WIDTH * mean("slower_sd"),
        mean("true_slower"),
    )


def judge_outsole_slows(
    limits: Settings,
    thickness: float,
    length_alone: float,
    with_mass: float,
    mass: float,
    turning: float,
    origin: str,
    pairs: int,
    longer: float,
    longer_half: float,
    slower: float,
    slower_half: float,
    really: float,
) -> Judgement:
    """Relative change of the step frequency (1) by an outsole: by its length and width alone, and with its mass [kg] a
    leg; `turning` [kg] is the mass at which the frequency stays the same. NaN if not computed.

    Calibrated from `pairs` of runs of one machine with the outsole and without: by how much its leg is `longer` [m] and
    its gait `slower` (1, negative), each with the half-width of its interval, and `really` slower.
    """
    known, weighed, calibrated = math.isfinite(length_alone), math.isfinite(with_mass), pairs > 0
    sure = not abs(slower) <= slower_half
    verdict = by_the_model(length_alone, with_mass)
    if calibrated:
        verdict = OPEN if not sure else FAILS if slower > 0 else verdict
    grams = f"{1e3 * mass:.1f} g"
    more = f", by {percent(with_mass)} with the {grams} of rubber a leg" if weighed else ""
    above = f"more than {1e3 * turning:.1f} g a leg" if math.isfinite(turning) else f"{grams} a leg"
    found = (
        f"; calibrated blind from {count_of(pairs, 'pair')} of {origin} runs with and without it, the leg is "
        f"{1e3 * longer:.2f} ± {1e3 * longer_half:.2f} mm longer and the step frequency changes by "
        f"{percent(slower)} ± {100 * slower_half:.2f} %"
    )
    return Judgement(
        (f"{1e3 * thickness:.1f} mm of outsole without mass change the step frequency by "
         f"{percent(length_alone)}{more}" if known else "no gait with an outsole")
        + (found if calibrated else ""),
        verdict,
        (
            (calibrated and origin != MEASURED, as_a_method(origin)[1]),
            (calibrated and not sure, "the calibrated interval of the change holds zero"),
            (calibrated and sure and slower > 0, f"the runs step quicker with it, by {percent(slower)}"),
            (calibrated and math.isfinite(really),
                  f"the robots of the runs really differ by {percent(really)}"),
            (verdict == HOLDS, "the longer leg is the slower pendulum, without any mass"),
            (
                length_alone >= 0,
                "length alone quickens the gait: it also raises the leg's mass centre and enlarges the foot's radius",
            ),
            (verdict == HOLDS_IF, f"the rubber's mass alone: {percent(with_mass - length_alone)}"),
            (verdict == FAILS and length_alone >= 0 and not with_mass < 0, "its mass does not outweigh that"),
            (length_alone >= 0 and not weighed, "what the rubber's mass does was not computed"),
            (not known, "no gait was found with an outsole"),
        ),
        f"the rubber's mass is meant with its length, and is {above}" if verdict == HOLDS_IF else "",
    )  # fmt: skip


def by_the_model(length_alone: float, with_mass: float) -> str:
    """The verdict on an outsole by what the constraint model says of its length, and of its mass with it."""
    if length_alone < 0:
        return HOLDS
    known = math.isfinite(length_alone) and math.isfinite(with_mass)
    return OPEN if not known else HOLDS_IF if with_mass < 0 else FAILS


def push_slows(e: Evidence) -> tuple[str, int, int, float, float, float]:
    frequencies = {run.report.name: run.report.step_frequency for run in e.results.imu.runs}
    truths = [truth for truth in e.results.campaign.runs if truth.name in frequencies]
    return e.measured.origin, len(frequencies), len(truths), *pushes_and_frequency(truths, frequencies)


def judge_push_slows(
    limits: Settings, origin: str, runs: int, pushed: int, correlation: float, significant: float, explained: float
) -> Judgement:
    """Of how many runs the push is known, the correlation of step frequency with it over the runs, the smallest
    magnitude that would be significant at 5 %, and the part of the frequencies' variance that the pushes explain; NaN
    if that is not known."""
    known, real = math.isfinite(correlation), origin == MEASURED
    tied = abs(correlation) > significant
    return Judgement(
        f"over {runs} {origin} runs frequency and push correlate by {correlation:+.2f} "
        f"(significant beyond {significant:.2f}); pushes explain {100 * explained:.0f} % of its variance"
        if known
        else f"the pushes of the {origin} runs are not known" if pushed < runs
        else f"{runs} {origin} runs are too few to correlate frequency and push" if runs < FEWEST_RUNS
        else f"the {origin} runs do not differ in push, or not in frequency",
        yes_or_no(tied) if known and real else OPEN,
        (
            made_up(origin),
            (
                known and not tied,
                f"{abs(correlation):.2f} is no more than chance gives {runs} runs, transient left out",
            ),
            (known and real and tied, f"pushes explain {100 * explained:.0f} % of the variance"),
            (known and not real and tied, "among these runs the frequency does go with the push"),
            (real and not known, "the database holds no pushes"),
        ),
    )


#: Of a parameter its name, the ends of its interval, Table 1's value, and the unit of all three.
Interval = tuple[str, float, float, float, str]


def prototype_is_model(e: Evidence) -> tuple[str, int, tuple[Interval, ...], int]:
    """The first robot's parameters beside Table 1's; those that Table 1 does not print are left out."""
    robots = e.results.calibrated_twin.robots
    if not robots:
        return e.measured.origin, 0, (), -1
    robot = robots[0]
    found = [(one, printed) for one in robot.numbers if (printed := _printed(e.parameters.biped, one)) > 0]
    intervals = tuple((one.name.partition(".")[2], *one.interval(HALF_WIDTH), printed, one.unit)
                      for one, printed in found)
    true = [one for one, _ in found if math.isfinite(one.truth)]
    held = sum(one.holds_truth(HALF_WIDTH) for one in true)
    return e.measured.origin, robot.runs, intervals, held if true else -1


def judge_prototype_is_model(
    limits: Settings, origin: str, runs: int, intervals: tuple[Interval, ...], held: int
) -> Judgement:
    """Intervals of parameters estimated from `runs`, with Table 1's values. Of the intervals `held` hold the machine's
    true value, where that is known; -1 where it is not."""
    known = bool(intervals)
    off = [name for name, lower, upper, printed, _ in intervals if not lower <= printed <= upper]
    wide = [name for name, lower, upper, printed, _ in intervals
            if name not in off and max(upper / printed, printed / lower) > limits.small_change]  # fmt: skip
    verdict = OPEN if not known or (wide and not off) else yes_or_no(not off)
    said = ", ".join(f"{name} {lower:.4g}..{upper:.4g} ({printed:g})" for name, lower, upper, printed, _ in
                     intervals)  # fmt: skip
    return Judgement(
        f"estimated from {count_of(runs, f'{origin} run')}, with biped.yaml's in brackets: {said}" if known
        else "no parameter was estimated from the runs",
        verdict,
        (
            as_a_method(origin),
            (not known, "a step frequency that agrees fits many sets of parameters: they must be estimated"),
            (verdict == HOLDS, "every interval holds the value of Table 1"),
            (bool(off), f"Table 1 lies outside for {', '.join(off)}"),
            (known and not off and bool(wide), f"too wide to decide: {', '.join(wide)}"),
            (held >= 0, f"{held} of {len(intervals)} intervals hold the robot's true value"),
        ),
    )  # fmt: skip


def _printed(biped: Biped, number: Number) -> float:
    """Table 1's value of a number; zero for one that is none of the biped's."""
    owner, _, key = number.name.partition(".")
    return biped.number(key) if owner == Biped.FILE else 0.0


def pushes_and_frequency(truths: Iterable[RunTruth], frequencies: dict[str, float]) -> tuple[float, float, float]:
    """Correlation of the runs' frequencies with the push of the stance leg, its 5 % level, and the part of the
    frequencies' variance that the pushes of both legs explain; for runs whose truth is known."""
    from scipy.special import stdtrit

    known = [truth for truth in truths if truth.name in frequencies]
    count = len(known)
    found = np.array([frequencies[truth.name] for truth in known])
    if count < FEWEST_RUNS or count < len(frequencies) or np.ptp(found) == 0:
        return NAN, NAN, NAN
    pushes = np.array([(truth.stance_push, truth.swing_push) for truth in known])
    if not (np.ptp(pushes, axis=0) > 0).all():
        return NAN, NAN, NAN
    t = stdtrit(count - 2, 0.975)
    terms = np.column_stack([np.ones(count), pushes])
    left = found - terms @ np.linalg.lstsq(terms, found, rcond=None)[0]
    explained = 1 - float((left**2).sum() / ((found - found.mean()) ** 2).sum())
    return float(np.corrcoef(pushes[:, 0], found)[0, 1]), float(t / math.sqrt(count - 2 + t**2)), explained


STATEMENTS = (
    Statement(
        "outsole_slows",
        "7.4",
        "This small difference can be attributed to the extra length added to the biped's legs due to the rubber "
        "outsoles, as a larger length generally leads to slower swing frequencies in pendulum-like systems.",
        "an outsole lowers the step frequency, by the length that it adds",
        outsole_slows,
        judge_outsole_slows,
        (
            "analytic.tolerance",
            "analytic.outsole",
            "twin.outsole_arc",
            "twin.outsole_density",
            *RUNS,
            "campaign.bare_runs",
        ),
        units={"kg": "mass turning", "m": "thickness longer longer_half"},
        plain="Rubber under the feet makes the robot step more slowly, because it makes the legs longer.",
    ),
    Statement(
        "push_slows",
        "7.4",
        "Another reason for this divergence could be the partial randomness in the initial velocity of the biped after "
        "each push at the beginning of each experiment.",
        "over the runs, step frequency goes with the push",
        push_slows,
        judge_push_slows,
        (*RUNS, "campaign.seed", "imu.skipped_steps"),
        plain="How hard the robot is pushed at the start decides in part how fast it then steps.",
    ),
    Statement(
        "prototype_is_model",
        "7.4",
        "[...] the dynamic elements and geometry of the prototype truly correspond to the parameter values selected "
        "and used in the simulation models.",
        "parameters estimated from the runs, with their intervals, hold those of Table 1",
        prototype_is_model,
        judge_prototype_is_model,
        (*RUNS, *CALIBRATION),
        units={OF_ITS_ROW: "intervals"},
        plain="The robot that was built has the masses and lengths of the model.",
    ),
)
