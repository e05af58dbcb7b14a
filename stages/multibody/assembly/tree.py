"""The biped in minimal coordinates: an Exudyn kinematic tree, without constraints, for explicit solvers.

Links: slide x, slide y (carries the hip mass), and for each leg a revolute joint, which carries the frame if there is
one, and a slide along the leg that carries the foot. With rigid legs the foot is part of the revolute joint's link.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

import numpy as np

from stages.biped.design import Biped
from stages.ground.contact_law import ContactLaw
from stages.ground.slope import Slope
from stages.multibody.assembly.contact import Lanes, add_ground, reactions
from stages.multibody.assembly.leg_bodies import (
    PlanarBody,
    above_spring,
    add_counterweight,
    add_hip,
    below_spring,
    joined,
)
from stages.multibody.assembly.quiet_exudyn import exudyn, items
from stages.multibody.walking.scuffing import Pose
from stages.planar.signals import GROUND_REACTION, IMU, SIGNALS
from stages.planar.state import PlanarState

JOINT = exudyn.JointType
OUTPUT = exudyn.OutputVariableType


class Tree:
    """Assembled system; see `stages.multibody.assembly.solver.Assembly` for what it offers."""

    exact_acceleration = True

    def __init__(
        self,
        biped: Biped,
        slope: Slope,
        contact: ContactLaw,
        lanes: Lanes = None,
        *,
        compiled: bool = True,
        signals: Collection[str] = SIGNALS,
    ) -> None:
        self.container = exudyn.SystemContainer()
        self.mbs = self.container.AddSystem()
        self.compliant = biped.legs == "compliant"
        self.natural_length = biped.leg(0).leg_length, biped.leg(1).leg_length
        self.tree, self.feet = self._add_bodies(biped, slope)
        self.contacts = self._add_ground(biped, contact, lanes, compiled)
        self._add_hip(biped, slope)
        self.sensors = self._add_sensors(signals)
        self.mbs.Assemble()
        self._coordinates = self.mbs.systemData.GetODE2Coordinates  # to look it up takes longer than to answer

    def _add_bodies(self, biped: Biped, slope: Slope) -> tuple[Any, tuple[int, int]]:
        leg_joints = [JOINT.RevoluteZ, JOINT.PrismaticY] if self.compliant else [JOINT.RevoluteZ]
        joints = [JOINT.PrismaticX, JOINT.PrismaticY, *leg_joints, *leg_joints]
        count, size = len(joints), len(leg_joints)
        feet = 1 + size, 1 + 2 * size
        parents = [-1, 0, 1, 2, 1, 4] if self.compliant else [-1, 0, 1, 1]
        offset, centre, inertia = np.zeros((count, 3)), np.zeros((count, 3)), np.zeros((count, 3, 3))
        mass, spring, damper = np.zeros(count), np.zeros(count), np.zeros(count)
        mass[1] = biped.hip_mass
        self.disc_centres = []
        bodies: dict[int, PlanarBody | None] = {}
        for number, foot in enumerate(feet):
            leg = biped.leg(number)
            reach, below, above = leg.leg_length - leg.foot_radius, below_spring(leg), above_spring(leg)
            if self.compliant:  # the foot's frame sits at the disc's centre
                offset[foot, 1], spring[foot], damper[foot] = -reach, leg.stiffness, leg.damping
                self.disc_centres.append([0.0, 0.0, 0.0])
                bodies[foot], bodies[foot - 1] = below, above
            else:
                self.disc_centres.append([0.0, -reach, 0.0])
                below = below._replace(upward=below.upward - reach)
                bodies[foot] = joined(below, above)
            if number == 0:
                self.mass_centre = [below.forward, below.upward, 0.0]
        for link, body in bodies.items():
            if body is not None:
                mass[link], centre[link, :2], inertia[link, 2, 2] = body.mass, body[1:3], body.inertia
        nothing = np.zeros(count)
        self.node = self.mbs.AddNode(
            items.NodeGenericODE2(
                referenceCoordinates=nothing,
                initialCoordinates=nothing,
                initialCoordinates_t=nothing,
                numberOfODE2Coordinates=count,
            )
        )
        tree = items.ObjectKinematicTree(
            nodeNumber=self.node,
            jointTypes=joints,
            linkParents=parents,
            jointTransformations=exudyn.Matrix3DList([np.eye(3)] * count),
            jointOffsets=exudyn.Vector3DList(list(offset)),
            linkInertiasCOM=exudyn.Matrix3DList(list(inertia)),
            linkCOMs=exudyn.Vector3DList(list(centre)),
            linkMasses=mass,
            gravity=[*slope.gravity_vector, 0.0],
            jointPControlVector=spring,
            jointDControlVector=damper,
            jointPositionOffsetVector=nothing,  # must be given in full length with the control vectors
            jointVelocityOffsetVector=nothing,
        )
        return self.mbs.AddObject(tree), feet

    def _add_ground(self, biped: Biped, contact: ContactLaw, lanes: Lanes, compiled: bool) -> list[Any]:
        discs = [
            items.MarkerKinematicTreeRigid(objectNumber=self.tree, linkNumber=foot, localPosition=centre)
            for foot, centre in zip(self.feet, self.disc_centres, strict=True)
        ]
        self.laws, contacts = add_ground(self.mbs, contact, biped.foot_radii, discs, lanes, compiled=compiled)
        return contacts

    def _add_hip(self, biped: Biped, slope: Slope) -> None:
        first, other = 2, 2 + (2 if self.compliant else 1)
        add_hip(self.mbs, biped, slope, ((self.node, first), (self.node, other)))
        if biped.weighed_hip != biped.hip_mass:
            place = items.MarkerKinematicTreeRigid(objectNumber=self.tree, linkNumber=1, localPosition=[0.0, 0.0, 0.0])
            add_counterweight(self.mbs, biped, slope, self.mbs.AddMarker(place))

    def _add_sensors(self, signals: Collection[str]) -> dict[str, Any]:
        kept = {"storeInternal": True, "writeToFile": False}
        sensors = {
            name: items.SensorNode(nodeNumber=self.node, outputVariableType=kind, **kept)
            for name, kind in (
                ("position", OUTPUT.Coordinates),
                ("velocity", OUTPUT.Coordinates_t),
                ("acceleration", OUTPUT.Coordinates_tt),
            )
        }
        if IMU in signals:
            sensors["foot acceleration"] = items.SensorKinematicTree(
                objectNumber=self.tree,
                linkNumber=self.feet[0],
                localPosition=self.mass_centre,
                outputVariableType=OUTPUT.Acceleration,
                **kept,
            )
        for leg, contact in enumerate(self.contacts if GROUND_REACTION in signals else ()):
            sensors[f"ground {leg}"] = items.SensorObject(
                objectNumber=contact, outputVariableType=OUTPUT.ForceLocal, **kept
            )
        return {name: self.mbs.AddSensor(sensor) for name, sensor in sensors.items()}

    def set_in_play(self, leg: int, acts: bool) -> None:
        """Let the ground act on a leg's foot, or not."""
        self.mbs.SetObjectParameter(self.contacts[leg], "activeConnector", bool(acts))

    def start(self, state: PlanarState) -> None:
        """Make `state` the initial one."""
        natural = self.natural_length
        place: list[float] = [*state.hip_position]
        motion: list[float] = [*state.hip_velocity]
        for leg in (0, 1):
            place.append(state.leg_angle[leg])
            motion.append(state.leg_rate[leg])
            if self.compliant:
                place.append(natural[leg] - state.leg_length[leg])
                motion.append(-state.leg_length_rate[leg])
            self.set_in_play(leg, state.in_play[leg])
        initial = exudyn.ConfigurationType.Initial
        self.mbs.systemData.SetODE2Coordinates(place, configuration=initial)
        self.mbs.systemData.SetODE2Coordinates_t(motion, configuration=initial)

    def pose(self) -> Pose:
        """Hip x, hip y, leg angles, leg lengths at the current step."""
        natural = self.natural_length
        if self.compliant:
            x, y, first, slide, second, other_slide = self._coordinates().tolist()
            return x, y, (first, second), (natural[0] - slide, natural[1] - other_slide)
        x, y, first, second = self._coordinates().tolist()
        return x, y, (first, second), natural

    def leg_rate(self, leg: int) -> float:
        """Rate of a leg's angle at the current step [rad/s]."""
        return float(self.mbs.systemData.GetODE2Coordinates_t()[2 + leg * (2 if self.compliant else 1)])

    def recording(self) -> dict[str, np.ndarray]:
        """Signals of the last solver call, named as in `Trajectory`; the position of the legs in its column order."""
        rows = {
            name: np.asarray(self.mbs.GetSensorStoredData(sensor), dtype=float) for name, sensor in self.sensors.items()
        }
        count = len(rows["position"])
        foot = rows.get("foot acceleration", np.zeros((count, 0)))
        return {
            "time": rows["position"][:, 0],
            "position": self._columns(rows["position"][:, 1:], self.natural_length),
            "velocity": self._columns(rows["velocity"][:, 1:], (0.0, 0.0)),
            "acceleration": self._columns(rows["acceleration"][:, 1:], (0.0, 0.0)),
            "foot_acceleration": foot[:, 1:3],
            "ground_reaction": reactions(rows, count),
        }

    def _columns(self, coordinates: np.ndarray, natural: tuple[float, float]) -> np.ndarray:
        if self.compliant:
            return np.column_stack([coordinates[:, [0, 1, 2, 4]], natural - coordinates[:, [3, 5]]])
        return np.column_stack([coordinates, np.full((len(coordinates), 2), natural)])

    def joint_drift(self) -> float:
        """Largest violation of a joint [m]: none in minimal coordinates."""
        return 0.0
