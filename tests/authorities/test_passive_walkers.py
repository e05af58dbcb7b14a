"""Published passive walkers: the simplest, hip mass and round feet, the compass gait, wheels, legs that differ.

The simplest: Garcia, Chatterjee, Ruina, Coleman, J. Biomech. Eng. 120 (1998) 281; the twelve digits are those of
M. J. Coleman and P. Bhounsule for hip mass 1000, foot mass 1 at the end of each leg, leg 1, gravity 1, slope 0.009.
With feet of no mass: simplestwalker.m of 25 August 2013, P. A. Bhounsule (repository pab47/pab47.github.io, read
there); he closes its gaits to some 1e-10. A stance angle of .200310900544287, which is remembered, could not be looked
up; this walker has it.
"""

import dataclasses
import math
from functools import cache

import numpy as np
import pytest
from scipy.optimize import brentq

from stages.analytic.gait.continuation import PERIOD_DOUBLING, continue_gait
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.gait_search import by_stability, find_gait, find_gaits
from stages.analytic.gait.poincare import poincare_map
from stages.analytic.integration.phase import EVENT, NO_NODES, integrate
from stages.analytic.model import terms as eq
from stages.analytic.model.walker import Walker, build_walker
from stages.analytic.phases.motion import RIGID, flow
from stages.analytic.walk.driven_stance import driven_stance
from stages.biped.design import Biped
from stages.ground.slope import Slope

#: stance angle, stance rate, swing angle relative to the stance leg, its rate: just after heel strike, Garcia's signs.
PUBLISHED_STEP = (0.200161072169750, -0.199906060087682, 0.400322144339512, -0.015805473227965)
OF_THE_SIMPLEST = 0.009
#: Feet of no mass, long step and short step: stance angle, stance rate, period.
WITHOUT_MASS = ((0.200310900563820, -0.199832473025474, 3.882), (0.193937369810188, -0.203866927442012, 3.096))
#: Multipliers of the long step as a program found in public quotes them, beside the same gait.
QUOTED = complex(-0.19120868949940, 0.55633363687106)


def simplest_walker(hip_mass: float = 1000.0) -> Biped:
    return Biped(legs="rigid", hip_mass=hip_mass, foot_mass=1.0, leg_length=1.0, foot_radius=0.0, foot_com=0.0,
                 stiffness=1.0, damping=0.0, leg_inertia=0.0)


def test_fixed_point_to_ten_digits():
    """Garcia's theta falls through the step and his phi is the stance angle minus the swing leg's own."""
    walker, point = find_gait(simplest_walker(), Slope(slope_deg=math.degrees(OF_THE_SIMPLEST), gravity=1.0), 1e-13)
    state = walker.stance_state(point.steps[0].state)
    found = (-state.stance_angle, -state.stance_rate,
             -state.stance_angle - state.swing_angle, -state.stance_rate - state.swing_rate)
    for value, published in zip(found, PUBLISHED_STEP, strict=True):
        assert value == pytest.approx(published, abs=1e-12), (found, PUBLISHED_STEP)
    assert np.abs(point.floquet_multipliers).max() < 1


def test_step_angle_follows_the_cube_root_of_the_slope():
    """Garcia 1998, long-period gait to leading order: stance angle 0.970956 slope^(1/3), period 3.812."""
    angles = []
    for slope in (1e-4, 1e-5):
        _, point = find_gait(simplest_walker(1e7), Slope(slope_deg=math.degrees(slope), gravity=1.0), 1e-12)
        angles.append(-point.z[0] / slope ** (1 / 3))
        period = point.steps[0].period
    assert abs(angles[1] - 0.970956) < abs(angles[0] - 0.970956) < 0.01
    assert period == pytest.approx(3.812, rel=3e-3)


