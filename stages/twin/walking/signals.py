"""Signals of the twin at given times: the planar projection every model reports, and what its sockets feel in space.

Sensor axes are those of the inner pair: forward, up the leg, lateral (along the hip axis, z of the slope frame when the
machine stands straight). A sensor measures acceleration minus gravity, and the angular velocity, on these axes.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import PchipInterpolator

from stages.biped.design import Biped
from stages.biped.quantity import quantity
from stages.biped.walk import Walk
from stages.ground.contact_law import ContactLaw
from stages.ground.slope import Slope
from stages.multibody.assembly.signals import GROUND_REACTION, IMU
from stages.twin.machine.contact import HINGE, PITCH, ROLL, SLIDE, YAW, Z, along, point_law
from stages.twin.machine.kinematics import pair_axes, point_motion
from stages.twin.machine.machine import Machine
from stages.twin.parameters import ATTITUDE, COORDINATES, FOOT_FORCE, IMU_IN_SPACE, SIGNALS
from stages.twin.walking.events import find_events
from stages.twin.walking.record import Record

#: Legs of each pair, and their slides among `SLIDE`.
PAIRS = (slice(0, 2), slice(2, 4))
COLUMNS = np.array(SLIDE)


@dataclass(frozen=True)
class Signals:
    """What is sampled of a walk in space; times as in `walk.time`. A signal that is not asked for has no rows."""

    walk: Walk = quantity("-", "planar projection: leg 0 the inner pair, leg 1 the outer pair, feet of a pair averaged")
    hip_imu_specific_force: np.ndarray = quantity(
        "m/s^2", "specific force at the hip socket: forward, up the leg, lateral, (n, 3)", symbol="f_hip"
    )
    hip_imu_angular_velocity: np.ndarray = quantity(
        "rad/s", "angular velocity at the hip socket on the same axes, (n, 3)", symbol="omega_hip"
    )
    foot_imu_specific_force: np.ndarray = quantity(
        "m/s^2", "specific force at the inner foot's socket on the same axes, (n, 3)", symbol="f_foot"
    )
    foot_imu_angular_velocity: np.ndarray = quantity(
        "rad/s", "angular velocity at the inner foot's socket on the same axes, (n, 3)", symbol="omega_foot"
    )
    roll: np.ndarray = quantity("rad", "roll about the forward axis, shape (n,)")
    yaw: np.ndarray = quantity("rad", "yaw about the slope's normal, shape (n,)")
    lateral: np.ndarray = quantity("m", "place of the hip across the slope, shape (n,)", symbol="z_hip")
    coordinates: np.ndarray = quantity(
        "m, rad", "x, y, z, yaw, roll, pitch, slides inner left and right, hinge, slides outer left and right, (n, 11)"
    )
    foot_force: np.ndarray = quantity("N", "force of the ground on each foot, x, y, z, shape (n, 4, 3)")


def sample(
    record: Record,
    machine: Machine,
    biped: Biped,
    slope: Slope,
    contact: ContactLaw,
    time: np.ndarray,
    hip_socket: tuple[float, ...],
    foot_socket: tuple[float, ...],
    signals: Collection[str] = SIGNALS,
) -> Signals:
    """Sample the motion and `signals` of a record at `time` (n,) [s].

    Sockets and names of signals as in `stages.twin.parameters`; what is not named is not computed either.

    Motion by Hermite interpolation between the solver's steps. Accelerations and forces, which have kinks, are computed
    at the solver's steps and interpolated by monotone cubics, so that no force becomes negative in between.
    """
    q, v = record.at(time)
    steps = record.position, record.velocity, record.acceleration
    felt, in_space = IMU in signals, IMU_IN_SPACE in signals
    inner = pair_axes(*steps, 0) if felt or in_space else None
    gravity = np.array([*slope.gravity_vector, 0.0])
    nothing = np.zeros((0, 3))

    def between(values: np.ndarray) -> np.ndarray:
        return np.asarray(PchipInterpolator(record.time, values)(time))

    def specific_force(place: np.ndarray, slide: int | None, wanted: bool) -> np.ndarray:
        if inner is None or not wanted:
            return nothing
        return between(inner.components(point_motion(*steps, inner, place, slide).acceleration - gravity))

    feet = np.zeros((0, 4, 3))
    if GROUND_REACTION in signals or FOOT_FORCE in signals:
        law = point_law(contact)
        feet = between(along(record.position, record.velocity, record.in_play(record.time), machine.feet, law)[0])
    socket_slide = SLIDE[0] if foot_socket[2] > 0.0 else SLIDE[1]
    centre = np.array([0.0, biped.foot_com - biped.leg_length, 0.0])  # the legs' mid-plane, as in the simple models
    mass_centre = np.mean([specific_force(centre, slide, felt) for slide in SLIDE[:2]], axis=0)
    spin = nothing
    if felt or in_space:
        axes = pair_axes(q, v, np.zeros_like(q), 0)
        spin = axes.components(axes.spin)
    turning = spin[:, 2] if felt else np.zeros(0)
    events = find_events(record, machine.feet)
    length = np.column_stack([machine.length[pair].mean() - q[:, COLUMNS[pair]].mean(axis=1) for pair in PAIRS])
    length_rate = np.column_stack([-v[:, COLUMNS[pair]].mean(axis=1) for pair in PAIRS])
    reaction = np.stack([feet[:, pair, :2].sum(axis=1) for pair in PAIRS], axis=1)
    walk = Walk(
        time=time,
        hip_position=q[:, :2].copy(),
        hip_velocity=v[:, :2].copy(),
        leg_angle=np.column_stack([q[:, PITCH], q[:, PITCH] + q[:, HINGE]]),
        leg_rate=np.column_stack([v[:, PITCH], v[:, PITCH] + v[:, HINGE]]),
        leg_length=length,
        leg_length_rate=length_rate,
        ground_reaction=reaction if GROUND_REACTION in signals else reaction[:0],
        hip_specific_force=specific_force(np.zeros(3), None, felt)[:, :2],
        hip_angular_velocity=turning.copy(),
        foot_specific_force=mass_centre[:, :2],
        foot_angular_velocity=turning.copy(),
        heel_strike_time=events.heel_strike_time,
        heel_strike_leg=events.heel_strike_leg,
        toe_off_time=events.toe_off_time,
        toe_off_leg=events.toe_off_leg,
    )
    attitude = len(time) if ATTITUDE in signals else 0
    return Signals(
        walk=walk,
        hip_imu_specific_force=specific_force(np.array(hip_socket), None, in_space),
        hip_imu_angular_velocity=spin if in_space else nothing,
        foot_imu_specific_force=specific_force(np.array(foot_socket), socket_slide, in_space),
        foot_imu_angular_velocity=spin.copy() if in_space else nothing,
        roll=q[:attitude, ROLL].copy(),
        yaw=q[:attitude, YAW].copy(),
        lateral=q[:attitude, Z].copy(),
        coordinates=q if COORDINATES in signals else q[:0],
        foot_force=feet if FOOT_FORCE in signals else feet[:0],
    )
