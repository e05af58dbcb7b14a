"""Claims on figure 8: how far the hips of the two models differ, and why.

They are judged in a limit that needs no choice of a contact set: constraint model with Coulomb friction, to which
penalty contact tends as it hardens, less the rolling constraint model. What the set of ground.yaml gives stands beside.
"""

import math

from stages.biped.quantity import mm
from stages.comparison.agreement import farthest
from stages.comparison.claims.statement import Statement
from stages.comparison.evidence import NAN, Evidence
from stages.comparison.parameters import Settings
from stages.comparison.result import FAILS, HOLDS, HOLDS_IF, OPEN, Judgement, Parts, listed, yes_or_no
from stages.error_budget.result import EFFECTS, POSITION, SLIP, UNEXPLAINED, VELOCITY, Split
from stages.studies.result import COMPLETED

#: Part of the largest contribution below which another is not named.
NEGLIGIBLE = 0.05
RESTS_ON = (
    "ground.static_friction", "ground.contact_stiffness", "ground.contact_damping", "ground.damping_depth",
    "ground.stiction_velocity", "error_budget.constraint_tolerance", "error_budget.penalty_tolerance",
    "analytic.tolerance", "multibody.tolerance",
)  # fmt: skip


def hip_displacement(e: Evidence) -> tuple[float, float, float, float, float, Parts, float, float, float]:
    analytic, multibody = e.results.analytic, e.results.multibody
    two = farthest(analytic.walk, multibody.walk, 2 * analytic.gait.period_s)
    limit, cycle = e.results.contact_study.limit, slip_between_cycles(e)
    budget, hardest = e.results.error_budget.step, None
    if limit is not None:
        known = [(share, one) for share, one in zip(limit.family_share, limit.family) if one.outcome == COMPLETED]
        hardest = min(known, key=lambda pair: float(pair[0]), default=None)
    return (
        float(limit.hard.hip_position.max()) if limit is not None else NAN,
        cycle[0],
        float(e.models.same_start.position.max()),
        float(two.max()),
        float(e.models.settled.position.max()),
        ends(budget.split) if budget is not None else (),
        float(limit.ground.hip_position.max()) if limit is not None else NAN,
        float(hardest[1].hip_position.max()) if hardest is not None else NAN,
        float(hardest[0]) if hardest is not None else NAN,
    )


def judge_hip_displacement(
    limits: Settings,
    limit_step: float,
    limit_cycle: float,
    step: float,
    two_steps: float,
    cycle: float,
    parts: Parts,
    from_limit: float,
    hardest: float,
    share: float,
) -> Judgement:
    """Largest differences of hip position [m]: of the limit over a step and over a stride of settled cycles, and of
    ground.yaml's set over one step, over two as figure 8 is drawn here, and over a settled stride.

    `parts` are the contributions [m] of each effect at the end of the step, with that set, and by how much they depend
    on the order of effects. `from_limit` [m] is how far
    that set is from the limit over a step, `hardest` [m] that of the hardest set of the
    study, with `share` left of creep and impact of the chosen one.
    """
    known, allowed = math.isfinite(limit_step), limits.position_limit
    inside = HOLDS if limit_cycle <= allowed else HOLDS_IF
    verdict = OPEN if not known else FAILS if limit_step > allowed else inside
    cancels = max((abs(part) for _, part, _ in parts), default=0.0) > step
    return Judgement(
        f"in the limit {mm(limit_step)} over one step from a common state, {mm(limit_cycle)} over a "
        f"stride of settled cycles; with ground.yaml's set {mm(step)} over one step, {mm(two_steps)} "
        f"over two, {mm(cycle)} over a settled stride",
        verdict,
        (
            (verdict == HOLDS, f"slip of the trailing foot moves the hip by at most {mm(limit_cycle)}"),
            (
                verdict == HOLDS_IF,
                f"slip of the trailing foot, which no contact set removes, moves the hip by {mm(limit_step)} "
                f"in a step; cycles have periods of their own, and a stride later it is {mm(limit_cycle)}",
            ),
            (verdict == FAILS, f"slip of the trailing foot alone makes {mm(limit_step)} in a step"),
            (verdict == OPEN, "the constraint model has no gait with Coulomb friction"),
            (
                hardest < from_limit,
                f"penalty contact tends to that limit: {1e3 * from_limit:.3f} mm away with ground.yaml's set, "
                f"{1e3 * hardest:.3f} mm with {share:.3g} of the chosen set's creep and impact",
            ),
            (cancels, f"with ground.yaml's set effects act against each other at the step's end: {listed(parts)}"),
        ),
        "it is measured over one step from a common state" if verdict == HOLDS_IF else "",
    )


def hip_velocity(e: Evidence) -> tuple[float, float, float, float]:
    study = e.results.contact_study
    step = float(study.limit.hard.hip_velocity.max()) if study.limit is not None else NAN
    inside = float(study.ground.impact_velocity.max())
    return step, slip_between_cycles(e)[1], float(e.models.same_start.velocity.max()), inside


