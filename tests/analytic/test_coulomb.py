"""The trailing foot with Coulomb friction: laws of contact, energy, derivative, and what it tends to."""

import dataclasses

import numpy as np
import pytest

from stages.analytic.errors import NoGait, StepFailed
from stages.analytic.gait import poincare
from stages.analytic.gait.gait_report import report_gait
from stages.analytic.gait.gait_search import find_gait
from stages.analytic.gait.poincare import fixed_point, poincare_map
from stages.analytic.integration import phase as phase_module
from stages.analytic.integration.phase import EVENT, STEP_LIMIT
from stages.analytic.integration.readable import terms
from stages.analytic.model.walker import build_walker
from stages.analytic.parameters import Parameters, Settings
from stages.analytic.phases.guards import contact_rates
from stages.analytic.phases.impact import (
    LIFTS,
    SLIPS,
    STICKS,
    UNDECIDED,
    heel_strike_reset,
    land,
    trailing_impulse,
)
from stages.analytic.phases.motion import DOUBLE_STANCE, HOVERING, SINGLE_STANCE, SLIDING_BACK, SLIDING_FORWARD
from stages.analytic.phases.section import section_state
from stages.analytic.run import run
from stages.analytic.walk.on_a_ramp import on_a_ramp
from stages.analytic.walk.recording import record, states_at
from stages.analytic.walk.sampling import accelerations_and_forces, sample_walk
from stages.analytic.walk.validity import dense_states
from stages.ground.slope import Friction
from tests.analytic.designs import (
    FRICTION,
    HEAVY_LEGS,
    RUBBER,
    SLOPE,
    TABLE_1,
    TABLE_1_RIGID,
    clearance,
    found_gait,
    walker_of,
)
from tests.analytic.test_transitions import landing_states

SLIDES = {SLIDING_FORWARD: 1.0, SLIDING_BACK: -1.0}


def with_friction(static, dynamic=None, design=TABLE_1):
    return build_walker(design, SLOPE, Friction(static, static if dynamic is None else dynamic))


@pytest.fixture(scope="module")
def gait():
    """(walker, fixed point) of Table 1 with the paper's friction."""
    return found_gait(TABLE_1, FRICTION)


@pytest.fixture(scope="module")
def step(gait):
    walker, point = gait
    return record(walker, section_state(point.z, walker.p), 1, 1e-12)


# --- impact --------------------------------------------------------------------------------------------------------


def matrices(walker, y):
    """M and Pi from the readable terms."""
    t = terms("compliant")
    return t.mass(y, walker.p), t.constraint_jacobian(y, walker.p)


@pytest.fixture(scope="module")
def landings():
    return landing_states(walker_of(HEAVY_LEGS), 150)


@pytest.mark.parametrize("friction", [(0.0, 0.0), (0.6, 0.6), (1.1, 1.0), (8.0, 6.0)])
def test_impulses_are_complementary(friction, landings):
    """No pull, no approach left, one of both zero; friction inside its cone, at mu_d against the slip if it slips."""
    walker, found = with_friction(*friction, design=HEAVY_LEGS), []
    for before in landings:
        y = before.copy()
        land(y, walker.p)
        mass, pi = matrices(walker, y)
        free = y[4:].copy()
        kind, *_ = trailing_impulse(y, walker.p)
        whole = before.copy()
        assert heel_strike_reset(whole, walker.p) == (kind != UNDECIDED)
        if kind == UNDECIDED:
            continue
        found.append(kind)
        normal, tangential = np.linalg.lstsq(pi, mass @ (whole[4:] - free), rcond=None)[0]
        rise, slip = pi.T @ whole[4:]
        assert np.abs(mass @ (whole[4:] - free) - pi @ [normal, tangential]).max() <= 1e-13
        assert normal >= -1e-14 and rise >= -1e-13 and abs(normal * rise) <= 1e-13
        assert abs(tangential) <= friction[0] * normal + 1e-13
        if kind == SLIPS:
            assert tangential == pytest.approx(-friction[1] * np.sign(slip) * normal, abs=1e-13)
        if kind == STICKS:
            assert abs(slip) <= 1e-13
        assert whole[4:] @ mass @ whole[4:] <= free @ mass @ free + 1e-13  # the contact only takes energy
    assert LIFTS in found and SLIPS in found and (STICKS in found or friction[0] < 5)


