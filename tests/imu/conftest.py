"""Walks and a good log of the stand-in that many files read."""

import pytest

from stages.campaign.parameters import Parameters
from stages.campaign.twin_run import TwinRun
from tests.imu.made_logs import Log, campaign_parameters, made_log, stand_in_walks

RUNS = 3


@pytest.fixture(scope="session")
def parameters() -> Parameters:
    return campaign_parameters()


@pytest.fixture(scope="session")
def walks(parameters: Parameters) -> list[TwinRun]:
    return stand_in_walks(RUNS, parameters)


@pytest.fixture(scope="session")
def log(walks: list[TwinRun], parameters: Parameters) -> Log:
    """The first run as it is."""
    return made_log(0, walks[0], parameters)
