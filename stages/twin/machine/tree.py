"""The twin in minimal coordinates: an Exudyn kinematic tree of eleven links, seven with rigid legs.

Three slides x, y, z bring the middle of the hip axis into place, revolute joints turn the inner frame: yaw about the
slope's normal, then roll about the forward axis, then pitch about the hip axis (the inner legs' angle). On the frame
slide the two inner feet; the outer frame turns on it about the hip axis and carries the two outer feet. A slide is
positive when the foot has moved up into the leg. On rigid legs the feet are part of their frame, and there are no
slides. The ground: `stages.twin.machine.contact`.

The same ground as eight of Exudyn's own connectors: the yardstick for `stages.twin.machine.contact`.

Exudyn itself turns each connector's force and torque into generalized forces, so the agreement of the two trees tests
the kinematics written there. It costs about four times as much.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from stages.ground.contact_law import ContactLaw
from stages.ground.friction import friction_slope, normal_force
from stages.ground.slope import Slope
from stages.multibody.assembly.contact import SYMBOLS, add_connector, symbolic_user_function
from stages.multibody.assembly.system import System, exudyn, items, symbolic
from stages.multibody.walking.watch import Look
from stages.planar.run import hip_creep
from stages.twin.machine.contact import (
    COUNT,
    HINGE,
    PITCH,
    RIGID_ROWS,
    ROLL,
    SLIDE,
    YAW,
    Y,
    clearances,
    point_law,
    solver_force,
)
from stages.twin.machine.machine import Machine, join
from stages.twin.machine.projection import project

JOINT = exudyn.JointType

JOINTS = (
    JOINT.PrismaticX, JOINT.PrismaticY, JOINT.PrismaticZ, JOINT.RevoluteY, JOINT.RevoluteX, JOINT.RevoluteZ,
    JOINT.PrismaticY, JOINT.PrismaticY, JOINT.RevoluteZ, JOINT.PrismaticY, JOINT.PrismaticY,
)  # fmt: skip
PARENTS = (-1, 0, 1, 2, 3, 4, 5, 5, 5, 8, 8)
#: Roll or yaw [rad] beyond which the machine has toppled or turned away.
TOPPLED = 0.5


class SpatialTree(System):
    """Assembled system. `ground` (4,) shows on which pair of feet it acts, 1 or 0, and its heights under them.

    Coordinates and rates are given and taken as (11,) for either kind of legs; the slides of rigid legs are zero.
    """

    def __init__(self, machine: Machine, slope: Slope, contact: ContactLaw) -> None:
        super().__init__()
        self.machine, self.feet, self.contact = machine, machine.feet, contact
        self.ground = np.array([1.0, 1.0, 0.0, 0.0])
        self.rows = rows = list(RIGID_ROWS) if machine.rigid else list(range(COUNT))  # coordinates of the tree
        bodies = (join(machine.bodies[:3]), join(machine.bodies[3:])) if machine.rigid else machine.bodies
        spring, damper = np.zeros(COUNT), np.zeros(COUNT)
        spring[list(SLIDE)], damper[list(SLIDE)] = machine.stiffness, machine.damping
        spring[HINGE], damper[HINGE] = machine.hip_stiffness, machine.bearing_friction
        relaxed = np.zeros(COUNT)
        relaxed[HINGE] = -machine.hip_rest_angle
        links = {link: (body.mass, body.centre, body.inertia) for link, body in enumerate(bodies, start=PITCH)}
        parents = [rows.index(PARENTS[row]) if PARENTS[row] >= 0 else -1 for row in rows]
        self.add_tree(slope, [JOINTS[row] for row in rows], parents, links, np.zeros((len(rows), 3)), spring[rows],
                      damper[rows], relaxed[rows])  # fmt: skip
        self._add_hip(slope)
        self.add_ground()
        self.assemble()

    def _add_hip(self, slope: Slope) -> None:
        """Friction between the frames, and the weight on the axis that no mass has."""
        machine = self.machine
        if machine.hip_friction:
            plane = self.mbs.AddMarker(items.MarkerNodeCoordinate(
                nodeNumber=self.mbs.AddNode(items.NodePointGround()), coordinate=0))
            hinge = items.MarkerNodeCoordinate(nodeNumber=self.node, coordinate=self.rows.index(HINGE))
            self.mbs.AddObject(items.ObjectConnectorCoordinateSpringDamperExt(
                markerNumbers=[plane, self.mbs.AddMarker(hinge)], dynamicFrictionForce=machine.hip_friction,
                frictionProportionalZone=hip_creep(project(machine), slope)))  # fmt: skip
        axis = items.MarkerKinematicTreeRigid(objectNumber=self.tree, linkNumber=PITCH, localPosition=[0.0] * 3)
        self.add_weight(axis, machine.hip_weight, slope)

    def foot_link(self, leg: int) -> int:
        """The link that carries a leg's foot."""
        return self.rows.index((PITCH, HINGE)[leg // 2] if self.machine.rigid else SLIDE[leg])

    def add_ground(self) -> None:
        """Let the ground act through the compiled generalized forces."""
        law = point_law(self.contact)
        force, self.ground = solver_force(self.feet, law, self.machine.rigid)

        def pushed(mbs: Any, time: float, item: int, q: list[float], v: list[float]) -> memoryview:
            return force(q, v)

        self.pushed = pushed
        self.mbs.SetObjectParameter(self.tree, "forceUserFunction", pushed)

    def set_in_play(self, pair: int, acts: bool) -> None:
        """Let the ground act on a pair's feet, or not."""
        self.ground[pair] = float(acts)

    def set_height(self, pair: int, height: float) -> None:
        """Put blocks of this height [m] under a pair's feet."""
        self.ground[2 + pair] = height

    def start(self, position: np.ndarray, velocity: np.ndarray, in_play: tuple[bool, bool]) -> None:
        """Make a state the initial one."""
        self.begin(*(np.asarray(values, dtype=float)[self.rows] for values in (position, velocity)))
        for pair in (0, 1):
            self.set_in_play(pair, in_play[pair])

    def position(self) -> np.ndarray:
        """Coordinates at the current step, (11,)."""
        return self._wide(np.asarray(self.coordinates()))

    def velocity(self) -> np.ndarray:
        """Rates of the coordinates at the current step, (11,)."""
        return self._wide(np.asarray(self.rates()))

    def look(self) -> Look:
        """Where its pairs of legs are at the current step."""
        place = self.position()
        (inner, outer), along = clearances(place, self.feet)
        clearance = inner - float(self.ground[2]), outer - float(self.ground[3])
        q = place.tolist()
        fell = "turned away from the walking direction in step {step}" if abs(q[YAW]) > TOPPLED else ""
        fell = "toppled sideways in step {step}" if abs(q[ROLL]) > TOPPLED else fell
        return Look(q[Y], (q[PITCH], q[PITCH] + q[HINGE]), clearance, along, sum(q), fell)

    def leg_rate(self, leg: int) -> float:
        """Rate of a pair's angle at the current step [rad/s]."""
        v = self.velocity()
        return float(v[PITCH] + (v[HINGE] if leg else 0.0))

    def recording(self) -> dict[str, np.ndarray]:
        """Time (n,), coordinates, rates and accelerations (n, 11) at the solver's own steps, named as in `Record`."""
        rows = self.kept()
        return {"time": rows["position"][:, 0]} | {name: self._wide(row[:, 1:]) for name, row in rows.items()}

    def _wide(self, values: np.ndarray) -> np.ndarray:
        """Values of the tree's coordinates (..., 7 or 11) as those of all eleven."""
        if not self.machine.rigid:
            return values
        wide = np.zeros((*values.shape[:-1], COUNT))
        wide[..., self.rows] = values
        return wide


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
        return normal * (slope * slip - upward)  # what acts on the ground's marker

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