def test_both_forms_of_the_rolling_impact_agree(landings):
    """Landing foot first, in the new coordinates, then a trailing foot that sticks; or both at once, in the old."""
    rolling = walker_of(HEAVY_LEGS)
    for before in landings[:40]:
        expected, y = before.copy(), before.copy()
        heel_strike_reset(expected, rolling.p)
        land(y, rolling.p)
        mass, pi = matrices(rolling, y)
        stuck = y[4:] - np.linalg.solve(mass, pi @ np.linalg.solve(pi.T @ np.linalg.solve(mass, pi), pi.T @ y[4:]))
        assert np.abs(y[:4] - expected[:4]).max() == 0
        assert np.abs(stuck - expected[4:]).max() <= 1e-13


# --- double stance -------------------------------------------------------------------------------------------------


def test_every_phase_keeps_its_law(gait, step):
    """Rolling inside the cone, sliding on it and against the slip, hovering above ground; the ground never pulls."""
    walker, _ = gait
    phases = [segment.phase for segment in step]
    assert phases[-1] == SINGLE_STANCE and HOVERING in phases and DOUBLE_STANCE in phases and set(phases) & set(SLIDES)
    for segment in step[:-1]:
        states = dense_states(walker, segment)
        tangential, normal = accelerations_and_forces(segment.phase, states, walker.p)[:, 6:].T
        rise, slip = np.array([contact_rates(y, walker.p) for y in states]).T
        height = np.array([clearance(y, walker.p)[0] for y in states])
        assert normal.min() >= -1e-12
        if segment.phase == HOVERING:
            assert height.min() >= -1e-13 and not normal.any() and not tangential.any()
            continue
        assert np.abs(height).max() <= 1e-10 and np.abs(rise).max() <= 1e-10
        if segment.phase == DOUBLE_STANCE:
            assert np.abs(slip).max() <= 1e-10
            assert (np.abs(tangential) <= 1.1 * normal + 1e-12).all()
        else:
            assert (SLIDES[segment.phase] * slip >= -1e-12).all()
            assert np.abs(tangential + SLIDES[segment.phase] * 1.0 * normal).max() <= 1e-13


def test_events_lie_where_the_laws_change(gait, step):
    """Slip, friction left, or normal force is zero at the end of each phase on the ground, to round-off."""
    walker, _ = gait
    for segment in step[:-1]:
        if segment.phase == HOVERING:
            assert min(abs(clearance(segment.end, walker.p)[0]), abs(segment.end[6])) <= 1e-13
            continue
        tangential, normal = accelerations_and_forces(segment.phase, segment.end[None], walker.p)[0, 6:]
        left = 1.1 * normal - abs(tangential) if segment.phase == DOUBLE_STANCE else normal
        slip = abs(contact_rates(segment.end, walker.p)[1]) if segment.phase in SLIDES else np.inf
        assert min(abs(left), slip) <= 1e-12


def moreau(walker, y, duration, steps):
    """State after `duration` by Moreau's time stepping with the readable terms: impulses and velocities, no phases.

    The trailing foot's contact counts where it is at or below ground; its impulse over a step obeys the same law with
    one friction coefficient. First order; M. Jean, The non-smooth contact dynamics method, 1999.
    """
    t, h, mu = terms("compliant"), duration / steps, walker.p.mu_s
    q, qd = y[:4].copy(), y[4:].copy()
    for _ in range(steps):
        middle = np.concatenate([q + h / 2 * qd, qd])
        mass = t.mass(middle, walker.p)
        qd = qd + h * np.linalg.solve(mass, t.force(middle, walker.p).ravel())
        if t.constraint(middle, walker.p)[0, 0] <= 0:
            pi = t.constraint_jacobian(middle, walker.p)
            spread = np.linalg.solve(mass, pi)
            w, u = pi.T @ spread, pi.T @ qd
            if u[0] < 0:
                impulse = -np.linalg.solve(w, u)
                if abs(impulse[1]) > mu * impulse[0]:
                    column = np.array([1.0, mu * np.sign(impulse[1])])
                    impulse = column * (-u[0] / (w[0] @ column))
                qd = qd + spread @ impulse
        q = middle[:4] + h / 2 * qd
    return np.concatenate([q, qd])


