"""Sensor to body: gravity at rest gives the vertical, the swing axis of the gyroscope gives the lateral.

Body axes of the leg the sensor rides on: forward, up the leg, lateral = forward cross up. At rest the leg stands at a
known angle, so gravity is known in body axes; walking turns the leg about the lateral axis. Two directions known in
both frames fix the rotation (Wahba's problem for two vectors, solved by TRIAD, Black 1964). The swing axis is met
exactly, for a planar walk turns about nothing else; gravity, which an accelerometer's bias b tilts by b / g, as far as
it is normal to that axis. What stays is the error of the pitch: the bias forward, the stand and the inclination.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from stages.imu.sources.schema import Device


@dataclass(frozen=True)
class Frame:
    """How a sensor sits on its body, as the recording shows it.

    `rotation` (3, 3): body = rotation @ sensor. `swing_residual_deg`: how far the swing axis is from normal to
    gravity; `swing_share`: part of the angular motion about the swing axis; `mounting_deg`: angle to the declared
    mounting (NaN where none is declared).
    """

    rotation: np.ndarray
    swing_residual_deg: float
    swing_share: float
    mounting_deg: float


def mounting(device: Device) -> np.ndarray:
    """Declared mounting (3, 3), body = mounting @ sensor; the identity where the source does not say."""
    if device.forward_axis is None or device.up_axis is None or device.forward_axis[1] == device.up_axis[1]:
        return np.eye(3)
    forward, up = (
        (-1.0 if name[0] == "-" else 1.0) * np.eye(3)["xyz".index(name[1])]
        for name in (device.forward_axis, device.up_axis)
    )
    return np.stack([forward, up, np.cross(forward, up)])


def is_mounting_declared(device: Device) -> bool:
    """Whether the source says how the sensor sits."""
    return device.forward_axis is not None and device.up_axis is not None


def gravity_on_body(slope: float, leg_angle: float) -> np.ndarray:
    """Direction (3,) of the specific force on body axes of a leg at rest; angles from the slope normal [rad]."""
    tilt = slope - leg_angle
    return np.array([-math.sin(tilt), math.cos(tilt), 0.0])


def swing_axis(angular_rate: np.ndarray) -> tuple[np.ndarray, float]:
    """Principal axis (3,) of the angular motion (n, 3) and the share of the motion about it."""
    values, vectors = np.linalg.eigh(angular_rate.T @ angular_rate)
    return vectors[:, -1], float(values[-1] / max(values.sum(), 1e-30))


def find_frame(
    static_force: np.ndarray, angular_rate: np.ndarray, device: Device, slope: float, rest_leg_angle: float
) -> Frame:
    """The frame from the mean specific force at rest (3,) and the angular rate while walking (n, 3), sensor axes.

    The sign of the swing axis follows the declared mounting; where none is declared, the leg swings forward faster
    than it rolls back, so the third moment of the rate about the lateral axis is positive.
    """
    axis, share = swing_axis(angular_rate)
    declared = is_mounting_declared(device)
    sign = axis @ mounting(device)[2] if declared else np.sum((angular_rate @ axis) ** 3)
    axis = axis if sign >= 0 else -axis
    plumb = static_force - (static_force @ axis) * axis
    plumb /= np.linalg.norm(plumb)
    on_sensor = np.stack([plumb, axis, np.cross(plumb, axis)])
    gravity, lateral = gravity_on_body(slope, rest_leg_angle), np.array([0.0, 0.0, 1.0])
    rotation = np.stack([gravity, lateral, np.cross(gravity, lateral)]).T @ on_sensor
    off_normal = axis @ static_force / np.linalg.norm(static_force)
    return Frame(
        rotation=rotation,
        swing_residual_deg=math.degrees(math.asin(np.clip(off_normal, -1, 1))),
        swing_share=share,
        mounting_deg=angle_between(rotation, mounting(device)) if declared else math.nan,
    )


def angle_between(first: np.ndarray, second: np.ndarray) -> float:
    """Angle of the rotation between two frames (3, 3) [deg]."""
    return math.degrees(math.acos(np.clip((np.trace(first @ second.T) - 1) / 2, -1, 1)))
