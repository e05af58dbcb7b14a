"""The twin seen from the side: its sums are those of the bill and of what Exudyn assembles, and z drops out."""

import dataclasses

import numpy as np
import pytest

from stages.biped.design import Biped
from stages.multibody.assembly.inventory import take_inventory
from stages.twin.machine.contact import HINGE, PITCH, SLIDE, X, Y
from stages.twin.machine.machine import Build, build, pieces
from stages.twin.machine.projection import machine_of, project, with_numbers_of
from stages.twin.machine.tree import SpatialTree
from stages.twin.walking.measures import mechanical_energy
from stages.twin.walking.record import pair_axes, point_motion

IN_PLANE = [X, Y, PITCH, HINGE, *SLIDE]


@pytest.fixture(scope="module")
def projected(machine):
    return project(machine)


def planar_bodies(biped):
    """Of each body mass, place from the hip forward and up its leg, and inertia, by its group among the parts."""
    found = {}
    for number, name in enumerate(("inner", "outer")):
        leg = biped.leg(number)
        found[f"{name}_frame"] = leg.frame_mass, leg.frame_offset, -leg.frame_com, leg.frame_inertia
        found[f"{name}_foot"] = leg.foot_mass, leg.foot_offset, leg.foot_com - leg.leg_length, leg.leg_inertia
    return found


def moments(mass, forward, upward, inertia):
    """Mass, mass times place and inertia about the hip: what adds up."""
    return np.array([mass, mass * forward, mass * upward, inertia + mass * (forward**2 + upward**2)])


def test_sums_are_those_of_the_rows_of_the_bill(projected, parameters):
    for group, body in planar_bodies(projected).items():
        rows = [piece for part in parameters.settings.parts if part.group == group for piece in pieces(part)]
        wanted = sum(moments(row.mass, *row.centre[:2], row.inertia[2, 2]) for row in rows)
        assert len(rows) > 1
        assert moments(*body) == pytest.approx(wanted, rel=1e-12, abs=1e-15)


def test_sums_are_those_of_exudyns_bodies(projected, machine, parameters):
    tree = SpatialTree(machine, parameters.slope, parameters.contact)
    links = tree.mbs.GetObject(tree.tree)
    total, mass = np.zeros(4), links["linkMasses"]
    for link in range(len(mass)):  # Exudyn's lists of matrices never end when they are iterated over
        total += moments(mass[link], *links["linkCOMs"][link][:2], links["linkInertiasCOM"][link][2, 2])
    found = sum(moments(*body) for body in planar_bodies(projected).values())
    assert found == pytest.approx(total, rel=1e-12, abs=1e-15)
    assert projected.total_mass == pytest.approx(machine.mass, rel=1e-14)
    assert projected.hip_mass == 0.0
    springs, dampers = links["jointPControlVector"], links["jointDControlVector"]
    for number, legs in enumerate((SLIDE[:2], SLIDE[2:])):
        leg = projected.leg(number)
        assert leg.stiffness == pytest.approx(sum(springs[slide] for slide in legs), rel=1e-14)
        assert leg.damping == pytest.approx(sum(dampers[slide] for slide in legs), rel=1e-14)


def test_what_lies_along_the_hip_axis_drops_out(machine, projected):
    wider = dataclasses.replace(
        machine,
        lane=2.0 * machine.lane,
        half_width=0.0,
        bodies=tuple(
            dataclasses.replace(body, centre=body.centre * [1.0, 1.0, 3.0], inertia=body.inertia * np.diag([0, 0, 1]))
            for body in machine.bodies
        ),
    )
    assert project(wider) == projected


@pytest.mark.parametrize("legs", ["compliant", "rigid"])
def test_point_masses_project_to_the_simple_model(parameters, legs):
    biped = dataclasses.replace(parameters.biped, leg_inertia=2e-3, legs=legs)
    points = project(build(biped, dataclasses.replace(parameters.settings, inertia="planar")))
    assert dataclasses.replace(points, foot_com=biped.foot_com) == biped
    assert points.foot_com == pytest.approx(biped.foot_com, rel=1e-14)


def test_an_outsole_and_friction_belong_to_the_projection(parameters, projected):
    settings = dataclasses.replace(parameters.settings, outsole=0.002, bearing_friction=1e-3, slider_friction=0.5)
    soled = project(build(parameters.biped, settings))
    rubber = 2.0 * settings.mass(parameters.biped.foot_radius, 0.002)
    for number in (0, 1):
        more, less = (dataclasses.asdict(each.leg(number)) for each in (soled, projected))
        found = [more[key] - less[key] for key in ("foot_mass", "leg_length", "foot_radius", "damping")]
        assert found == pytest.approx([rubber, 0.002, 0.002, 1.0], rel=1e-10)
    assert soled.hip_damping == 1e-3


