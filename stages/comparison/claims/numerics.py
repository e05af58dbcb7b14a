"""Claims on computing: effort of constraints, rounding, stiff solvers.

Work is counted in evaluations of the rates, or of an implicit step's residual: as many as its Newton iterations take.
"""

import math
from collections.abc import Iterable

from stages.comparison.claims.paper import SETTINGS
from stages.comparison.claims.statement import Statement
from stages.comparison.evidence import NAN, Evidence
from stages.comparison.parameters import Settings
from stages.comparison.result import FAILS, HOLDS, HOLDS_IF, OPEN, Judgement, yes_or_no
from stages.tradeoff.result import Row, cost_at

#: Words in the names of implicit ways to compute a walk.
IMPLICIT = ("BDF", "Radau", "LSODA", "trapezoidal", "generalized_alpha")
RESTS_ON = ("tradeoff.resolution", "tradeoff.walked_steps", "ground.contact_stiffness")


ROLLING, PENALTY = "constraint model, rolling", "penalty model"


def constraints_reduce_effort(e: Evidence) -> tuple[float, float, float, float, float]:
    rows, study = e.results.tradeoff.rows, e.results.contact_study
    paper = of_the_paper(rows, PENALTY)
    error = paper.errors.hip_position if paper is not None else NAN
    work, more = (least_work(of_model(rows, model), error) for model in (ROLLING, PENALTY))
    v, default = study.variations, study.default
    stiffer = [(float(v.value[row]), float(v.evaluations[row])) for row in v.rows("contact_stiffness")
               if v.outcome[row] == default.outcome]  # fmt: skip
    value, steps = max(stiffer, default=(NAN, NAN))
    return (error, work, more, steps / max(default.evaluations, 1), value / default.law.contact_stiffness)


def judge_constraints_reduce_effort(
    limits: Settings, error: float, constraint: float, penalty: float, stiffer: float, stiffer_by: float
) -> Judgement:
    """Evaluations a step at the same hip error [m], for both models, each by its cheapest way; NaN if unknown.

    `stiffer` is the part by which a penalty step gets dearer as the contact's stiffness grows `stiffer_by` times.
    """
    ratio = penalty / constraint
    verdict = yes_or_no(ratio > 1) if math.isfinite(ratio + error) else OPEN
    return Judgement(
        f"at a hip error of {error:.0e} m a step takes {constraint:.0f} evaluations with constraints, "
        f"{penalty:.0f} with penalty contact",
        verdict,
        (
            (verdict == HOLDS, f"penalty contact takes {ratio:.1f} times the work"),
            (
                verdict == HOLDS and stiffer > 1,
                f"stiffness is what costs: {stiffer_by:g} times k_c takes {stiffer:.1f} times as many",
            ),
            (verdict == FAILS, f"penalty contact takes only {ratio:.2f} times the work"),
            (not math.isfinite(error), "the penalty model has no walk at the paper's setting"),
            (verdict == OPEN and math.isfinite(error), "no way of one of the models reached this error"),
        ),
    )


def tight_tolerances(e: Evidence) -> tuple[str, float, float, float, float, float, float]:
    rows, paper = of_model(e.results.tradeoff.rows, ROLLING), float(SETTINGS["analytic.tolerance"][0])
    ways = {row.way for row in rows if "default" in row.mark}
    own = sorted((row for row in rows if row.way in ways and row.completed), key=lambda row: row.tolerance)
    if len(own) < 2:
        return "no way", NAN, NAN, NAN, paper, NAN, 0.0
    tightest, before = own[:2]
    usual = min(own, key=lambda row: abs(math.log(row.tolerance / paper)))
    return (
        tightest.way, tightest.tolerance, tightest.errors.hip_position, before.errors.hip_position, usual.tolerance,
        tightest.evaluations / usual.evaluations, tightest.doubt.hip_position,
    )  # fmt: skip


def judge_tight_tolerances(
    limits: Settings, way: str, tightest: float, error: float, before: float, paper: float, cost: float, doubt: float
) -> Judgement:
    """Hip error [m] at the tightest tolerance and at the one before, and the growth of evaluations from `paper` to it.

    `way` is that way's name. Tolerances are dimensionless. What the errors are taken against is sure to `doubt` [m].
    """
    known, rises = math.isfinite(error), error - doubt > before + doubt
    falls = doubt < error < before
    last, now = (f"{'< ' * (value <= doubt)}{max(value, doubt):.1e}"
                     for value in (before, error))  # fmt: skip
    return Judgement(
        f"{way}: from a tolerance of {paper:g} to {tightest:g} evaluations grow {cost:.1f} "
        f"times; the last tightening takes the hip's error from {last} to {now} m",
        yes_or_no(rises) if known else OPEN,
        (
            (known and rises, f"it makes the error {error / before:.1f} times larger"),
            (
                known and not rises,
                f"steps grow, as the paper says, but rounding stays below {max(error, doubt):.0e} m: "
                + (
                    "the error falls to the tightest tolerance that was tried"
                    if falls
                    else "the reference is known no better"
                ),
            ),
            (not known, "one tolerance at most was measured"),
        ),
    )