def judge_hip_velocity(
    limits: Settings, limit_step: float, limit_cycle: float, step: float, impact: float
) -> Judgement:
    """Largest differences of hip velocity [m/s]: of the limit over a step and over a settled stride; of ground.yaml's
    set over one step, outside and inside of the impact."""
    allowed, worst = limits.velocity_limit, max(limit_step, limit_cycle)
    known = math.isfinite(limit_step)
    verdict = yes_or_no(worst <= allowed) if known else OPEN
    return Judgement(
        f"in the limit {1e3 * limit_step:.1f} mm/s over one step and {1e3 * limit_cycle:.1f} mm/s over a "
        f"settled stride; with ground.yaml's set {1e3 * step:.1f} mm/s over one step outside of the impact",
        verdict,
        (
            (verdict == HOLDS, f"slip of the trailing foot changes it by {1e3 * worst:.1f} mm/s at most"),
            (verdict == FAILS, f"slip of the trailing foot alone makes {1e3 * worst:.1f} mm/s"),
            (verdict == OPEN, "the constraint model has no gait with Coulomb friction"),
            (
                impact > allowed,
                f"inside the impact, which constraints pass in no time, penalty contact is {1e3 * impact:.0f} mm/s off",
            ),
        ),
    )


def integration_tolerance(e: Evidence) -> tuple[str, float, float, float, Parts, float, float]:
    budget = e.results.error_budget
    if budget.step is None:
        return budget.outcome, NAN, NAN, NAN, (), NAN, NAN
    split = budget.step.split
    return (
        budget.outcome,
        float(budget.step.paper_integration[:, :2].max()),
        split.peak(split.total, POSITION),
        split.peak(split.part(UNEXPLAINED), POSITION),
        ends(split),
        split.explained(POSITION),
        budget.cycle.split.explained(POSITION) if budget.cycle is not None else NAN,
    )


def judge_integration_tolerance(
    limits: Settings,
    outcome: str,
    integration: float,
    whole: float,
    rest: float,
    parts: Parts,
    explained: float,
    explained_cycle: float,
) -> Judgement:
    """Hip displacement over one step [m]: by integration at the paper's tolerances, in all, and left unexplained.

    `parts` as for the displacement; `explained` and `explained_cycle` are the shares explained by other effects, NaN if
    they could not be split; `outcome` says why.
    """
    if not math.isfinite(whole):
        return Judgement(outcome, OPEN, ((True, f"the difference could not be split: {outcome}"),))
    holds = integration > rest
    larger = tuple(part for part in parts if abs(part[1]) > integration)
    between = f", {100 * explained_cycle:.0f} % between cycles" if math.isfinite(explained_cycle) else ""
    return Judgement(
        f"at the paper's tolerances integration moves the hip by {1e3 * integration:.0e} mm of "
        f"{mm(whole)} over one step; other effects explain {100 * explained:.0f} % of it (rms){between}",
        yes_or_no(holds),
        (
            (holds, f"integration outweighs the {1e3 * rest:.0e} mm that no other effect explains"),
            (
                not holds,
                f"integration is {whole / integration if integration else math.inf:.0e} times "
                "smaller than the difference",
            ),
            (not holds and bool(larger), f"each larger than that, at the step's end: {listed(larger)}"),
        ),
    )


def slip_between_cycles(e: Evidence) -> tuple[float, float]:
    """Largest differences of hip position [m] and velocity [m/s] between the cycles of the two constraint models, at
    equal phase over a stride, velocities outside of impacts: at one, round-off says on which side a phase is."""
    budget = e.results.error_budget.cycle
    if budget is None:
        return NAN, NAN
    slip = budget.split.part(SLIP)
    return budget.split.peak(slip, POSITION), budget.split.peak(slip, VELOCITY)


def ends(split: Split) -> Parts:
    """Contributions [m] to the hip's place down the slope at the end of the step, without negligible ones, each with
    half the interval in which the order of effects lets it lie."""
    parts = []
    for name in EFFECTS:
        least, most = (float(edge[-1, 0]) for edge in split.interval(name))
        if name != UNEXPLAINED:
            parts.append((name, (least + most) / 2, (most - least) / 2))
    largest = max(abs(part) for _, part, _ in parts)
    return tuple(part for part in parts if abs(part[1]) > NEGLIGIBLE * largest)


STATEMENTS = (
    Statement(
        "hip_displacement",
        "3.5, figure 8",
        "Hip displacement along the x and y directions [...] present a maximum difference of 0.3 mm.",
        "the hips of constraint and penalty model stay within 0.3 mm; what no contact parameter removes is the "
        "distance to the constraint model with Coulomb friction, to which penalty contact tends as it hardens",
        hip_displacement,
        judge_hip_displacement,
        RESTS_ON,
        units={"m": "limit_step limit_cycle step two_steps cycle parts from_limit hardest"},
        plain="On hard and on springy ground the hip takes the same path, to 0.3 mm.",
    ),
    Statement(
        "hip_velocity",
        "3.5, figure 8",
        "Hip velocity along the x and y directions [...] present a maximum difference of 5 mm/s.",
        "the hip velocities stay within 5 mm/s, judged in the same limit",
        hip_velocity,
        judge_hip_velocity,
        RESTS_ON,
        units={"m/s": "limit_step limit_cycle step impact"},
        plain="On hard and on springy ground the hip moves equally fast, to 5 mm/s.",
    ),
    Statement(
        "integration_tolerance",
        "3.5, figure 8",
        "After elimination of other possible causes, the small errors are attributed to integration tolerances.",
        "at the paper's tolerances integration moves the hip by more than what no other effect explains",
        integration_tolerance,
        judge_integration_tolerance,
        (*RESTS_ON, "error_budget.paper_constraint_tolerance", "error_budget.paper_penalty_tolerance"),
        units={"m": "integration whole rest parts"},
        plain="The two models differ only because they were computed inexactly.",
    ),
)
