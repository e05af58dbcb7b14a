"""Gaits with Coulomb friction at the hip, of rigid and of compliant legs: events, sticking, energy, derivatives."""

import numpy as np
import pytest

from stages.analytic.derivatives.gait import step_tangents
from stages.analytic.derivatives.numbers import moved
from stages.analytic.gait.gait_report import report_gait
from stages.analytic.gait.gait_search import find_gait
from stages.analytic.gait.poincare import fixed_point, poincare_derivative
from stages.analytic.integration.phase import EVENT, NO_NODES, integrate
from stages.analytic.model.kinds import DetailedCompliant, DetailedRigid, directions
from stages.analytic.model.walker import build_walker
from stages.analytic.phases.motion import HIP_STICKS, ON_BOTH, RUBS_BACK, RUBS_FORWARD, flow, holding_torque, motion
from stages.analytic.phases.section import section_state, section_tangent
from stages.analytic.phases.succession import ends_step, first_phase, hip_phase, hip_succession, succeed
from stages.analytic.run import without_impact
from stages.analytic.walk.recording import crossing_state, record, walk_on
from stages.analytic.walk.sampling import sample_walk
from stages.biped.design import BeyondModel
from tests.analytic.designs import FRICTION, SLOPE, TABLE_1, TABLE_1_RIGID, changed, found_gait
from tests.analytic.differences import extrapolated, map_slope, shares, step_slope

FREE = {"rigid": changed(TABLE_1_RIGID, frame_mass=0.01, frame_com=0.02),
        "compliant": changed(TABLE_1, frame_mass=0.01, frame_com=0.02)}  # fmt: skip
KINDS = {"rigid": DetailedRigid, "compliant": DetailedCompliant}
#: Of differences: lengths change by less than the springs' deflection.
SIZES = {"rigid": (4e-6, 4e-6, 4e-6), "compliant": (4e-6, 4e-7, 4e-7, 4e-6, 4e-6)}
#: One change of each of the numbers that the hip's events feel in ways of their own; of compliant legs toe-off, heel
#: strike and impact as well.
OF_HIP = ("tau_h", "k_h", "l", "m_2", "phi_h", "g_x", "b_h", "l_f_2")
NUMBERS = ("tau_h", "k", "b_2", "l", "m_2", "phi_h", "g_x", "b_h", "l_f_2", "r_2", "L_nat")
#: Steps through turning and sticking: friction, where they begin (of compliant legs angle and rate alone), and phases.
STEPS = [
    ("rigid", 3e-3, (-0.28, 0.3, 0.0), (RUBS_FORWARD, RUBS_BACK)),
    ("rigid", 3e-3, (-0.28, 0.45, -0.5), (RUBS_BACK, RUBS_FORWARD)),
    ("rigid", 0.075, (-0.25, 0.2, 0.3), (RUBS_FORWARD, RUBS_BACK, RUBS_FORWARD, HIP_STICKS)),
    ("rigid", 0.2, (-0.28, 0.3, 0.4), (RUBS_FORWARD, HIP_STICKS)),
    ("compliant", 0.003, (-0.24, 0.35), (RUBS_BACK + ON_BOTH, RUBS_FORWARD + ON_BOTH, RUBS_FORWARD)),
    ("compliant", 0.01, (-0.30, 0.42), (RUBS_BACK + ON_BOTH, RUBS_BACK, RUBS_FORWARD, RUBS_BACK)),
]
MANY_TURNS = ("rigid", 0.03, (-0.12, 0.3, -0.8), (RUBS_BACK, RUBS_FORWARD, RUBS_BACK, RUBS_FORWARD))


def rubbing(legs, friction, **values):
    return build_walker(changed(FREE[legs], hip_friction=friction, **values), SLOPE)


def gait_of(walker, legs, tolerance=1e-12):
    """The gait beside that of a free hip."""
    return fixed_point(walker, found_gait(FREE[legs])[1].z, tolerance)


def begun(legs, start):
    """Section coordinates of the start of a step."""
    if legs == "rigid":
        return np.array(start)
    z = found_gait(FREE[legs])[1].z.copy()
    z[[0, 3]] = start
    return z


@pytest.mark.parametrize(("legs", "alike"), [("rigid", 2e-3), ("compliant", 5e-3)])
def test_without_friction_nothing_rubs(legs, alike):
    """The gait goes to that of a free hip in proportion to the friction."""
    period = found_gait(FREE[legs])[1].period
    first, second = (gait_of(rubbing(legs, friction), legs).period - period for friction in (1e-5, 2e-5))
    assert abs(first) > 1e-8 and second == pytest.approx(2 * first, rel=alike)


