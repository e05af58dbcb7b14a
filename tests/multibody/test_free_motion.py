"""Both assemblies away from the ground, against textbook solutions."""

import dataclasses

import numpy as np
import pytest

from stages.planar.energy import kinetic_energy, mass_moment, spring_energy
from stages.planar.run import PlanarState

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