@cache
def limit_of_light_feet():
    """(stance angle, stance rate, period) and multipliers of both gaits, extrapolated to feet of no mass.

    The gait depends on the mass ratio e smoothly; three ratios a factor 10 apart leave an error of order e^3.
    """
    found = []
    for hip_mass in (1e4, 1e5, 1e6):
        walker = build_walker(simplest_walker(hip_mass), Slope(slope_deg=math.degrees(OF_THE_SIMPLEST), gravity=1.0))
        gaits = find_gaits(walker, 1e-14, unstable=True)[:2]
        found.append([np.array([-gait.z[0], gait.z[1] / walker.time, gait.steps[0].period * walker.time,
                                *gait.floquet_multipliers[:2]]) for gait in gaits])  # fmt: skip
    limits = []
    for coarse, middle, fine in zip(*found, strict=True):
        once, twice = (10 * middle - coarse) / 9, (10 * fine - middle) / 9
        limit = (100 * twice - once) / 99
        limits.append((limit[:3].real, limit[3:]))
    return limits


@pytest.mark.parametrize("number", [0, 1], ids=["long step", "short step"])
def test_light_feet_tend_to_the_published_gaits(number):
    found, _ = limit_of_light_feet()[number]
    angle, rate, period = WITHOUT_MASS[number]
    assert found[:2] == pytest.approx([angle, -rate], abs=3e-10)
    assert found[2] == pytest.approx(period, abs=5e-4)


def test_the_remembered_thirteen_digits():
    """Not looked up, see above: what a limit in the mass of the feet gives."""
    found, _ = limit_of_light_feet()[0]
    assert found[:2] == pytest.approx([0.200310900544287, 0.199832473004977], abs=1e-12)


def by_differences(walker, gait, h):
    """Leading multiplier by central differences of the map over 2 h."""
    columns = [(poincare_map(walker, gait.z + e, 1e-14).z - poincare_map(walker, gait.z - e, 1e-14).z) / (2 * h)
               for e in h * np.eye(3)]  # fmt: skip
    multipliers = np.linalg.eigvals(np.column_stack(columns))
    return multipliers[np.argmax(multipliers.imag)]


def test_multipliers_of_light_feet():
    """Two digits of the quoted multipliers are right, no more; the short step's are quoted as 4.000 and 0.459.

    Central differences of the map tend to the exact derivative with the square of their step; they are as far off as
    the quoted numbers, 1.7e-3, at a step of some 4e-4.
    """
    _, multipliers = limit_of_light_feet()[0]
    found = complex(multipliers[np.argmax(multipliers.imag)])
    assert found == pytest.approx(complex(-0.190099841, 0.557598777), abs=2e-8)
    assert abs(found - QUOTED) == pytest.approx(1.7e-3, rel=0.05)
    walker = build_walker(simplest_walker(1e6), Slope(slope_deg=math.degrees(OF_THE_SIMPLEST), gravity=1.0))
    gait = find_gaits(walker, 1e-14, unstable=False)[0]
    exact = gait.floquet_multipliers[0]
    errors = [abs(by_differences(walker, gait, h) - exact) for h in (4e-4, 1e-5, 1e-6)]
    assert errors[2] < 5e-8 and errors[1] / errors[2] == pytest.approx(100, rel=0.2)
    assert 1e-3 < errors[0] < 3e-3
    _, short = limit_of_light_feet()[1]
    assert short.real == pytest.approx([4.0039, 0.45959], abs=1e-4)
    assert short.real == pytest.approx([4.000, 0.459], abs=5e-3)


# --- Hip mass and round feet, the compass gait, wheels as limits, legs that differ.


SLOPE = Slope(slope_deg=math.degrees(0.01), gravity=1.0)
#: Point feet; the program counts q2 with the other sign.
POINT_FEET = (0.162597833780052, -0.231869638058967, 0.325195667560120, -0.037978468073739)
#: "passivewalker", 26 December 2009, round feet of radius 0.2.
ROUND_FEET = (0.189472782205104, -0.239124222551699, 0.378945564410209, -0.053691703909393)


