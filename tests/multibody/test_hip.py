"""What a detailed design has at the hip, in both assemblies, against motions that can be written down."""

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
from tests.analytic.test_driven_stance import ROBOT
from tests.analytic.test_driven_stance import START as STANCE

ASSEMBLIES = pytest.mark.parametrize("assembly", ["tree", "joints"])
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
