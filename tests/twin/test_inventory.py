"""The twin's inventory: six bodies of which an empty one weighs nothing, eleven coordinates, four feet."""

from stages.multibody.assembly.inventory import take_inventory
from stages.twin.machine.machine import build
from stages.twin.machine.tree import SpatialTree


def test_the_twin_holds_what_is_named(parameters):
    tree = SpatialTree(build(parameters.biped, parameters.settings), parameters.slope, parameters.contact)
    found = take_inventory(tree.mbs, len(tree.feet))
    assert (found.bodies, found.coordinates, found.joints, found.springs) == (6, 11, 11, 4)
    assert (found.contact_pairs, found.sensors, found.recorded_bytes) == (4, 3, 0)