def test_legs_of_a_pair_that_differ_are_taken_on_average(parameters, projected):
    departure = Build(body_mass=(1.0, 1.1, 0.9, 1.0, 1.0, 1.0), stiffness=(1.2, 0.8, 1.0, 1.0),
                      leg_length=(1e-3, 0.0, 0.0, 0.0))  # fmt: skip
    built = project(build(parameters.biped, parameters.settings, departure))
    found, drawn = planar_bodies(built), planar_bodies(projected)
    assert moments(*found["inner_foot"]) == pytest.approx(moments(*drawn["inner_foot"]))
    assert built.stiffness == pytest.approx(projected.stiffness)
    assert built.leg_length - projected.leg_length == pytest.approx(0.5e-3)
    assert built.leg(1) == projected.leg(1)


#: What may act between the frames, and at the hip.
HIP = {"hip_damping": 2e-3, "hip_stiffness": 0.02, "hip_rest_angle": 0.05, "hip_friction": 1e-3}


def test_what_details_add_departs_by_nothing(parameters):
    """In mass and first moments, length and spring of each pair a built machine has as much more as its drawing."""
    detailed = dataclasses.replace(
        parameters.biped, frame_mass=0.05, frame_com=0.03, frame_offset=2e-3, hip_gravity_mass=0.29, **HIP)
    departure = Build(body_mass=(1.01, 0.98, 1.03, 0.99, 1.02, 0.97), stiffness=(1.02, 0.99, 1.01, 0.97),
                      damping=(0.98, 1.01, 1.02, 0.99), leg_length=(1e-4, 2e-4, -1e-4, 3e-4), outsole=2e-3)  # fmt: skip
    found = []
    for how in (Build(), departure):
        more, less = (project(machine_of(design, parameters.settings, how)) for design in (detailed, parameters.biped))
        assert {key: getattr(more, key) for key in HIP} == pytest.approx(HIP)
        assert more.weighed_hip - more.hip_mass == pytest.approx(0.29 - parameters.biped.hip_mass)
        found.append([
            np.subtract(*([leg.foot_mass, leg.leg_length, leg.foot_com, leg.stiffness, leg.damping, leg.frame_mass,
                           leg.frame_mass * leg.frame_com, leg.frame_mass * leg.frame_offset]
                          for leg in (more.leg(number), less.leg(number)))) for number in (0, 1)])  # fmt: skip
    assert np.allclose(*found, rtol=1e-9, atol=1e-12) and np.ptp(found[0], axis=0) == pytest.approx(0.0, abs=1e-12)
    assert found[0][0][5:] == pytest.approx([0.05, 0.05 * 0.03, 0.05 * 2e-3])


def test_a_machine_takes_the_numbers_of_a_planar_biped(machine, projected):
    """Frames, feet, springs and hip of either pair: what it is then projected on is the biped that was asked for."""
    wanted = dataclasses.replace(
        projected, foot_mass=0.36, leg_length=0.34, foot_radius=0.09, foot_com=0.104, stiffness=2500.0, damping=50.0,
        leg_inertia=1.1e-3, frame_mass=0.15, frame_com=0.02, frame_inertia=2e-4, other_leg_length=0.3402,
        other_foot_mass=0.33, **HIP)  # fmt: skip
    ahead = dataclasses.replace(projected, foot_offset=2e-3)
    found = project(with_numbers_of(with_numbers_of(machine, ahead), wanted))
    assert {key: getattr(found, key) for key in HIP} == HIP
    for leg in (0, 1):
        assert dataclasses.asdict(found.leg(leg)) == pytest.approx(dataclasses.asdict(wanted.leg(leg)), abs=1e-12)
    assert found.hip_mass == 0.0


def test_a_machine_takes_a_hip_without_frames(machine):
    plain = Biped("compliant", 0.3, 0.36, 0.34, 0.09, 0.104, 2500.0, 50.0, 1.1e-3)
    found = project(with_numbers_of(machine, plain))
    assert found.hip_mass == pytest.approx(0.3, rel=1e-14)
    assert found.frame_mass == found.leg(1).frame_mass == 0.0
    assert found.leg_inertia == pytest.approx(1.1e-3, rel=1e-12)


