"""The readable SciPy path against the compiled one, and the extremes of a gait's forces and clearance beside it."""

import dataclasses
from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import minimize_scalar

from stages.analytic.errors import StepFailed
from stages.analytic.gait.gait_report import record_steps
from stages.analytic.gait.gait_search import find_gait, step_length
from stages.analytic.gait.poincare import fixed_point, poincare_map
from stages.analytic.integration import readable
from stages.analytic.integration.readable import accelerations, clearance, derivative, refine, take_step
from stages.analytic.parameters import Parameters, Settings
from stages.analytic.phases.section import section_state
from stages.analytic.phases.succession import in_contact
from stages.analytic.run import run
from stages.analytic.walk.error_estimate import along, carried_error, estimate_errors, gait_error
from stages.analytic.walk.recording import crossing_state, in_single_stance, record, states_at, walk_on
from stages.analytic.walk.sampling import walk_from_mid_stance
from stages.analytic.walk.validity import assess
from stages.biped.accuracy.estimate import walk_differences
from stages.biped.design import Biped
from stages.ground.slope import Friction, Slope
from tests.analytic.designs import (
    FRICTION,
    RUBBER,
    SLOPE,
    TABLE_1,
    found_gait,
    gait_beside,
    stiff_gait,
)
from tests.analytic.test_detailed import LAME


@pytest.mark.parametrize("legs", ["rigid", "compliant"])
@pytest.mark.parametrize("design", [TABLE_1, LAME])
def test_both_paths_take_the_same_steps(design, legs):
    """Of legs that differ each stands once: with frames, a hip with spring and damper, a counterweight."""
    walker, point = found_gait(dataclasses.replace(design, legs=legs))
    z = point.z * 1.001
    for standing in (walker, walker.exchanged)[: len(point.steps)]:
        compiled, other = poincare_map(standing, z, 1e-12), take_step(standing, z, 1e-12)
        assert np.abs(other.z - compiled.z).max() <= 1e-9
        assert other.period == pytest.approx(compiled.period, rel=1e-9)
        assert other.double_stance == pytest.approx(compiled.double_stance, abs=1e-10)
        z = compiled.z


@pytest.fixture(scope="module")
def refined(table_1_gait):
    """The gait of Table 1 on the readable path, from beside it; Newton's steps have the derivative at the gait."""
    walker, point = table_1_gait
    once = cache(lambda: derivative(walker, point.z, 1e-9))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(readable, "derivative", lambda *_: once())
        return refine(walker, point.z + 1e-6, 1e-9, iterations=2)


def test_gait_and_derivative_on_the_readable_path_without_variational_equations(table_1_gait, refined):
    assert np.abs(refined.monodromy_matrix - table_1_gait[1].monodromy_matrix).max() <= 1e-4
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


# --- Extremes of a gait's forces and clearance, beside an integration by SciPy of the readable equations.


def arm(length, angle):
    """Acceleration of the end of an arm (length and angle with both derivatives) along (sin, cos) of its angle."""
    (long, rate, change), (turned, spin, turning) = length, angle
    along, across = change - long * spin**2, 2 * rate * spin + long * turning
    sine, cosine = np.sin(turned), np.cos(turned)
    return np.array([along * sine + across * cosine, along * cosine - across * sine])


def forces(walker, y, both):
    """Tangential and normal force on the leading and on the trailing foot, by Newton's law for three masses."""
    p, half = walker.p, y.size // 2
    change, second = accelerations(walker, y, both)
    q, v, a = y[:half], y[half:], change
    if walker.rigid:
        q, v, a = ([one[0], fixed, one[1], fixed] for one, fixed in ((q, p.L_nat), (v, 0.0), (a, 0.0)))
    (theta, first, psi, other) = zip(q, v, a, strict=True)
    rolling = np.array([p.r * theta[2], 0.0])
    hip = rolling + arm((first[0] - p.r, *first[1:]), theta)
    stance = rolling + arm((p.l - p.r, 0.0, 0.0), theta)
    swing = hip - arm((other[0] - p.l, *other[1:]), tuple(-one for one in psi))
    weight = np.array([p.g_x, p.g_y])
    total = p.M * (hip - weight) + p.m * (stance - weight) + p.m * (swing - weight)
    trailing = np.array([second[1], second[0]])
    return np.concatenate([total - trailing, trailing])


