"""The gait of the compiled penalty walker that others look at."""

import pytest

from stages.penalty.step_map import PenaltyStepper
from stages.penalty.walk import Settings
from stages.planar.limit_cycle import gait_near
from tests.planar_start import biped, contact, rough, slope, start

__all__ = ["biped", "contact", "rough", "slope", "start"]  # fixtures


@pytest.fixture(scope="session")
def gait(biped, slope, contact, start):
    return gait_near(PenaltyStepper(biped, slope, contact, start, Settings(1e-12)), start)
