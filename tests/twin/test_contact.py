"""The compiled ground against the laws' own text, the principle of virtual power, and Exudyn's connectors."""

import dataclasses

import numpy as np
import pytest

from stages.ground.friction import SCALARS
from stages.ground.laws import FRICTIONS, NORMAL_FORCES
from stages.multibody.assembly.contact import disc_force
from stages.twin.machine.contact import (
    COUNT,
    HINGE,
    PITCH,
    ROLL,
    SLIDE,
    YAW,
    X,
    Y,
    along,
    clearances,
    feet_forces,
    point_law,
)
from stages.twin.machine.machine import build
from stages.twin.machine.tree import ConnectorTree
from stages.twin.walking.record import pair_axes, point_motion


@pytest.mark.parametrize("normal", NORMAL_FORCES)
@pytest.mark.parametrize("friction", FRICTIONS)
def test_a_pair_of_feet_that_stands_straight_feels_the_planar_models_force(parameters, machine, normal, friction):
    law = dataclasses.replace(parameters.contact, normal_force=normal, friction=friction)
    numbers, radius = point_law(law), float(machine.radius[0])
    reach = machine.length[0] - radius
    for depth, upward, forward, turn in ((2e-5, -0.2, 0.003, 0.1), (1e-4, 0.05, 0.7, -0.4), (3e-4, -0.3, -2.0, 0.5)):
        q, v = np.zeros(COUNT), np.zeros(COUNT)
        q[Y], v[X], v[Y], v[PITCH] = machine.length[0] - depth, forward, upward, turn
        force = feet_forces(q, v, np.array([1.0, 0.0, 0.0, 0.0]), machine.feet, numbers)[1].sum(axis=0)
        planar = disc_force(law, radius, radius - depth, forward + reach * turn, upward, turn, SCALARS)
        assert force[:2] == pytest.approx(planar, rel=1e-9, abs=1e-12) and force[2] == 0.0


def test_power_of_the_forces_is_that_of_the_generalized_forces(parameters, machine, random_states):
    q, v, _ = random_states
    numbers, touching = point_law(parameters.contact), 0
    for place, motion in zip(q, v, strict=True):
        place[1] -= min(clearances(place, machine.feet)[0]) + 2e-5
        generalized, force, power = feet_forces(place, motion, np.array([1.0, 1.0, 0.0, 0.0]), machine.feet, numbers)
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


@pytest.mark.parametrize(("legs", "solver", "within"), [
    ("compliant", {"tolerance": 1e-5}, 1e-8), ("rigid", {"tolerance": 1e-4, "largest_step": 2e-3}, 1e-6)])
def test_exudyn_connectors_move_the_machine_alike(parameters, walk_from, legs, solver, within):
    """The same steps are taken by both."""
    machine = build(dataclasses.replace(parameters.biped, legs=legs), parameters.settings)
    push = {"yaw": 0.02, "yaw_rate": 0.1, "roll_rate": 0.05, "sideways": 0.01}
    connectors = ConnectorTree(machine, parameters.slope, parameters.contact)
    ours, theirs = (walk_from(machine, 1, tree=tree, push=push, **solver) for tree in (None, connectors))
    assert ours.completed and theirs.completed
    time = np.linspace(0.0, min(ours.time[-1], theirs.time[-1]), 200)
    assert abs(ours.at(time)[0] - theirs.at(time)[0]).max() < within


def standing(machine, lanes, half_width):
    """The feet's numbers with other lanes and widths."""
    feet = machine.feet.copy()
    feet[:, 0], feet[:, 3] = lanes, half_width
    return feet


@pytest.mark.parametrize(("lanes", "half_width"), [((0.04, -0.04, 0.085, -0.085), 0.0), (np.zeros(4), 0.01)])
def test_where_the_feet_stand_resists_roll_and_yaw(parameters, machine, lanes, half_width):
    """Two feet apart, or one with two edges: a roll is pushed back, a spin braked; without either nothing resists."""
    law, feet, line = point_law(parameters.contact), standing(machine, lanes, half_width), standing(machine, 0.0, 0.0)

    def push(feet, roll=0.0, yaw=0.0, spin=0.0):
        """On an upright machine that stands on its inner pair."""
        q, v = np.zeros(COUNT), np.zeros(COUNT)
        q[Y], q[YAW], q[ROLL], q[HINGE], v[YAW] = machine.length[0] - 1.5e-5, yaw, roll, 0.3, spin
        return feet_forces(q, v, np.array([1.0, 0.0, 0.0, 0.0]), feet, law)[0]

    for sign in (1.0, -1.0):
        assert sign * push(feet, roll=sign * 2e-4)[ROLL] < -1e-2
        # a line foot tilts about its line: the ground's force then passes by the hip and pushes it further
        assert sign * push(line, roll=sign * 2e-4)[ROLL] > -1e-9
        assert sign * push(feet, spin=sign * 0.5)[YAW] < -1e-3
        assert push(line, spin=sign * 0.5)[YAW] == pytest.approx(0.0, abs=1e-12)
    assert push(feet, yaw=0.2)[YAW] == pytest.approx(0.0, abs=1e-12)
