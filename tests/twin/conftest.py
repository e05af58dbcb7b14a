"""The twin of the study's own parameter files, a start for it, and a short walk that others look at."""

import dataclasses

import numpy as np
import pytest

from stages.biped.walk import StanceState
from stages.twin.machine.contact import COUNT
from stages.twin.machine.machine import build
from stages.twin.walking.simulate import Start, rolling_start, simulate_twin
from tests import planar_start
from tests.study import parameters_of

#: Mid-stances from which walkers find their gait, by whether their legs are rigid; no result of the study.
ROUGH = {False: planar_start.ROUGH, True: StanceState(0.0, 0.333, 0.27, 0.333, 0.72, 0.0, 1.85, 0.0)}
STANDING_FORCE = 9.4


@pytest.fixture(scope="session")
def parameters():
    return parameters_of("twin")


@pytest.fixture(scope="session")
def settings(parameters):
    return parameters.settings


@pytest.fixture(scope="session")
def machine(parameters):
    return build(parameters.biped, parameters.settings)


@pytest.fixture(scope="session")
def rough():
    return ROUGH[False]


@pytest.fixture(scope="session")
def walk_from(parameters):
    """Walk a machine some steps from a rough state, which may be pushed; other keywords change the settings."""

    def walk(machine, steps, tree=None, ramp=None, push=None, stance=None, **changes):
        settings = dataclasses.replace(parameters.settings, **changes)
        start = rolling_start(
            machine, parameters.contact, stance or ROUGH[machine.rigid], STANDING_FORCE, **(push or {}))
        return simulate_twin(
            machine, parameters.slope, parameters.contact, start, settings, steps=steps, tree=tree, ramp=ramp
        )

    return walk


@pytest.fixture(scope="session")
def three_steps(machine, walk_from):
    return walk_from(machine, 3, tolerance=1e-7)


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
