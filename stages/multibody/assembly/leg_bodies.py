"""The rigid bodies of a leg, and what a detailed design has at the hip: spring, damper, friction, a counterweight.

All of it is Exudyn's: connectors between the coordinates that are the legs' angles, and a load. What a design does
not have is not assembled.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from stages.biped.design import Biped, Leg
from stages.ground.slope import Slope
from stages.multibody.assembly.quiet_exudyn import items
from stages.planar.state import hip_creep


class PlanarBody(NamedTuple):
    """Mass [kg], mass centre [m] forward and up the leg from some point on its line, inertia about it [kg m^2]."""

    mass: float
    forward: float
    upward: float
    inertia: float


def below_spring(leg: Leg) -> PlanarBody:
    """The foot with all that moves with it, seen from the foot's centre."""
    return PlanarBody(leg.foot_mass, leg.foot_offset, leg.foot_com - leg.foot_radius, leg.leg_inertia)


def above_spring(leg: Leg) -> PlanarBody | None:
    """The frame, seen from the hip; None if the leg has none."""
    if not (leg.frame_mass or leg.frame_inertia):
        return None
    return PlanarBody(leg.frame_mass, leg.frame_offset, -leg.frame_com, leg.frame_inertia)


def joined(one: PlanarBody, other: PlanarBody | None) -> PlanarBody:
    """One rigid body of two seen from the same point, or the first alone."""
    if other is None:
        return one
    mass = one.mass + other.mass
    forward, upward = (
        (one.mass * here + other.mass * there) / mass for here, there in zip(one[1:3], other[1:3], strict=True)
    )
    apart = (one.forward - other.forward) ** 2 + (one.upward - other.upward) ** 2
    return PlanarBody(mass, forward, upward, one.inertia + other.inertia + one.mass * other.mass / mass * apart)


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