def walker_with_feet(radius: float) -> Biped:
    return Biped(legs="rigid", hip_mass=1.0, foot_mass=0.5, leg_length=1.0 + radius, foot_radius=radius,
                 foot_com=0.5 + radius, stiffness=1.0, damping=0.0, leg_inertia=0.02)


def published_coordinates(walker: Walker, y: np.ndarray) -> np.ndarray:
    """(q1, u1, q2, u2) of a rigid state in the published units."""
    theta, psi, dtheta, dpsi = y * walker.scales()
    return np.array([-theta, -dtheta, -theta - psi, -dtheta - dpsi])


def test_point_feet_to_twelve_digits():
    walker, point = find_gait(walker_with_feet(0.0), SLOPE, 1e-13)
    assert published_coordinates(walker, point.steps[0].state) == pytest.approx(POINT_FEET, abs=1e-12)
    assert by_stability(point) < 1


def published_step(walker: Walker, z: np.ndarray) -> np.ndarray:
    """One step with the impact as the published program has it.

    Its balance of the trailing leg about the hip has a term -I u2 too much: the leg is the old stance leg, whose
    spin is I u1 alone. Adding that term here is the whole difference.
    """
    y = np.array([z[0], -abs(z[0]), z[1], z[2]])
    status, *_ = integrate(RIGID, y, walker.p, 1e-13, 30.0, 10_000, 0.02, NO_NODES)
    assert status == EVENT
    stray = walker.p.I * (y[2] + y[3])
    momentum = np.array(eq.rigid_handover(y[0], y[1], walker.p)).reshape(2, 2) @ y[2:] + stray
    m11, m12, m22, *_ = eq.rigid_terms(-y[1], -y[0], 0.0, 0.0, walker.p)
    return np.array([-y[1], *np.linalg.solve([[m11, m12], [m12, m22]], momentum)])


def test_round_feet_to_twelve_digits_with_the_published_impact():
    """The published root is that of an impact with a stray term; with it, all digits agree."""
    walker = build_walker(walker_with_feet(0.2), SLOPE)
    z = np.array([-0.19, 0.24, 0.05 - 0.24]) * [1, math.sqrt(1.2), math.sqrt(1.2)]
    for _ in range(200):
        z = published_step(walker, z)
    found = published_coordinates(walker, np.array([z[0], -abs(z[0]), z[1], z[2]]))
    assert found == pytest.approx(ROUND_FEET, abs=1e-11)


def test_round_feet_without_the_stray_term():
    """The impact that keeps the trailing leg's angular momentum has a gait nearby, not the same."""
    walker, point = find_gait(walker_with_feet(0.2), SLOPE, 1e-13)
    found = published_coordinates(walker, point.steps[0].state)
    assert np.abs(found - ROUND_FEET).max() == pytest.approx(2.3e-3, rel=0.05)
    assert abs(found[0] - ROUND_FEET[0]) < 1e-4 and by_stability(point) < 1


# --- The compass gait: hip 10 kg, legs of 5 kg at half their length, point feet (mu = 2, beta = 1).


DOUBLES_AT = 4.39090


def compass(scale: float = 1.0, slope_deg: float = 3.0) -> DesignPoint:
    """The compass gait with masses and lengths times `scale`."""
    biped = Biped("rigid", 10.0 * scale, 5.0 * scale, scale, 0.0, 0.5 * scale, 1.0, 0.0, 0.0)
    return DesignPoint(biped, Slope(slope_deg=slope_deg, gravity=9.81 / scale))


@pytest.mark.parametrize("scale", [1.0, 0.3])
def test_the_first_doubling(scale):
    design = compass(scale)
    _, point = find_gait(design.biped, design.slope, 1e-12)
    branch = continue_gait(design, "ground.slope_deg", (2.9, 4.6), point.z, 1e-12)
    doublings = [point.value for kind, point in branch.special if kind == PERIOD_DOUBLING]
    assert doublings == pytest.approx([DOUBLES_AT], abs=1e-5)


