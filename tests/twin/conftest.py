"""The twin of the study's own parameter files, a start for it, and a short walk that others look at."""

import dataclasses

import numpy as np
import pytest

from pipeline.parameters.loading import load
from stages.biped.gait import StanceState
from stages.twin.machine.contact import COUNT
from stages.twin.machine.machine import build
from stages.twin.parameters import Parameters
from stages.twin.walking.simulate import Start, rolling_start, simulate_twin

STANDING_FORCE = 9.4


@pytest.fixture(scope="session")
def parameters(repository):
    return load(repository / "params", [], {"twin": Parameters}, [Parameters])["twin"]


@pytest.fixture(scope="session")
def settings(parameters):
    return parameters.settings


@pytest.fixture(scope="session")
def machine(parameters):
    return build(parameters.biped, parameters.settings)


@pytest.fixture(scope="session")
def rough():
    """A mid-stance from which the walker finds its gait; the numbers are no result of the study."""
    return StanceState(0.0, 0.331, 0.27, 0.334, 0.71, 0.0, 1.8, 0.0)


@pytest.fixture(scope="session")
def walk_from(parameters, rough):
    """Walk a machine some steps from the rough state; other keywords are pushes."""

    def walk(machine, settings, steps, tree=None, ramp=None, **push):
        start = rolling_start(machine, parameters.contact, rough, STANDING_FORCE, **push)
        return simulate_twin(
            machine, parameters.slope, parameters.contact, start, settings, steps=steps, tree=tree, ramp=ramp
        )

    return walk


@pytest.fixture(scope="session")
def three_steps(machine, settings, walk_from):
    return walk_from(machine, dataclasses.replace(settings, tolerance=1e-7), 3)


@pytest.fixture(scope="session")
def fly(parameters):
    """Let a machine go 3 m above the ground at given rates; its motion under gravity for a quarter of a second."""

    def fly(machine, velocity, seconds=0.25):
        high = np.zeros(COUNT)
        high[1] = 3.0
        settings = dataclasses.replace(parameters.settings, tolerance=1e-10, longest_step=seconds)
        start = Start(high, velocity, in_play=(True, True))
        return simulate_twin(machine, parameters.slope, parameters.contact, start, settings, steps=1)

    return fly


@pytest.fixture(scope="session")
def random_states():
    """Coordinates, rates and accelerations of 20 poses near walking, each (20, 11)."""
    rng = np.random.default_rng(5)
    q = rng.normal(size=(20, 11)) * np.array([1, 0.01, 0.1, 0.2, 0.1, 0.3, 0.002, 0.002, 0.4, 0.002, 0.002])
    q[:, 1] += 0.325
    return q, rng.normal(size=(20, 11)), rng.normal(size=(20, 11))
