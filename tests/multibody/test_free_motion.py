"""Both assemblies away from the ground, against textbook solutions."""

import dataclasses

import numpy as np
import pytest

from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.walk.driven_stance import driven_stance
from stages.biped.design import BeyondModel
from stages.biped.walk import StanceState
from stages.ground.contact_law import family_member
from stages.ground.slope import Slope
from stages.multibody.parameters import Settings
from stages.multibody.walking.walk import simulate
from stages.planar.energy import damper_power, kinetic_energy, mass_moment, spring_energy
from stages.planar.run import PlanarState, hip_creep, rolling_state
from tests.analytic.test_driven_stance import ROBOT, START as STANCE

ASSEMBLIES = pytest.mark.parametrize("assembly", ["tree", "joints"])
LEGS = pytest.mark.parametrize("legs", ["compliant", "rigid"])
TUMBLING = PlanarState((0.0, 1.0), (0.3, 0.5), (0.2, -0.3), (3.0, -2.0), (0.333, 0.333), (0.0, 0.0), (False, False))


#: Legs that differ in everything, frames on both, all off the line, and a spring between them.
UNEQUAL = {
    "foot_offset": 0.006, "frame_mass": 0.15, "frame_com": 0.02, "frame_offset": -0.008, "frame_inertia": 2e-4,
    "hip_stiffness": 0.4, "hip_rest_angle": 0.2, "other_foot_mass": 0.3, "other_leg_length": 0.325,
    "other_foot_radius": 0.07, "other_foot_com": 0.09, "other_stiffness": 2500.0, "other_leg_inertia": 1e-3,
    "other_foot_offset": -0.004, "other_frame_mass": 0.1, "other_frame_com": -0.01, "other_frame_offset": 0.005,
    "other_frame_inertia": 1e-4,
}  # fmt: skip
DETAILS = pytest.mark.parametrize("details", [{}, UNEQUAL, {**UNEQUAL, "hip_mass": 0.0}],
                                  ids=["plain", "unequal", "no hip mass"])  # fmt: skip


def flown(scene, assembly, legs, details, **changes):
    """A design in the air, and its flight from `TUMBLING`."""
    if details and legs == "rigid" and assembly == "joints":
        pytest.skip("this assembly has no frames on rigid legs")
    return fly(scene, assembly=assembly, legs=legs, **{"leg_inertia": 2e-3, **details, **changes})


def fly(scene, state=TUMBLING, duration=0.1, rolling_step=1e-4, **changes):
    high = scene.but(rolling_step=rolling_step, **changes)
    run = high.walk(dataclasses.replace(state, hip_position=(0.0, 5.0)), duration=duration)
    assert run.completed
    return high.biped, run.trajectory


@ASSEMBLIES
@LEGS
@DETAILS
def test_mass_centre_falls_on_a_parabola(scene, assembly, legs, details):
    design, flight = flown(scene, assembly, legs, details, rolling_step=2e-4)
    centre = mass_moment(design, flight.position) / design.total_mass
    gravity, t = np.array(scene.slope.gravity_vector), flight.time[:, None]
    thrown = moving_masses(design, flight.position, flight.velocity)
    start_velocity = sum(mass * velocity[0] for mass, _, velocity in thrown) / design.total_mass
    parabola = centre[0] + start_velocity * t + 0.5 * gravity * t**2
    assert np.abs(centre - parabola).max() < 1e-6


@ASSEMBLIES
@LEGS
@DETAILS
def test_undamped_flight_keeps_its_energy_and_spin(scene, assembly, legs, details):
    duration, step = (0.05, 3.5e-5) if details else (0.1, 1e-4)
    design, flight = flown(
        scene, assembly, legs, details, damping=0.0, other_damping=None, duration=duration, rolling_step=step)
    moving = kinetic_energy(design, flight.position, flight.velocity)
    energy = moving + spring_energy(design, flight.position)
    energy -= mass_moment(design, flight.position) @ np.array(scene.slope.gravity_vector)
    assert np.abs(energy - energy[0]).max() < 1e-5 * moving[0]
    spin = spin_about_mass_centre(design, flight.position, flight.velocity)
    assert np.abs(spin - spin[0]).max() < 1e-6 * abs(spin[0])


@ASSEMBLIES
@LEGS
def test_the_watch_is_told_the_rate_of_each_leg(scene, assembly, legs):
    flying = scene.but(legs=legs, assembly=assembly)
    high = dataclasses.replace(TUMBLING, hip_position=(0.0, 5.0), leg_length_rate=(0.4, -0.7))
    machine = flying.build()
    last = flying.walk(high, duration=0.01, assembly=machine).trajectory.velocity[-1]
    assert last[2] > 1.5 and last[3] < -1.0 and np.abs(last[[0, 1, 4, 5]]).max() < 1.0
    assert [machine.leg_rate(leg) for leg in (0, 1)] == pytest.approx(last[2:4], rel=1e-9)


