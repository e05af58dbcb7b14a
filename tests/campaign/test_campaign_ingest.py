"""Several seeds of the whole synthetic campaign through the blind ingest, with the issue's limits and the margins."""

import dataclasses
from functools import partial
from typing import Any

import numpy as np
import pytest

from stages.analytic.run import run as run_analytic
from stages.biped.processes import each_in_a_process
from stages.campaign.parameters import Parameters
from stages.campaign.result import Result as Campaign
from stages.campaign.run import MOUNTING, SYNTHETIC, database_bytes, device, sensed_run
from stages.campaign.twin_run import TwinRun, first_state, walk_twin
from stages.comparison.ingest_score import IngestScore, score_ingest
from stages.imu.run import Inputs
from stages.imu.run import run as ingest

pytestmark = pytest.mark.slow

SEEDS = (11, 12, 13)
RUNS = 30
ROUGH = {"stall_share": 0.10, "loss_share": 0.05}


def seeded(parameters: Parameters, seed: int) -> Parameters:
    return dataclasses.replace(parameters, runs=dataclasses.replace(parameters.runs, seed=seed, runs=RUNS))


@pytest.fixture(scope="module")
def walked(every: dict[str, Any]) -> dict[int, list[TwinRun]]:
    """The twin's walks of every seed; the radio does not change them."""
    state, force = first_state(run_analytic(every["analytic"]).walk)
    walks = {}
    for seed in SEEDS:
        one = partial(walk_twin, state=state, normal_force=force, parameters=seeded(every["campaign"], seed))
        found = dict(each_in_a_process(one, range(RUNS)))
        walks[seed] = [found[number] for number in range(RUNS)]
    return walks


@pytest.fixture(scope="module", params=["usual radio", "5 % lost, 10 % stalls"])
def scores(
    request: pytest.FixtureRequest, every: dict[str, Any], walked: dict[int, list[TwinRun]], tmp_path_factory: Any
) -> list[IngestScore]:
    path = tmp_path_factory.mktemp("campaign") / "measurements.sqlite"
    found = []
    for seed, walks in walked.items():
        parameters = seeded(every["campaign"], seed)
        if request.param != "usual radio":
            parameters = dataclasses.replace(parameters, radio=dataclasses.replace(parameters.radio, **ROUGH))
        made = [sensed_run(number, walk, parameters) for number, walk in enumerate(walks)]
        sent = [(experiment, sent) for experiment, _, sent in made]
        path.write_bytes(database_bytes([device(place, parameters) for place in MOUNTING], sent))
        result = ingest(every["imu"], Inputs(path))
        assert len(result.runs) == RUNS
        score = score_ingest(Campaign(SYNTHETIC, tuple(truth for _, truth, _ in made), (), (), {}), result, 3, 9.81)
        assert score is not None
        print(f"seed {seed}, {request.param}:", *(" ".join(row) for row in score.table()[2]), sep="\n  ")
        found.append(score)
    return found


def test_clock(scores: list[IngestScore]) -> None:
    assert max(np.sqrt(np.mean(one.clock_error**2)) for one in scores) <= 1e-3


def test_heel_strikes(scores: list[IngestScore]) -> None:
    assert min(one.recall.mean() for one in scores) >= 0.99
    assert min(one.precision.mean() for one in scores) >= 0.99
    assert all(one.legs_right.all() for one in scores)


def test_step_frequency(scores: list[IngestScore]) -> None:
    errors = np.concatenate([one.frequency_error for one in scores])
    assert np.abs(errors).max() <= 1e-3
    assert np.sqrt(np.mean(errors**2)) <= 3e-4, "so that the limit lies more than three standard deviations off"


def test_frames_are_as_good_as_the_stand_and_the_accelerometer_allow(
    scores: list[IngestScore], every: dict[str, Any]
) -> None:
    """The pitch comes from gravity at rest: the forward bias, the stand and the inclination go into it whole.

    With the campaign's spreads that is 0.16 degrees rms, so of 60 sensors one now and then lies beyond 0.5 degrees.
    """
    runs, sensor = every["campaign"].runs, every["campaign"].sensor
    bias = np.degrees(sensor.acceleration_bias_sd / 9.81)
    expected = np.sqrt(bias**2 + runs.stance_sd_deg**2 + runs.slope_reading_sd_deg**2)
    worst = np.concatenate([one.frame_angle for one in scores])
    # the worse of two sensors that share the stand: at most the square root of two times one of them, rms
    assert np.sqrt(np.mean(worst**2)) <= 1.1 * np.sqrt(2) * expected
    assert np.quantile(worst, 0.95) <= 0.5