@pytest.mark.parametrize("inertia", ["parts", "planar"])
def test_bodies_of_a_detailed_design_are_possible(parameters, inertia):
    """No moment is above the sum of the other two: frames that turn, legs that turn more, and less, than the first."""
    settings = dataclasses.replace(parameters.settings, inertia=inertia)
    for other in (1.2e-3, 2e-3, 3e-3):
        design = dataclasses.replace(parameters.biped, leg_inertia=2e-3, other_leg_inertia=other, other_foot_mass=0.34,
                                     frame_mass=0.1, frame_com=0.06, frame_inertia=8e-4)  # fmt: skip
        machine = machine_of(design, settings)
        assert project(machine).leg(1).leg_inertia == pytest.approx(other, rel=1e-12)
        for body in machine.bodies:
            low, middle, high = np.linalg.eigvalsh(body.inertia)
            assert low > -1e-12 * high and high <= (1.0 + 1e-12) * (low + middle)


# --- Kinematics of points against finite differences, and of sensors against the planar definition.


H = 1e-4


def states(time):
    """A smooth motion of all coordinates and its first two derivatives."""
    k = np.arange(11)
    speed, scale = 1.0 + 0.3 * k, 0.3 / (1.0 + k)
    angle = time[:, None] * speed + k
    return scale * np.sin(angle), scale * speed * np.cos(angle), -scale * speed**2 * np.sin(angle)


@pytest.mark.parametrize(("pair", "slide"), [(0, None), (0, 6), (0, 7), (1, None), (1, 9), (1, 10)])
def test_velocity_and_acceleration_are_derivatives(pair, slide):
    time = np.linspace(0.0, 2.0, 7)
    place = np.array([0.02, -0.2, 0.07])

    def motion(t):
        q, v, a = states(t)
        return point_motion(q, v, a, pair_axes(q, v, a, pair), place, slide)

    now, before, after = motion(time), motion(time - H), motion(time + H)
    assert now.velocity == pytest.approx((after.position - before.position) / (2 * H), abs=1e-7)
    assert now.acceleration == pytest.approx((after.velocity - before.velocity) / (2 * H), abs=1e-6)


# --- The twin's inventory: bodies of which an empty one weighs nothing, coordinates, four feet.


@pytest.mark.parametrize(("legs", "held"), [("compliant", (6, 11, 11, 4)), ("rigid", (2, 7, 7, 0))])
def test_the_twin_holds_what_is_named(parameters, legs, held):
    """Rigid legs have no slides and no springs."""
    machine = build(dataclasses.replace(parameters.biped, legs=legs), parameters.settings)
    tree = SpatialTree(machine, parameters.slope, parameters.contact)
    found = take_inventory(tree.mbs, len(tree.feet))
    assert (found.bodies, found.coordinates, found.joints, found.springs) == held
    assert (found.contact_pairs, found.sensors, found.recorded_bytes) == (4, 3, 0)
    assert tree.position().shape == tree.velocity().shape == (11,)


# --- Motion without ground: gravity alone, and what must not change.


@pytest.fixture(scope="module")
def tumbling(machine, fly):
    free = dataclasses.replace(machine, damping=np.zeros(4))
    rates = np.array([0.2, 0.5, -0.1, 0.4, -0.3, 0.8, 0.02, -0.03, -1.1, 0.01, 0.04])
    return free, fly(free, rates)


def test_energy_is_kept_in_flight_and_the_mass_centre_flies_a_parabola(tumbling, parameters):
    machine, record = tumbling
    gravity, t = np.array([*parameters.slope.gravity_vector, 0.0]), record.time[:, None]
    energy, moment = mechanical_energy(machine, record.position, record.velocity)
    assert np.ptp(energy - moment @ gravity) < 1e-8
    free = moment / machine.mass - 0.5 * gravity * t**2
    straight = free[0] + (free[-1] - free[0]) * t / t[-1]
    assert abs(free - straight).max() < 1e-8


def test_angular_momentum_is_kept_in_flight(tumbling):
    machine, record = tumbling
    states = record.position, record.velocity, record.acceleration
    axes = [pair_axes(*states, pair) for pair in (0, 1)]
    momentum, moment, linear = 0.0, 0.0, 0.0
    for index, body in enumerate(machine.bodies):
        slide = None if index % 3 == 0 else SLIDE[(index // 3) * 2 + index % 3 - 1]
        pair = axes[index // 3]
        motion = point_motion(*states, pair, body.centre, slide)
        frame = np.stack([pair.forward, pair.upward, pair.lateral], axis=2)
        spin = np.einsum("nij,jk,nk->ni", frame, body.inertia, pair.components(pair.spin))
        momentum = momentum + spin + body.mass * np.cross(motion.position, motion.velocity)
        moment, linear = moment + body.mass * motion.position, linear + body.mass * motion.velocity
    about_centre = momentum - np.cross(moment, linear) / machine.mass
    assert abs(about_centre[0]).max() > 1e-3
    assert abs(about_centre - about_centre[0]).max() < 1e-8
