"""Heel strike and toe-off: where they fire, what impacts conserve, the derivative; the limit of stiff legs."""

import numpy as np
import pytest

from stages.analytic.gait.poincare import fixed_point, poincare_derivative, poincare_map
from stages.analytic.integration.phase import EVENT, NO_NODES, integrate
from stages.analytic.model import terms as eq
from stages.analytic.phases.guards import guard
from stages.analytic.phases.impact import heel_strike_reset
from stages.analytic.phases.motion import DOUBLE_STANCE, RIGID, SINGLE_STANCE, flow
from stages.analytic.walk.recording import record, states_at
from stages.analytic.walk.validity import dense_states, impulses
from tests.analytic.designs import HEAVY_LEGS, TABLE_1, TABLE_1_RIGID, changed, clearance, random_states, walker_of


def guard_of(phase, y, p):
    rates = np.empty(y.size)
    flow(phase, y, p, rates)
    return guard(phase, y, p, rates, 0)


def landing_states(walker, count):
    """States with the swing foot just on the ground ahead of the stance foot, moving down."""
    states = []
    for y in random_states(walker, 4000, seed=5):
        if not walker.rigid:
            psi = np.cos(y[0]) * (y[1] - walker.p.r) / (y[3] - walker.p.r)
            if abs(psi) > 1 or y[0] < 0.05:
                continue
            y[2] = np.arccos(psi)
        else:
            y[0] = abs(y[0])
            y[1] = y[0]
        if clearance(y, walker.p)[1] < 0:
            states.append(y)
    return np.array(states[:count])


# --- heel strike ---------------------------------------------------------------------------------------------------

@pytest.mark.parametrize("phase, shift, exact", [
    (SINGLE_STANCE, 1e-4, 1e-14),
    (DOUBLE_STANCE, 1e-5, 1e-13)])  # a spring's force: its condition number times round-off is 2e-14
def test_guards_change_sign_at_heel_strike_and_toe_off(table_1_step, table_1_gait, phase, shift, exact):
    """Positive just before, negative just after; at heel strike with the foot ahead, the event state on the ground."""
    walker, _ = table_1_gait
    segment = next(one for one in table_1_step if one.phase == phase)
    value, rate, armed = guard_of(phase, segment.end, walker.p)
    landing = phase == SINGLE_STANCE
    assert abs(value) <= exact and rate < (-0.1 if landing else 0.0) and (armed or not landing)
    for sign in (1, -1):
        y = states_at(phase, segment.times[-1:], segment.states[-1:], np.array([segment.duration - sign * shift]),
                      walker.p)[0]  # fmt: skip
        assert np.sign(guard_of(phase, y, walker.p)[0]) == sign


def naive_guard(phase, y, p):
    """Trap 1: the foot counts as landed when it is at or below ground once the swing leg has passed upright."""
    height, _, _ = clearance(y, p)
    return height <= 0 and y[1 if phase == RIGID else 2] > 0


@pytest.mark.parametrize("legs", ["compliant", "rigid"])
def test_scuffing_is_no_heel_strike(legs, table_1_step, table_1_gait, rigid_gait):
    """After mid-swing the foot is still below ground for a while: a naive guard fires there at once.

    The clearance must first have become positive and must fall through zero; a start inside the scuff reaches the
    same heel strike as the whole step does.
    """
    if legs == "compliant":
        walker, segment = table_1_gait[0], table_1_step[-1]
    else:
        walker = rigid_gait[0]
        segment = record(walker, rigid_gait[1].steps[0].state, 1, 1e-12, RIGID)[-1]
    phase = segment.phase
    inside = [y for y in dense_states(walker, segment)[:-1] if naive_guard(phase, y, walker.p)
              and clearance(y, walker.p)[0] < 0]
    assert inside, "the gait must scuff for this test to mean anything"
    for start in inside:
        y = start.copy()
        assert naive_guard(phase, y, walker.p)
        status, duration, *_ = integrate(phase, y, walker.p, 1e-12, 30.0, 100_000, 0.02, NO_NODES)
        assert status == EVENT and duration > 0.5
        assert np.abs(y - segment.end).max() <= 1e-9
        assert clearance(y, walker.p)[1] < 0


def test_foot_that_falls_behind_the_stance_foot_is_no_heel_strike(table_1_step, table_1_gait):
    """The swing foot goes down through the ground behind the stance foot, once a step, and the walk goes on."""
    walker, _ = table_1_gait
    states = dense_states(walker, table_1_step[-1])
    heights = np.array([clearance(y, walker.p)[0] for y in states])
    crossings = states[:-1][(heights[:-1] > 1e-12) & (heights[1:] <= 1e-12)]
    assert len(crossings) == 2
    assert [clearance(y, walker.p)[2] > 0 for y in crossings] == [False, True]


