"""The study's own parameters, and a step in a scene that is walked once."""

import pytest

from stages.error_budget.path import OneStep
from tests.study import parameters_of


@pytest.fixture(scope="session")
def parameters():
    return parameters_of("error_budget")


@pytest.fixture(scope="session")
def scene(parameters):
    return OneStep(parameters)
