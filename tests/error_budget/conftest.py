"""The study's own parameters, and a step in a scene that is walked once."""

import pytest

from pipeline.study import locate
from stages.error_budget.path import OneStep


@pytest.fixture(scope="session")
def parameters(repository):
    return locate(start=repository).parameters(["error_budget"])["error_budget"]


@pytest.fixture(scope="session")
def scene(parameters):
    return OneStep(parameters)
