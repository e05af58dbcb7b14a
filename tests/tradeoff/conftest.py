"""The study's parameters for the tradeoff stage, and the constraint model's mid-stance."""

from types import SimpleNamespace

import pytest

from stages.analytic.gait.gait_search import find_gait
from stages.analytic.walk.recording import crossing_state, record
from stages.analytic.walk.sampling import sample_walk
from tests.study import parameters_of


@pytest.fixture(scope="session")
def parameters():
    return parameters_of("tradeoff")


@pytest.fixture(scope="session")
def analytic(parameters):
    """What the stage reads of the analytic result: mid-stance of the gait and the force of the walk's first sample."""
    walker, point = find_gait(parameters.biped, parameters.slope, 1e-12)
    upright = crossing_state(walker, point.z, 1e-12)
    walk = sample_walk(walker, record(walker, upright, 1, 1e-12, 1), 1000.0)
    return SimpleNamespace(mid_stance=walker.stance_state(upright), walk=walk)
