"""Comparison stage: how far all sources agree, and the paper's claims with verdicts.

Inputs: the results of the models, of their studies and of the ingest. Settings: params/comparison.yaml. Outputs:
`Result`, claims.yaml.
"""

from __future__ import annotations

from dataclasses import dataclass

from stages.analytic.result import Result as Analytic
from stages.biped.progress import Progress, ignore
from stages.biped.walk import require
from stages.campaign.result import Result as Campaign
from stages.comparison import claims
from stages.comparison.agreement import ModelAgreement, TwinAgreement, compare_models, compare_twin
from stages.comparison.ingest_score import score_ingest
from stages.comparison.measurement import MeasurementAgreement, compare_measurement
from stages.comparison.parameters import Parameters
from stages.comparison.result import Claim, Result
from stages.comparison.stride import last_stride
from stages.contact_study.result import Result as ContactStudy
from stages.error_budget.result import Result as ErrorBudget
from stages.imu.result import Result as Ingested
from stages.multibody.result import Result as Multibody
from stages.twin.result import Result as Twin


@dataclass(frozen=True)
class Inputs:
    """The results that are compared and judged."""

    analytic: Analytic
    multibody: Multibody
    contact_study: ContactStudy
    error_budget: ErrorBudget
    twin: Twin
    campaign: Campaign
    imu: Ingested


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
        inputs.imu, inputs.twin.walk, strides["twin"], strides["multibody"], settings.skipped_steps
    )
    score = score_ingest(inputs.campaign, inputs.imu, settings.skipped_steps)
    progress(0.8, "judging the claims")
    verdicts = judge(parameters, inputs, models, twin, measured)
    return Result(models, twin, measured, score, verdicts, {"claims.yaml": claims.as_yaml(verdicts)})


def judge(
    parameters: Parameters,
    inputs: Inputs,
    models: ModelAgreement,
    twin: TwinAgreement,
    measured: MeasurementAgreement,
) -> tuple[Claim, ...]:
    """All claims in the paper's order."""
    analytic, multibody, settings = inputs.analytic, inputs.multibody, parameters.settings
    return (
        claims.step_frequency(analytic, settings),
        claims.stable_gait(analytic),
        claims.multipliers_minimised(analytic),
        claims.twice_differentiated_constraints(analytic),
        claims.rolling_without_slip(analytic, parameters.friction.static_friction),
        claims.contact_set(inputs.contact_study, settings),
        claims.hip_displacement(models, settings),
        claims.hip_velocity(models, settings),
        claims.integration_tolerance(inputs.error_budget),
        claims.friction_velocities(
            multibody.friction_variations,
            multibody.cycle.period_s,
            multibody.cycle.step_length_m,
            settings.frequency_tolerance,
            inputs.contact_study,
        ),
        claims.twin_settles(twin),
        claims.twin_like_simple(twin, settings),
        claims.ramp_length(analytic),
        claims.sensor_range(twin),
        claims.measurement_encloses(measured, settings),
        claims.measurement_slower(measured),
        claims.outsole_slows(analytic),
    )