@ASSEMBLIES
def test_legs_ring_like_two_masses_on_a_damped_spring(scene, assembly):
    stretched = dataclasses.replace(
        TUMBLING, hip_velocity=(0.0, 0.0), leg_angle=(0.0, 0.0), leg_rate=(0.0, 0.0), leg_length=(0.343, 0.343)
    )
    biped, flight = fly(scene, stretched, assembly=assembly, slope_deg=0.0)
    compliance = 1.0 / biped.hip_mass + 0.5 / biped.foot_mass  # one hip against two feet
    decay, t = biped.damping * compliance, flight.time
    ringing = np.sqrt(2 * biped.stiffness * compliance - decay**2 + 0j)
    expected = (0.01 * np.exp(-decay * t) * (np.cos(ringing * t) + decay / ringing * np.sin(ringing * t))).real
    assert np.abs(flight.position[:, 4] - 0.333 - expected).max() < (1e-8 if assembly == "tree" else 2e-5)


def moving_masses(biped, position, velocity):
    """Mass, position and velocity of hip, feet and frames."""
    masses = [(biped.hip_mass, position[:, :2], velocity[:, :2])]
    for number in (0, 1):
        leg = biped.leg(number)
        angle, rate = position[:, 2 + number, None], velocity[:, 2 + number, None]
        along, across = np.hstack([np.sin(angle), -np.cos(angle)]), np.hstack([np.cos(angle), np.sin(angle)])
        sliding = position[:, 4 + number, None] - leg.foot_com, velocity[:, 4 + number, None]
        bodies = (leg.foot_mass, *sliding, leg.foot_offset), (leg.frame_mass, leg.frame_com, 0.0, leg.frame_offset)
        for mass, arm, arm_rate, aside in bodies:
            place, motion = arm * along + aside * across, arm_rate * along + rate * (arm * across - aside * along)
            masses.append((mass, position[:, :2] + place, velocity[:, :2] + motion))
    return masses


def spin_about_mass_centre(biped, position, velocity):
    masses = moving_masses(biped, position, velocity)
    centre = sum(mass * place for mass, place, _ in masses) / biped.total_mass
    drift = sum(mass * motion for mass, _, motion in masses) / biped.total_mass
    legs = biped.leg(0), biped.leg(1)
    spin = sum((leg.leg_inertia + leg.frame_inertia) * velocity[:, 2 + number] for number, leg in enumerate(legs))
    for mass, place, motion in masses:
        lever, speed = place - centre, motion - drift
        spin = spin + mass * (lever[:, 0] * speed[:, 1] - lever[:, 1] * speed[:, 0])
    return spin


# --- What a detailed design has at the hip, in both assemblies, against motions that can be written down.


#: Legs like scissors: the hip stays between them, as they fall.
SCISSORS = PlanarState((0.0, 5.0), (0.0, 0.0), (0.01, -0.01), (0.0, 0.0), (0.333, 0.333), (0.0, 0.0), (False, False))


@pytest.fixture
def scissors(scene):
    """Fall with two rigid legs that turn against each other; other numbers are those of the hip."""

    def falling(assembly, state=SCISSORS, duration=0.2, **hip):
        level = scene.but(legs="rigid", leg_inertia=2e-3, slope_deg=0.0, assembly=assembly, rolling_step=1e-4, **hip)
        run = level.walk(state, duration=duration)
        assert run.completed
        return level.biped, run.trajectory

    return falling


def inertia_about_hip(design):
    return design.leg_inertia + design.foot_mass * (design.leg_length - design.foot_com) ** 2


@ASSEMBLIES
def test_legs_on_a_hip_spring_ring_about_its_rest_angle(scissors, assembly):
    design, flight = scissors(assembly, duration=0.3, hip_stiffness=2.0, hip_damping=0.01, hip_rest_angle=0.012)
    inertia, t = inertia_about_hip(design), flight.time
    decay = design.hip_damping / inertia
    ringing = np.sqrt(2 * design.hip_stiffness / inertia - decay**2)
    shape = np.exp(-decay * t) * (np.cos(ringing * t) + decay / ringing * np.sin(ringing * t))
    assert ringing * t[-1] > np.pi
    apart = flight.position[:, 2] - flight.position[:, 3]
    assert np.abs(apart - (0.012 + 0.008 * shape)).max() < 2e-6


