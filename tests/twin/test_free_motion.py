"""Motion without ground: gravity alone, and what must not change."""

import dataclasses

import numpy as np
import pytest

from stages.twin.machine.contact import COUNT, SLIDE
from stages.twin.walking.measures import mechanical_energy
from stages.twin.walking.record import pair_axes, point_motion


@pytest.fixture(scope="module")
def tumbling(machine, fly):
    free = dataclasses.replace(machine, damping=np.zeros(4))
    rates = np.array([0.2, 0.5, -0.1, 0.4, -0.3, 0.8, 0.02, -0.03, -1.1, 0.01, 0.04])
    return free, fly(free, rates)


def test_a_machine_at_rest_falls_as_a_stone(machine, parameters, fly):
    record = fly(machine, np.zeros(COUNT))
    gravity = np.array([*parameters.slope.gravity_vector, 0.0])
    fallen = 0.5 * gravity * record.time[:, None] ** 2 + [0.0, 3.0, 0.0]
    assert record.time[-1] > 0.2
    assert abs(record.position[:, :3] - fallen).max() < 1e-9
    assert abs(record.position[:, 3:]).max() < 1e-9


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
