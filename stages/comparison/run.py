"""Comparison stage: how far all sources agree, the paper's claims with verdicts, and its figures.

Inputs: the results of all other stages. Settings: params/comparison.yaml. Outputs: `Result`, figures with
captions.yaml, claims.yaml.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from stages.biped.progress import Progress, ignore
from stages.biped.walk import require
from stages.comparison import captions, claims
from stages.comparison.agreement import ModelAgreement, TwinAgreement, compare_models, compare_twin
from stages.comparison.figures import (
    error_budget,
    extremes,
    figure_02,
    figure_04,
    figure_05,
    figure_06,
    figure_07,
    figure_08,
    figure_10,
    figure_16,
    gait_animation,
    tradeoff,
    twin_ladder,
    twin_pushes,
)
from stages.comparison.figures.drawing import Drawing, pictures_of
from stages.comparison.ingest_score import score_ingest
from stages.comparison.measurement import MeasurementAgreement, compare_measurement
from stages.comparison.parameters import Parameters
from stages.comparison.result import Result
from stages.comparison.stride import Stride, last_stride


def run(parameters: Parameters, inputs: Mapping[str, Any], progress: Progress = ignore) -> Result:
    """Compare, judge and draw.

    Raises ValueError if one of the walks is too short to hold a whole stride, NotRecorded if one lacks a signal.
    """
    settings = parameters.settings
    for name in ("multibody", "twin"):
        walk = inputs[name].walk
        require(name, {"ground_reaction": walk.ground_reaction, "imu": walk.hip_specific_force})
    require("multibody", {"slip": inputs["multibody"].slip_velocity})
    walkers = ("analytic", "multibody", "twin")
    strides = {name: last_stride(inputs[name].walk, settings.phase_points) for name in walkers}
    models = compare_models(inputs["analytic"], inputs["multibody"], strides)
    twin = compare_twin(inputs["twin"], strides)
    measured = compare_measurement(
        inputs["imu"], inputs["twin"].walk, strides["twin"], strides["multibody"], settings.skipped_steps
    )
    score = score_ingest(inputs["campaign"], inputs["imu"], settings.skipped_steps)
    progress(0.2, "judging the claims")
    verdicts = judge(parameters, inputs, models, twin, measured)
    progress(0.3, "drawing")
    figures = draw_all(parameters, inputs, strides, measured)
    compared = captions.Compared(inputs, parameters, models, twin, measured)
    drawn = list(dict.fromkeys(path.removeprefix("figures/").partition(".")[0] for path in figures))
    files = {"claims.yaml": claims.as_yaml(verdicts), "captions.yaml": captions.as_yaml(compared, drawn), **figures}
    return Result(models, twin, measured, score, verdicts, files)


def judge(
    parameters: Parameters,
    inputs: Mapping[str, Any],
    models: ModelAgreement,
    twin: TwinAgreement,
    measured: MeasurementAgreement,
) -> tuple[claims.Claim, ...]:
    """All claims in the paper's order."""
    analytic, multibody, settings = inputs["analytic"], inputs["multibody"], parameters.settings
    return (
        claims.step_frequency(analytic, settings),
        claims.stable_gait(analytic),
        claims.multipliers_minimised(analytic),
        claims.twice_differentiated_constraints(analytic),
        claims.rolling_without_slip(analytic, parameters.contact.static_friction),
        claims.contact_set(inputs["contact_study"], settings),
        claims.hip_displacement(models, settings),
        claims.hip_velocity(models, settings),
        claims.integration_tolerance(inputs["error_budget"]),
        claims.friction_velocities(
            multibody.friction_variations,
            multibody.cycle.period_s,
            multibody.cycle.step_length_m,
            settings.frequency_tolerance,
            inputs["contact_study"],
        ),
        claims.twin_settles(twin),
        claims.twin_like_simple(twin, settings),
        claims.ramp_length(analytic),
        claims.sensor_range(twin),
        claims.measurement_encloses(measured, settings),
        claims.measurement_slower(measured),
        claims.outsole_slows(analytic),
    )


def draw_all(
    parameters: Parameters, inputs: Mapping[str, Any], strides: Mapping[str, Stride], measured: MeasurementAgreement
) -> dict[str, bytes]:
    """All figures as files, by path in the results folder."""
    settings, radius = parameters.settings, parameters.biped.foot_radius
    analytic, multibody, twin, imu = (inputs[name] for name in ("analytic", "multibody", "twin", "imu"))
    study = inputs["contact_study"]
    limits = (settings.position_limit, settings.velocity_limit)
    measured_strides = np.concatenate([run.strides for run in imu.runs])
    shown = gait_animation.sources(analytic.walk, multibody.walk, twin.walk)
    drawings = (
        Drawing(figure_02.NAME, figure_02.draw, (analytic.walk, multibody.walk)),
        Drawing(figure_04.NAME, figure_04.draw, (parameters.contact,)),
        Drawing(figure_05.NAME, figure_05.draw, (study, analytic.walk)),
        Drawing(figure_06.NAME, figure_06.draw, (study, analytic.walk)),
        Drawing(figure_07.NAME, figure_07.draw, (multibody.walk, radius, parameters.slope.angle)),
        Drawing(figure_08.NAME, figure_08.draw, (analytic.walk, multibody.walk, 2 * analytic.gait.period_s, limits)),
        Drawing(figure_10.NAME, figure_10.draw, (twin.walk, twin.snapshots)),
        Drawing(error_budget.NAME, error_budget.draw, (inputs["error_budget"],)),
        Drawing(twin_ladder.NAME, twin_ladder.draw, (inputs["twin_ladder"],)),
        Drawing(twin_pushes.NAME, twin_pushes.draw, (inputs["twin_pushes"],)),
        Drawing(tradeoff.NAME, tradeoff.draw, (inputs["tradeoff"],)),
        Drawing(extremes.NAME, extremes.draw, (inputs["extremes"],)),
        Drawing(figure_16.NAME, figure_16.draw, (measured_strides, measured, strides["twin"], strides["multibody"])),
    )
    return gait_animation.draw(shown, radius, parameters.slope.angle) | pictures_of(drawings, settings.resolution_dpi)
