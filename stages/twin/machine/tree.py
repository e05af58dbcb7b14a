"""The twin in minimal coordinates: an Exudyn kinematic tree of eleven links.

Three slides x, y, z bring the middle of the hip axis into place, revolute joints turn the inner frame: yaw about the
slope's normal, then roll about the forward axis, then pitch about the hip axis (the inner legs' angle). On the frame
slide the two inner feet; the outer frame turns on it about the hip axis and carries the two outer feet. A slide is
positive when the foot has moved up into the leg. The ground: `stages.twin.machine.contact`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from stages.ground.contact_law import ContactLaw
from stages.ground.slope import Slope
from stages.multibody.assembly.quiet_exudyn import exudyn, items
from stages.twin.machine.contact import COUNT, HINGE, PITCH, SLIDE, point_law, solver_force
from stages.twin.machine.machine import Machine

JOINT = exudyn.JointType
OUTPUT = exudyn.OutputVariableType

JOINTS = (
    JOINT.PrismaticX, JOINT.PrismaticY, JOINT.PrismaticZ, JOINT.RevoluteY, JOINT.RevoluteX, JOINT.RevoluteZ,
    JOINT.PrismaticY, JOINT.PrismaticY, JOINT.RevoluteZ, JOINT.PrismaticY, JOINT.PrismaticY,
)  # fmt: skip
PARENTS = (-1, 0, 1, 2, 3, 4, 5, 5, 5, 8, 8)


class SpatialTree:
    """Assembled system. `in_play` (2,) tells the ground on which pair of feet it acts: 1 or 0."""

    def __init__(self, machine: Machine, slope: Slope, contact: ContactLaw) -> None:
        self.machine = machine
        self.feet = machine.feet
        self.contact = contact
        self.in_play = np.ones(2)
        self.container = exudyn.SystemContainer()
        self.mbs = self.container.AddSystem()
        nothing = np.zeros(COUNT)
        self.node = self.mbs.AddNode(
            items.NodeGenericODE2(
                referenceCoordinates=nothing,
                initialCoordinates=nothing,
                initialCoordinates_t=nothing,
                numberOfODE2Coordinates=COUNT,
            )
        )
        self.tree = self.mbs.AddObject(self._links(slope))
        kept = {"storeInternal": True, "writeToFile": False}
        self.sensors = [
            self.mbs.AddSensor(items.SensorNode(nodeNumber=self.node, outputVariableType=kind, **kept))
            for kind in (OUTPUT.Coordinates, OUTPUT.Coordinates_t, OUTPUT.Coordinates_tt)
        ]
        self.add_ground()
        self.mbs.Assemble()

    def _links(self, slope: Slope) -> items.ObjectKinematicTree:
        mass, centre, inertia = np.zeros(COUNT), np.zeros((COUNT, 3)), np.zeros((COUNT, 3, 3))
        for link, body in enumerate(self.machine.bodies, start=PITCH):
            mass[link], centre[link], inertia[link] = body.mass, body.centre, body.inertia
        spring, damper = np.zeros(COUNT), np.zeros(COUNT)
        spring[list(SLIDE)], damper[list(SLIDE)] = self.machine.stiffness, self.machine.damping
        damper[HINGE] = self.machine.bearing_friction
        nothing = np.zeros(COUNT)
        return items.ObjectKinematicTree(
            nodeNumber=self.node,
            jointTypes=list(JOINTS),
            linkParents=list(PARENTS),
            jointTransformations=exudyn.Matrix3DList([np.eye(3)] * COUNT),
            jointOffsets=exudyn.Vector3DList([np.zeros(3)] * COUNT),
            linkInertiasCOM=exudyn.Matrix3DList(list(inertia)),
            linkCOMs=exudyn.Vector3DList(list(centre)),
            linkMasses=mass,
            gravity=[*slope.gravity_vector, 0.0],
            jointPControlVector=spring,
            jointDControlVector=damper,
            jointPositionOffsetVector=nothing,  # must be given in full length with the control vectors
            jointVelocityOffsetVector=nothing,
        )

    def add_ground(self) -> None:
        """Let the ground act through the compiled generalized forces."""
        array, force = np.array, solver_force(self.in_play, self.feet, point_law(self.contact))

        def ground(mbs: Any, time: float, item: int, q: list[float], v: list[float]) -> np.ndarray:
            return force(array(q), array(v))

        self.ground = ground
        self.mbs.SetObjectParameter(self.tree, "forceUserFunction", ground)

    def set_in_play(self, pair: int, acts: bool) -> None:
        """Let the ground act on a pair's feet, or not."""
        self.in_play[pair] = float(acts)

    def start(self, position: np.ndarray, velocity: np.ndarray, in_play: tuple[bool, bool]) -> None:
        """Make a state the initial one."""
        initial = exudyn.ConfigurationType.Initial
        self.mbs.systemData.SetODE2Coordinates(np.asarray(position, dtype=float), configuration=initial)
        self.mbs.systemData.SetODE2Coordinates_t(np.asarray(velocity, dtype=float), configuration=initial)
        for pair in (0, 1):
            self.set_in_play(pair, in_play[pair])

    def position(self) -> np.ndarray:
        """Coordinates at the current step, (11,)."""
        return np.asarray(self.mbs.systemData.GetODE2Coordinates())

    def velocity(self) -> np.ndarray:
        """Rates of the coordinates at the current step, (11,)."""
        return np.asarray(self.mbs.systemData.GetODE2Coordinates_t())

    def recording(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Time (n,), coordinates, rates and accelerations (n, 11) at the solver's own steps."""
        rows = [self.mbs.GetSensorStoredData(sensor) for sensor in self.sensors]
        return rows[0][:, 0], rows[0][:, 1:], rows[1][:, 1:], rows[2][:, 1:]
