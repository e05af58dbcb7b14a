"""A scene holds what is named and no more, and what it leaves out costs nothing."""

import dataclasses

import numpy as np
import pytest

from stages.biped.gait import StanceState
from stages.ground.friction import Lane
from stages.multibody.assembly.inventory import take_inventory
from stages.multibody.walking.walk import build, simulate
from stages.planar.run import rolling_state


def counts(biped, slope, contact, settings, lanes=None):
    found = take_inventory(build(biped, slope, contact, settings, lanes).mbs)
    return found.bodies, found.coordinates, found.joints, found.springs, found.contact_pairs


def test_each_assembly_holds_what_is_named(biped, slope, contact, settings):
    """Hip and two feet; two coordinates of the hip and one or two a leg; rigid legs bring no spring and no slide."""
    rigid, joints = dataclasses.replace(biped, legs="rigid"), dataclasses.replace(settings, assembly="joints")
    assert counts(biped, slope, contact, settings) == (3, 6, 6, 2, 2)
    assert counts(rigid, slope, contact, settings) == (3, 4, 4, 0, 2)
    assert counts(biped, slope, contact, joints) == (3, 9, 2, 2, 2)
    assert counts(rigid, slope, contact, joints) == (3, 9, 2, 0, 2)


def test_blocks_and_laws_add_no_object(biped, slope, contact, settings):
    """They change the law of the contacts that are there."""
    own = counts(biped, slope, contact, settings)
    lanes = Lane(0.0, 0.32, 0.08), Lane(0.16, 0.32, 0.08)
    assert counts(biped, slope, contact, settings, lanes) == own
    for change in ({"friction": "none"}, {"friction": "coulomb"}, {"normal_force": "restitution"}):
        assert counts(biped, slope, dataclasses.replace(contact, **change), settings) == own


def test_the_record_grows_with_the_run_and_holds_its_sensors_alone(biped, slope, contact, start, settings):
    """Time and 6 coordinates, rates, accelerations; a foot's acceleration and two forces of 3: 33 numbers a row."""
    coarse = dataclasses.replace(settings, tolerance=1e-5, largest_step=2e-3)
    machine = build(biped, slope, contact, coarse)
    assert take_inventory(machine.mbs).recorded_bytes == 0
    run = simulate(biped, slope, contact, start, coarse, steps=1, assembly=machine)
    found = take_inventory(machine.mbs)
    assert found.sensors == 6
    assert found.recorded_bytes == 8 * (3 * 7 + 3 * 4) * len(machine.mbs.GetSensorStoredData(0))
    assert abs(len(machine.mbs.GetSensorStoredData(0)) - run.solver_steps) <= 2


def test_what_a_scene_leaves_out_costs_nothing(biped, slope, contact, start, settings):
    """Values of laws and scenes that are not chosen change neither the solver's steps nor a bit of the walk."""
    coarse = dataclasses.replace(settings, tolerance=1e-5, largest_step=2e-3)
    idle = dataclasses.replace(coarse, block_length=0.05, rolling_step=1e-3, impact_step=5e-4, impact_window=0.05)
    quiet = dataclasses.replace(contact, restitution=0.7, impact_speed=2.0)
    usual = simulate(biped, slope, contact, start, coarse, steps=1)
    other = simulate(biped, slope, quiet, start, idle, steps=1)
    assert other.solver_steps == usual.solver_steps
    assert np.array_equal(other.trajectory.position, usual.trajectory.position)


@pytest.mark.parametrize("legs", ["rigid", "compliant"])
def test_rigid_legs_carry_no_idle_coordinate(biped, slope, contact, settings, legs):
    own = dataclasses.replace(biped, legs=legs)
    stance = StanceState(0.0, biped.leg_length, 0.27, biped.leg_length, 0.71, 0.0, 1.8, 0.0)
    machine = build(own, slope, contact, settings)
    run = simulate(own, slope, contact, rolling_state(own, contact, stance, 9.4), settings, duration=1e-3,
                   assembly=machine)  # fmt: skip
    rows = machine.mbs.GetSensorStoredData(0)
    assert rows.shape[1] == 1 + (4 if legs == "rigid" else 6) and len(run.trajectory.time) > 1
