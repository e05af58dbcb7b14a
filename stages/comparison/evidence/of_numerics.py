"""Numbers of the claims on computing."""

from __future__ import annotations

import math

from stages.comparison.claims import numerics
from stages.comparison.claims.paper import SETTINGS
from stages.comparison.evidence import studies
from stages.comparison.evidence.evidence import NAN, Evidence
from stages.comparison.evidence.studies import of_model

#: Models of the study of speed against accuracy.
ROLLING, PENALTY = "constraint model, rolling", "penalty model"


def constraints_reduce_effort(e: Evidence) -> numerics.ConstraintsReduceEffort:
    rows, study = e.results.tradeoff.rows, e.results.contact_study
    paper = studies.of_the_paper(rows, PENALTY)
    error = paper.errors.hip_position if paper is not None else NAN
    work, more = (studies.least_work(of_model(rows, model), error) for model in (ROLLING, PENALTY))
    v, default = study.variations, study.default
    stiffer = [(float(v.value[row]), float(v.evaluations[row])) for row in v.rows("contact_stiffness")
               if v.outcome[row] == default.outcome]  # fmt: skip
    value, steps = max(stiffer, default=(NAN, NAN))
    return numerics.ConstraintsReduceEffort(
        error, work, more, steps / max(default.evaluations, 1), value / default.law.contact_stiffness
    )


def tight_tolerances(e: Evidence) -> numerics.TightTolerancesAddRounding:
    rows, paper = of_model(e.results.tradeoff.rows, ROLLING), float(SETTINGS["analytic.tolerance"].value)
    ways = {row.way for row in rows if "default" in row.mark}
    own = sorted((row for row in rows if row.way in ways and row.completed), key=lambda row: row.tolerance)
    if len(own) < 2:
        return numerics.TightTolerancesAddRounding("no way", NAN, NAN, NAN, paper, NAN)
    tightest, before = own[:2]
    usual = min(own, key=lambda row: abs(math.log(row.tolerance / paper)))
    return numerics.TightTolerancesAddRounding(
        tightest.way, tightest.tolerance, tightest.errors.hip_position, before.errors.hip_position, usual.tolerance,
        tightest.evaluations / usual.evaluations, tightest.doubt.hip_position,
    )  # fmt: skip


def stiff_solver(e: Evidence) -> numerics.StiffSolver:
    rows, found = e.results.tradeoff.rows, []
    for model in (ROLLING, PENALTY):
        paper = studies.of_the_paper(rows, model)
        stiff = paper is not None and not studies.explicit(paper)
        error = paper.errors.hip_position if paper is not None and stiff else NAN
        found.append(paper.evaluations if paper is not None and stiff else NAN)
        found.append(studies.least_work(filter(studies.explicit, of_model(rows, model)), error))
    return numerics.StiffSolver(*found)
