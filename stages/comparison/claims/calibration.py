"""Claims that a calibration decides. Where the runs are not measured it decides as a method, and says so."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from stages.biped.design import Biped
from stages.calibrated_twin.result import Number
from stages.calibration.result import HALF_WIDTH
from stages.comparison.claims.measured import Measured
from stages.comparison.claims.measurement import MEASURED, RUNS
from stages.comparison.claims.verdict import FAILS, HOLDS, HOLDS_IF, OPEN, Cause, Judgement, percent, yes_or_no
from stages.comparison.evidence import NAN, Evidence
from stages.comparison.parameters import Settings

CALIBRATION = ("calibration.fitted_runs", "calibration.discrepancy_runs")


def as_a_method(origin: str) -> Cause:
    """What a verdict by runs that are not measured is about."""
    why = f"the runs are {origin}, made by the Exudyn twin: this is a verdict on that machine, found blind, on no other"
    return Cause(origin != MEASURED, why)


@dataclass(frozen=True)
class OutsoleSlows(Measured):
    """Relative change of the step frequency (1) by an outsole: by its length and width alone, and with its mass [kg] a
    leg; `turning` [kg] is the mass at which the frequency stays the same. NaN if not computed.

    Calibrated from `pairs` of runs of one machine with the outsole and without: by how much its leg is `longer` [m] and
    its gait `slower` (1, negative), each with the half-width of its interval, and `really` slower.
    """

    ID = "outsole_slows"
    UNITS = (("kg", "mass turning"), ("m", "thickness longer longer_half"))
    RESTS_ON = ("analytic.tolerance", "analytic.outsole", "twin.outsole_arc", "twin.outsole_density", *RUNS,
                "campaign.bare_runs")

    thickness: float
    length_alone: float
    with_mass: float
    mass: float
    turning: float
    origin: str
    pairs: int
    longer: float
    longer_half: float
    slower: float
    slower_half: float
    really: float

    def judge(self, limits: Settings) -> Judgement:
        known, calibrated = math.isfinite(self.length_alone), self.pairs > 0
        by_length, by_mass = self.length_alone < 0, self.with_mass < 0
        undecided = known and not by_length and not math.isfinite(self.with_mass)
        verdict = OPEN if undecided or not known else HOLDS if by_length else HOLDS_IF if by_mass else FAILS
        sure = not abs(self.slower) <= self.slower_half
        if calibrated:
            verdict = OPEN if not sure else FAILS if self.slower > 0 else verdict
        grams, weighed = f"{1e3 * self.mass:.1f} g", math.isfinite(self.with_mass)
        more = f", by {percent(self.with_mass)} with the {grams} of rubber a leg" if weighed else ""
        above = f"more than {1e3 * self.turning:.1f} g a leg" if math.isfinite(self.turning) else f"{grams} a leg"
        found = (
            f"; calibrated blind from {self.pairs} {'pair' if self.pairs == 1 else 'pairs'} of {self.origin} runs with "
            f"and without it, the leg is {1e3 * self.longer:.2f} ± {1e3 * self.longer_half:.2f} mm longer and the step "
            f"frequency changes by {percent(self.slower)} ± {100 * self.slower_half:.2f} %"
        ) if calibrated else ""
        return Judgement(
            (f"{1e3 * self.thickness:.1f} mm of outsole without mass change the step frequency by "
             f"{percent(self.length_alone)}{more}" if known else "no gait with an outsole") + found,
            verdict,
            (
                Cause(calibrated and self.origin != MEASURED, as_a_method(self.origin).words),
                Cause(calibrated and not sure, "the calibrated interval of the change holds zero"),
                Cause(calibrated and math.isfinite(self.really),
                      f"the machines of the runs really differ by {percent(self.really)}"),
                Cause(verdict == HOLDS, "the longer leg is the slower pendulum, without any mass"),
                Cause(
                    known and not by_length,
                    "length alone quickens the gait: it also raises the leg's mass and widens the foot",
                ),
                Cause(verdict == HOLDS_IF, f"the rubber's mass alone: {percent(self.with_mass - self.length_alone)}"),
                Cause(verdict == FAILS and not by_mass, "its mass does not outweigh that"),
                Cause(undecided, "what the rubber's mass does was not computed"),
                Cause(not known, "no gait was found with an outsole"),
            ),
            f"the rubber's mass is meant with its length, and is {above}" if verdict == HOLDS_IF else "",
        )  # fmt: skip


@dataclass(frozen=True)
class PrototypeIsModel(Measured):
    """Intervals of parameters estimated from `runs`, with Table 1's values: (name, lower, upper, printed). Of the
    intervals `held` hold the machine's true value, where that is known; -1 where it is not."""

    ID = "prototype_is_model"
    RESTS_ON = (*RUNS, *CALIBRATION)

    origin: str
    runs: int
    intervals: tuple[tuple[str, float, float, float], ...]
    held: int

    def judge(self, limits: Settings) -> Judgement:
        known = bool(self.intervals)
        off = [name for name, lower, upper, printed in self.intervals if not lower <= printed <= upper]
        wide = [name for name, lower, upper, printed in self.intervals
                if name not in off and max(upper / printed, printed / lower) > limits.small_change]  # fmt: skip
        verdict = OPEN if not known or (wide and not off) else yes_or_no(not off)
        said = ", ".join(f"{name} {lower:.4g} to {upper:.4g} ({printed:g})" for name, lower, upper, printed in
                         self.intervals)  # fmt: skip
        runs = f"{self.runs} {self.origin} {'run' if self.runs == 1 else 'runs'}"
        return Judgement(
            f"estimated blind from {runs}, with Table 1 in brackets: {said}" if known
            else "no parameter was estimated from the runs",
            verdict,
            (
                as_a_method(self.origin),
                Cause(not known, "a step frequency that agrees fits many sets of parameters: they must be estimated"),
                Cause(verdict == HOLDS, "every interval holds the value of Table 1"),
                Cause(bool(off), f"Table 1 lies outside for {', '.join(off)}"),
                Cause(known and not off and bool(wide), f"too wide to decide: {', '.join(wide)}"),
                Cause(self.held >= 0, f"{self.held} of {len(self.intervals)} intervals hold the machine's true value"),
            ),
        )  # fmt: skip


