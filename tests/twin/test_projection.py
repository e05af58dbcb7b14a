"""The twin seen from the side: its sums are those of the bill and of what Exudyn assembles, and z drops out."""

import dataclasses

import numpy as np
import pytest

from stages.twin.machine.bill import pieces
from stages.twin.machine.contact import PITCH, SLIDE, X, Y
from stages.twin.machine.machine import FOOT_BODY, FRAME_BODY, Build, build
from stages.twin.machine.projection import project
from stages.twin.machine.tree import SpatialTree
from stages.twin.walking.energy import mechanical_energy

IN_PLANE = [X, Y, PITCH, *SLIDE, 8]


@pytest.fixture(scope="module")
def projected(machine):
    return project(machine)


def places(projected):
    """The four bodies by the name of their group among the parts."""
    return {
        f"{name}_{part}": getattr(getattr(projected, name), part)
        for name in ("inner", "outer") for part in ("frame", "foot")
    }


def moments(body):
    """Mass, mass times place and inertia about the hip: what adds up."""
    return np.array([body.mass, body.mass * body.forward, body.mass * body.upward, body.inertia_about_hip()])


def test_sums_are_those_of_the_rows_of_the_bill(projected, parameters):
    for group, body in places(projected).items():
        rows = [piece for part in parameters.settings.parts if part.group == group for piece in pieces(part)]
        wanted = sum(
            np.array([1.0, *piece.centre[:2], piece.centre[:2] @ piece.centre[:2]]) * piece.mass
            + [0.0, 0.0, 0.0, piece.inertia[2, 2]]
            for piece in rows
        )
        assert len(rows) > 1
        assert moments(body) == pytest.approx(wanted, rel=1e-12, abs=1e-15)


def test_sums_are_those_of_exudyns_bodies(projected, machine, parameters):
    tree = SpatialTree(machine, parameters.slope, parameters.contact)
    links = tree.mbs.GetObject(tree.tree)
    total, mass = np.zeros(4), links["linkMasses"]
    for link in range(len(mass)):  # Exudyn's lists of matrices never end when they are iterated over
        x, y, _ = links["linkCOMs"][link]
        turning = links["linkInertiasCOM"][link][2, 2] + mass[link] * (x * x + y * y)
        total += [mass[link], mass[link] * x, mass[link] * y, turning]
    assert sum(map(moments, places(projected).values())) == pytest.approx(total, rel=1e-12, abs=1e-15)
    assert projected.mass == pytest.approx(machine.mass, rel=1e-14)
    springs = links["jointPControlVector"]
    for pair, legs in ((projected.inner, SLIDE[:2]), (projected.outer, SLIDE[2:])):
        assert pair.stiffness == pytest.approx(sum(springs[leg] for leg in legs), rel=1e-14)


def test_energy_of_motion_in_the_plane_is_that_of_four_planar_bodies(machine, random_states):
    """With frames off the leg's line and pairs that differ, and a bearing's angle between them."""
    crooked = dataclasses.replace(machine, bodies=tuple(
        dataclasses.replace(body, centre=body.centre + (np.array([0.004, 0.01, 0.0]) if i in FRAME_BODY else 0.0))
        for i, body in enumerate(machine.bodies)
    ))  # fmt: skip
    q, v = (np.zeros_like(row) for row in random_states[:2])
    for level, row in ((q, random_states[0]), (v, random_states[1])):
        level[:, IN_PLANE] = row[:, IN_PLANE]
        level[:, [7, 10]] = level[:, [6, 9]]  # left and right slide alike
    energy, moment = mechanical_energy(crooked, q, v)
    found, place = 0.0, 0.0
    for number, pair in enumerate((project(crooked).inner, project(crooked).outer)):
        angle, rate = (row[:, PITCH] + number * row[:, 8] for row in (q, v))
        slide, speed = (row[:, SLIDE[2 * number]] for row in (q, v))
        forward, upward = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
        found = found + 0.5 * pair.stiffness * slide**2
        for body, moved, moving in ((pair.frame, 0.0, 0.0), (pair.foot, slide, speed)):
            up = body.upward + moved
            motion = v[:, :2].T + (moving + body.forward * rate) * upward - up * rate * forward
            found = found + 0.5 * body.mass * (motion**2).sum(axis=0) + 0.5 * body.inertia * rate**2
            place = place + body.mass * (q[:, :2].T + body.forward * forward + up * upward)
    assert found == pytest.approx(energy, rel=1e-12)
    assert pytest.approx(moment[:, :2], rel=1e-12, abs=1e-14) == place.T


def test_what_lies_along_the_hip_axis_drops_out(machine, projected):
    wider = dataclasses.replace(
        machine,
        lane=2.0 * machine.lane,
        half_width=0.0,
        bodies=tuple(
            dataclasses.replace(body, centre=body.centre * [1.0, 1.0, 3.0], inertia=body.inertia * np.eye(3)[2])
            for body in machine.bodies
        ),
    )
    assert project(wider) == projected


def test_point_masses_project_to_the_simple_model(parameters):
    biped = dataclasses.replace(parameters.biped, leg_inertia=2e-3)
    points = project(build(biped, dataclasses.replace(parameters.settings, inertia="planar")))
    assert moments(points.inner.frame) == pytest.approx([biped.hip_mass, 0.0, 0.0, 0.0])
    assert moments(points.outer.frame) == pytest.approx(np.zeros(4))
    for pair in (points.inner, points.outer):
        assert pair.foot.upward + pair.length == pytest.approx(biped.foot_com, rel=1e-14)
        assert (pair.foot.mass, pair.foot.inertia) == pytest.approx((biped.foot_mass, biped.leg_inertia))
        assert (pair.stiffness, pair.damping) == pytest.approx((biped.stiffness, biped.damping))
        assert (pair.length, pair.radius) == (biped.leg_length, biped.foot_radius)


def test_an_outsole_and_friction_belong_to_the_projection(parameters, projected):
    settings = dataclasses.replace(parameters.settings, outsole=0.002, bearing_friction=1e-3, slider_friction=0.5)
    soled = project(build(parameters.biped, settings))
    rubber = 2.0 * settings.mass(parameters.biped.foot_radius, 0.002)
    assert soled.inner.foot.mass - projected.inner.foot.mass == pytest.approx(rubber, rel=1e-10)
    assert soled.outer.length - projected.outer.length == pytest.approx(0.002)
    assert soled.outer.damping - projected.outer.damping == pytest.approx(1.0)
    assert soled.hip_damping == 1e-3


def test_legs_of_a_pair_that_differ_are_taken_on_average(parameters, projected):
    departure = Build(body_mass=(1.0, 1.1, 0.9, 1.0, 1.0, 1.0), stiffness=(1.2, 0.8, 1.0, 1.0),
                      leg_length=(1e-3, 0.0, 0.0, 0.0))  # fmt: skip
    built = project(build(parameters.biped, parameters.settings, departure))
    assert moments(built.inner.foot) == pytest.approx(moments(projected.inner.foot))
    assert built.inner.stiffness == pytest.approx(projected.inner.stiffness)
    assert built.inner.length - projected.inner.length == pytest.approx(0.5e-3)
    assert built.outer == projected.outer


def test_nothing_of_a_machine_is_left_at_the_hip(machine, projected):
    frames = sum(machine.bodies[number].mass for number in FRAME_BODY)
    feet = sum(machine.bodies[number].mass for number in FOOT_BODY)
    assert projected.inner.frame.mass + projected.outer.frame.mass == pytest.approx(frames)
    assert projected.inner.foot.mass + projected.outer.foot.mass == pytest.approx(feet)
