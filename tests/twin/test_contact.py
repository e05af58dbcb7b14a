"""The compiled ground against the laws' own text, the principle of virtual power, and Exudyn's connectors."""

import dataclasses

import numpy as np
import pytest

from stages.ground.friction import SCALARS
from stages.ground.laws import FRICTIONS, NORMAL_FORCES
from stages.multibody.assembly.contact import disc_force
from stages.twin.machine.connectors import ConnectorTree
from stages.twin.machine.contact import COUNT, PITCH, SLIDE, X, Y, along, clearances, feet_forces, point_law
from stages.twin.machine.kinematics import pair_axes, point_motion


@pytest.mark.parametrize("normal", NORMAL_FORCES)
@pytest.mark.parametrize("friction", FRICTIONS)
def test_a_pair_of_feet_that_stands_straight_feels_the_planar_models_force(parameters, machine, normal, friction):
    law = dataclasses.replace(parameters.contact, normal_force=normal, friction=friction)
    numbers, radius = point_law(law), float(machine.radius[0])
    reach = machine.length[0] - radius
    for depth, upward, forward, turn in ((2e-5, -0.2, 0.003, 0.1), (1e-4, 0.05, 0.7, -0.4), (3e-4, -0.3, -2.0, 0.5)):
        q, v = np.zeros(COUNT), np.zeros(COUNT)
        q[Y], v[X], v[Y], v[PITCH] = machine.length[0] - depth, forward, upward, turn
        force = feet_forces(q, v, np.array([1.0, 0.0]), machine.feet, numbers)[1].sum(axis=0)
        planar = disc_force(law, radius, radius - depth, forward + reach * turn, upward, turn, SCALARS)
        assert force[:2] == pytest.approx(planar, rel=1e-9, abs=1e-12) and force[2] == 0.0


def test_power_of_the_forces_is_that_of_the_generalized_forces(parameters, machine, random_states):
    q, v, _ = random_states
    numbers, touching = point_law(parameters.contact), 0
    for place, motion in zip(q, v, strict=True):
        place[1] -= min(clearances(place, machine.feet)[0]) + 2e-5
        generalized, force, power = feet_forces(place, motion, np.ones(2), machine.feet, numbers)
        assert generalized @ motion == pytest.approx(power, rel=1e-9, abs=1e-9)
        assert generalized[:3] == pytest.approx(force.sum(axis=0))
        touching += bool(force[:, 1].sum() > 0.0)
    assert touching > 10


def test_lowest_point_is_found_on_the_cylinders_rim(machine, random_states):
    q, v, a = random_states
    around = np.linspace(0.0, 2.0 * np.pi, 20001)
    circle = machine.radius[0] * np.array([np.cos(around), np.sin(around)])
    for pair in (0, 1):
        axes, lowest = pair_axes(q, v, a, pair), np.full(len(q), np.inf)
        for leg in (2 * pair, 2 * pair + 1):
            for side in (-1, 1):
                z = machine.lane[leg] + side * machine.half_width
                place = np.array([0.0, machine.radius[leg] - machine.length[leg], z])
                centre = point_motion(q, v, a, axes, place, SLIDE[leg]).position
                rim = centre[:, 1, None] + axes.forward[:, 1, None] * circle[0] + axes.upward[:, 1, None] * circle[1]
                lowest = np.minimum(lowest, rim.min(axis=1))
        found = [clearances(place, machine.feet)[0][pair] for place in q]
        assert found == pytest.approx(lowest, abs=1e-8)


def test_no_force_on_a_pair_out_of_play(parameters, machine, random_states):
    q, v, _ = (values.copy() for values in random_states)
    q[:, 1] -= 0.05
    force, _ = along(q, v, np.tile([0.0, 1.0], (len(q), 1)), machine.feet, point_law(parameters.contact))
    assert not force[:, :2].any() and force[:, 2:, 1].max() > 0.0


def test_exudyn_connectors_move_the_machine_alike(parameters, machine, settings, walk_from):
    coarse = dataclasses.replace(settings, tolerance=1e-5)  # the same steps are taken by both
    push = {"yaw": 0.02, "yaw_rate": 0.1, "roll_rate": 0.05, "sideways": 0.01}
    ours = walk_from(machine, coarse, 1, **push)
    connectors = ConnectorTree(machine, parameters.slope, parameters.contact)
    theirs = walk_from(machine, coarse, 1, tree=connectors, **push)
    time = np.linspace(0.0, min(ours.time[-1], theirs.time[-1]), 200)
    assert abs(ours.at(time)[0] - theirs.at(time)[0]).max() < 1e-8


def standing(machine, lanes, half_width):
    """The feet's numbers with other lanes and widths, and coordinates of an upright machine on its inner pair."""
    feet = machine.feet.copy()
    feet[:, 0], feet[:, 3] = lanes, half_width
    q = np.zeros(11)
    q[1], q[8] = machine.length[0] - 1.5e-5, 0.3
    return feet, q


@pytest.mark.parametrize(("lanes", "half_width"), [((0.04, -0.04, 0.085, -0.085), 0.0), (np.zeros(4), 0.01)])
def test_where_the_feet_stand_resists_roll_and_yaw(parameters, machine, lanes, half_width):
    """Two feet apart, or one with two edges: a roll is pushed back, a spin braked; without either nothing resists."""
    law, play = point_law(parameters.contact), np.array([1.0, 0.0])
    feet, q = standing(machine, lanes, half_width)
    line, _ = standing(machine, np.zeros(4), 0.0)
    spin = np.zeros(11)
    spin[3] = 0.5
    for sign in (1.0, -1.0):
        rolled = q.copy()
        rolled[4] = sign * 2e-4
        assert sign * feet_forces(rolled, np.zeros(11), play, feet, law)[0][4] < -1e-2
        # a line foot tilts about its line: the ground's force then passes by the hip and pushes it further
        assert sign * feet_forces(rolled, np.zeros(11), play, line, law)[0][4] > -1e-9
        assert sign * feet_forces(q, sign * spin, play, feet, law)[0][3] < -1e-3
        assert feet_forces(q, sign * spin, play, line, law)[0][3] == pytest.approx(0.0, abs=1e-12)
    turned = q.copy()
    turned[3] = 0.2
    assert feet_forces(turned, np.zeros(11), play, feet, law)[0][3] == pytest.approx(0.0, abs=1e-12)
