"""The readable SciPy path against the compiled one."""

import dataclasses
from functools import cache

import numpy as np
import pytest

from stages.analytic.errors import StepFailed
from stages.analytic.gait.gait_search import find_gait
from stages.analytic.gait.poincare import poincare_map
from stages.analytic.integration import readable
from stages.analytic.integration.readable import derivative, heel_strike, refine, take_step
from stages.analytic.parameters import Parameters, Settings
from stages.analytic.phases.impact import heel_strike_reset
from stages.analytic.phases.section import section_state
from stages.analytic.run import run
from tests.analytic.designs import FRICTION, HEAVY_LEGS, RUBBER, SLOPE, TABLE_1, found_gait, random_states, walker_of
from tests.analytic.test_detailed import LAME


@pytest.mark.parametrize("kind", ["table_1_gait", "rigid_gait"])
def test_both_paths_take_the_same_step(kind, request):
    walker, point = request.getfixturevalue(kind)
    z = point.z * 1.003
    compiled, other = poincare_map(walker, z, 1e-12), take_step(walker, z, 1e-12)
    assert np.abs(other.z - compiled.z).max() <= 1e-9
    assert other.period == pytest.approx(compiled.period, rel=1e-9)
    assert other.double_stance == pytest.approx(compiled.double_stance, abs=1e-10)


@pytest.mark.parametrize("legs", ["rigid", "compliant"])
def test_both_paths_take_the_same_stride_of_legs_that_differ(legs):
    """Frames, a hip with spring and damper, a counterweight: each leg stands once."""
    walker, point = found_gait(dataclasses.replace(LAME, legs=legs))
    z = point.z * 1.001
    for standing in (walker, walker.exchanged):
        compiled, other = poincare_map(standing, z, 1e-12), take_step(standing, z, 1e-12)
        assert np.abs(other.z - compiled.z).max() <= 1e-9
        assert other.period == pytest.approx(compiled.period, rel=1e-9)
        z = compiled.z


def test_both_paths_have_the_same_impact():
    walker = walker_of(HEAVY_LEGS)
    for y in random_states(walker, 30):
        expected = y.copy()
        heel_strike_reset(expected, walker.p)
        assert np.abs(heel_strike(walker, y) - expected).max() <= 1e-12


@pytest.fixture(scope="module")
def refined(table_1_gait):
    """The gait of Table 1 on the readable path, from beside it; Newton's steps have the derivative at the gait."""
    walker, point = table_1_gait
    once = cache(lambda: derivative(walker, point.z, 1e-9))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(readable, "derivative", lambda *_: once())
        return refine(walker, point.z + 1e-6, 1e-9, iterations=2)


def test_derivative_without_variational_equations(table_1_gait, refined):
    assert np.abs(refined.monodromy_matrix - table_1_gait[1].monodromy_matrix).max() <= 1e-4


def test_gait_refined_on_the_readable_path(table_1_gait, refined):
    assert np.abs(refined.z - table_1_gait[1].z).max() <= 1e-9


@pytest.mark.slow
def test_stage_runs_on_the_readable_path():
    """`integrator: scipy` gives the same result to the accuracy of its finite differences."""
    names = ("compiled", "scipy")
    both = [Settings(tolerance=1e-10, steps=1, sampling_rate_hz=100.0, integrator=name) for name in names]
    results = [run(Parameters(TABLE_1, SLOPE, FRICTION, RUBBER, settings)) for settings in both]
    gaits = [result.gait for result in results]
    assert gaits[0].period_s == pytest.approx(gaits[1].period_s, rel=1e-8)
    assert np.abs(gaits[0].floquet_multipliers[:2] - gaits[1].floquet_multipliers[:2]).max() <= 1e-4
    assert gaits[0].period_s != gaits[1].period_s, "the setting must change how the gait is computed"


def test_a_foot_that_scuffs_without_end_is_given_up(table_1_gait, monkeypatch):
    """Each strike found is behind the stance foot: the search for the next one ends."""
    walker, point = table_1_gait
    y = section_state(point.z, walker.p)
    monkeypatch.setattr(readable, "integrate", lambda *_: (0.0, y))
    monkeypatch.setattr(readable, "advance", lambda *_: -1.0)
    with pytest.raises(StepFailed, match="scuffs without end"):
        readable.single_stance(walker, y, 1e-6)


def test_rigid_legs_that_pass_are_no_heel_strike():
    """Equal legs in parallel have both feet at one place; at 1e-9 round-off put the swing foot a hair ahead here."""
    design = dataclasses.replace(TABLE_1, legs="rigid", foot_com=0.0223)
    walker, point = find_gait(design, dataclasses.replace(SLOPE, slope_deg=0.8), 1e-11)
    for tolerance in (1e-7, 1e-8, 1e-9, 1e-10, 1e-11):
        assert take_step(walker, point.z, tolerance).period == pytest.approx(point.steps[0].period, rel=1e3 * tolerance)
