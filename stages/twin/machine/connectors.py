"""The same ground as eight of Exudyn's own connectors: the yardstick for `stages.twin.machine.contact`.

Exudyn itself turns each connector's force and torque into generalized forces, so the agreement of the two trees tests
the kinematics written there. It costs about four times as much.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from stages.ground.contact_law import ContactLaw
from stages.ground.friction import friction_slope, normal_force
from stages.ground.slope import Slope
from stages.multibody.assembly.contact import SYMBOLS, add_connector, symbolic_user_function
from stages.multibody.assembly.quiet_exudyn import items, symbolic
from stages.twin.machine.machine import Machine
from stages.twin.machine.tree import SpatialTree


def edge_law(point: ContactLaw, radius: float) -> Callable[..., Any]:
    """User function of one end circle of a foot, its marker at the circle's centre, the ground's at the origin.

    Vectors of expressions keep the costly terms single: normal force and friction slope are each evaluated once.
    """
    zero, one = symbolic.Real(0.0), symbolic.Real(1.0)

    def ground(  # type: ignore[no-untyped-def]  # the signature is Exudyn's
        mbs, t, item, displacement, rotation, velocity, angularVelocity, stiffness, damping, rotJ0, rotJ1, offset
    ):
        v, w = velocity, angularVelocity
        a0 = symbolic.sin(rotation[1])  # the hip axis, third column of the rotation
        a1 = -symbolic.sin(rotation[0]) * symbolic.cos(rotation[1])
        a2 = symbolic.cos(rotation[0]) * symbolic.cos(rotation[1])
        level = symbolic.sqrt(1.0 - a1 * a1)
        d0, d1, d2 = radius * a1 * a0 / level, -radius * level, radius * a1 * a2 / level  # to the lowest point
        s0, s1, s2 = v[0] + w[1] * d2 - w[2] * d1, v[1] + w[2] * d0 - w[0] * d2, v[2] + w[0] * d1 - w[1] * d0
        normal = normal_force(point, -(displacement[1] + d1), -s1, SYMBOLS)
        slope = friction_slope(point.numbers, s0, s2, SYMBOLS)
        upward = symbolic.Vector([zero, one, zero, -d2, zero, d0])
        slip = symbolic.Vector([s0, zero, s2, d1 * s2, d2 * s0 - d0 * s2, -(d1 * s0)])
        return normal * (slope * slip - upward)  # what the ground's marker feels

    return ground


class ConnectorTree(SpatialTree):
    """`SpatialTree` with connectors for the ground."""

    def __init__(self, machine: Machine, slope: Slope, contact: ContactLaw) -> None:
        self.point = contact.shared_by(4)
        self.edges: list[list[Any]] = [[], []]
        super().__init__(machine, slope, contact)

    def add_ground(self) -> None:
        """Let the ground act through two connectors a foot."""
        plane = self.mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=self.mbs.AddObject(items.ObjectGround())))
        self.laws = []  # Exudyn needs them alive
        for leg, (lane, radius, length, half) in enumerate(self.feet):
            self.laws.append(symbolic_user_function(self.mbs, edge_law(self.point, float(radius))))
            for z in (lane - half, lane + half):
                circle = items.MarkerKinematicTreeRigid(
                    objectNumber=self.tree,
                    linkNumber=self.foot_link(leg),
                    localPosition=[0.0, float(radius - length), float(z)],
                )
                self.edges[leg // 2].append(add_connector(self.mbs, plane, circle, self.laws[-1]))

    def set_in_play(self, pair: int, acts: bool) -> None:
        """Let the ground act on a pair's feet, or not."""
        super().set_in_play(pair, acts)
        for edge in self.edges[pair]:
            self.mbs.SetObjectParameter(edge, "activeConnector", bool(acts))
