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
    agreement, ratio, direction, scale, gain, of_hip, of_foot = (math.nan,) * 7
    grid = common_grid(sensors, settings) if sensors else np.empty(0)
    seen = {place: on_grid(sensor, grid, settings) for place, sensor in sensors.items()}
    if len(sensors) == 2:
        agreement, ratio = agreement_of(*(seen[place][:, 3 + LATERAL] for place in PLACES))
        direction, scale, gain, of_hip, of_foot = lever_of(
            grid, seen["hip"], seen["foot"], strikes, settings.grid_rate_hz, quick)
    symmetry, gravity = {}, {}
    for place, sensor in sensors.items():
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
        forward_gain=gain,
        rate_scale=scale,
        third_moment=skewness(sensors[first].rate[~sensors[first].trace.rest, LATERAL]) if first else math.nan,
        hip_turning=of_hip,
        foot_turning=of_foot,
        strike_symmetry_deg=symmetry.get(first, math.nan),
        hip_gravity=gravity.get("hip", (math.nan, math.nan))[0],
        foot_gravity=gravity.get("foot", (math.nan, math.nan))[0],
        hip_gravity_deg=gravity.get("hip", (math.nan, math.nan))[1],
        foot_gravity_deg=gravity.get("foot", (math.nan, math.nan))[1],
        spacing=spacing,
        alternating=alternating,
    )
