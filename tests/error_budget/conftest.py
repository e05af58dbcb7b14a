"""The study's own parameters, and a step in a scene that is walked once."""

import pytest

from pipeline.parameters.loading import load
from stages.error_budget.one_step import OneStep
from stages.error_budget.parameters import Parameters


@pytest.fixture(scope="session")
def parameters(repository):
    return load(repository / "params", [], {"error_budget": Parameters}, [Parameters])["error_budget"]


@pytest.fixture(scope="session")
def scene(parameters):
    return OneStep(parameters)
