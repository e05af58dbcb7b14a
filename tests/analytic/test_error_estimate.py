"""Error estimates of gait and walk against the same computed at a far smaller tolerance."""

import dataclasses
from functools import cache

import numpy as np
import pytest

from stages.analytic.gait.gait_search import step_length
from stages.analytic.gait.poincare import fixed_point
from stages.analytic.phases.section import section_state
from stages.analytic.walk import error_estimate
from stages.analytic.walk.error_estimate import along, carried_error, estimate_errors, gait_error
from stages.analytic.walk.recording import crossing_state, record, states_at, walk_on
from stages.analytic.walk.sampling import walk_from_mid_stance
from stages.biped.accuracy.estimate import walk_differences
from stages.ground.slope import Friction
from tests.analytic.designs import TABLE_1, found_gait, gait_beside, stiff_gait
from tests.analytic.test_detailed import LAME

STEPS = 6
FRAMES = dataclasses.replace(TABLE_1, frame_mass=0.01, frame_com=0.02)
SLIPPERY = Friction(static_friction=1.1, dynamic_friction=0.9)


def computed(walker, z, tolerance):
    point = fixed_point(walker, z, tolerance)
    walk, _ = walk_from_mid_stance(walker, point.z, STEPS, tolerance, 2000.0)
    return point, point.period * walker.time, step_length(walker, point) * walker.length, walk


@cache
def as_exact_as_can_be(design, friction):
    """Walker, gait, and what is computed of it, at the finest tolerance; each design's once."""
    walker, found = found_gait(dataclasses.replace(design, hip_friction=0.0), friction)
    if design.hip_friction:
        walker, found = gait_beside(design, found.z)
    return walker, found, computed(walker, found.z, 1e-13)


def is_the_error(design, friction, tolerance):
    """Hold what is estimated of the gait and a walk on it at this tolerance against what a finer one finds."""
    walker, found, (_, period, length, exact) = as_exact_as_can_be(design, friction)
    point, coarse_period, coarse_length, walk = computed(walker, found.z, tolerance)
    estimate = estimate_errors(walker, point, STEPS, tolerance)
    true = walk_differences(walk, exact)
    assert estimate.given
    assert estimate.period == pytest.approx(period - coarse_period, rel=0.1)
    assert estimate.step_length == pytest.approx(length - coarse_length, rel=0.1)
    assert estimate.hip_position == pytest.approx(true["hip_position_m"], rel=0.25)
    assert estimate.step_duration == pytest.approx(true["period_s"], rel=0.25)


@pytest.mark.parametrize(("design", "legs", "friction"), [
    (TABLE_1, "compliant", None), (TABLE_1, "rigid", None), (TABLE_1, "compliant", SLIPPERY),
    (LAME, "compliant", None), (LAME, "rigid", None), (LAME, "compliant", SLIPPERY),
])  # fmt: skip
@pytest.mark.parametrize("tolerance", [1e-6, 1e-8])
def test_the_estimate_is_the_error(design, legs, friction, tolerance):
    """Of gaits of one step, and of the strides of legs that differ."""
    own = dataclasses.replace(design, legs=legs)
    assert len(as_exact_as_can_be(own, friction)[1].steps) == (1 if design is TABLE_1 else 2)
    is_the_error(own, friction, tolerance)


@pytest.mark.parametrize(("design", "legs"), [
    (FRAMES, "rigid"), (FRAMES, "compliant"), (LAME, "rigid"), (LAME, "compliant")])
@pytest.mark.parametrize("tolerance", [1e-6, pytest.param(1e-8, marks=pytest.mark.slow)])
def test_the_estimate_is_the_error_of_a_hip_that_rubs(design, legs, tolerance):
    """Through the events at which the hip turns, or comes to rest."""
    own = dataclasses.replace(design, legs=legs, hip_friction=2e-3)
    assert as_exact_as_can_be(own, None)[0].p.tau_h > 0.0
    is_the_error(own, None, tolerance)


@pytest.mark.parametrize("design", [TABLE_1, LAME])
def test_an_error_at_the_start_is_carried_through_impacts_and_phases(design):
    """A small change of the start, carried as an error, is what the changed walk differs by."""
    walker, found = found_gait(design)
    start = crossing_state(walker, found.z, 1e-13)
    change = 1e-7 * np.array([0.0, 0.3, -1.0, 0.2, 1.0, -0.4, 0.5, 0.7])
    walks = [walk_on(walker, start + sign * change, 3, 1e-13) for sign in (1, -1)]
    carried = carried_error(walker, walk_on(walker, start, 3, 1e-13), change)
    for index in range(1, len(walks[0])):
        ahead, behind = (walk[index] for walk in walks)
        assert carried[index].delay == pytest.approx((ahead.start - behind.start) / 2, abs=1e-12)
        assert carried[index].origin == pytest.approx((ahead.origin - behind.origin) / 2, abs=1e-12)
        assert carried[index].states[0] == pytest.approx((ahead.states[0] - behind.states[0]) / 2, abs=1e-11)


def test_the_errors_of_the_steps_have_the_integrators_order():
    """A quarter of a step has an own error, and so an estimate of it, of about 1 / 4^9."""
    walker, found = found_gait(TABLE_1)
    single = record(walker, section_state(found.z, walker.p), 1, 1e-4)[-1]
    sizes = []
    for length in (0.06, 0.015):
        state = single.states[1]
        target = states_at(single.phase, np.zeros(1), state[None, :], np.array([length]), walker.p)[0]
        piece = dataclasses.replace(single, times=np.zeros(1), states=state[None, :], duration=length, end=target)
        sizes.append(np.abs(along(walker, piece, np.zeros(8))[-1]).max())
    assert 4**8 < sizes[0] / sizes[1] < 4**10


def test_on_stiff_legs_an_estimate_that_does_not_lead_is_not_given():
    """Radau's order falls on stiff legs, so that halves of a step do not tell the error of the whole."""
    stiff = dataclasses.replace(TABLE_1, stiffness=2800.0 * 1e4, damping=58.35 * 1e2)
    walker, found = stiff_gait(stiff, 1e-7)
    assert walker.stiff
    estimate = estimate_errors(walker, found, STEPS, 1e-7)
    assert not estimate.given
    assert "differ otherwise than estimated" in estimate.checked


def test_where_estimates_do_not_lead_none_is_given(monkeypatch):
    walker, found = gait_beside(TABLE_1, found_gait(TABLE_1)[1].z, tolerance=1e-8)
    monkeypatch.setattr(error_estimate, "OFF", 0.0)
    estimate = estimate_errors(walker, found, STEPS, 1e-8)
    assert not estimate.given
    assert "differ otherwise than estimated" in estimate.checked
    assert gait_error(walker, found, 1e-8).period is None
