"""Signals of the twin at given times: the planar projection every model reports, and what its sockets feel in space.

Sensor axes are those of the inner pair: forward, up the leg, lateral (along the hip axis, z of the slope frame when the
machine stands straight). A sensor measures acceleration minus gravity, and the angular velocity, on these axes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import PchipInterpolator

from stages.biped.design import Biped
from stages.biped.quantity import quantity
from stages.biped.walk import Walk
from stages.ground.contact_law import ContactLaw
from stages.ground.slope import Slope
from stages.twin.contact import HINGE, PITCH, ROLL, SLIDE, YAW, Z, along, law_numbers
from stages.twin.events import find_events
from stages.twin.kinematics import pair_axes, point_motion
from stages.twin.machine import Machine
from stages.twin.record import Record

#: Legs of each pair, and their slides among `SLIDE`.
PAIRS = (slice(0, 2), slice(2, 4))
COLUMNS = np.array(SLIDE)


@dataclass(frozen=True)
class Signals:
    """What is sampled of a walk in space; times as in `walk.time`."""

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
) -> Signals:
    """Sample a record at `time` (n,) [s]; sockets as in `stages.twin.parameters.Settings`.

    Motion by Hermite interpolation between the solver's steps. Accelerations and forces, which have kinks, are computed
    at the solver's steps and interpolated by monotone cubics, so that no force becomes negative in between.
    """
    q, v = record.at(time)
    steps = record.position, record.velocity, record.acceleration
    inner = pair_axes(*steps, 0)
    gravity = np.array([*slope.gravity_vector, 0.0])

    def between(values: np.ndarray) -> np.ndarray:
        return PchipInterpolator(record.time, values)(time)

    def specific_force(place: np.ndarray, slide: int | None) -> np.ndarray:
        return between(inner.components(point_motion(*steps, inner, place, slide).acceleration - gravity))

    force = along(record.position, record.velocity, record.in_play(record.time), machine.feet, law_numbers(contact))[0]
    feet = between(force)
    socket_slide = SLIDE[0] if foot_socket[2] > 0.0 else SLIDE[1]
    centre = np.array([0.0, biped.foot_com - biped.leg_length, 0.0])  # the legs' mid-plane, as in the simple models
    mass_centre = np.mean([specific_force(centre, slide) for slide in SLIDE[:2]], axis=0)
    axes = pair_axes(q, v, np.zeros_like(q), 0)
    spin = axes.components(axes.spin)
    events = find_events(record, machine.feet)
    length = np.column_stack([machine.length[pair].mean() - q[:, COLUMNS[pair]].mean(axis=1) for pair in PAIRS])
    length_rate = np.column_stack([-v[:, COLUMNS[pair]].mean(axis=1) for pair in PAIRS])
    walk = Walk(
        time=time,
        hip_position=q[:, :2].copy(),
        hip_velocity=v[:, :2].copy(),
        leg_angle=np.column_stack([q[:, PITCH], q[:, PITCH] + q[:, HINGE]]),
        leg_rate=np.column_stack([v[:, PITCH], v[:, PITCH] + v[:, HINGE]]),
        leg_length=length,
        leg_length_rate=length_rate,
        ground_reaction=np.stack([feet[:, pair, :2].sum(axis=1) for pair in PAIRS], axis=1),
        hip_specific_force=specific_force(np.zeros(3), None)[:, :2],
        hip_angular_velocity=spin[:, 2].copy(),
        foot_specific_force=mass_centre[:, :2],
        foot_angular_velocity=spin[:, 2].copy(),
        heel_strike_time=events.heel_strike_time,
        heel_strike_leg=events.heel_strike_leg,
        toe_off_time=events.toe_off_time,
        toe_off_leg=events.toe_off_leg,
    )
    return Signals(
        walk=walk,
        hip_imu_specific_force=specific_force(np.array(hip_socket), None),
        hip_imu_angular_velocity=spin,
        foot_imu_specific_force=specific_force(np.array(foot_socket), socket_slide),
        foot_imu_angular_velocity=spin.copy(),
        roll=q[:, ROLL].copy(),
        yaw=q[:, YAW].copy(),
        lateral=q[:, Z].copy(),
        coordinates=q,
        foot_force=feet,
    )
