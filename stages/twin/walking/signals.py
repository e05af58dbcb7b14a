"""Signals of the twin at given times: the planar projection every model reports, and what its sockets feel in space.

Sensor axes are those of the inner pair: forward, up the leg, lateral (along the hip axis, z of the slope frame when the
machine stands straight). A sensor measures acceleration minus gravity, and the angular velocity, on these axes.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np
from scipy.interpolate import PchipInterpolator

from stages.biped.between_steps import largest
from stages.biped.walk import Walk
from stages.planar.signals import GROUND_REACTION, IMU
from stages.twin.machine.contact import HINGE, PITCH, ROLL, SLIDE, YAW, Y, Z, along, point_law
from stages.twin.machine.kinematics import Axes, pair_axes, point_motion
from stages.twin.parameters import ATTITUDE, COORDINATES, FOOT_FORCE, IMU_IN_SPACE, Settings
from stages.twin.result import Signals
from stages.twin.walking.record import Record, find_events

#: Legs of each pair, and their slides among `SLIDE`.
PAIRS = (slice(0, 2), slice(2, 4))
COLUMNS = np.array(SLIDE)


@dataclass(frozen=True)
class Sampling:
    """A record between its solver's steps, at times of one's own (n,) [s].

    Motion by Hermite interpolation. Accelerations and forces, which have kinks, are computed at the solver's steps and
    interpolated by monotone cubics, so that no force becomes negative in between.
    """

    record: Record
    time: np.ndarray

    @cached_property
    def motion(self) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates and rates, each (n, 11)."""
        return self.record.at(self.time)

    @cached_property
    def inner_axes(self) -> Axes:
        """Axes of the inner pair at the solver's steps."""
        return pair_axes(*self.record.steps, 0)

    def between(self, values: np.ndarray) -> np.ndarray:
        """Values at the solver's steps, brought to the times."""
        return np.asarray(PchipInterpolator(self.record.time, values)(self.time))

    def specific_force(self, place: np.ndarray, slide: int | None = None) -> np.ndarray:
        """Acceleration minus gravity [m/s^2] of a point of the inner frame, or of the foot with this slide, (n, 3)."""
        gravity = np.array([*self.record.slope.gravity_vector, 0.0])
        acceleration = point_motion(*self.record.steps, self.inner_axes, place, slide).acceleration
        return self.between(self.inner_axes.components(acceleration - gravity))

    def spin(self) -> np.ndarray:
        """Angular velocity [rad/s] of the inner pair on its own axes, (n, 3)."""
        q, v = self.motion
        axes = pair_axes(q, v, np.zeros_like(q), 0)
        return axes.components(axes.spin)

    def foot_force(self) -> np.ndarray:
        """Force of the ground on each foot [N], (n, 4, 3)."""
        return self.between(foot_forces(self.record, self.record.time, *self.record.steps[:2]))


def foot_forces(record: Record, time: np.ndarray, q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Force of the ground on each foot [N] by the contact law, (n, 4, 3), from the motion at times (n,) [s]."""
    return np.asarray(along(q, v, record.ground(time), record.machine.feet, point_law(record.contact))[0])


def peak_force(record: Record) -> float:
    """Largest normal force on a pair of feet [N], between the solver's steps too."""

    def normal(time: np.ndarray, pair: slice) -> np.ndarray:
        return np.asarray(foot_forces(record, time, *record.at(time))[:, pair, Y].sum(axis=1))

    return max(largest(record.time, normal(record.time, pair), partial(normal, pair=pair))[1] for pair in PAIRS)


def sample(record: Record, time: np.ndarray, settings: Settings) -> Signals:
    """Sample the motion and the settings' signals of a record at `time` (n,) [s].

    What the settings do not name has no rows, and is not computed either.
    """
    at, wanted = Sampling(record, time), set(settings.signals)
    q, _ = at.motion
    feet = at.foot_force() if wanted & {GROUND_REACTION, FOOT_FORCE} else np.zeros((0, 4, 3))
    hip = foot = spin = np.zeros((0, 3))
    if IMU_IN_SPACE in wanted:
        hip, spin = at.specific_force(np.array(settings.hip_socket)), at.spin()
        socket = settings.foot_sensor(record.machine.drawn_foot_com)
        foot = at.specific_force(np.array(socket), SLIDE[0] if socket[2] > 0.0 else SLIDE[1])
    attitude = q if ATTITUDE in wanted else q[:0]
    return Signals(
        walk=planar_walk(at, feet if GROUND_REACTION in wanted else feet[:0], IMU in wanted),
        hip_imu_specific_force=hip,
        hip_imu_angular_velocity=spin,
        foot_imu_specific_force=foot,
        foot_imu_angular_velocity=spin,
        roll=attitude[:, ROLL].copy(),
        yaw=attitude[:, YAW].copy(),
        lateral=attitude[:, Z].copy(),
        coordinates=q if COORDINATES in wanted else q[:0],
        foot_force=feet if FOOT_FORCE in wanted else feet[:0],
    )


def planar_walk(at: Sampling, foot_force: np.ndarray, sensed: bool) -> Walk:
    """The planar projection: each pair of feet as one, what is felt (if it is) at the hip and at the feet's middle."""
    (q, v), machine = at.motion, at.record.machine
    events = find_events(at.record)
    hip, foot, turning = np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0)
    if sensed:
        centre = np.array([0.0, machine.drawn_foot_com, 0.0])  # the legs' mid-plane, as in the simple models
        hip, turning = at.specific_force(np.zeros(3)), at.spin()[:, 2]
        foot = np.mean([at.specific_force(centre, slide) for slide in SLIDE[:2]], axis=0)
    return Walk(
        time=at.time,
        hip_position=q[:, :2].copy(),
        hip_velocity=v[:, :2].copy(),
        leg_angle=np.column_stack([q[:, PITCH], q[:, PITCH] + q[:, HINGE]]),
        leg_rate=np.column_stack([v[:, PITCH], v[:, PITCH] + v[:, HINGE]]),
        leg_length=np.column_stack([machine.length[pair].mean() - q[:, COLUMNS[pair]].mean(axis=1) for pair in PAIRS]),
        leg_length_rate=np.column_stack([-v[:, COLUMNS[pair]].mean(axis=1) for pair in PAIRS]),
        ground_reaction=np.stack([foot_force[:, pair, :2].sum(axis=1) for pair in PAIRS], axis=1),
        hip_specific_force=hip[:, :2],
        hip_angular_velocity=turning.copy(),
        foot_specific_force=foot[:, :2],
        foot_angular_velocity=turning.copy(),
        heel_strike_time=events.heel_strike_time,
        heel_strike_leg=events.heel_strike_leg,
        toe_off_time=events.toe_off_time,
        toe_off_leg=events.toe_off_leg,
    )