def outsole_slows(e: Evidence) -> OutsoleSlows:
    """What the constraint model says of an outsole, and what pairs of runs do."""
    layer, usual = e.results.analytic.outsole, e.results.analytic.gait.step_frequency_hz
    pairs = [one for one in e.results.calibrated_twin.pairs if math.isfinite(one.slower + one.slower_sd)]

    def mean(field: str) -> float:
        return float(np.mean([getattr(one, field) for one in pairs])) if pairs else NAN

    return OutsoleSlows(
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


def prototype_is_model(e: Evidence) -> PrototypeIsModel:
    """The first robot's parameters beside Table 1's; those that Table 1 does not print are left out."""
    robots = e.results.calibrated_twin.robots
    if not robots:
        return PrototypeIsModel(e.measured.origin, 0, (), -1)
    robot = robots[0]
    found = [(one, printed) for one in robot.numbers if (printed := _printed(e.parameters.biped, one)) > 0]
    intervals = tuple((one.name.partition(".")[2], *one.interval(HALF_WIDTH), printed) for one, printed in found)
    true = [one for one, _ in found if math.isfinite(one.truth)]
    held = sum(one.holds_truth(HALF_WIDTH) for one in true)
    return PrototypeIsModel(e.measured.origin, robot.runs, intervals, held if true else -1)


def _printed(biped: Biped, number: Number) -> float:
    """Table 1's value of a number; zero for one that is none of the biped's."""
    owner, _, key = number.name.partition(".")
    return biped.number(key) if owner == Biped.FILE else 0.0
