"""What a scene really holds, counted in the assembled system and not in what was requested."""

from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from stages.biped.quantity import quantity


@dataclass(frozen=True)
class Inventory:
    """Counts of an assembled system, and the size of what its sensors recorded.

    The joints assembly pauses to change its step; the last solver call is then the last stretch of the walk.
    """

    bodies: int = quantity("1", "bodies with mass")
    coordinates: int = quantity("1", "coordinates of the equations of motion")
    joints: int = quantity("1", "joints: of a tree one a coordinate, else those that constrain")
    springs: int = quantity("1", "springs with dampers in the legs")
    contact_pairs: int = quantity("1", "pairs of a foot and the ground that are evaluated")
    sensors: int = quantity("1", "signals recorded at every solver step")
    recorded_bytes: int = quantity("B", "size of the signals recorded in the last solver call")
    sampled_bytes: int = quantity("B", "size of the signals sampled for the result", default=0)


def take_inventory(mbs: Any, feet_in_tree: int = 0, sampled_bytes: int = 0) -> Inventory:
    """Count an Exudyn system after its run. `feet_in_tree`: feet whose ground acts through the tree's force function,
    which Exudyn does not list as objects. `sampled_bytes`: size of what was sampled afterwards.
    """
    system = mbs.systemData
    items = [mbs.GetObject(number) for number in range(system.NumberOfObjects())]
    bodies, joints, springs, contacts = 0, 0, 0, feet_in_tree
    for item in items:
        kind = item["objectType"]
        if kind == "KinematicTree":
            bodies += sum(mass > 0.0 for mass in item["linkMasses"])
            joints += len(item["jointTypes"])
            springs += int(np.count_nonzero(item["jointPControlVector"]))
        bodies += kind == "RigidBody2D" and item["mass"] > 0.0
        joints += kind.startswith("Joint")
        springs += kind == "ConnectorSpringDamper"
        contacts += kind == "ConnectorRigidBodySpringDamper"
    sensors = system.NumberOfSensors()
    recorded = sum(np.asarray(mbs.GetSensorStoredData(number)).nbytes for number in range(sensors))
    return Inventory(bodies, system.ODE2Size(), joints, springs, contacts, sensors, recorded, sampled_bytes)


def bytes_of(*parts: Any) -> int:
    """Size of arrays and of the arrays that results hold [B]."""
    total = 0
    for part in parts:
        if isinstance(part, np.ndarray):
            total += part.nbytes
        else:
            total += bytes_of(*(getattr(part, field.name) for field in fields(part)))
    return total
