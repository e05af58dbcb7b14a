"""Comparison stage: how far all sources agree, determinants of gait, and the paper's claims with verdicts.

Inputs: the results of the models, of their studies and of the ingest. Settings: params/comparison.yaml. Outputs:
`Result`, claims.yaml.
"""

from __future__ import annotations

import math

from stages.biped.progress import Progress, ignore
from stages.biped.walk import require
from stages.comparison.claims.as_yaml import as_yaml, headlines
from stages.comparison.claims.judge import judge, measure
from stages.comparison.claims.numerics import constraints_reduce_effort
from stages.comparison.determinants import Determinants, digits_of, of_walk
from stages.comparison.evidence import NAN, Evidence, known, largest
from stages.comparison.inputs import Inputs
from stages.comparison.parameters import Parameters
from stages.comparison.result import Result, tables_of
from stages.comparison.summary import BipedSummary


def summarise(e: Evidence) -> BipedSummary:
    """The summary of the study's biped."""
    analytic, validity = e.results.analytic, e.results.analytic.validity
    models, work, twin = known(lambda: e.models), known(lambda: constraints_reduce_effort(e)), known(lambda: e.twin)
    limit, rung = known(lambda: e.results.contact_study.limit), known(lambda: e.results.twin_ladder.twin)
    return BipedSummary(
        analytic.gait.step_frequency_hz,
        analytic.gait.step_length_m,
        abs(analytic.numerical_error.period),
        analytic.numerical_error.hip_position,
        models.period_difference if models is not None else NAN,
        models.step_length_difference if models is not None else NAN,
        float(limit.hard.hip_position.max()) if limit is not None else NAN,
        float(models.same_start.position.max()) if models is not None else NAN,
        twin.step_frequency if twin is not None else NAN,
        largest(analytic.gait.floquet_multipliers),
        largest(rung.plane_multipliers) if rung is not None else NAN,
        validity.friction_single_stance,
        max(validity.impulse_friction_landing, validity.impulse_friction_trailing),
        e.parameters.contact.static_friction,
        math.sin(e.parameters.slope.angle),
        work.constraint if work is not None else NAN,
        work.penalty if work is not None else NAN,
        work.error if work is not None else NAN,
    )


def run(parameters: Parameters, inputs: Inputs, progress: Progress = ignore) -> Result:
    """Compare and judge; what a claim lacks it says in place of its numbers.

    Raises NotRecorded if a walk lacks a signal, NoEvidence without the constraint model.
    """
    for name in {"multibody", "twin"}.difference(inputs.missing):
        walk = getattr(inputs, name).walk
        require(name, {"ground_reaction": walk.ground_reaction, "imu": walk.hip_specific_force})
    if "multibody" not in inputs.missing:
        require("multibody", {"slip": inputs.multibody.slip_velocity})
    e = Evidence(parameters, inputs)
    models, twin = known(lambda: e.models), known(lambda: e.twin)
    measured, score = known(lambda: e.measured), known(lambda: e.ingest)
    progress(0.8, "judging the claims")
    determined, biped, level = determinants(e), summarise(e), parameters.level.level
    models_alone = {name: one for name, one in determined.items() if not name.startswith("runs")}
    digits = digits_of(e.results.analytic.uncertainties, models_alone)
    claims = judge(parameters, measure(e))
    tables = tables_of(biped, determined, digits, level, claims)
    files = {"claims.yaml": as_yaml(claims, tables, headlines(biped, claims), level)}
    return Result(models, twin, measured, score, determined, digits, biped, claims, level, files)


def determinants(e: Evidence) -> dict[str, Determinants]:
    """Determinants of all models; of the runs, which have no walk but heel strikes, only what these tell."""
    biped, gravity, layer = e.parameters.biped, e.parameters.slope.gravity, e.parameters.twin.outsole

    def of(name: str, layer: float = 0.0) -> Determinants | None:
        radius, leg_length = biped.foot_radius + layer, biped.leg_length + layer
        return known(lambda: of_walk(getattr(e.results, name).walk, radius, leg_length, gravity))

    measured = known(lambda: e.measured)
    found = {
        "constraint model": of("analytic"),
        "multibody model": of("multibody"),
        "twin": of("twin", layer),
        f"runs ({measured.origin if measured else ''})":
            Determinants(step_frequency=measured.step_frequency) if measured else None,
    }
    return {name: one for name, one in found.items() if one is not None}
