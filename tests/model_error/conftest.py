"""The study's parameters of the stage, and one small result."""

import dataclasses

import pytest

from stages.model_error.run import run
from tests.study import parameters_of


@pytest.fixture(scope="session")
def parameters():
    return parameters_of("model_error")


@pytest.fixture(scope="session")
def small(parameters):
    """What few designs tell, and how far they are the while."""

    def progress(share, what):
        assert 0.0 <= share <= 1.0 and what

    settings = dataclasses.replace(parameters.settings, designs=8, twins=1, seed=4)  # whose gaits are found at once
    return run(dataclasses.replace(parameters, settings=settings), progress=progress)
