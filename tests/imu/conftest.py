"""Walks and a good log of the stand-in that many files read."""

import pytest

from stages.campaign.parameters import Parameters
from stages.campaign.twin_run import TwinRun
from tests.imu.made_logs import Log, made_log, stand_in_walks
from tests.imu.stand_in import EVERY

RUNS = 3


@pytest.fixture(scope="session")
def parameters() -> Parameters:
    """The campaign's as they are in the study."""
    found: Parameters = EVERY["campaign"]
    return found


@pytest.fixture(scope="session")
def walks(parameters: Parameters) -> list[TwinRun]:
    return stand_in_walks(RUNS, parameters)


@pytest.fixture(scope="session")
def log(walks: list[TwinRun], parameters: Parameters) -> Log:
    """The first run as it is."""
    return made_log(0, walks[0], parameters)