def test_phases_agree_with_time_stepping_that_knows_none():
    """Through hop, slide, roll, slide and lift-off; the difference falls with the first order of time stepping."""
    walker = with_friction(1.1)
    point = fixed_point(walker, np.array([-0.2651, 1.00253, 0.99483, 0.4237, -0.1577, 0.0, 0.0]), 1e-11)
    segments = record(walker, section_state(point.z, walker.p), 1, 1e-12)
    hover = segments[-2]
    duration = 0.04
    assert hover.phase == HOVERING and hover.start < duration < hover.start + hover.duration
    exact = states_at(HOVERING, hover.times, hover.states, np.array([duration - hover.start]), walker.p)[0]
    start = section_state(point.z, walker.p)
    errors = [np.abs(moreau(walker, start, duration, n) - exact).max() for n in (500, 2000)]
    rolled = record(walker_of(), np.concatenate([start[:6], section_state(point.z[:5], walker_of().p)[6:]]), 1,
                    1e-12, DOUBLE_STANCE)[1]
    other = states_at(SINGLE_STANCE, rolled.times, rolled.states, np.array([duration - rolled.start]), walker.p)[0]
    assert np.log(errors[0] / errors[1]) / np.log(4) == pytest.approx(1.0, abs=0.01), errors
    assert np.abs(other - exact).max() > 20 * errors[1]  # a foot that rolls on is told apart


def test_hop_after_heel_strike_is_resolved(gait, step):
    """The trailing foot leaves the impact at v_N and falls back under its spring: 2 v_N over the rate it is pressed."""
    walker, point = gait
    hop = step[0]
    assert hop.phase == HOVERING and hop.duration < 1e-3
    heights = np.array([clearance(y, walker.p)[0] for y in dense_states(walker, hop)])
    assert heights.max() > 0 and abs(heights[-1]) <= 1e-13
    rates = [contact_rates(y, walker.p)[0] for y in (hop.states[0], hop.end)]
    assert rates[0] == pytest.approx(point.z[5], rel=1e-9)
    assert hop.duration == pytest.approx(2 * rates[0] * hop.duration / (rates[0] - rates[1]), rel=0.05)


# --- gait ----------------------------------------------------------------------------------------------------------


def test_gait_closes_and_is_near_that_of_rolling_feet(gait, table_1_gait):
    _, point = gait
    assert point.residual <= 1e-11
    assert np.abs(point.floquet_multipliers).max() < 1
    assert 1e-4 < abs(point.steps[0].period / table_1_gait[1].steps[0].period - 1) < 1e-2
    assert point.z[5] > 0 and abs(point.z[6]) > 1e-3  # the trailing foot leaves the impact hopping and slipping


def test_report_asks_no_more_friction_than_there_is(gait):
    """The trailing foot keeps to its cone; what is left to ask is the landing foot's, and it is reported."""
    walker, point = gait
    validity = report_gait(walker, point, 1e-12, FRICTION.static_friction).validity
    assert validity.feet_push_only and 0.99 < validity.friction_double_stance_loaded <= 1.1 * (1 + 1e-9)
    assert (validity.time_outside_cone, validity.impulse_outside_cone) == (0.0, 0.0)
    assert 0.1 < validity.impulse_friction_landing < 1.1
    said = on_a_ramp(validity, stable=True).sentence
    assert "friction" not in said and "pull" not in said


