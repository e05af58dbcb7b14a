"""A walk of the planar model in Exudyn that others look at."""

import pytest

from stages.multibody.parameters import Settings
from stages.multibody.walking.walk import simulate
from tests.planar_start import biped, contact, rough, slope, start

__all__ = ["biped", "contact", "rough", "slope", "start"]  # fixtures


@pytest.fixture(scope="session")
def settings():
    return Settings(
        assembly="tree",
        steps=2,
        sampling_rate_hz=2000.0,
        tolerance=1e-9,
        largest_step=5e-4,
        implicit_solver="trapezoidal",
        rolling_step=2e-4,
        impact_step=1e-5,
        impact_window=0.02,
        longest_step=3.0,
    )


@pytest.fixture(scope="session")
def two_steps(biped, slope, contact, start, settings):
    return simulate(biped, slope, contact, start, settings)
