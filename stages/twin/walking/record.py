"""What the solver left behind, its values between the steps, and the heel strikes and toe-offs in it.

Points fixed to the twin's bodies move as the coordinates of its tree do. Axes of a pair of legs: forward, up the leg,
along the hip axis; all in the slope frame. Shapes are (n, 3).

Signals of the twin at given times: the planar projection every model reports, and what its sockets measure in space.

Sensor axes are those of the inner pair: forward, up the leg, lateral (along the hip axis, z of the slope frame when the
machine stands straight). A sensor measures acceleration minus gravity, and the angular velocity, on these axes.
"""

from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np
from scipy.interpolate import PchipInterpolator

from stages.biped.between_steps import largest
from stages.biped.kinematics import Motion
from stages.biped.walk import Walk
from stages.ground.contact_law import ContactLaw
from stages.ground.slope import Slope
from stages.planar.run import COMPLETED, Recorded
from stages.planar.sampling import Events, located
from stages.planar.signals import GROUND_REACTION, IMU
from stages.twin.machine.contact import (
    HINGE,
    PITCH,
    ROLL,
    SLIDE,
    YAW,
    Y,
    Z,
    along,
    clearances,
    clearances_along,
    point_law,
)
from stages.twin.machine.machine import Machine
from stages.twin.parameters import ATTITUDE, COORDINATES, FOOT_FORCE, IMU_IN_SPACE, Settings
from stages.twin.result import Signals, Snapshots


@dataclass(frozen=True)
class Axes:
    """Axes of a pair of legs and how they turn: angular velocity [rad/s] and acceleration [rad/s^2]."""

    forward: np.ndarray
    upward: np.ndarray
    lateral: np.ndarray
    spin: np.ndarray
    spin_rate: np.ndarray

    def components(self, vector: np.ndarray) -> np.ndarray:
        """Components (n, 3) of a vector on these axes: forward, upward, lateral."""
        axes = (self.forward, self.upward, self.lateral)
        return np.column_stack([np.einsum("ij,ij->i", vector, axis) for axis in axes])


def pair_axes(q: np.ndarray, v: np.ndarray, a: np.ndarray, pair: int) -> Axes:
    """Axes of the inner (0) or outer (1) pair from coordinates, rates and accelerations (n, 11)."""
    sy, cy, sr, cr = np.sin(q[:, YAW]), np.cos(q[:, YAW]), np.sin(q[:, ROLL]), np.cos(q[:, ROLL])
    zero = np.zeros(len(q))
    level = np.column_stack([cy, zero, -sy])
    upright = np.column_stack([sr * sy, cr, sr * cy])
    lateral = np.column_stack([cr * sy, -sr, cr * cy])
    angle, rate, rate_rate = (column[:, PITCH] + (column[:, HINGE] if pair else 0.0) for column in (q, v, a))
    sine, cosine = np.sin(angle)[:, None], np.cos(angle)[:, None]
    yawing, rolling = v[:, YAW, None] * [[0.0, 1.0, 0.0]], v[:, ROLL, None] * level
    spin = yawing + rolling + rate[:, None] * lateral
    spin_rate = (
        a[:, YAW, None] * [[0.0, 1.0, 0.0]]
        + a[:, ROLL, None] * level
        + rate_rate[:, None] * lateral
        + np.cross(yawing, rolling)
        + np.cross(yawing + rolling, rate[:, None] * lateral)
    )
    return Axes(cosine * level + sine * upright, cosine * upright - sine * level, lateral, spin, spin_rate)


def point_motion(
    q: np.ndarray, v: np.ndarray, a: np.ndarray, axes: Axes, place: np.ndarray, slide: int | None = None
) -> Motion:
    """Motion (n, 3) of a point given by its place (3,) in the drawing, on a frame or on the foot with this slide."""
    zero = np.zeros(len(q))
    moved, speed, pull = (zero, zero, zero) if slide is None else (q[:, slide], v[:, slide], a[:, slide])
    arm = place[0] * axes.forward + (place[1] + moved)[:, None] * axes.upward + place[2] * axes.lateral
    sliding = speed[:, None] * axes.upward
    turning = np.cross(axes.spin, arm)
    acceleration = (
        a[:, :3]
        + np.cross(axes.spin_rate, arm)
        + np.cross(axes.spin, turning)
        + 2.0 * np.cross(axes.spin, sliding)
        + pull[:, None] * axes.upward
    )
    return Motion(q[:, :3] + arm, v[:, :3] + turning + sliding, acceleration)


@dataclass(frozen=True)
class Record(Recorded):
    """A machine's run on its ground: coordinates, rates and accelerations (n, 11) are those of `SpatialTree`.

    `outcome` and `reason` show how it ended; `evaluations` of the rates count rejected steps too.
    """

    machine: Machine
    slope: Slope
    contact: ContactLaw
    outcome: str
    reason: str
    heel_strikes: int
    evaluations: int

    @property
    def completed(self) -> bool:
        """Whether it walked as many steps as were requested."""
        return self.outcome == COMPLETED

    @property
    def steps(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Coordinates, rates and accelerations at the solver's steps, each (n, 11)."""
        return self.position, self.velocity, self.acceleration

    def ground(self, time: np.ndarray) -> np.ndarray:
        """1 where the ground acts on a pair, else 0, and its heights under the pairs [m], (n, 4)."""
        return np.hstack([self.in_play(time), self.under(time)])


def snapshots(record: Record, times: np.ndarray) -> Snapshots:
    """Poses at given times [s]."""
    machine = record.machine
    q, v = record.at(times)
    none = np.zeros_like(q)
    axes = [pair_axes(q, v, none, pair) for pair in (0, 1)]
    tops, ups, centres = [], [], []
    for leg, slide in enumerate(SLIDE):
        pair, lane = axes[leg // 2], machine.lane[leg]
        low = np.array([0.0, machine.radius[leg] - machine.length[leg], lane])
        tops.append(point_motion(q, v, none, pair, np.array([0.0, 0.0, lane])).position)
        centres.append(point_motion(q, v, none, pair, low, slide).position)
        ups.append(pair.upward)
    return Snapshots(
        time=times,
        hip=q[:, :3].copy(),
        hip_axis=axes[0].lateral,
        leg_top=np.stack(tops, axis=1),
        leg_up=np.stack(ups, axis=1),
        foot_centre=np.stack(centres, axis=1),
        foot_radius=machine.radius.copy(),
        foot_width=2.0 * machine.half_width,
    )


def find_events(record: Record) -> Events:
    """First touch-down and last lift-off of each pair's lowest point while the ground acts on the pair.

    A pair that bounces at heel strike counts once. A pair still on the ground at the end has no toe-off yet.
    """
    feet = record.machine.feet

    def depth_at(position: np.ndarray, velocity: np.ndarray, leg: int) -> float:
        return -float(clearances(position, feet)[0][leg])

    return located(record, -clearances_along(record.position, feet), depth_at, within=1e-14)


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
    """The planar projection: each pair of feet as one, what is sensed (if so) at the hip and at the feet's middle."""
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