def test_recorded_walk_has_one_toe_off_a_step(gait):
    walker, point = gait
    segments = record(walker, section_state(point.z, walker.p), 3, 1e-12)
    walk = sample_walk(walker, segments, 4000.0)
    period, double = point.steps[0].period * walker.time, point.steps[0].double_stance * walker.time
    assert np.abs(walk.heel_strike_time - period * np.arange(1, 4)).max() <= 1e-9
    assert np.abs(walk.toe_off_time - (period * np.arange(3) + double)).max() <= 1e-9
    assert walk.toe_off_leg.tolist() == [1, 0, 1] and walk.heel_strike_leg.tolist() == [1, 0, 1]
    assert (walk.ground_reaction[:, :, 1] >= -1e-9).all()


# --- limits --------------------------------------------------------------------------------------------------------


def test_high_friction_keeps_the_foot_rolling_until_it_carries_nothing(table_1_gait):
    """From the same state after heel strike the foot rolls as in the rolling model until its friction is used up; that
    moment tends to the rolling model's toe-off with first order in 1 / mu.

    The rolling model itself is no limit of friction: it lets a foot go that is still pushed along the ground.
    """
    walker, point = table_1_gait
    start = section_state(point.z, walker.p)
    toe_off = record(walker, start, 1, 1e-12)[0]
    gaps = []
    for mu in (1e2, 1e3, 1e4):
        limited = with_friction(mu)
        first = record(limited, start, 1, 1e-12)[0]
        assert first.phase == DOUBLE_STANCE
        gaps.append(toe_off.duration - first.duration)
        at_end = states_at(DOUBLE_STANCE, toe_off.times, toe_off.states, np.array([first.duration]), walker.p)[0]
        assert np.abs(at_end - first.end).max() <= 1e-11
    assert gaps[-1] > 0 and np.log10(np.array(gaps[:-1]) / gaps[1:]) == pytest.approx([1.0, 1.0], abs=0.05)


@pytest.mark.parametrize("tolerance", [1e-5, 1e-8, 1e-12])
@pytest.mark.parametrize("mu", [30.0, 1e4])
def test_foot_that_friction_can_wedge_is_refused(mu, tolerance, table_1_gait):
    """Beyond the friction the rolling impact needs (24) the foot may rise or jam: no choice is made (Painleve)."""
    with pytest.raises(StepFailed, match="wedge"):
        poincare_map(with_friction(mu), np.append(table_1_gait[1].z, [0.0, 0.0]), tolerance)


def test_wedging_friction_is_named_as_the_reason_for_no_gait():
    with pytest.raises(NoGait, match="wedge"):
        find_gait(TABLE_1, SLOPE, 1e-9, Friction(100.0, 100.0))


@pytest.mark.parametrize(
    ("stiffness", "slope_deg"), [(1000.0, 1.0), pytest.param(2800.0, 0.464, marks=pytest.mark.slow)])
def test_a_slope_too_flat_for_a_gait_is_refused_with_little_work(stiffness, slope_deg, monkeypatch):
    """Counted in evaluations, not on the clock: some ten times those of a search that finds its gait."""
    spent, honest = [], poincare.walk_step

    def counted(*arguments):
        answer = honest(*arguments)
        spent.append(answer[4])
        return answer

    monkeypatch.setattr(poincare, "walk_step", counted)
    with pytest.raises(NoGait, match="in the range searched"):
        find_gait(dataclasses.replace(TABLE_1, stiffness=stiffness), dataclasses.replace(SLOPE, slope_deg=slope_deg),
                  1e-9, FRICTION)
    assert 1e5 < sum(spent) < 1e7


def test_phases_that_creep_one_after_another_end_the_step(monkeypatch):
    """Each within its own limit, but together far beyond it: no step takes a hundred times that."""
    limit, phases = 1000, []

    def creep(phase, *_):
        phases.append(phase)
        return EVENT, 1e-9, 1e-9, 0, 12 * limit

    monkeypatch.setattr(phase_module, "integrate", creep)
    monkeypatch.setattr(phase_module, "first_phase", lambda *_: (HOVERING, True))
    monkeypatch.setattr(phase_module, "succeed", lambda phase, *_: (SLIDING_BACK + HOVERING - phase, True))
    status, phase, *_ = phase_module.walk_step.py_func(
        np.zeros(8), with_friction(1.1).p, 1e-8, 30.0, limit)
    assert status == STEP_LIMIT and len(phases) == 3
    assert "integration steps" in poincare.step_failure(status, phase)


