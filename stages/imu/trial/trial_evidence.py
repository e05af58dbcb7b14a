"""The evidence of a run, gathered from its sensors, strikes and strides."""

from __future__ import annotations

import math

import numpy as np

from stages.imu.judgement.evidence import (
    agreement_of,
    gravity_of,
    lever_of,
    skewness,
    spacing_of,
    symmetry_of,
    turning_of,
)
from stages.imu.parameters import Settings
from stages.imu.reports.run_report import Evidence
from stages.imu.sources.schema import Experiment
from stages.imu.strikes.landings import HeelStrikes
from stages.imu.trial.places import LATERAL, PLACES, BodySensor, angle_on, common_grid, on_grid


def evidence_of(
    sensors: dict[str, BodySensor],
    strikes: HeelStrikes,
    bounds: np.ndarray,
    experiment: Experiment,
    settings: Settings,
    quick: float,
) -> Evidence:
    """What the run's signals say about themselves; the robot is so `quick` as Table 1's."""
    agreement, ratio, direction, fit, scale = (math.nan,) * 5
    grid = common_grid(sensors, settings) if sensors else np.empty(0)
    seen = {place: on_grid(sensor, grid, settings) for place, sensor in sensors.items()}
    if len(sensors) == 2:
        agreement, ratio = agreement_of(*(seen[place][:, 3 + LATERAL] for place in PLACES))
        direction, fit, scale = lever_of(grid, seen["hip"], seen["foot"], strikes, settings.grid_rate_hz, quick)
    turning, symmetry, gravity = {}, {}, {}
    for place, sensor in sensors.items():
        turning[place] = turning_of(sensor.force, sensor.rate, sensor.trace.rate_hz, settings.turning_hz)
        if not len(bounds) or not len(grid):
            continue
        angle = angle_on(grid, place, seen, sensor, settings)
        symmetry[place] = symmetry_of(np.interp(strikes.time, grid, angle), strikes)
        size, downhill = gravity_of(grid, seen[place][:, :3], angle, (bounds[0, 0], bounds[-1, 1]))
        gravity[place] = size / settings.gravity, math.degrees(downhill) - (experiment.slope_deg or 0.0)
    first = next((place for place in PLACES if place in sensors), "")
    spacing, alternating = spacing_of(strikes)
    return Evidence(
        agreement=agreement,
        rate_ratio=ratio,
        lever_direction_deg=direction,
        lever_fit=fit,
        rate_scale=scale,
        third_moment=skewness(sensors[first].rate[~sensors[first].trace.rest, LATERAL]) if first else math.nan,
        hip_turning=turning.get("hip", math.nan),
        foot_turning=turning.get("foot", math.nan),
        strike_symmetry_deg=symmetry.get(first, math.nan),
        hip_gravity=gravity.get("hip", (math.nan, math.nan))[0],
        foot_gravity=gravity.get("foot", (math.nan, math.nan))[0],
        hip_gravity_deg=gravity.get("hip", (math.nan, math.nan))[1],
        foot_gravity_deg=gravity.get("foot", (math.nan, math.nan))[1],
        spacing=spacing,
        alternating=alternating,
    )
