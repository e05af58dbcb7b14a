"""Shortcuts that cost a wrong gait, each taken here on purpose to show what it costs.

Scuffing has its test beside the guards, in test_transitions; slip of the trailing foot in test_validity.
"""

import numpy as np

from stages.analytic.gait.poincare import fixed_point, poincare_map
from stages.analytic.phases.impact import heel_strike_reset
from stages.analytic.phases.motion import SINGLE_STANCE
from stages.analytic.phases.section import section_coordinates
from stages.analytic.walk.recording import states_at

#: One millionth of a second, as a common setting of event location has it.
MICROSECOND = 1e-6


def test_the_first_root_found_need_not_be_the_gait(table_1_gait, table_1_gaits):
    """Newton's method from a short step finds a gait too, and it is unstable; the search names the stable one."""
    walker, stable = table_1_gait
    short = next(point for point in table_1_gaits if np.abs(point.floquet_multipliers).max() > 1)
    first = fixed_point(walker, short.z + 1e-3 * np.array([1.0, 0.0, 0.0, -1.0, 0.0]), 1e-11)
    assert first is not None and first.residual <= 1e-10
    assert np.abs(first.floquet_multipliers).max() > 1
    assert np.abs(stable.floquet_multipliers).max() < 1
    assert abs(first.steps[0].period - stable.steps[0].period) > 1e-2


def test_an_event_known_to_a_microsecond_caps_everything(table_1_gait, table_1_step):
    """The step ended a microsecond early is off by more than 1e-8; steps at two tolerances agree to 1e-11."""
    walker, point = table_1_gait
    single = table_1_step[-1]
    assert single.phase == SINGLE_STANCE
    early = np.array([single.duration - MICROSECOND / walker.time])
    naive = states_at(SINGLE_STANCE, single.times[-1:], single.states[-1:], early - single.times[-1], walker.p)[0]
    heel_strike_reset(naive, walker.p)
    exact = poincare_map(walker, point.z, 1e-13).z
    assert np.abs(section_coordinates(naive, walker.p) - exact).max() > 1e-8
    assert np.abs(poincare_map(walker, point.z, 1e-11).z - exact).max() <= 1e-11