@pytest.mark.parametrize("largest_step", [0.02, 0.3, 1.0])
def test_heel_strike_does_not_depend_on_the_first_step_size(largest_step, table_1_gait, table_1_step):
    walker, _ = table_1_gait
    single = table_1_step[-1]
    y = single.states[0].copy()
    status, duration, *_ = integrate(
        SINGLE_STANCE, y, walker.p, 1e-12, 30.0, 100_000, largest_step, NO_NODES)
    assert status == EVENT
    assert duration == pytest.approx(single.duration, rel=1e-11)


# --- impact --------------------------------------------------------------------------------------------------------

def velocities(walker, q, qd):
    """Velocities of hip, stance mass and swing mass, and both leg rates about z, with their positions."""
    theta, stance, psi, swing = (q[0], 1.0, q[1], 1.0) if walker.rigid else q
    dtheta, dstance, dpsi, dswing = (qd[0], 0.0, qd[1], 0.0) if walker.rigid else qd
    radius, com = walker.p.r, walker.p.l
    up, across = np.array([np.sin(theta), np.cos(theta)]), np.array([np.cos(theta), -np.sin(theta)])
    down, along = np.array([np.sin(psi), -np.cos(psi)]), np.array([np.cos(psi), np.sin(psi)])
    centre, rolling = np.array([radius * theta, radius]), np.array([radius * dtheta, 0.0])
    hip = centre + (stance - radius) * up
    dhip = rolling + dstance * up + (stance - radius) * dtheta * across
    places = [hip, centre + (com - radius) * up, hip + (swing - com) * down]
    speeds = [dhip, rolling + (com - radius) * dtheta * across, dhip + dswing * down + (swing - com) * dpsi * along]
    landing = hip + (swing - radius) * down - np.array([0.0, radius])
    return places, speeds, (-dtheta, dpsi), landing


def cross(a, b):
    """z component of the product of two plane vectors."""
    return a[0] * b[1] - a[1] * b[0]


def angular_momentum(walker, places, speeds, rates, point):
    """About z through `point`, of the masses and the legs' own inertia."""
    masses = (walker.p.M, walker.p.m, walker.p.m)
    orbital = sum(
        mass * cross(a - point, v)
        for mass, a, v in zip(masses, places, speeds, strict=True))
    return orbital + walker.p.I * sum(rates)


@pytest.mark.parametrize("design", [
    TABLE_1_RIGID, changed(TABLE_1_RIGID, leg_inertia=2e-3), changed(TABLE_1_RIGID, foot_radius=0.0, hip_mass=0.0),
], ids=["Table 1", "leg inertia", "point feet, no hip mass"])
def test_rigid_impact_keeps_angular_momentum_about_the_landing_contact(design):
    """Of the whole walker about the new contact, and of the old stance leg about the hip (it feels no impulse)."""
    walker = walker_of(design)
    for y in landing_states(walker, 40):
        places, speeds, rates, landing = velocities(walker, y[:2], y[2:])
        before = angular_momentum(walker, places, speeds, rates, landing)
        trailing = walker.p.m * cross(places[1] - places[0], speeds[1]) + walker.p.I * rates[0]
        after = y.copy()
        heel_strike_reset(after, walker.p)
        places2, speeds2, rates2, _ = velocities(walker, after[:2], after[2:])
        contact = np.array([walker.p.r * after[0], 0.0])
        assert angular_momentum(walker, places2, speeds2, rates2, contact) == pytest.approx(before, abs=1e-13)
        leg = walker.p.m * cross(places2[2] - places2[0], speeds2[2]) + walker.p.I * rates2[1]
        assert leg == pytest.approx(trailing, abs=1e-13)


def test_compliant_impact_keeps_momentum_in_every_direction_the_constraints_leave_free():
    """M (qd+ - qd-) has no component along motions that keep both feet rolling, and both feet do roll after."""
    walker = walker_of(HEAVY_LEGS)
    for y in landing_states(walker, 40):
        landed = y.copy()
        heel_strike_reset(landed, walker.p)
        after = landed[[6, 7, 4, 5]] * [-1, 1, -1, 1]  # in the names before it
        t = eq.compliant_terms(*y[:4], 0.0, 0.0, 0.0, 0.0, walker.p)
        mass = np.zeros((4, 4))
        mass[np.triu_indices(4)] = t[:10]
        mass += np.triu(mass, 1).T
        pi = np.array(eq.contact_terms(*y[:4], 0.0, 0.0, 0.0, 0.0, walker.p)[:8]).reshape(2, 4)
        free = np.linalg.svd(pi)[2][2:]
        jump = np.asarray(after) - y[4:]
        assert np.abs(free @ mass @ jump).max() <= 1e-13
        assert np.abs(pi @ after).max() <= 1e-13


@pytest.mark.parametrize("design", [HEAVY_LEGS, changed(TABLE_1_RIGID, leg_inertia=2e-3)], ids=["compliant", "rigid"])
def test_impulses_of_the_feet_are_the_change_of_momentum(design):
    walker = walker_of(design)
    half, masses = walker.size // 2, np.array([walker.p.M, walker.p.m, walker.p.m])
    for y in landing_states(walker, 20):
        after = y.copy()
        heel_strike_reset(after, walker.p)
        before = masses @ np.array(velocities(walker, y[:half], y[half:])[1])
        later = masses[[0, 2, 1]] @ np.array(velocities(walker, after[:half], after[half:])[1])[[0, 2, 1]]
        landing, trailing = impulses(walker, y)
        assert np.abs(landing + trailing - (later - before)).max() <= 1e-13


