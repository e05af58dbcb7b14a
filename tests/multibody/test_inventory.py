"""A scene holds what is named and no more, and what it leaves out costs nothing."""

import numpy as np
import pytest

from stages.biped.walk import StanceState
from stages.ground.friction import Lane
from stages.multibody.assembly.inventory import take_inventory
from stages.planar.run import rolling_state

LANES = Lane(0.0, 0.32, 0.08), Lane(0.16, 0.32, 0.08)


@pytest.mark.parametrize(("changes", "lanes", "held"), [
    ({}, None, (3, 6, 6, 2, 2)),
    ({"legs": "rigid"}, None, (3, 4, 4, 0, 2)),
    ({"assembly": "joints"}, None, (3, 9, 2, 2, 2)),
    ({"legs": "rigid", "assembly": "joints"}, None, (3, 9, 2, 0, 2)),
    ({}, LANES, (3, 6, 6, 2, 2)),
    ({"friction": "none"}, None, (3, 6, 6, 2, 2)),
    ({"friction": "coulomb"}, None, (3, 6, 6, 2, 2)),
    ({"normal_force": "restitution"}, None, (3, 6, 6, 2, 2)),
])
def test_each_assembly_holds_what_is_named(scene, changes, lanes, held):
    """Hip and two feet; two coordinates of the hip and one or two a leg; rigid legs bring no spring and no slide.

    Blocks and laws change the law of the contacts that are there.
    """
    found = take_inventory(scene.but(**changes).build(lanes).mbs)
    assert (found.bodies, found.coordinates, found.joints, found.springs, found.contact_pairs) == held


def test_the_record_grows_with_the_run_and_holds_its_sensors_alone(scene, start):
    """Time and 6 coordinates, rates, accelerations; a foot's acceleration and two forces of 3: 33 numbers a row."""
    coarse = scene.but(tolerance=1e-5, largest_step=2e-3)
    machine = coarse.build()
    assert take_inventory(machine.mbs).recorded_bytes == 0
    run = coarse.walk(start, steps=1, assembly=machine)
    found, rows = take_inventory(machine.mbs), len(machine.mbs.GetSensorStoredData(0))
    assert found.sensors == 6 and found.recorded_bytes == 8 * (3 * 7 + 3 * 4) * rows
    assert abs(rows - run.solver_steps) <= 2


def test_what_a_scene_leaves_out_costs_nothing(scene, start):
    """Values of laws and scenes that are not chosen change neither the solver's steps nor a bit of the walk."""
    coarse = scene.but(tolerance=1e-5, largest_step=2e-3)
    idle = coarse.but(rolling_step=1e-3, impact_step=5e-4, impact_window=0.05, restitution=0.7,
                      impact_speed=2.0)  # fmt: skip
    usual, other = (each.walk(start, steps=1) for each in (coarse, idle))
    assert other.solver_steps == usual.solver_steps
    assert np.array_equal(other.trajectory.position, usual.trajectory.position)


@pytest.mark.parametrize(("legs", "coordinates"), [("rigid", 4), ("compliant", 6)])
def test_rigid_legs_carry_no_idle_coordinate(scene, contact, legs, coordinates):
    own = scene.but(legs=legs)
    stance = StanceState(0.0, own.biped.leg_length, 0.27, own.biped.leg_length, 0.71, 0.0, 1.8, 0.0)
    machine = own.build()
    run = own.walk(rolling_state(own.biped, contact, stance, 9.4), duration=1e-3, assembly=machine)
    assert machine.mbs.GetSensorStoredData(0).shape[1] == 1 + coordinates and len(run.trajectory.time) > 1