@pytest.mark.parametrize(("slope_deg", "alternates"), [(DOUBLES_AT - 0.05, False), (DOUBLES_AT + 0.05, True)])
def test_a_walk_alternates_beyond_it(slope_deg, alternates):
    design = compass(slope_deg=slope_deg)
    walker, point = find_gait(design.biped, design.slope, 1e-10)
    z = point.z * 1.001
    for _ in range(600):
        before, z = z, poincare_map(walker, z, 1e-10).z
    assert (np.abs(z - before).max() > 1e-3) == alternates


# --- Wheels as limits of walkers: the rimless wheel of the simplest walker, McGeer's synthetic wheel of round feet.


def rate_after_impact(half_angle: float, slope: float, kept: float, rate: float = 1.0) -> float:
    """Steady rate of a rimless wheel just after an impact that keeps the share `kept` of it.

    Over a step u-^2 = u+^2 + 4 rate^2 sin(half_angle) sin(slope), and u+ = kept u-.
    """
    gained = 4 * rate**2 * math.sin(half_angle) * math.sin(slope)
    return kept * math.sqrt(gained / (1 - kept**2))


def test_the_formula_has_the_published_digits():
    found = rate_after_impact(math.pi / 6, 0.2, 2 / 3, math.sqrt(2 / 3))
    assert found == pytest.approx(0.460341126609455, abs=1e-14)


@pytest.mark.parametrize("number", [0, 1], ids=["long step", "short step"])
def test_the_hip_of_the_simplest_walker_is_a_rimless_wheel(number):
    """Massless legs: a wheel whose spokes have the angle of the gait, and whose impact keeps cos(2 angle)."""
    angle, rate = limit_of_light_feet()[number][0][:2]
    assert rate == pytest.approx(rate_after_impact(angle, OF_THE_SIMPLEST, math.cos(2 * angle)), abs=2e-10)


def synthetic_wheel_period() -> float:
    """Period of McGeer's synthetic wheel in swing times 1 / omega: feet as large as the leg, a heavy hip, level ground.

    The hip rolls at constant speed, so the swing leg is a free pendulum. It starts at -alpha with the rate -Omega of
    the leg it was, and ends at alpha with the rate -Omega of the leg it becomes, Omega T = 2 alpha:
    A sin(x) = alpha, A omega cos(x) = -Omega with x = omega T / 2, that is tan(x) = -x.
    """
    return 2 * float(brentq(lambda x: math.sin(x) + x * math.cos(x), 1.6, 3.1, xtol=1e-14))


def test_round_feet_tend_to_mcgeers_synthetic_wheel():
    """Small steps on feet of .999 leg lengths: their period tends to the wheel's with the square of the angle."""
    radius, height = 0.999, 0.5
    angles, periods = [], []
    for share in (0.01, 0.02):
        biped = Biped("rigid", 1e7, 1.0, 1.0, radius, 1.0 - height, 1.0, 0.0, 0.0)
        slope = Slope(slope_deg=math.degrees(share * (1 - radius) ** 2), gravity=1.0)
        gaits = find_gaits(build_walker(biped, slope), 1e-12, unstable=False)
        wheel = min(gaits, key=lambda point: abs(point.steps[0].period - synthetic_wheel_period() * math.sqrt(height)))
        assert by_stability(wheel) < 1
        angles.append(-wheel.z[0])
        periods.append(wheel.steps[0].period / math.sqrt(height))
    slope_of_period, at_zero = np.polyfit(np.square(angles), periods, 1)
    assert slope_of_period > 0
    assert at_zero == pytest.approx(synthetic_wheel_period(), rel=5e-4)


# --- Walkers with legs that differ, masses off the legs' lines and a hip with torque and friction, against
# published ones.