@pytest.mark.parametrize("rate", [-1.0, -2.5e-4, -1e-7])
def test_a_guard_is_located_once_it_is_round_off_however_slowly_it_falls(monkeypatch, rate):
    """One that falls slowly changed its sign back and forth between two times until all 60 corrections were spent."""
    root, lengths = 1.6683571134e-4, []

    def guard(*_):
        return 3.3e-16 * (2 * (rate * (lengths[-1] - root) // 6.6e-16) + 1), rate, True

    monkeypatch.setattr(phase_module, "take_step", lambda phase, y, length, *_: lengths.append(length))
    monkeypatch.setattr(phase_module, "flow", lambda *_: None)
    monkeypatch.setattr(phase_module, "guard", guard)
    ends = ([-rate * root, rate, 1.0, 0.0], [rate * (3.6e-4 - root), rate, 1.0, 0.0])
    located = phase_module.locate.py_func(SLIDING_BACK, np.zeros(8), 3.6e-4, 0, *map(np.array, ends), *5 * [None])
    assert abs(rate * (located - root)) < 1e-15 and len(lengths) < 10


def test_stiff_legs_tend_to_rigid_ones(rigid_gait):
    """With a foot that may slip and rise, compliant gaits tend to the gait of rigid legs, with order 1 / sqrt(k).

    So does the order that is seen to one, and is extrapolated.
    """
    _, rigid = rigid_gait
    z, gaps = np.array([-0.27644, 1.00000665, 0.99998695, 0.474717, -0.20571, 0.0, 0.0]), []
    for stiffness in (1e6, 1e7, 1e8, 1e9):
        design = dataclasses.replace(TABLE_1, stiffness=stiffness, damping=58.35 * np.sqrt(stiffness / 2800.0))
        walker = with_friction(1.1, 1.0, design)
        point = fixed_point(walker, z, 1e-9)
        assert point is not None
        gaps.append(abs(point.steps[0].period / rigid.steps[0].period - 1))
        assert point.steps[0].double_stance == 0  # the trailing foot leaves at once
        z = point.z.copy()
        z[1:3] = 1 + (z[1:3] - 1) / 10
    *_, before, last = 2 * np.log10(np.array(gaps[:-1]) / gaps[1:])
    assert last + (last - before) / (np.sqrt(10) - 1) == pytest.approx(1.0, abs=0.02), gaps


def test_rigid_legs_do_not_ask_for_friction():
    """Their trailing foot leaves without an impulse, which is the law's own answer: the gait is the same."""
    assert build_walker(TABLE_1_RIGID, SLOPE, FRICTION) == build_walker(TABLE_1_RIGID, SLOPE)


def test_stage_walks_with_limited_friction(gait):
    """From the parameters to the result: the same gait, its walk from mid-stance, and its neighbours' multipliers."""
    settings = Settings(tolerance=1e-10, steps=2, sampling_rate_hz=1000.0, transition="coulomb")
    result = run(Parameters(TABLE_1, SLOPE, FRICTION, RUBBER, settings))
    walker, point = gait
    assert result.gait.period_s == pytest.approx(point.steps[0].period * walker.time, rel=1e-8)
    assert result.monodromy_matrix.shape == (7, 7) and abs(result.energy.residual) <= 1e-9
    assert np.abs(result.constraint_drift).max() <= 1e-10
    assert len(result.walk.heel_strike_time) == 3 and len(result.walk.toe_off_time) == 2
    assert all(np.isfinite(each.multiplier_above) for each in result.variations)


def test_readable_path_refuses_limited_friction():
    settings = Settings(tolerance=1e-9, steps=1, sampling_rate_hz=100.0, integrator="scipy", transition="coulomb")
    assert [broken.key for broken in settings.broken_rules()] == ["integrator"]
