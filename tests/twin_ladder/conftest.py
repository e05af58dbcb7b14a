"""The ladder's machines of the study's own parameters, and a planar start that is near the gait."""

import numpy as np
import pytest

from stages.twin_ladder.run import rungs
from tests.study import parameters_of


@pytest.fixture(scope="session")
def parameters():
    return parameters_of("twin_ladder")


@pytest.fixture(scope="session")
def machines(parameters):
    return rungs(parameters.biped, parameters.twin, parameters.settings.outsole)


@pytest.fixture(scope="session")
def plane():
    """A mid-stance in the plane from which all machines step on; the numbers are no result of the study."""
    return np.array([0.330985, 0.27, 0.331, 0.334, 0.235, 0.0, -0.71, 1.8, 0.0, 0.0])
