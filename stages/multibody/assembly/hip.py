"""What a detailed design has at the hip: spring, damper and friction between the legs, and a counterweight.

All of it is Exudyn's: connectors between the coordinates that are the legs' angles, and a load. What a design does not
have is not assembled.
"""

from __future__ import annotations

from typing import Any

from stages.biped.design import Biped
from stages.ground.slope import Slope
from stages.multibody.assembly.quiet_exudyn import items
from stages.planar.state import hip_creep


def add_hip(mbs: Any, biped: Biped, slope: Slope, angles: tuple[Any, Any]) -> list[Any]:
    """Connectors between the legs' angles, given as (node, coordinate) of leg 0 and of leg 1; those that were added.

    They act on angle 0 minus angle 1.
    """
    added = []
    if biped.hip_stiffness or biped.hip_damping:
        added.append(items.ObjectConnectorCoordinateSpringDamper(
            markerNumbers=_coordinates(mbs, angles),
            stiffness=biped.hip_stiffness,
            damping=biped.hip_damping,
            offset=biped.hip_rest_angle,
        ))  # fmt: skip
    if biped.hip_friction:
        added.append(items.ObjectConnectorCoordinateSpringDamperExt(
            markerNumbers=_coordinates(mbs, angles),
            dynamicFrictionForce=biped.hip_friction,
            frictionProportionalZone=hip_creep(biped, slope),
        ))  # fmt: skip
    return [mbs.AddObject(connector) for connector in added]


def _coordinates(mbs: Any, angles: tuple[Any, Any]) -> list[Any]:
    """Markers of leg 1's and leg 0's angle: a connector takes the second's coordinate minus the first's."""
    return [mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=row)) for node, row in angles[::-1]]


def add_counterweight(mbs: Any, biped: Biped, slope: Slope, hip: Any) -> None:
    """The weight by which the hip's mass for gravity exceeds its mass, at a marker of the hip."""
    excess = biped.weighed_hip - biped.hip_mass
    if excess:
        load = [excess * component for component in slope.gravity_vector]
        mbs.AddLoad(items.LoadForceVector(markerNumber=hip, loadVector=[*load, 0.0]))
