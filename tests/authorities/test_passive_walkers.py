"""Published passive walkers: hip mass and round feet, the compass gait, wheels as limits, legs that differ."""

import dataclasses
import math

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
from tests.authorities.test_simplest_walker import SLOPE as OF_THE_SIMPLEST, limit_of_light_feet

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