@ASSEMBLIES
def test_friction_brings_the_legs_to_rest_and_holds_them(scissors, assembly):
    torque, rate = 0.006, 0.03
    turning = dataclasses.replace(SCISSORS, leg_angle=(0.0, 0.0), leg_rate=(rate, -rate))
    design, flight = scissors(assembly, turning, hip_friction=torque)
    stops = rate * inertia_about_hip(design) / torque
    assert stops < 0.7 * flight.time[-1]
    apart = flight.velocity[:, 2] - flight.velocity[:, 3]
    creep = hip_creep(design, Slope(0.0, 9.81))
    assert np.abs(apart - 2 * rate * np.maximum(0.0, 1 - flight.time / stops)).max() < 2 * creep
    assert np.abs(apart - 2 * rate * (1 - flight.time / stops))[flight.time < 0.9 * stops].max() < 1e-4 * rate


@ASSEMBLIES
@pytest.mark.parametrize("weighed", [-0.2, 0.1, 0.5])
def test_a_counterweight_is_weight_without_mass(scissors, assembly, weighed):
    design, flight = scissors(assembly, hip_gravity_mass=weighed)
    centre = mass_moment(design, flight.position)[:, 1] / design.total_mass
    pull = 9.81 * (design.total_mass - design.hip_mass + weighed) / design.total_mass
    assert np.abs(centre - centre[0] + 0.5 * pull * flight.time**2).max() < 2e-6


@ASSEMBLIES
def test_energy_goes_where_the_hip_takes_it(scissors, assembly):
    turning = dataclasses.replace(SCISSORS, leg_rate=(2.0, -1.0))
    design, flight = scissors(assembly, turning, hip_friction=0.02, hip_damping=0.01, hip_stiffness=0.5)
    energy = kinetic_energy(design, flight.position, flight.velocity) + spring_energy(design, flight.position)
    energy -= mass_moment(design, flight.position) @ np.array([0.0, -9.81])
    power = damper_power(design, flight.velocity)
    lost = np.concatenate([[0.0], np.cumsum(0.5 * np.diff(flight.time) * (power[1:] + power[:-1]))])
    assert lost[-1] > 0.005
    assert np.abs(energy - energy[0] + lost).max() < 1e-3 * lost[-1]


@pytest.mark.parametrize(("friction", "samples", "shares"), [
    pytest.param(0.03, 61, (0.3, 0.03), marks=pytest.mark.slow), (0.12, 41, (0.6, 0.1))])
def test_standing_legs_slip_and_stick_as_in_the_constraint_model(contact, friction, samples, shares):
    """Point feet on level ground, a counterweight, friction at the hip. With harder ground the two come together.

    What the hip creeps while it should be at rest is left.
    """
    design, level = dataclasses.replace(ROBOT, hip_friction=friction), Slope(0.0, 9.81)
    times = 0.005 * np.arange(samples)
    found = driven_stance(DesignPoint(design, level), STANCE[:4], 0.005, np.zeros(samples)).states
    at_rest = np.abs(found[:, 2] + found[:, 3]) < 1e-9
    assert at_rest.any() and not at_rest.all()
    apart = []
    for share in shares:
        ground = family_member(contact, share)
        state = StanceState(STANCE[0], 0.28, STANCE[1], 0.28, STANCE[2], 0.0, STANCE[3], 0.0)
        start = rolling_state(design, ground, state, 9.81 * design.weighed_mass)
        run = simulate(design, level, ground, start, Settings.of_one_step(1e-6, 1e-3), duration=times[-1])
        place = run.trajectory.at(times)[0]
        apart.append(np.abs(place[:, 2:4] * [-1.0, 1.0] - found[:, :2]).max(axis=0))
    creep = hip_creep(design, level)
    crept = creep * 0.005 * at_rest.sum()
    assert np.all(apart[1] < 1.1 * shares[1] / shares[0] * apart[0] + crept) and apart[1].max() < 3e-4
    rates = run.trajectory.at(times[at_rest])[1]
    assert np.abs(rates[:, 2] - rates[:, 3]).max() < creep


def test_nothing_is_assembled_for_what_is_not_there(scene):
    def objects(**design):
        return scene.but(**design).build().mbs.systemData.NumberOfObjects()

    plain = objects()
    assert objects(frame_mass=0.1, other_leg_length=0.32) == plain
    assert objects(hip_stiffness=1.0, hip_damping=0.1) == objects(hip_friction=0.1) == plain + 1


def test_frames_on_rigid_legs_are_refused_by_the_joints_alone(scene):
    rigid = scene.but(legs="rigid", frame_mass=0.1)
    rigid.build()
    with pytest.raises(BeyondModel, match=r"multibody\.assembly = tree has"):
        rigid.but(assembly="joints").build()
