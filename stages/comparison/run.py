"""Comparison stage: how far all sources agree, determinants of gait, and the paper's claims with verdicts.

Inputs: the results of the models, of their studies and of the ingest. Settings: params/comparison.yaml. Outputs:
`Result`, claims.yaml.
"""

from __future__ import annotations

from stages.biped.progress import Progress, ignore
from stages.biped.walk import require
from stages.comparison.agreement import compare_models, compare_twin
from stages.comparison.claims.as_yaml import as_yaml
from stages.comparison.claims.headlines import headlines
from stages.comparison.claims.judge import judge
from stages.comparison.determinants import Determinants, of_walk
from stages.comparison.digits import digits_of
from stages.comparison.evidence.evidence import Evidence
from stages.comparison.evidence.measure import measure
from stages.comparison.evidence.summarise import summarise
from stages.comparison.inputs import Inputs
from stages.comparison.parameters import Parameters
from stages.comparison.result import Result, tables_of
from stages.comparison.runs.ingest_score import score_ingest
from stages.comparison.runs.measurement import compare_measurement
from stages.comparison.stride import last_stride


def run(parameters: Parameters, inputs: Inputs, progress: Progress = ignore) -> Result:
    """Compare and judge.

    Raises ValueError if one of the walks is too short to hold a whole stride, NotRecorded if one lacks a signal.
    """
    settings = parameters.settings
    walks = {"analytic": inputs.analytic.walk, "multibody": inputs.multibody.walk, "twin": inputs.twin.walk}
    for name in ("multibody", "twin"):
        require(name, {"ground_reaction": walks[name].ground_reaction, "imu": walks[name].hip_specific_force})
    require("multibody", {"slip": inputs.multibody.slip_velocity})
    strides = {name: last_stride(walk, settings.phase_points) for name, walk in walks.items()}
    models = compare_models(inputs.analytic, inputs.multibody, strides)
    twin = compare_twin(inputs.twin, strides)
    measured = compare_measurement(
        inputs.imu, inputs.twin.walk, strides["twin"], strides["multibody"], inputs.multibody.walk,
        settings.skipped_steps,
    )  # fmt: skip
    score = score_ingest(inputs.campaign, inputs.imu, settings.skipped_steps, parameters.slope.gravity)
    progress(0.8, "judging the claims")
    evidence = Evidence(parameters, inputs, models, twin, measured, score)
    determined, biped, level = determinants(evidence), summarise(evidence), parameters.level.level
    models_alone = {name: one for name, one in determined.items() if not name.startswith("runs")}
    digits = digits_of(inputs.analytic.uncertainties, models_alone)
    claims = judge(parameters, measure(evidence))
    tables = tables_of(biped, determined, digits, level)
    files = {"claims.yaml": as_yaml(claims, tables, headlines(biped, claims), level)}
    return Result(models, twin, measured, score, determined, digits, biped, claims, level, files)


def determinants(e: Evidence) -> dict[str, Determinants]:
    """Determinants of all models; of the runs, which have no walk but heel strikes, only what these tell."""
    biped, gravity, layer = e.parameters.biped, e.parameters.slope.gravity, e.parameters.twin.outsole
    return {
        "constraint model": of_walk(e.results.analytic.walk, biped.foot_radius, biped.leg_length, gravity),
        "multibody model": of_walk(e.results.multibody.walk, biped.foot_radius, biped.leg_length, gravity),
        "twin": of_walk(e.results.twin.walk, biped.foot_radius + layer, biped.leg_length + layer, gravity),
        f"runs ({e.measured.origin})": Determinants(step_frequency=e.measured.step_frequency),
    }
