"""The study's parameters of the stage, and one small result."""

import dataclasses

import pytest

from pipeline.parameters.loading import load
from stages.model_error.parameters import Parameters
from stages.model_error.run import run
from stages.stability.parameters import Parameters as Stability


@pytest.fixture(scope="session")
def parameters(repository):
    return load(repository / "params", [], {"model_error": Parameters}, [Parameters, Stability])["model_error"]


@pytest.fixture(scope="session")
def small(parameters):
    """What few designs tell."""
    settings = dataclasses.replace(parameters.settings, designs=8, twins=1, seed=4)  # whose gaits are found at once
    return run(dataclasses.replace(parameters, settings=settings))
