"""The biped as bodies and joints, as the paper builds it: a hip and two feet, hinged and sliding, for implicit solvers.

Each leg is one `ObjectJointPrismatic2D` without its rotational constraint: the hip point stays on the foot's axis and
the foot turns about it freely, a revolute and a prismatic joint in series without the massless body between them.
With rigid legs it is a revolute joint. A frame is a body of its own between the two, hinged to the hip, on which the
foot slides without turning.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from typing import Any

import numpy as np

from stages.biped.design import BeyondModel, Biped, Leg
from stages.ground.contact_law import ContactLaw
from stages.ground.slope import Slope
from stages.multibody.assembly.contact import Lanes, add_ground, reactions
from stages.multibody.assembly.leg_bodies import PlanarBody, above_spring, add_counterweight, add_hip
from stages.multibody.assembly.quiet_exudyn import exudyn, items
from stages.multibody.walking.scuffing import Pose
from stages.planar.signals import GROUND_REACTION, IMU, SIGNALS
from stages.planar.state import PlanarState

OUTPUT = exudyn.OutputVariableType
IDLE_INERTIA = 1e-3
COORDINATES = (
    ("position", OUTPUT.Coordinates),
    ("velocity", OUTPUT.Coordinates_t),
    ("acceleration", OUTPUT.Coordinates_tt),
)


class Joints:
    """Assembled system; see `stages.multibody.assembly.solver.Assembly`.

    Coordinates: x, y, angle of the hip, then of each foot, then of each frame, at the mass centres. The hip's angle is
    idle: the joint wants a body with an orientation, but no moment acts on it and it stays zero. Raises BeyondModel for
    frames on rigid legs.
    """

    exact_acceleration = False

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
        self.biped = biped
        self.legs = biped.leg(0), biped.leg(1)
        self.frames = {leg: body for leg in (0, 1) if (body := above_spring(self.legs[leg])) is not None}
        if self.frames and biped.legs == "rigid":
            raise BeyondModel("multibody.assembly = joints has no frames on rigid legs; multibody.assembly = tree has")
        self.bodies = self._add_bodies(slope)
        self._add_legs()
        self._add_hip(slope)
        self.contacts = self._add_ground(contact, lanes, compiled)
        self.sensors = self._add_sensors(signals)
        self.mbs.Assemble()

    def _add_bodies(self, slope: Slope) -> list[Any]:
        """Hip and feet hanging under it; the reference configuration has both legs upright at the natural length."""
        mbs, biped = self.mbs, self.biped
        hung = [PlanarBody(biped.hip_mass, 0.0, 0.0, IDLE_INERTIA)]
        hung += [PlanarBody(leg.foot_mass, leg.foot_offset, leg.foot_com - leg.leg_length, leg.leg_inertia)
                 for leg in self.legs]  # fmt: skip
        self.nodes, bodies = [], []
        for part in [*hung, *self.frames.values()]:
            node = mbs.AddNode(items.NodeRigidBody2D(referenceCoordinates=[part.forward, part.upward, 0.0]))
            self.nodes.append(node)
            bodies.append(mbs.AddObject(items.ObjectRigidBody2D(mass=part.mass, inertia=part.inertia, nodeNumber=node)))
        for body in bodies:
            marker = mbs.AddMarker(items.MarkerBodyMass(bodyNumber=body))
            mbs.AddLoad(items.LoadMassProportional(markerNumber=marker, loadVector=[*slope.gravity_vector, 0.0]))
        return bodies

    def _add_legs(self) -> None:
        mbs, rigid = self.mbs, self.biped.legs == "rigid"
        self.joints = []
        frames = dict(zip(self.frames, self.bodies[3:], strict=True))
        for number, (leg, foot) in enumerate(zip(self.legs, self.bodies[1:3], strict=True)):
            above, aside = leg.leg_length - leg.foot_com, 0.0 - leg.foot_offset
            hip = mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=self.bodies[0]))
            if rigid:
                end = mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=foot, localPosition=[aside, above, 0.0]))
                self.joints.append(mbs.AddObject(items.ObjectJointRevolute2D(markerNumbers=[hip, end])))
                continue
            top = self._hinge(hip, frames[number], leg) if number in frames else hip
            # The foot must be marker 1: its normal turns with it. The other way round is accepted and wrong.
            axis = mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=foot, localPosition=[aside, 0.0, 0.0]))
            self.joints.append(
                mbs.AddObject(
                    items.ObjectJointPrismatic2D(
                        markerNumbers=[top, axis],
                        axisMarker0=[0.0, 1.0, 0.0],
                        normalMarker1=[1.0, 0.0, 0.0],
                        constrainRotation=number in frames,
                    )
                )
            )
            centre = mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=foot, localPosition=[aside, 0.0, 0.0]))
            mbs.AddObject(
                items.ObjectConnectorSpringDamper(
                    markerNumbers=[hip, centre],
                    referenceLength=above,
                    stiffness=leg.stiffness,
                    damping=leg.damping,
                )
            )

    def _hinge(self, hip: Any, frame: Any, leg: Leg) -> Any:
        """Hang a frame on the hip: a marker at its upper end."""
        upper = [0.0 - leg.frame_offset, leg.frame_com, 0.0]
        top = self.mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=frame, localPosition=upper))
        self.joints.append(self.mbs.AddObject(items.ObjectJointRevolute2D(markerNumbers=[hip, top])))
        return top

    def _add_hip(self, slope: Slope) -> None:
        add_hip(self.mbs, self.biped, slope, ((self.nodes[1], 2), (self.nodes[2], 2)))
        if self.biped.weighed_hip != self.biped.hip_mass:
            hip = self.mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=self.bodies[0]))
            add_counterweight(self.mbs, self.biped, slope, hip)

    def _add_ground(self, contact: ContactLaw, lanes: Lanes, compiled: bool) -> list[Any]:
        discs = [
            items.MarkerBodyRigid(
                bodyNumber=foot, localPosition=[0.0 - leg.foot_offset, leg.foot_radius - leg.foot_com, 0.0]
            )
            for leg, foot in zip(self.legs, self.bodies[1:3], strict=True)
        ]
        self.laws, contacts = add_ground(self.mbs, contact, self.biped.foot_radii, discs, lanes, compiled=compiled)
        return contacts

    def _add_sensors(self, signals: Collection[str]) -> dict[str, Any]:
        kept = {"storeInternal": True, "writeToFile": False}
        sensors: dict[str, Any] = {}
        for name, kind in COORDINATES if IMU in signals else COORDINATES[:2]:  # nothing else needs accelerations
            for index, node in enumerate(self.nodes[:3]):
                sensors[f"{name} {index}"] = items.SensorNode(nodeNumber=node, outputVariableType=kind, **kept)
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
        place, motion = [*state.hip_position, 0.0], [*state.hip_velocity, 0.0]
        hung = [
            (number, leg.foot_offset, state.leg_length[number] - leg.foot_com, state.leg_length_rate[number],
             leg.foot_com - leg.leg_length) for number, leg in enumerate(self.legs)
        ]  # fmt: skip
        hung += [(number, frame.forward, -frame.upward, 0.0, frame.upward) for number, frame in self.frames.items()]
        for number, aside, arm, arm_rate, upward in hung:
            angle, rate = state.leg_angle[number], state.leg_rate[number]
            sine, cosine = np.sin(angle), np.cos(angle)
            x = state.hip_position[0] + arm * sine + aside * cosine
            y = state.hip_position[1] - arm * cosine + aside * sine
            place += [x - aside, y - upward, angle]  # from where it hangs in the reference configuration
            motion += [
                state.hip_velocity[0] + arm_rate * sine + arm * rate * cosine - aside * rate * sine,
                state.hip_velocity[1] - arm_rate * cosine + arm * rate * sine + aside * rate * cosine,
                rate,
            ]
        for number in (0, 1):
            self.set_in_play(number, state.in_play[number])
        initial = exudyn.ConfigurationType.Initial
        self.mbs.systemData.SetODE2Coordinates(place, configuration=initial)
        self.mbs.systemData.SetODE2Coordinates_t(motion, configuration=initial)

    def pose(self) -> Pose:
        """Hip x, hip y, leg angles, leg lengths at the current step."""
        place = self.mbs.systemData.GetODE2Coordinates().tolist()
        length, other = (self._arm(place, leg, math.sin, math.cos)[1] + self.legs[leg].foot_com for leg in (0, 1))
        return place[0], place[1], (place[5], place[8]), (length, other)

    def leg_rate(self, leg: int) -> float:
        """Rate of a leg's angle at the current step [rad/s]."""
        return float(self.mbs.systemData.GetODE2Coordinates_t()[5 + 3 * leg])

    def recording(self) -> dict[str, np.ndarray]:
        """Signals of the last solver call, named as in `Trajectory`."""
        rows = {
            name: np.asarray(self.mbs.GetSensorStoredData(sensor), dtype=float) for name, sensor in self.sensors.items()
        }
        count, none = len(rows["position 0"]), np.zeros((len(rows["position 0"]), 4))
        place, motion, change = (
            np.column_stack([rows.get(f"{name} {index}", none)[:, 1:] for index in range(3)]) for name, _ in COORDINATES
        )
        felt = "acceleration 0" in rows
        self._drift = self._slide_error(place)
        return {
            "time": rows["position 0"][:, 0],
            "position": self._place(place),
            "velocity": self._motion(place, motion),
            "acceleration": np.column_stack([change[:, :2], change[:, [5, 8]], np.full((count, 2), np.nan)]),
            "foot_acceleration": change[:, 3:5] if felt else np.zeros((count, 0)),
            "ground_reaction": reactions(rows, count),
        }

    def joint_drift(self) -> float:
        """Largest distance of the hip from a foot's axis (rigid legs: from the leg's end) in the last call [m]."""
        return self._drift

    def _arm(self, place: Any, leg: int, sin: Any = np.sin, cos: Any = np.cos) -> tuple[Any, Any]:
        """From a foot's mass centre to the hip, across and along the leg [m], by the coordinates, numbers or rows."""
        foot, design = 3 + 3 * leg, self.legs[leg]
        aside, below = design.foot_offset, design.foot_com - design.leg_length
        dx, dy = place[0] - place[foot] - aside, place[1] - place[foot + 1] - below
        sine, cosine = sin(place[foot + 2]), cos(place[foot + 2])
        return dx * cosine + dy * sine, dy * cosine - dx * sine

    def _place(self, place: np.ndarray) -> np.ndarray:
        lengths = [self._arm(place.T, leg)[1] + self.legs[leg].foot_com for leg in (0, 1)]
        return np.column_stack([place[:, [0, 1, 5, 8]], *lengths])

    def _motion(self, place: np.ndarray, motion: np.ndarray) -> np.ndarray:
        rates = []
        for leg in (0, 1):
            foot = 3 + 3 * leg
            across = self._arm(place.T, leg)[0]
            dx, dy = motion[:, 0] - motion[:, foot], motion[:, 1] - motion[:, foot + 1]
            sine, cosine = np.sin(place[:, foot + 2]), np.cos(place[:, foot + 2])
            rates.append(dy * cosine - dx * sine - across * motion[:, foot + 2])
        return np.column_stack([motion[:, [0, 1, 5, 8]], *rates])

    def _slide_error(self, place: np.ndarray) -> float:
        arms = [self._arm(place.T, leg) for leg in (0, 1)]
        error = max(np.abs(across + leg.foot_offset).max() for (across, _), leg in zip(arms, self.legs, strict=True))
        if self.biped.legs == "rigid":
            ends = zip(arms, self.legs, strict=True)
            error = max(error, *(np.abs(along - (leg.leg_length - leg.foot_com)).max() for (_, along), leg in ends))
        return float(error)