#: P. A. Bhounsule, "passivewalker", 26 December 2009: M = 1, m = 0.5, I = 0.02, hip to foot centre 1, feet of radius
#: 0.2, mass centre 0.5 below the hip and w forward, slope 0.01, hip torque Th, at (q1, u1, q2, u2) below.
WITH_ROUND_FEET = Biped(
    "rigid", hip_mass=1.0, foot_mass=0.5, leg_length=1.2, foot_radius=0.2, foot_com=0.7, stiffness=1.0, damping=0.0,
    leg_inertia=0.02)  # fmt: skip
STATE = 0.19, -0.24, 0.35, -0.06
#: Accelerations of q1 and q2 by w and Th.
PUBLISHED = {
    (0.0, 0.0): (0.20986158624403897, -0.4591141028673396),
    (0.03, 0.0): (0.1890925799693329, -0.3484780261203298),
    (0.03, 0.02): (0.19990259518150155, -0.4967125147303366),
}

#: A. M. Boudali and J. Z. Tang, model of the asymmetric Sydney Compass-Gait Robot with hip friction (2017): inner leg
#: of 0.7 kg, 0.0448 m below the hip, outer of 0.6 kg, 0.0702 m, inertia 0.003 kg m^2 each, hip 2 kg, for gravity
#: -0.409 kg, at hip angle 0.31, stance angle 0.12, rates -1.1 and 0.9, signal 40. Legs with the inertias exchanged in
#: that program are alike here. Accelerations of hip and stance angle with the outer, then with the inner leg standing.
OUTER_FIRST = Biped(
    "rigid", hip_mass=2.0, foot_mass=0.6, leg_length=0.2778, foot_radius=0.0, foot_com=0.2778 - 0.0702, stiffness=1.0,
    damping=0.0, leg_inertia=0.003, hip_gravity_mass=-0.409, hip_damping=0.00156, hip_friction=0.00611,
    other_foot_mass=0.7, other_foot_com=0.2778 - 0.0448)  # fmt: skip
TORQUE = -0.0182 * 40.0
ROBOT = {"outer": (-180.15485013580025, 4.483212785837682), "inner": (-137.59785139198559, 4.690658049699934)}


@pytest.mark.parametrize(("offset", "torque"), PUBLISHED)
def test_offset_masses_and_a_torque_between_the_legs(offset, torque):
    """The torque comes from a spring here, which has it at this angle between the legs."""
    spring = torque / STATE[2]
    biped = dataclasses.replace(WITH_ROUND_FEET, foot_offset=offset, hip_stiffness=spring)
    walker = build_walker(biped, Slope(slope_deg=math.degrees(0.01), gravity=1.0), detailed=True)
    q1, u1, q2, u2 = STATE
    rates = np.empty(4)
    flow(RIGID, np.array([-q1, q1 - q2, -u1, u1 - u2]) / walker.scales(), walker.p, rates)
    theta, psi = (rates * walker.scales() / walker.time)[2:]
    assert (-theta, -theta - psi) == pytest.approx(PUBLISHED[offset, torque], rel=1e-14)


@pytest.mark.parametrize("stance", ROBOT)
def test_legs_that_differ_a_counterweight_and_friction(stance):
    """Acceleration over a microsecond from the start, extrapolated."""
    biped = OUTER_FIRST if stance == "outer" else OUTER_FIRST.exchanged
    design, short = DesignPoint(biped, Slope(slope_deg=0.0, gravity=9.81)), 1e-5
    rates = driven_stance(design, np.array([0.12, 0.19, 0.9, -2.0]), short, np.full(3, TORQUE)).states[:, 2:]
    theta, psi = (-1.5 * rates[0] + 2.0 * rates[1] - 0.5 * rates[2]) / short
    assert (theta + psi, theta) == pytest.approx(ROBOT[stance], rel=1e-7)
