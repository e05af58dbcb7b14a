"""Claims on computing: effort of constraints, rounding, stiff solvers.

Work is counted in evaluations of the rates, or of an implicit step's residual: as many as its Newton iterations take.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from stages.comparison import studies
from stages.comparison.claims.measured import Measured
from stages.comparison.claims.paper import SETTINGS
from stages.comparison.claims.verdict import FAILS, HOLDS, HOLDS_IF, OPEN, Cause, Judgement, yes_or_no
from stages.comparison.evidence import NAN, Evidence
from stages.comparison.parameters import Settings
from stages.comparison.studies import of_model

RESTS_ON = ("tradeoff.resolution", "tradeoff.walked_steps", "ground.contact_stiffness")


@dataclass(frozen=True)
class ConstraintsReduceEffort(Measured):
    """Evaluations a step at the same hip error [m], for both models, each by its cheapest way; NaN if unknown.

    `stiffer` is the part by which a penalty step gets dearer as the contact's stiffness grows `stiffer_by` times.
    """

    ID = "constraints_reduce_effort"
    UNITS = (("m", "error"),)
    RESTS_ON = RESTS_ON
    METHOD = True

    error: float
    constraint: float
    penalty: float
    stiffer: float
    stiffer_by: float

    def judge(self, limits: Settings) -> Judgement:
        ratio = self.penalty / self.constraint
        verdict = yes_or_no(ratio > 1) if math.isfinite(ratio + self.error) else OPEN
        return Judgement(
            f"at a hip error of {self.error:.0e} m a step takes {self.constraint:.0f} evaluations with constraints, "
            f"{self.penalty:.0f} with penalty contact",
            verdict,
            (
                Cause(verdict == HOLDS, f"penalty contact takes {ratio:.1f} times the work"),
                Cause(
                    verdict == HOLDS and self.stiffer > 1,
                    f"stiffness is what costs: {self.stiffer_by:g} times k_c takes {self.stiffer:.1f} times as many",
                ),
                Cause(verdict == FAILS, f"penalty contact takes only {ratio:.2f} times the work"),
                Cause(not math.isfinite(self.error), "the penalty model has no walk at the paper's setting"),
                Cause(verdict == OPEN and math.isfinite(self.error), "no way of one of the models reached this error"),
            ),
        )


@dataclass(frozen=True)
class TightTolerancesAddRounding(Measured):
    """Hip error [m] at the tightest tolerance and at the one before, and the growth of evaluations from `paper` to it.

    `way` is that way's name. Tolerances are dimensionless. What the errors are taken against is sure to `doubt` [m].
    """

    ID = "tight_tolerances_add_rounding"
    UNITS = (("m", "error before"),)
    RESTS_ON = ("tradeoff.walked_steps",)
    METHOD = True

    way: str
    tightest: float
    error: float
    before: float
    paper: float
    cost: float
    doubt: float = 0.0

    def judge(self, limits: Settings) -> Judgement:
        known, rises = math.isfinite(self.error), self.error - self.doubt > self.before + self.doubt
        falls = self.doubt < self.error < self.before
        before, error = (f"{'< ' * (value <= self.doubt)}{max(value, self.doubt):.1e}"
                         for value in (self.before, self.error))  # fmt: skip
        return Judgement(
            f"{self.way}: from a tolerance of {self.paper:g} to {self.tightest:g} evaluations grow {self.cost:.1f} "
            f"times; the last tightening takes the hip's error from {before} to {error} m",
            yes_or_no(rises) if known else OPEN,
            (
                Cause(known and rises, f"it makes the error {self.error / self.before:.1f} times larger"),
                Cause(
                    known and not rises,
                    f"steps grow, as the paper says, but rounding stays below {max(self.error, self.doubt):.0e} m: "
                    + ("the error falls to the tightest tolerance that was tried" if falls else
                       "what the error is taken against is no surer"),
                ),
                Cause(not known, "one tolerance at most was measured"),
            ),
        )


@dataclass(frozen=True)
class StiffSolver(Measured):
    """Evaluations a step of the paper's stiff solvers (or what stands in for them), and of the cheapest explicit way at
    the same error: of the constraint model and of the penalty model."""

    ID = "stiff_solver"
    RESTS_ON = RESTS_ON
    METHOD = True

    constraint_stiff: float
    constraint_explicit: float
    penalty_stiff: float
    penalty_explicit: float

    def judge(self, limits: Settings) -> Judgement:
        pairs = (
            ("constraint model", self.constraint_stiff, self.constraint_explicit),
            ("penalty model", self.penalty_stiff, self.penalty_explicit),
        )
        known = [(name, stiff, explicit) for name, stiff, explicit in pairs if math.isfinite(stiff + explicit)]
        won = [name for name, stiff, explicit in known if stiff <= explicit]
        lost = [f"{name} 1/{stiff / explicit:.1f} of the work" for name, stiff, explicit in known if stiff > explicit]
        verdict = OPEN if not known else HOLDS if not lost else FAILS if not won else HOLDS_IF
        said = "; ".join(f"{name}: {stiff:.0f} by the stiff solver, {explicit:.0f} explicitly" for name, stiff, explicit
                         in known)  # fmt: skip
        return Judgement(
            f"evaluations a step at the same error: {said}" if known else "no pair of solvers",
            verdict,
            (
                Cause(bool(lost), f"an explicit solver takes less: for the {' and for the '.join(lost)}"),
                Cause(bool(won), f"the stiff solver takes no more for the {' and the '.join(won)}"),
                Cause(not known, "no pair of stiff and explicit solvers was measured"),
            ),
            f"the {won[0]} is meant" if verdict == HOLDS_IF else "",
        )


#: Models of the study of speed against accuracy.
ROLLING, PENALTY = "constraint model, rolling", "penalty model"


def constraints_reduce_effort(e: Evidence) -> ConstraintsReduceEffort:
    rows, study = e.results.tradeoff.rows, e.results.contact_study
    paper = studies.of_the_paper(rows, PENALTY)
    error = paper.errors.hip_position if paper is not None else NAN
    work, more = (studies.least_work(of_model(rows, model), error) for model in (ROLLING, PENALTY))
    v, default = study.variations, study.default
    stiffer = [(float(v.value[row]), float(v.evaluations[row])) for row in v.rows("contact_stiffness")
               if v.outcome[row] == default.outcome]  # fmt: skip
    value, steps = max(stiffer, default=(NAN, NAN))
    return ConstraintsReduceEffort(
        error, work, more, steps / max(default.evaluations, 1), value / default.law.contact_stiffness
    )


def tight_tolerances(e: Evidence) -> TightTolerancesAddRounding:
    rows, paper = of_model(e.results.tradeoff.rows, ROLLING), float(SETTINGS["analytic.tolerance"].value)
    ways = {row.way for row in rows if "default" in row.mark}
    own = sorted((row for row in rows if row.way in ways and row.completed), key=lambda row: row.tolerance)
    if len(own) < 2:
        return TightTolerancesAddRounding("no way", NAN, NAN, NAN, paper, NAN)
    tightest, before = own[:2]
    usual = min(own, key=lambda row: abs(math.log(row.tolerance / paper)))
    return TightTolerancesAddRounding(
        tightest.way, tightest.tolerance, tightest.errors.hip_position, before.errors.hip_position, usual.tolerance,
        tightest.evaluations / usual.evaluations, tightest.doubt.hip_position,
    )  # fmt: skip


def stiff_solver(e: Evidence) -> StiffSolver:
    rows, found = e.results.tradeoff.rows, []
    for model in (ROLLING, PENALTY):
        paper = studies.of_the_paper(rows, model)
        stiff = paper is not None and not studies.explicit(paper)
        error = paper.errors.hip_position if paper is not None and stiff else NAN
        found.append(paper.evaluations if paper is not None and stiff else NAN)
        found.append(studies.least_work(filter(studies.explicit, of_model(rows, model)), error))
    return StiffSolver(*found)
