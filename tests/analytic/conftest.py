"""The gait of Table 1, found once for all tests."""

import pytest

from stages.analytic.phases.motion import DOUBLE_STANCE
from stages.analytic.phases.section import section_state
from stages.analytic.walk.recording import record
from tests.analytic.designs import TABLE_1, TABLE_1_RIGID, found_gait


@pytest.fixture(scope="session")
def table_1_gait():
    """(walker, fixed point) of Table 1 at tolerance 1e-12."""
    return found_gait(TABLE_1)


@pytest.fixture(scope="session")
def rigid_gait():
    """(walker, fixed point) of Table 1 with rigid legs at tolerance 1e-12."""
    return found_gait(TABLE_1_RIGID)


@pytest.fixture(scope="session")
def table_1_step(table_1_gait):
    """Segments of one step of the gait of Table 1: double stance, single stance."""
    walker, point = table_1_gait
    return record(walker, section_state(point.z, walker.p), 1, 1e-12, DOUBLE_STANCE)
