"""The biped in minimal coordinates: an Exudyn kinematic tree, without constraints, for explicit solvers.

Links: slide x, slide y (carries the hip mass), and for each leg a revolute joint, which carries the frame if there is
one, and a slide along the leg that carries the foot. With rigid legs the foot is part of the revolute joint's link.
"""

from collections.abc import Collection

import numpy as np

from stages.ground.slope import Slope
from stages.multibody.assembly.planar import Planar, PlanarBody, Pose, above_spring, below_spring, joined, reactions
from stages.multibody.assembly.system import OUTPUT, exudyn, items
from stages.planar.run import PlanarState
from stages.planar.signals import IMU

JOINT = exudyn.JointType


class Tree(Planar):
    """Assembled system."""

    def add_bodies(self, slope: Slope, signals: Collection[str]) -> None:
        """Add the tree."""
        self.compliant = self.biped.legs == "compliant"
        self.natural_length = self.legs[0].leg_length, self.legs[1].leg_length
        leg_joints = [JOINT.RevoluteZ, JOINT.PrismaticY] if self.compliant else [JOINT.RevoluteZ]
        joints = [JOINT.PrismaticX, JOINT.PrismaticY, *leg_joints, *leg_joints]
        self.turning = 2, 2 + len(leg_joints)
        feet = [number + len(leg_joints) - 1 for number in self.turning]
        parents = [-1, 0, 1, 2, 1, 4] if self.compliant else [-1, 0, 1, 1]
        offset, spring, damper = np.zeros((len(joints), 3)), np.zeros(len(joints)), np.zeros(len(joints))
        links: dict[int, PlanarBody | None] = {1: PlanarBody(self.biped.hip_mass, 0.0, 0.0, 0.0)}
        centres, discs = [], []
        for leg, foot in zip(self.legs, feet, strict=True):
            reach, below, above = leg.leg_length - leg.foot_radius, below_spring(leg), above_spring(leg)
            if self.compliant:  # the foot's frame sits at the disc's centre
                offset[foot, 1], spring[foot], damper[foot] = -reach, leg.stiffness, leg.damping
                links[foot], links[foot - 1] = below, above
                reach = 0.0
            else:
                below = below._replace(upward=below.upward - reach)
                links[foot] = joined(below, above)
            centres.append([below.forward, below.upward, 0.0])
            discs.append((foot, [0.0, -reach, 0.0]))
        bodies = {
            link: (body.mass, (body.forward, body.upward, 0.0), np.diag([0.0, 0.0, body.inertia]))
            for link, body in links.items() if body is not None
        }  # fmt: skip
        self.add_tree(slope, joints, parents, bodies, offset, spring, damper)
        self.angles = (self.node, self.turning[0]), (self.node, self.turning[1])
        self.hip, *self.discs = (
            items.MarkerKinematicTreeRigid(objectNumber=self.tree, linkNumber=link, localPosition=place)
            for link, place in ((1, [0.0, 0.0, 0.0]), *discs)
        )
        if IMU in signals:
            self.keep("foot acceleration", items.SensorKinematicTree, objectNumber=self.tree, linkNumber=feet[0],
                      localPosition=centres[0], outputVariableType=OUTPUT.Acceleration)  # fmt: skip

    def start(self, state: PlanarState) -> None:
        """Make `state` the initial one."""
        place, motion = [*state.hip_position], [*state.hip_velocity]
        for leg in (0, 1):
            place.append(state.leg_angle[leg])
            motion.append(state.leg_rate[leg])
            if self.compliant:
                place.append(self.natural_length[leg] - state.leg_length[leg])
                motion.append(-state.leg_length_rate[leg])
            self.set_in_play(leg, state.in_play[leg])
        self.begin(place, motion)

    def pose(self) -> Pose:
        """Hip x, hip y, leg angles, leg lengths at the current step."""
        natural = self.natural_length
        if self.compliant:
            x, y, first, slide, second, other_slide = self.coordinates().tolist()
            return x, y, (first, second), (natural[0] - slide, natural[1] - other_slide)
        x, y, first, second = self.coordinates().tolist()
        return x, y, (first, second), natural

    def leg_rate(self, leg: int) -> float:
        """Rate of a leg's angle at the current step [rad/s]."""
        return float(self.rates()[self.turning[leg]])

    def recording(self) -> dict[str, np.ndarray]:
        """Signals of the last solver call, named as in `Trajectory`; the position of the legs in its column order."""
        rows = self.kept()
        count = len(rows["position"])
        foot = rows.get("foot acceleration", np.zeros((count, 0)))
        return {
            "time": rows["position"][:, 0],
            "position": self._columns(rows["position"], self.natural_length),
            "velocity": self._columns(rows["velocity"], (0.0, 0.0)),
            "acceleration": self._columns(rows["acceleration"], (0.0, 0.0)),
            "foot_acceleration": foot[:, 1:3],
            "ground_reaction": reactions(rows, count),
        }

    def _columns(self, rows: np.ndarray, natural: tuple[float, float]) -> np.ndarray:
        if self.compliant:
            return np.column_stack([rows[:, [1, 2, 3, 5]], natural - rows[:, [4, 6]]])
        return np.column_stack([rows[:, 1:], np.full((len(rows), 2), natural)])