@pytest.mark.parametrize(("legs", "friction", "start", "phases"), [*STEPS, MANY_TURNS])
def test_the_map_is_exact_through_turning_and_sticking(legs, friction, start, phases):
    walker, z = rubbing(legs, friction), begun(legs, start)
    segments = record(walker, section_state(z, walker.p), 1, 1e-12)
    assert tuple(segment.phase for segment in segments) == phases
    _, derivative = poincare_derivative(walker, z, 1e-13)
    allowed = (1e-6 if walker.rigid else 5e-6) * max(1.0, np.abs(derivative).max())
    assert np.abs(derivative - map_slope(walker, z, SIZES[legs])).max() < allowed
    if phases[-1] == HIP_STICKS:
        assert np.abs(segments[-1].states[:, 2] + segments[-1].states[:, 3]).max() < 1e-12
        assert np.linalg.svd(derivative)[1][-1] < 1e-9  # legs that land as one body forget how they came to


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_hip_that_sticks_lets_go_where_friction_is_used_up(side):
    """Either way, from legs that are together and swing as one."""
    walker, y = rubbing("rigid", 0.05), side * np.array([-0.05, 0.05, 0.5, -0.5])
    assert first_phase(y, walker.p) == (HIP_STICKS, True)
    to_event(walker.p, HIP_STICKS, y, 1e-12)
    assert abs(y[2] + y[3]) < 1e-12
    needed = holding_torque(HIP_STICKS, y, walker.p)
    assert abs(needed) == pytest.approx(walker.p.tau_h, rel=1e-9)
    assert succeed(HIP_STICKS, y, walker.p) == (RUBS_BACK if needed > 0 else RUBS_FORWARD, True)


def to_event(p, phase, y, tolerance=1e-13, numbers=None):
    status, duration, *_ = integrate(phase, y, p, tolerance, 30.0, 100_000, 0.02, NO_NODES, numbers)
    assert status == EVENT
    return duration


def together(walker, both):
    """A state whose legs do not move against each other, of legs that are equally long and both on the ground at an
    angle, length and rate; or else of the first that stands alone."""
    if both is None:
        return np.array([-0.05, 1.0, 0.3, 1.0, 0.5, 0.0, -0.5, 0.0])
    angle, length, rate_of_stance = both

    def rate(speed):
        y = section_state(np.array([angle, length, length, rate_of_stance, speed]), walker.p)
        return y[4] + y[6], y

    low, high = rate(0.0)[0], rate(1.0)[0]
    return rate(-low / (high - low))[1]


#: Hips that stick, in single stance to the landing or until they let go, in double stance to toe-off or the same:
#: friction, where both feet stand, and what follows.
STUCK = [(0.5, None, None), (0.04, None, (RUBS_FORWARD, RUBS_BACK)), (10.0, (-0.1, 1.0, 0.1), (HIP_STICKS,)),
         (12.6, (-0.2, 0.99, 0.1), (RUBS_FORWARD + ON_BOTH,))]  # fmt: skip


@pytest.mark.parametrize(("friction", "both", "follows"), STUCK)
def test_a_hip_that_sticks_goes_on_to_what_comes_first(friction, both, follows):
    """It moves as one body to that event, and variations are those of differences."""
    walker = rubbing("compliant", friction)
    start = together(walker, both)
    phase = hip_phase(bool(both), start, walker.p)
    assert phase == HIP_STICKS + (ON_BOTH if both else 0)
    y = np.concatenate([start, np.eye(8).ravel()])
    assert to_event(walker.p, phase, y) > 1e-3 and abs(y[4] + y[6]) < 1e-11
    landed = ends_step(phase, y, walker.p)
    assert landed == (follows is None)
    if not landed:
        assert hip_succession(phase, y, walker.p) in follows
    for column, unit in enumerate(np.eye(8)):

        def there(h):
            y = start + h * unit  # noqa: B023
            to_event(walker.p, phase, y)
            return y

        wanted, found = extrapolated(there, 4e-6), y[8 * column + 8 : 8 * column + 16]
        assert found == pytest.approx(wanted, rel=0, abs=2e-6 * max(1.0, np.abs(wanted).max())), column


@pytest.mark.parametrize("both", [True, False])
def test_the_holding_torque_holds(both):
    """Rates of a hip that sticks keep the angle between the legs; constraints stay; power of friction is negative."""
    walker = rubbing("compliant", 0.3)
    y = section_state(found_gait(FREE["compliant"])[1].z, walker.p)
    y[6] = -y[4]
    rates = np.empty(8)
    flow(HIP_STICKS + (ON_BOTH if both else 0), y, walker.p, rates)
    assert abs(rates[4] + rates[6]) < 1e-12
    rubs = RUBS_FORWARD + (ON_BOTH if both else 0)
    qdd, _, system = motion(rubs, y, walker.p._replace(tau_h=0.0))
    held = holding_torque(rubs, y, walker.p)
    assert rates[4:] == pytest.approx(np.array(qdd) + held * np.array(system.by_torque), abs=1e-12)


