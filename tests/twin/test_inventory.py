"""The twin's inventory: bodies of which an empty one weighs nothing, coordinates, four feet."""

import dataclasses

import pytest

from stages.multibody.assembly.inventory import take_inventory
from stages.twin.machine.machine import build
from stages.twin.machine.tree import SpatialTree


@pytest.mark.parametrize(("legs", "held"), [("compliant", (6, 11, 11, 4)), ("rigid", (2, 7, 7, 0))])
def test_the_twin_holds_what_is_named(parameters, legs, held):
    """Rigid legs have no slides and no springs."""
    machine = build(dataclasses.replace(parameters.biped, legs=legs), parameters.settings)
    tree = SpatialTree(machine, parameters.slope, parameters.contact)
    found = take_inventory(tree.mbs, len(tree.feet))
    assert (found.bodies, found.coordinates, found.joints, found.springs) == held
    assert (found.contact_pairs, found.sensors, found.recorded_bytes) == (4, 3, 0)
    assert tree.position().shape == tree.velocity().shape == (11,)
