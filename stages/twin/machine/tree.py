"""The twin in minimal coordinates: an Exudyn kinematic tree of eleven links, seven with rigid legs.

Three slides x, y, z bring the middle of the hip axis into place, revolute joints turn the inner frame: yaw about the
slope's normal, then roll about the forward axis, then pitch about the hip axis (the inner legs' angle). On the frame
slide the two inner feet; the outer frame turns on it about the hip axis and carries the two outer feet. A slide is
positive when the foot has moved up into the leg. On rigid legs the feet are part of their frame, and there are no
slides. The ground: `stages.twin.machine.contact`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from stages.ground.contact_law import ContactLaw
from stages.ground.slope import Slope
from stages.multibody.assembly.quiet_exudyn import exudyn, items
from stages.twin.machine.bill import join
from stages.twin.machine.contact import COUNT, HINGE, PITCH, RIGID_ROWS, SLIDE, point_law, solver_force
from stages.twin.machine.machine import Machine

JOINT = exudyn.JointType
OUTPUT = exudyn.OutputVariableType

JOINTS = (
    JOINT.PrismaticX, JOINT.PrismaticY, JOINT.PrismaticZ, JOINT.RevoluteY, JOINT.RevoluteX, JOINT.RevoluteZ,
    JOINT.PrismaticY, JOINT.PrismaticY, JOINT.RevoluteZ, JOINT.PrismaticY, JOINT.PrismaticY,
)  # fmt: skip
PARENTS = (-1, 0, 1, 2, 3, 4, 5, 5, 5, 8, 8)


class SpatialTree:
    """Assembled system. `in_play` (2,) tells the ground on which pair of feet it acts: 1 or 0.

    Coordinates and rates are given and taken as (11,) for either kind of legs; the slides of rigid legs are zero.
    """

    def __init__(self, machine: Machine, slope: Slope, contact: ContactLaw) -> None:
        self.machine = machine
        self.feet = machine.feet
        self.contact = contact
        self.rows = list(RIGID_ROWS) if machine.rigid else list(range(COUNT))  # coordinates of the tree
        self.in_play = np.ones(2)
        self.container = exudyn.SystemContainer()
        self.mbs = self.container.AddSystem()
        nothing = np.zeros(len(self.rows))
        self.node = self.mbs.AddNode(
            items.NodeGenericODE2(
                referenceCoordinates=nothing,
                initialCoordinates=nothing,
                initialCoordinates_t=nothing,
                numberOfODE2Coordinates=len(self.rows),
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
        system = self.mbs.systemData  # asked for once: to look it up takes longer than to answer
        self._coordinates, self._rates = system.GetODE2Coordinates, system.GetODE2Coordinates_t

    def _links(self, slope: Slope) -> items.ObjectKinematicTree:
        machine, rows = self.machine, self.rows
        bodies = machine.bodies
        if machine.rigid:
            bodies = join(bodies[:3]), join(bodies[3:])
        size = len(rows)
        mass, centre, inertia = np.zeros(size), np.zeros((size, 3)), np.zeros((size, 3, 3))
        for link, body in enumerate(bodies, start=PITCH):
            mass[link], centre[link], inertia[link] = body.mass, body.centre, body.inertia
        spring, damper = np.zeros(COUNT), np.zeros(COUNT)
        spring[list(SLIDE)], damper[list(SLIDE)] = machine.stiffness, machine.damping
        damper[HINGE] = machine.bearing_friction
        nothing = np.zeros(size)
        return items.ObjectKinematicTree(
            nodeNumber=self.node,
            jointTypes=[JOINTS[row] for row in rows],
            linkParents=[rows.index(PARENTS[row]) if PARENTS[row] >= 0 else -1 for row in rows],
            jointTransformations=exudyn.Matrix3DList([np.eye(3)] * size),
            jointOffsets=exudyn.Vector3DList([np.zeros(3)] * size),
            linkInertiasCOM=exudyn.Matrix3DList(list(inertia)),
            linkCOMs=exudyn.Vector3DList(list(centre)),
            linkMasses=mass,
            gravity=[*slope.gravity_vector, 0.0],
            jointPControlVector=spring[rows],
            jointDControlVector=damper[rows],
            jointPositionOffsetVector=nothing,  # must be given in full length with the control vectors
            jointVelocityOffsetVector=nothing,
        )

    def foot_link(self, leg: int) -> int:
        """The link that carries a leg's foot."""
        return self.rows.index((PITCH, HINGE)[leg // 2] if self.machine.rigid else SLIDE[leg])

    def add_ground(self) -> None:
        """Let the ground act through the compiled generalized forces."""
        law = point_law(self.contact)
        force, self.in_play = solver_force(self.feet, law, self.machine.rigid)

        def ground(mbs: Any, time: float, item: int, q: list[float], v: list[float]) -> memoryview:
            return force(q, v)

        self.ground = ground
        self.mbs.SetObjectParameter(self.tree, "forceUserFunction", ground)

    def set_in_play(self, pair: int, acts: bool) -> None:
        """Let the ground act on a pair's feet, or not."""
        self.in_play[pair] = float(acts)

    def start(self, position: np.ndarray, velocity: np.ndarray, in_play: tuple[bool, bool]) -> None:
        """Make a state the initial one."""
        initial = exudyn.ConfigurationType.Initial
        self.mbs.systemData.SetODE2Coordinates(np.asarray(position, dtype=float)[self.rows], configuration=initial)
        self.mbs.systemData.SetODE2Coordinates_t(np.asarray(velocity, dtype=float)[self.rows], configuration=initial)
        for pair in (0, 1):
            self.set_in_play(pair, in_play[pair])

    def position(self) -> np.ndarray:
        """Coordinates at the current step, (11,)."""
        return self._wide(np.asarray(self._coordinates()))

    def velocity(self) -> np.ndarray:
        """Rates of the coordinates at the current step, (11,)."""
        return self._wide(np.asarray(self._rates()))

    def recording(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Time (n,), coordinates, rates and accelerations (n, 11) at the solver's own steps."""
        rows = [self.mbs.GetSensorStoredData(sensor) for sensor in self.sensors]
        return rows[0][:, 0], *(self._wide(row[:, 1:]) for row in rows)

    def _wide(self, values: np.ndarray) -> np.ndarray:
        """Values of the tree's coordinates (..., 7 or 11) as those of all eleven."""
        if not self.machine.rigid:
            return values
        wide = np.zeros((*values.shape[:-1], COUNT))
        wide[..., self.rows] = values
        return wide