def stiff_solver(e: Evidence) -> tuple[float, float, float, float]:
    rows = e.results.tradeoff.rows
    return *stiff_and_explicit(rows, ROLLING), *stiff_and_explicit(rows, PENALTY)


def stiff_and_explicit(rows: tuple[Row, ...], model: str) -> tuple[float, float]:
    """Evaluations a step of the paper's way if it is stiff, and of the cheapest explicit way at the same error."""
    paper = of_the_paper(rows, model)
    if paper is None or explicit(paper):
        return NAN, NAN
    return paper.evaluations, least_work(filter(explicit, of_model(rows, model)), paper.errors.hip_position)


def judge_stiff_solver(
    limits: Settings, constraint_stiff: float, constraint_explicit: float, penalty_stiff: float, penalty_explicit: float
) -> Judgement:
    """Evaluations a step of the paper's stiff solvers (or what stands in for them), and of the cheapest explicit way at
    the same error: of the constraint model and of the penalty model."""
    pairs = (
        ("constraint model", constraint_stiff, constraint_explicit),
        ("penalty model", penalty_stiff, penalty_explicit),
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
            (bool(lost), f"an explicit solver takes less: for the {' and for the '.join(lost)}"),
            (bool(won), f"the stiff solver takes no more for the {' and the '.join(won)}"),
            (not known, "no pair of stiff and explicit solvers was measured"),
        ),
        f"the {won[0]} is meant" if verdict == HOLDS_IF else "",
    )


def explicit(row: Row) -> bool:
    """Whether a way takes explicit steps alone."""
    return not any(word in row.way for word in IMPLICIT)


def least_work(rows: Iterable[Row], error: float) -> float:
    """Evaluations a step of the cheapest of these ways at a hip error [m]."""
    ways: dict[str, list[tuple[float, float]]] = {}
    for row in rows:
        if row.completed and math.isfinite(row.errors.hip_position):
            ways.setdefault(row.way, []).append((row.errors.hip_position, row.evaluations))
    costs = [cost_at(sorted(points), error) for points in ways.values()]
    return min((cost for cost in costs if math.isfinite(cost)), default=NAN)


def of_the_paper(rows: Iterable[Row], model: str) -> Row | None:
    """The way that is the paper's, or stands in for it."""
    return next((row for row in rows if row.model == model and "paper" in row.mark and row.completed), None)


def of_model(rows: tuple[Row, ...], model: str) -> list[Row]:
    return [row for row in rows if row.model == model]


STATEMENTS = (
    Statement(
        "constraints_reduce_effort",
        "2.1",
        "The practice of using Lagrange multipliers to model contacts in dynamic systems minimizes the computational "
        "effort by reducing the overall stiffness of the system.",
        "the constraint model needs fewer evaluations of its rates a step than the penalty model, at the same error",
        constraints_reduce_effort,
        judge_constraints_reduce_effort,
        RESTS_ON,
        units={"m": "error"},
        method=True,
        plain="To treat the ground as rigid takes less computing than to treat it as a stiff spring.",
    ),
    Statement(
        "tight_tolerances_add_rounding",
        "2.3",
        "[...] too small tolerances would lead to a large increase in solver steps, increasing the overall rounding "
        "error accumulated over the same time.",
        "below some tolerance a tighter one makes the error larger",
        tight_tolerances,
        judge_tight_tolerances,
        ("tradeoff.walked_steps",),
        units={"m": "error before"},
        method=True,
        plain="Asking a solver for too much accuracy makes its result worse.",
    ),
    Statement(
        "stiff_solver",
        "3.5",
        "As reasoned in Section 2, a stiff solver is appropriate for this system.",
        "the stiff solvers of the paper reach their error with no more work than an explicit one",
        stiff_solver,
        judge_stiff_solver,
        RESTS_ON,
        method=True,
        plain="A solver for stiff equations suits this robot.",
    ),
)
