"""Claims on figure 8: how far the hips of the two models differ, and why.

They are judged in a limit that needs no choice of a contact set: constraint model with Coulomb friction, to which
penalty contact tends as it hardens, less the rolling constraint model. What the set of ground.yaml gives stands beside.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from stages.comparison import studies
from stages.comparison.claims.measured import Measured
from stages.comparison.claims.verdict import (
    FAILS,
    HOLDS,
    HOLDS_IF,
    OPEN,
    Cause,
    Judgement,
    Parts,
    listed,
    mm,
    yes_or_no,
)
from stages.comparison.evidence import NAN, Evidence
from stages.comparison.hip_motion import farthest
from stages.comparison.parameters import Settings
from stages.error_budget.result import POSITION, SLIP, UNEXPLAINED, VELOCITY
from stages.studies.result import COMPLETED

RESTS_ON = (
    "ground.static_friction", "ground.contact_stiffness", "ground.contact_damping", "ground.damping_depth",
    "ground.stiction_velocity", "error_budget.constraint_tolerance", "error_budget.penalty_tolerance",
    "analytic.tolerance", "multibody.tolerance",
)  # fmt: skip


@dataclass(frozen=True)
class HipDisplacement(Measured):
    """Largest differences of hip position [m]: of the limit over a step and over a stride of settled cycles, and of
    ground.yaml's set over one step, over two as figure 8 is drawn here, and over a settled stride.

    `parts` are the contributions [m] of each effect at the end of the step, with that set, and by how much they depend
    on the order of effects. `from_limit` [m] is how far
    that set is from the limit over a step, `hardest` [m] that of the hardest set of the
    study, with `share` left of creep and impact of the chosen one.
    """

    ID = "hip_displacement"
    UNITS = (("m", "limit_step limit_cycle step two_steps cycle parts from_limit hardest"),)
    RESTS_ON = RESTS_ON

    limit_step: float
    limit_cycle: float
    step: float
    two_steps: float
    cycle: float
    parts: Parts
    from_limit: float
    hardest: float
    share: float

    def judge(self, limits: Settings) -> Judgement:
        allowed = limits.position_limit
        if not math.isfinite(self.limit_step):
            verdict = OPEN
        elif self.limit_step > allowed:
            verdict = FAILS
        else:
            verdict = HOLDS if self.limit_cycle <= allowed else HOLDS_IF
        cancels = max((abs(part) for _, part, _ in self.parts), default=0.0) > self.step
        return Judgement(
            f"in the limit {mm(self.limit_step)} over one step from a common state, {mm(self.limit_cycle)} over a "
            f"stride of settled cycles; with ground.yaml's set {mm(self.step)} over one step, {mm(self.two_steps)} "
            f"over two, {mm(self.cycle)} over a settled stride",
            verdict,
            (
                Cause(verdict == HOLDS, f"slip of the trailing foot moves the hip by at most {mm(self.limit_cycle)}"),
                Cause(
                    verdict == HOLDS_IF,
                    f"slip of the trailing foot, which no contact set removes, moves the hip by {mm(self.limit_step)} "
                    f"in a step; cycles have periods of their own, and a stride later it is {mm(self.limit_cycle)}",
                ),
                Cause(verdict == FAILS, f"slip of the trailing foot alone makes {mm(self.limit_step)} in a step"),
                Cause(verdict == OPEN, "the constraint model has no gait with Coulomb friction"),
                Cause(
                    self.hardest < self.from_limit,
                    f"penalty contact tends to that limit: {1e3 * self.from_limit:.3f} mm away with ground.yaml's set, "
                    f"{1e3 * self.hardest:.3f} mm with {self.share:.3g} of the chosen set's creep and impact",
                ),
                Cause(cancels, f"with ground.yaml's set effects cancel at the step's end: {listed(self.parts)}"),
            ),
            "it is measured over one step from a common state" if verdict == HOLDS_IF else "",
        )


@dataclass(frozen=True)
class HipVelocity(Measured):
    """Largest differences of hip velocity [m/s]: of the limit over a step and over a settled stride; of ground.yaml's
    set over one step, outside and inside of the impact."""

    ID = "hip_velocity"
    UNITS = (("m/s", "limit_step limit_cycle step impact"),)
    RESTS_ON = RESTS_ON

    limit_step: float
    limit_cycle: float
    step: float
    impact: float

    def judge(self, limits: Settings) -> Judgement:
        allowed, worst = limits.velocity_limit, max(self.limit_step, self.limit_cycle)
        known = math.isfinite(self.limit_step)
        verdict = yes_or_no(worst <= allowed) if known else OPEN
        return Judgement(
            f"in the limit {1e3 * self.limit_step:.1f} mm/s over one step and {1e3 * self.limit_cycle:.1f} mm/s over a "
            f"settled stride; with ground.yaml's set {1e3 * self.step:.1f} mm/s over one step outside of the impact",
            verdict,
            (
                Cause(verdict == HOLDS, f"slip of the trailing foot changes it by {1e3 * worst:.1f} mm/s at most"),
                Cause(verdict == FAILS, f"slip of the trailing foot alone makes {1e3 * worst:.1f} mm/s"),
                Cause(verdict == OPEN, "the constraint model has no gait with Coulomb friction"),
                Cause(
                    self.impact > allowed,
                    f"inside the impact, which constraints pass in no time, penalty contact is {1e3 * self.impact:.0f} "
                    "mm/s off",
                ),
            ),
        )


@dataclass(frozen=True)
class IntegrationTolerance(Measured):
    """Hip displacement over one step [m]: by integration at the paper's tolerances, in all, and left unexplained.

    `parts` as for the displacement; `explained` and `explained_cycle` are the shares explained by other effects, NaN if
    they could not be split; `outcome` says why.
    """

    ID = "integration_tolerance"
    UNITS = (("m", "integration whole rest parts"),)
    RESTS_ON = (*RESTS_ON, "error_budget.paper_constraint_tolerance", "error_budget.paper_penalty_tolerance")

    outcome: str
    integration: float
    whole: float
    rest: float
    parts: Parts
    explained: float
    explained_cycle: float

    def judge(self, limits: Settings) -> Judgement:
        if not math.isfinite(self.whole):
            return Judgement(self.outcome, OPEN, (Cause(True, f"the difference could not be split: {self.outcome}"),))
        holds = self.integration > self.rest
        larger = tuple(part for part in self.parts if abs(part[1]) > self.integration)
        between = f", {100 * self.explained_cycle:.0f} % between cycles" if math.isfinite(self.explained_cycle) else ""
        return Judgement(
            f"at the paper's tolerances integration moves the hip by {1e3 * self.integration:.0e} mm of "
            f"{mm(self.whole)} over one step; other effects explain {100 * self.explained:.0f} % of it (rms){between}",
            yes_or_no(holds),
            (
                Cause(holds, f"integration outweighs the {1e3 * self.rest:.0e} mm that no other effect explains"),
                Cause(
                    not holds,
                    f"integration is {self.whole / self.integration if self.integration else math.inf:.0e} times "
                    "smaller than the difference",
                ),
                Cause(not holds and bool(larger), f"each larger than that, at the step's end: {listed(larger)}"),
            ),
        )


def hip_displacement(e: Evidence) -> HipDisplacement:
    analytic, multibody = e.results.analytic, e.results.multibody
    two = farthest(analytic.walk, multibody.walk, 2 * analytic.gait.period_s)
    limit, cycle = e.results.contact_study.limit, slip_between_cycles(e)
    budget, hardest = e.results.error_budget.step, None
    if limit is not None:
        known = [(share, one) for share, one in zip(limit.family_share, limit.family) if one.outcome == COMPLETED]
        hardest = min(known, key=lambda pair: float(pair[0]), default=None)
    return HipDisplacement(
        float(limit.hard.hip_position.max()) if limit is not None else NAN,
        cycle[0],
        float(e.models.same_start.position.max()),
        float(two.max()),
        float(e.models.settled.position.max()),
        studies.ends(budget.split) if budget is not None else (),
        float(limit.ground.hip_position.max()) if limit is not None else NAN,
        float(hardest[1].hip_position.max()) if hardest is not None else NAN,
        float(hardest[0]) if hardest is not None else NAN,
    )


def hip_velocity(e: Evidence) -> HipVelocity:
    study = e.results.contact_study
    step = float(study.limit.hard.hip_velocity.max()) if study.limit is not None else NAN
    inside = float(study.ground.impact_velocity.max())
    return HipVelocity(step, slip_between_cycles(e)[1], float(e.models.same_start.velocity.max()), inside)


def slip_between_cycles(e: Evidence) -> tuple[float, float]:
    """Largest differences of hip position [m] and velocity [m/s] between the cycles of the two constraint models, at
    equal phase over a stride, velocities outside of impacts: at one, round-off says on which side a phase is."""
    budget = e.results.error_budget.cycle
    if budget is None:
        return NAN, NAN
    slip = budget.split.part(SLIP)
    return budget.split.peak(slip, POSITION), budget.split.peak(slip, VELOCITY)


def integration_tolerance(e: Evidence) -> IntegrationTolerance:
    budget = e.results.error_budget
    if budget.step is None:
        return IntegrationTolerance(budget.outcome, NAN, NAN, NAN, (), NAN, NAN)
    split = budget.step.split
    return IntegrationTolerance(
        budget.outcome,
        float(budget.step.paper_integration[:, :2].max()),
        split.peak(split.total, POSITION),
        split.peak(split.part(UNEXPLAINED), POSITION),
        studies.ends(split),
        split.explained(POSITION),
        budget.cycle.split.explained(POSITION) if budget.cycle is not None else NAN,
    )