def largest(solution, end, quantity):
    times = np.linspace(0.0, end, 2001)
    values = np.array([quantity(solution(time)) for time in times])
    top = int(np.argmax(values))
    bounds = times[max(top - 1, 0)], times[min(top + 1, 2000)]
    found = minimize_scalar(lambda time: -quantity(solution(time)), bounds=bounds, method="bounded",
                            options={"xatol": 1e-12})
    return max(values[top], -found.fun)


def own(walker, segments):
    """The extremes, in the terms of `Validity`."""
    found = {}
    for segment in segments:
        both, start = in_contact(segment.phase), segment.states[0]
        if not (both or in_single_stance(segment)):
            continue

        def rates(_, y, both=both):
            return np.concatenate([y[y.size // 2 :], accelerations(walker, y, both)[0]])

        solution = solve_ivp(rates, (0.0, segment.duration), start, method="DOP853", rtol=1e-13, atol=1e-13,
                             dense_output=True, max_step=0.01).sol
        quantities = {"stance": lambda y, both=both: -forces(walker, y, both)[1]}
        if both:
            quantities["trailing"] = lambda y: -forces(walker, y, True)[3]
        else:
            quantities["friction"] = lambda y: abs(np.divide(*forces(walker, y, False)[:2]))
            quantities["scuff"] = lambda y: -clearance(walker, y)
        for name, quantity in quantities.items():
            value = largest(solution, segment.duration, quantity)
            found[name] = max(found.get(name, -np.inf), value)
    return found


#: Length [m], gravity [m/s^2], stiffness in that of Table 1 relative to weight and length, and the legs.
WALKERS = {
    "Table 1": (0.333, 9.81, 1.0, "compliant"), "soft": (0.333, 9.81, 0.6, "compliant"),
    "stiff": (0.333, 9.81, 3.0, "compliant"), "large": (1.2, 9.81, 0.8, "compliant"),
    "small, on the Moon": (0.15, 1.62, 1.5, "compliant"), "rigid": (0.333, 9.81, 1.0, "rigid"),
}  # fmt: skip


def design(length, gravity, stiffness, legs):
    grown, heavier = length / 0.333, gravity / 9.81
    stiff, damped = 2800.0 * stiffness * heavier / grown, 58.35 * np.sqrt(stiffness * heavier / grown)
    sizes = (grown * size for size in (0.333, 0.083, 0.1))
    return Biped(legs, 0.316, 0.335, *sizes, stiff, damped, 0.0), Slope(2.0, gravity)


@pytest.mark.slow
@pytest.mark.parametrize("name", WALKERS)
def test_extremes_are_those_of_another_integration(name):
    """Forces by Newton's law, events of the same duration; to 1e-10 of the weight, of one and of the leg's length."""
    walker, point = find_gait(*design(*WALKERS[name]), 1e-12)
    segments = record_steps(walker, point, 1e-12)
    report, known = assess(walker, segments, 1.1), own(walker, segments)
    assert report.least_normal_force_stance / walker.force == pytest.approx(-known["stance"], abs=1e-10)
    assert report.friction_single_stance == pytest.approx(known["friction"], abs=1e-10)
    assert report.deepest_scuff / walker.length == pytest.approx(max(known["scuff"], 0.0), abs=1e-10)
    if not walker.rigid:
        assert report.least_normal_force_trailing / walker.force == pytest.approx(-known["trailing"], abs=1e-10)


# --- Error estimates of gait and walk against the same computed at a far smaller tolerance.


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
    *((dataclasses.replace(design, hip_friction=2e-3), legs, None)
      for design in (FRAMES, LAME) for legs in ("rigid", "compliant")),
])  # fmt: skip
@pytest.mark.parametrize("tolerance", [1e-6, 1e-8])
def test_the_estimate_is_the_error(design, legs, friction, tolerance):
    """Of gaits of one step, of the strides of legs that differ, and of hips that rub, turn and come to rest."""
    own = dataclasses.replace(design, legs=legs)
    walker, point, *_ = as_exact_as_can_be(own, friction)
    assert len(point.steps) == (1 if own.other_foot_mass is None else 2)
    assert own.hip_friction == 0.0 or walker.p.tau_h > 0.0
    is_the_error(own, friction, tolerance)


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
    assert gait_error(walker, found, 1e-7).period is None