@pytest.mark.parametrize("angle", [-0.196, -0.19559929, -0.19519993])
def test_rigid_legs_that_pass_each_other_land_no_foot(angle):
    """Clearance falls through zero with both feet in one place: no tolerance may take that for a heel strike."""
    walker = walker_of(TABLE_1_RIGID)
    z = np.array([angle, 0.3543684, -0.33596808])
    periods = [take(walker, z, tolerance).period for tolerance in (1e-5, 1e-6, 1e-8, 1e-10, 1e-12)
               for take in (poincare_map, lambda *given: poincare_derivative(*given)[0])]  # fmt: skip
    assert max(periods) - min(periods) < 1e-5 and min(periods) > 2.0


# --- Compliant legs as their stiffness grows. Their limit is a walker with rigid legs, but not the one whose trailing
# foot leaves the ground without an impulse: in the compliant model both feet keep rolling through the impact (model.md,
# trap 4), and only then do the legs stop their axial motion. That limit is composed here from the two impacts, and the
# compliant gaits tend to it with first order in 1 / sqrt(stiffness) when the damping ratio is kept.


def limit_reset(y):
    """Both feet rolling through the landing, legs free along themselves; then the new stance foot alone rolls and
    the legs become rigid: axial velocities vanish, angular momenta of both legs' motions are kept."""
    full = np.array([y[0], 1.0, y[1], 1.0, y[2], 0.0, y[3], 0.0])
    p = walker_of(TABLE_1).p  # stiffness and damping do not enter an impact
    heel_strike_reset(full, p)
    t = eq.compliant_terms(*full[:4], 0.0, 0.0, 0.0, 0.0, p)
    mass = np.zeros((4, 4))
    mass[np.triu_indices(4)] = t[:10]
    mass += np.triu(mass, 1).T
    angles = [0, 2]
    rates = np.linalg.solve(mass[np.ix_(angles, angles)], (mass @ full[4:])[angles])
    return np.array([full[0], full[2], *rates])


def limit_step(walker, z):
    y = np.array([z[0], -abs(z[0]), z[1], z[2]])
    status, period, *_ = integrate(RIGID, y, walker.p, 1e-12, 30.0, 10_000, 0.02, NO_NODES)
    assert status == EVENT
    after = limit_reset(y)
    return after[[0, 2, 3]], period


@pytest.fixture(scope="module")
def limit():
    """Stance angle, and period, of the limit's gait: a stable gait, reached by walking."""
    walker = walker_of(TABLE_1_RIGID)
    z = np.array([-0.277, 0.42, -0.31])
    for _ in range(120):
        z, period = limit_step(walker, z)
    assert np.abs(limit_step(walker, z)[0] - z).max() <= 1e-11
    return z[0], period


def stiffened(count):
    """Gaits from 1e5 N/m on, stiffness times ten each, damping ratio kept."""
    z = np.array([-0.2769, 1.000066, 0.99987, 0.47385, -0.2048])
    gaits = []
    for stiffness in 1e5 * 10.0 ** np.arange(count):
        damping = 58.35 * np.sqrt(stiffness / 2800.0)
        walker = walker_of(changed(TABLE_1, stiffness=stiffness, damping=damping))
        z[1:3] = 1 + np.array([walker.p.m, -(walker.p.M + walker.p.m) / 2]) / walker.p.k
        point = fixed_point(walker, z, 1e-9)
        assert point is not None
        gaits.append(point)
        z = point.z.copy()
    return gaits


def test_compliant_gait_tends_to_the_rigid_limit_with_its_order(limit):
    angle, period = limit
    gaits = stiffened(4)
    errors = np.array([abs(point.steps[0].period - period) for point in gaits])
    orders = np.log10(errors[1:-1] / errors[2:]) * 2  # in powers of 1 / sqrt(k)
    assert errors[-1] <= 1e-4
    assert orders[-1] == pytest.approx(1.0, abs=0.35), (errors, orders)
    assert abs(gaits[-1].z[0] - angle) <= 1e-5


def test_the_limit_is_not_the_gait_without_impulse_on_the_trailing_foot(limit, rigid_gait):
    """Stated so that nobody takes the one rigid model for the limit of the compliant one: 0.4% in period."""
    _, free = rigid_gait
    assert 2e-3 < abs(limit[1] / free.steps[0].period - 1) < 1e-2


def test_stiff_dampers_have_the_same_limit(limit):
    walker = walker_of(changed(TABLE_1, damping=1e5))
    point = fixed_point(walker, np.array([-0.2772, 0.99843, 0.99836, 0.475, -0.2054]), 1e-9)
    assert point is not None
    # the legs stand a little shorter than natural: compare in their own lengths
    assert point.z[0] == pytest.approx(limit[0], abs=2e-4)
