"""The paper's biped on the paper's slope and Adams' default ground, and a mid-stance from which it finds its gait."""

import pytest

from stages.biped.walk import StanceState
from stages.ground.contact_law import ContactLaw
from stages.planar.run import rolling_state
from stages.planar.section import section_scales
from tests.study import SLOPE, TABLE_1

#: A mid-stance from which the walker finds its gait; the numbers are no result of the study.
ROUGH = StanceState(0.0, 0.331, 0.27, 0.334, 0.71, 0.0, 1.8, 0.0)
#: Scales of the section's numbers.
SCALES = section_scales(TABLE_1, SLOPE)


@pytest.fixture(scope="session")
def biped():
    return TABLE_1


@pytest.fixture(scope="session")
def slope():
    return SLOPE


@pytest.fixture(scope="session")
def contact():
    return ContactLaw(1e5, 2.2, 1e4, 1e-4, 1.1, 1.0, 0.1, 1.0)


@pytest.fixture(scope="session")
def rough():
    return ROUGH


@pytest.fixture(scope="session")
def start(biped, contact, rough):
    return rolling_state(biped, contact, rough, normal_force=9.4)
