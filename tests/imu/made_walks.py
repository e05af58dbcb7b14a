"""Walks of the stand-in in the form of the campaign's, for tests that have no time for the twin."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from pipeline.study import locate
from stages.campaign.parameters import Parameters
from stages.campaign.twin_run import TwinRun, draw_variation, generator, joined, rolling_leg, stand_and_push
from tests.imu.stand_in import BIPED, GRID, SLOPE, walking

STEPS, PERIOD_S, REST_S, PUSH_S = 9, 0.48, 2.5, 0.4


def campaign_parameters() -> Parameters:
    """The campaign's parameters as they are in the study."""
    found: Parameters = locate(start=Path(__file__).parents[2]).parameters(["campaign"])["campaign"]
    return found


def stand_in_walks(count: int, parameters: Parameters) -> list[TwinRun]:
    """So many walks of different step period, with a still stand and a push before each."""
    walks = []
    for number in range(count):
        rng = generator(parameters.runs.seed, number, 0)
        variation = draw_variation(parameters.runs.of(parameters.biped), SLOPE, rng)
        hip, foot, strikes, truth = walking(STEPS, PERIOD_S * (1 + 0.01 * rng.normal()))
        rate = hip.angular_velocity[:, 2]
        time, leg = stand_and_push(0.0, (0.0, rate[0], (rate[1] - rate[0]) / GRID), REST_S, PUSH_S, GRID)
        before = rolling_leg((leg[0], leg[1], leg[2]), BIPED, SLOPE, time)
        legs = (np.arange(STEPS) + 1) % 2
        walks.append(TwinRun(joined(before[0], hip), joined(before[1], foot), strikes, legs, truth, variation, 1))
    return walks
