"""The biped as bodies and joints, as the paper builds it: a hip and two feet, hinged and sliding, for implicit solvers.

Each leg is one `ObjectJointPrismatic2D` without its rotational constraint: the hip point stays on the foot's axis and
the foot turns about it freely, a revolute and a prismatic joint in series without the massless body between them.
With rigid legs it is a revolute joint. A frame is a body of its own between the two, hinged to the hip, on which the
foot slides without turning.
"""

import math
from collections.abc import Collection
from typing import Any

import numpy as np

from stages.biped.design import BeyondModel, Leg
from stages.ground.slope import Slope
from stages.multibody.assembly.planar import Planar, PlanarBody, Pose, above_spring, reactions
from stages.multibody.assembly.system import COORDINATES, items
from stages.planar.run import PlanarState
from stages.planar.signals import IMU

IDLE_INERTIA = 1e-3


class Joints(Planar):
    """Assembled system.

    Coordinates: x, y, angle of the hip, then of each foot, then of each frame, at the mass centres. The hip's angle is
    idle: the joint wants a body with an orientation, but no moment acts on it and it stays zero. `drift` is the largest
    distance of the hip from a foot's axis (rigid legs: from the leg's end). Raises BeyondModel for frames on rigid
    legs.
    """

    exact_acceleration = False

    def add_bodies(self, slope: Slope, signals: Collection[str]) -> None:
        """Hip and feet hanging under it; the reference configuration has both legs upright at the natural length."""
        mbs = self.mbs
        self.frames = {leg: body for leg in (0, 1) if (body := above_spring(self.legs[leg])) is not None}
        if self.frames and self.biped.legs == "rigid":
            raise BeyondModel("multibody.assembly = joints has no frames on rigid legs; multibody.assembly = tree has")
        hung = [PlanarBody(self.biped.hip_mass, 0.0, 0.0, IDLE_INERTIA)]
        hung += [PlanarBody(leg.foot_mass, leg.foot_offset, leg.foot_com - leg.leg_length, leg.leg_inertia)
                 for leg in self.legs]  # fmt: skip
        nodes, bodies = [], []
        for part in [*hung, *self.frames.values()]:
            node = mbs.AddNode(items.NodeRigidBody2D(referenceCoordinates=[part.forward, part.upward, 0.0]))
            nodes.append(node)
            bodies.append(mbs.AddObject(items.ObjectRigidBody2D(mass=part.mass, inertia=part.inertia, nodeNumber=node)))
        for body in bodies:
            marker = mbs.AddMarker(items.MarkerBodyMass(bodyNumber=body))
            mbs.AddLoad(items.LoadMassProportional(markerNumber=marker, loadVector=[*slope.gravity_vector, 0.0]))
        frames = dict(zip(self.frames, bodies[3:], strict=True))
        for number, foot in enumerate(bodies[1:3]):
            self._add_leg(self.legs[number], bodies[0], foot, frames.get(number))
        self.discs = [
            self._marker(foot, 0.0 - leg.foot_offset, leg.foot_radius - leg.foot_com)
            for leg, foot in zip(self.legs, bodies[1:3], strict=True)
        ]
        self.angles, self.hip = ((nodes[1], 2), (nodes[2], 2)), items.MarkerBodyPosition(bodyNumber=bodies[0])
        for name, kind in COORDINATES if IMU in signals else COORDINATES[:2]:  # nothing else needs accelerations
            for index, node in enumerate(nodes[:3]):
                self.keep(f"{name} {index}", items.SensorNode, nodeNumber=node, outputVariableType=kind)

    def _add_leg(self, leg: Leg, hip_body: Any, foot: Any, frame: Any) -> None:
        mbs = self.mbs
        above, aside = leg.leg_length - leg.foot_com, 0.0 - leg.foot_offset
        hip = mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=hip_body))
        if self.biped.legs == "rigid":
            end = mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=foot, localPosition=[aside, above, 0.0]))
            mbs.AddObject(items.ObjectJointRevolute2D(markerNumbers=[hip, end]))
            return
        top = hip
        if frame is not None:  # hung on the hip by its upper end
            top = mbs.AddMarker(self._marker(frame, 0.0 - leg.frame_offset, leg.frame_com))
            mbs.AddObject(items.ObjectJointRevolute2D(markerNumbers=[hip, top]))
        # The foot must be marker 1: its normal turns with it. The other way round is accepted and wrong.
        axis = mbs.AddMarker(self._marker(foot, aside, 0.0))
        mbs.AddObject(items.ObjectJointPrismatic2D(
            markerNumbers=[top, axis], axisMarker0=[0.0, 1.0, 0.0], normalMarker1=[1.0, 0.0, 0.0],
            constrainRotation=frame is not None))  # fmt: skip
        centre = mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=foot, localPosition=[aside, 0.0, 0.0]))
        mbs.AddObject(items.ObjectConnectorSpringDamper(
            markerNumbers=[hip, centre], referenceLength=above, stiffness=leg.stiffness,
            damping=leg.damping))  # fmt: skip

    def _marker(self, body: Any, across: float, along: float) -> Any:
        """A marker of a body at a place from its mass centre [m]."""
        return items.MarkerBodyRigid(bodyNumber=body, localPosition=[across, along, 0.0])

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
        self.begin(place, motion)

    def pose(self) -> Pose:
        """Hip x, hip y, leg angles, leg lengths at the current step."""
        place = self.coordinates().tolist()
        length, other = (self._arm(place, leg, math.sin, math.cos)[1] + self.legs[leg].foot_com for leg in (0, 1))
        return place[0], place[1], (place[5], place[8]), (length, other)

    def leg_rate(self, leg: int) -> float:
        """Rate of a leg's angle at the current step [rad/s]."""
        return float(self.rates()[5 + 3 * leg])

    def recording(self) -> dict[str, np.ndarray]:
        """Signals of the last solver call, named as in `Trajectory`."""
        rows = self.kept()
        count, none = len(rows["position 0"]), np.zeros((len(rows["position 0"]), 4))
        place, motion, change = (
            np.column_stack([rows.get(f"{name} {index}", none)[:, 1:] for index in range(3)]) for name, _ in COORDINATES
        )
        arms = [self._arm(place.T, leg) for leg in (0, 1)]
        lengths = [along + leg.foot_com for (_, along), leg in zip(arms, self.legs, strict=True)]
        rates = []
        for foot, (across, _) in zip((3, 6), arms, strict=True):
            dx, dy = motion[:, 0] - motion[:, foot], motion[:, 1] - motion[:, foot + 1]
            sine, cosine = np.sin(place[:, foot + 2]), np.cos(place[:, foot + 2])
            rates.append(dy * cosine - dx * sine - across * motion[:, foot + 2])
        errors = [across + leg.foot_offset for (across, _), leg in zip(arms, self.legs, strict=True)]
        if self.biped.legs == "rigid":
            errors += [along - (leg.leg_length - leg.foot_com) for (_, along), leg in zip(arms, self.legs, strict=True)]
        self.drift = float(np.max(np.abs(errors)))
        return {
            "time": rows["position 0"][:, 0],
            "position": np.column_stack([place[:, [0, 1, 5, 8]], *lengths]),
            "velocity": np.column_stack([motion[:, [0, 1, 5, 8]], *rates]),
            "acceleration": np.column_stack([change[:, :2], change[:, [5, 8]], np.full((count, 2), np.nan)]),
            "foot_acceleration": change[:, 3:5] if "acceleration 0" in rows else np.zeros((count, 0)),
            "ground_reaction": reactions(rows, count),
        }

    def _arm(self, place: Any, leg: int, sin: Any = np.sin, cos: Any = np.cos) -> tuple[Any, Any]:
        """From a foot's mass centre to the hip, across and along the leg [m], by the coordinates, numbers or rows."""
        foot, design = 3 + 3 * leg, self.legs[leg]
        aside, below = design.foot_offset, design.foot_com - design.leg_length
        dx, dy = place[0] - place[foot] - aside, place[1] - place[foot + 1] - below
        sine, cosine = sin(place[foot + 2]), cos(place[foot + 2])
        return dx * cosine + dy * sine, dy * cosine - dx * sine
