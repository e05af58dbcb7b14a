"""The ground under a foot as an Exudyn connector: the laws of `stages.ground`, compiled from symbols.

The connector is an `ObjectConnectorRigidBodySpringDamper` between a marker on the ground plane (marker 0, anywhere on
the plane, axes of the slope frame) and a marker at the centre of the foot's disc (marker 1). No Python runs when the
solver evaluates it.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from stages.ground.contact_law import ContactLaw
from stages.ground.friction import SCALARS, Lane, Operations, friction_coefficient, normal_force, with_single_terms
from stages.multibody.assembly.system import CreateSymbolicUserFunction, items, symbolic

Lanes = tuple[Lane, Lane] | None

CONNECTOR = "ObjectConnectorRigidBodySpringDamper"
USER_FUNCTION = "springForceTorqueUserFunction"

SYMBOLS = with_single_terms(
    symbolic.sin,
    symbolic.asin,
    symbolic.sqrt,
    sign=symbolic.sign,
    absolute=symbolic.abs,
    round=symbolic.round,
    power=lambda x, exponent: symbolic.pow(x, symbolic.Real(exponent)),
    minimum=lambda x, limit: symbolic.min(x, symbolic.Real(limit)),
    maximum=lambda x, limit: symbolic.max(x, symbolic.Real(limit)),
)


def disc_force(
    law: ContactLaw,
    radius: float,
    height: Any,
    velocity_x: Any,
    velocity_y: Any,
    angular_velocity: Any,
    ops: Operations = SYMBOLS,
) -> tuple[Any, Any]:
    """Force [N] (x, y) of the ground on an upright disc whose centre is at `height` [m] above the ground.

    The penetration is radius - height. Friction acts at the radius, so that its power is force times slip and the
    losses are exact; its moment about the centre is radius * F_x.
    """
    normal = normal_force(law, radius - height, -velocity_y, ops)
    friction = friction_coefficient(law, velocity_x + radius * angular_velocity, ops) * normal
    return -friction, normal


def planar_connector_law(
    law: ContactLaw, radius: float, lane: Lane | None, ops: Operations = SYMBOLS
) -> Callable[..., list[Any]]:
    """User function of a planar foot: what acts on marker 0, the negative of the force and torque on the foot.

    With a lane the ground exists on its blocks only; their edges are not modelled.
    """

    def ground(  # type: ignore[no-untyped-def]  # the signature is Exudyn's
        mbs, t, item, displacement, rotation, velocity, angularVelocity, stiffness, damping, rotJ0, rotJ1, offset
    ):
        tangential, normal = disc_force(law, radius, displacement[1], velocity[0], velocity[1], angularVelocity[2], ops)
        if lane is not None:
            there = lane.presence(displacement[0], ops)
            tangential, normal = there * tangential, there * normal
        return [-tangential, -normal, 0.0, 0.0, 0.0, -(radius * tangential)]

    return ground


def symbolic_user_function(mbs: Any, function: Callable[..., list[Any]]) -> Any:
    """Compile a connector law. Keep the returned object alive as long as the system: it owns the expression."""
    symbolic.SetRecording(True)  # Exudyn's default; a compiled law evaluates wrongly while it is off
    return CreateSymbolicUserFunction(mbs, function, USER_FUNCTION, itemTypeName=CONNECTOR)


def add_ground(
    mbs: Any, law: ContactLaw, radii: Sequence[float], discs: Sequence[Any], lanes: Lanes = None, *,
    compiled: bool = True, rough: bool = False
) -> tuple[list[Any], list[Any], list[Any]]:
    """Let the ground act on planar feet of these radii [m] whose disc centres carry these markers.

    Gives their laws, to be kept, connectors, and what they stand on: each on its own if the ground is `rough`.

    `compiled=False` calls Python instead, to measure what that costs.
    """
    grounds = [mbs.AddObject(items.ObjectGround()) for _ in discs[: len(discs) if rough else 1]]
    planes = [mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=ground)) for ground in grounds]
    feet = zip(radii, lanes or (None, None), strict=True)
    if compiled:
        laws = [symbolic_user_function(mbs, planar_connector_law(law, radius, lane)) for radius, lane in feet]
    else:
        laws = [planar_connector_law(law, radius, lane, SCALARS) for radius, lane in feet]
    return laws, [add_connector(mbs, planes[leg if rough else 0], disc, own)
                  for leg, (disc, own) in enumerate(zip(discs, laws, strict=True))], grounds  # fmt: skip


def add_connector(mbs: Any, plane: Any, place: Any, law: Any) -> Any:
    """A connector with this law between the plane's marker and a new one at a foot's place: its number."""
    return mbs.AddObject(
        items.ObjectConnectorRigidBodySpringDamper(
            markerNumbers=[plane, mbs.AddMarker(place)],
            stiffness=np.zeros((6, 6)),
            damping=np.zeros((6, 6)),
            springForceTorqueUserFunction=law,
        )
    )
