"""Rigid legs are rigid: no slides in the tree, and the walk of the planar model with rigid legs."""

import dataclasses

import numpy as np
import pytest

from stages.biped.gait import StanceState
from stages.multibody.assembly.inventory import take_inventory
from stages.multibody.parameters import Settings as PlanarSettings
from stages.multibody.walking.walk import simulate
from stages.planar.run import rolling_state
from stages.planar.section import section_numbers, section_state
from stages.twin.machine.connectors import ConnectorTree
from stages.twin.machine.contact import SLIDE
from stages.twin.machine.machine import build
from stages.twin.machine.tree import SpatialTree
from stages.twin.walking.measures import energy_balance
from stages.twin.walking.record import find_events
from stages.twin.walking.simulate import rolling_start, simulate_twin
from stages.twin_ladder.cycle import SectionState, step_map

#: A mid-stance from which rigid legs find their gait; the numbers are no result of the study.
ROUGH = StanceState(0.0, 0.333, 0.27, 0.333, 0.72, 0.0, 1.85, 0.0)


@pytest.fixture(scope="module")
def biped(parameters):
    return dataclasses.replace(parameters.biped, legs="rigid")


@pytest.fixture(scope="module")
def settings(parameters):
    return dataclasses.replace(parameters.settings, tolerance=1e-9, largest_step=5e-4)


@pytest.fixture(scope="module")
def walk(parameters, settings):
    def walked(machine, steps, tree=None, settings=settings, **push):
        start = rolling_start(machine, parameters.contact, ROUGH, 9.4, **push)
        return simulate_twin(machine, parameters.slope, parameters.contact, start, settings, steps=steps, tree=tree)

    return walked


def test_the_planar_equivalent_walks_as_the_planar_model_does(parameters, biped, settings, walk):
    p = parameters
    planar = PlanarSettings(1e-9, "tree", 2, 2000.0, 5e-4, "trapezoidal", 2e-4, 1e-5, 0.02, 3.0)
    state = rolling_state(biped, p.contact, ROUGH, 9.4)
    checker = simulate(biped, p.slope, p.contact, state, planar)
    machine = build(biped, dataclasses.replace(settings, inertia="planar"))
    twin = walk(machine, 2)
    assert checker.completed and twin.completed
    time = np.linspace(0.0, min(checker.trajectory.time[-1], twin.time[-1]), 1000)
    assert abs(checker.trajectory.at(time)[0][:, :2] - twin.at(time)[0][:, :2]).max() < 1e-7
    assert not twin.position[:, list(SLIDE)].any()


def test_the_ladders_step_is_the_planar_models(parameters, biped, settings):
    p = parameters
    planar = PlanarSettings(1e-9, "tree", 1, 2000.0, 5e-4, "trapezoidal", 2e-4, 1e-5, 0.02, 3.0)
    state = rolling_state(biped, p.contact, ROUGH, 9.4)
    numbers = section_numbers(state)
    machine = build(biped, dataclasses.replace(settings, inertia="planar"))
    step = step_map(machine, p.slope, p.contact, settings)(SectionState(numbers, np.zeros(9)), 0)
    run = simulate(biped, p.slope, p.contact, section_state(numbers, state), planar)
    hip = run.trajectory.at(np.array([step.duration]))[0][0]
    assert step.length == pytest.approx(hip[0], abs=1e-7)
    assert step.end.plane[[0, 2, 3]] == pytest.approx([hip[1], 0.333, 0.333], abs=1e-7)


def test_the_tree_has_no_slides_and_no_springs(parameters, biped, settings):
    machine = build(biped, settings)
    tree = SpatialTree(machine, parameters.slope, parameters.contact)
    held = take_inventory(tree.mbs, len(tree.feet))
    assert (held.coordinates, held.joints, held.springs, held.bodies) == (7, 7, 0, 2)
    assert tree.position().shape == tree.velocity().shape == (11,)


def test_exudyn_connectors_move_the_machine_alike(parameters, biped, settings, walk):
    machine = build(biped, settings)
    push = {"yaw": 0.02, "yaw_rate": 0.1, "roll_rate": 0.05, "sideways": 0.01}
    coarse = dataclasses.replace(settings, tolerance=1e-4, largest_step=2e-3)  # the same steps are taken by both
    ours = walk(machine, 1, settings=coarse, **push)
    connectors = ConnectorTree(machine, parameters.slope, parameters.contact)
    theirs = walk(machine, 1, connectors, coarse, **push)
    assert ours.completed and theirs.completed
    time = np.linspace(0.0, min(ours.time[-1], theirs.time[-1]), 200)
    assert abs(ours.at(time)[0] - theirs.at(time)[0]).max() < 1e-6


def test_energy_balances(biped, settings, walk):
    record = walk(build(biped, settings), 2, settings=dataclasses.replace(settings, tolerance=1e-7, largest_step=1e-3))
    balance = energy_balance(record, *find_events(record).heel_strike_time[-2:])
    assert balance.gravity_work > 0.03 and balance.leg_damper_loss == 0.0
    assert balance.relative_residual < 1e-4