@pytest.mark.parametrize(("legs", "angles", "alike"), [("rigid", [0, 1], 0.05), ("compliant", [0, 2], 0.1)])
def test_energy_audit_closes_with_friction(legs, angles, alike):
    walker = rubbing(legs, 3e-3)
    report = report_gait(walker, gait_of(walker, legs), 1e-12, 1.1)
    assert abs(report.energy.residual) < 1e-8
    turned = sum(abs(segment.end[angles].sum() - segment.states[0, angles].sum()) for segment in report.segments)
    assert walker.p.tau_h * turned * walker.energy > 1e-2 * report.energy.gravity_work  # the audit counts it
    assert report.energy.damper_loss > 1e-4
    plain = report_gait(*found_gait(FREE[legs]), 1e-12, 1.1).validity
    assert report.validity.least_normal_force_stance == pytest.approx(plain.least_normal_force_stance, rel=alike)


@pytest.mark.parametrize("legs", FREE)
def test_a_walk_is_sampled_through_its_events(legs):
    walker = rubbing(legs, 3e-3)
    point = gait_of(walker, legs)
    walk = sample_walk(walker, walk_on(walker, crossing_state(walker, point.z, 1e-12), 3, 1e-12), 500.0)
    periods = np.diff(walk.heel_strike_time)
    assert periods == pytest.approx(point.period * walker.time, abs=1e-9) and len(periods) == 3
    assert walker.rigid or len(walk.toe_off_time) == len(periods)


def test_the_search_finds_a_gait_by_itself():
    walker, point = find_gait(changed(FREE["compliant"], hip_friction=2e-3), SLOPE, 1e-10)
    assert isinstance(walker.p, DetailedCompliant) and point.residual < 1e-9
    found = without_impact(walker, record(walker, section_state(point.z, walker.p), 1, 1e-10))
    assert found.slip_at_end == pytest.approx(found.slip_at_landing, rel=1e-9)  # the contact holds it, rubbing or not


def test_what_is_not_known_is_said():
    with pytest.raises(BeyondModel, match="together with a trailing foot that may slip"):
        build_walker(changed(FREE["compliant"], hip_friction=1e-3), SLOPE, FRICTION)


# --- derivatives by the numbers of the design -----------------------------------------------------------------------


@pytest.mark.parametrize(("legs", "friction", "start", "phases"), STEPS)
def test_a_step_s_derivatives_by_numbers_are_exact_through_turning_and_sticking(legs, friction, start, phases):
    """Against extrapolated differences: coordinates after the step, and its period."""
    walker, z = rubbing(legs, friction, hip_stiffness=1e-3), begun(legs, start)
    names, size, allowed = (OF_HIP, 1e-5, 1e-6) if walker.rigid else (NUMBERS, 4e-6, 2e-6)
    assert tuple(segment.phase for segment in record(walker, section_state(z, walker.p), 1, 1e-12)) == phases
    along = shares(walker, names)
    exact = step_tangents(walker, z, along, 1e-13)
    by_state = poincare_derivative(walker, z, 1e-13)[1]
    assert np.abs(exact.by_start - by_state).max() < 1e-9 * max(1.0, np.abs(by_state).max())
    for row, name in enumerate(names):
        found = np.append(exact.along[:, row], exact.time_along[row])
        wanted = step_slope(walker, z, along[row], size)
        assert found == pytest.approx(wanted, rel=0, abs=allowed * max(1.0, np.abs(found).max())), name


@pytest.mark.parametrize(("friction", "both", "phases"), [
    (friction, both, 2 if follows and follows[0] != HIP_STICKS else 1) for friction, both, follows in STUCK])
def test_derivatives_by_numbers_are_exact_where_the_hip_sticks(friction, both, phases):
    """In single stance to the landing, or until it lets go and on; in double stance to toe-off, or the same."""
    walker = rubbing("compliant", friction)
    start, along = together(walker, both), shares(walker, NUMBERS)

    def walked(p, y, numbers=None):
        """The state at the last event, and how long all took."""
        phase, duration = HIP_STICKS + (ON_BOTH if both else 0), 0.0
        for each in range(phases):
            phase = phase if each == 0 else succeed(phase, y, p, numbers)[0]
            duration += to_event(p, phase, y, numbers=numbers)
        assert phases == 1 or phase not in (HIP_STICKS, HIP_STICKS + ON_BOTH)
        return y, duration

    def begun(p):
        y = start.copy()
        if both:  # both feet stay on the ground where the numbers change
            y = section_state(np.array([start[0], start[1], start[3], start[4], start[5]]), p)
        return y

    numbers = directions(along, len(along))
    own = np.zeros(8 * len(along))
    if both:
        own = section_tangent(start[[0, 1, 3, 4, 5]], start, walker.p, numbers)[40:]
    y, _ = walked(walker.p, np.concatenate([start, own]), numbers)
    for row, name in enumerate(NUMBERS):

        def there(share):
            beside = moved(walker, share * along[row]).p  # noqa: B023
            return np.append(*walked(beside, begun(beside)))

        found = np.append(y[8 * row + 8 : 8 * row + 16], numbers.delays[row])
        wanted = extrapolated(there, 1e-5)
        assert found == pytest.approx(wanted, rel=0, abs=3e-6 * max(1.0, np.abs(found).max())), name
