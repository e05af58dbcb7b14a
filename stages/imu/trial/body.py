"""Sensors in body axes, and those of one leg on a common grid: what they show together, and the leg's angle.

Gravity at rest gives the vertical, the swing axis of the gyroscope gives the lateral. Body axes of the leg the sensor
rides on: forward, up the leg, lateral = forward cross up. At rest the leg stands at a known angle, so gravity is known
in body axes; walking turns the leg about the lateral axis. Two directions known in both frames fix the rotation
(Wahba's problem for two vectors, solved by TRIAD, Black 1964). The swing axis is met exactly, for a planar walk turns
about nothing else; gravity, which an accelerometer's bias b tilts by b / g, as far as it is normal to that axis. What
stays is the error of the pitch: the bias forward, the stand and the inclination.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from stages.biped.between_steps import running_integral
from stages.biped.quantity import quantity
from stages.imu.clock.clock import resample
from stages.imu.parameters import Settings
from stages.imu.result import FrameFit
from stages.imu.sources.schema import Device
from stages.imu.strikes.heel_strikes import filled
from stages.imu.trial.sensor import SensorTrace

PLACES = ("hip", "foot")
FORWARD, UP, LATERAL = 0, 1, 2
MOVING = 0.1  # of the largest rate
ROUNDED = 1e-3  # of a step of the grid: stamps since 1970 are rounded to a tenth of it


@dataclass(frozen=True)
class Frame(FrameFit):
    """How a sensor sits on its body, as the recording shows it."""

    rotation: np.ndarray = quantity("1", "rotation from sensor to body axes, shape (3, 3)", symbol="R")


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
    than it rolls back, so the third moment of the rate about the lateral axis is positive. Rows with a NaN are drawn
    over for it: what is beyond full scale is the swing.
    """
    axis, share = swing_axis(angular_rate[np.isfinite(angular_rate).all(axis=1)])
    declared = is_mounting_declared(device)
    sign = axis @ mounting(device)[2] if declared else np.sum(filled(angular_rate @ axis) ** 3)
    axis = axis if sign >= 0 else -axis
    plumb = static_force - (static_force @ axis) * axis
    plumb /= np.linalg.norm(plumb)
    on_sensor = np.stack([plumb, axis, np.cross(plumb, axis)])
    gravity, lateral = gravity_on_body(slope, rest_leg_angle), np.array([0.0, 0.0, 1.0])
    rotation = np.stack([gravity, lateral, np.cross(gravity, lateral)]).T @ on_sensor
    off_normal = axis @ static_force / np.linalg.norm(static_force)
    return Frame(
        math.degrees(math.asin(np.clip(off_normal, -1, 1))), share,
        angle_between(rotation, mounting(device)) if declared else math.nan, rotation)


def angle_between(first: np.ndarray, second: np.ndarray) -> float:
    """Angle of the rotation between two frames (3, 3) [deg]."""
    return math.degrees(math.acos(np.clip((np.trace(first @ second.T) - 1) / 2, -1, 1)))


def frame_of(trace: SensorTrace, settings: Settings) -> Frame | None:
    """The frame of a sensor; None without a still stand or without motion after it."""
    moving, static = trace.angular_rate[~trace.rest] - trace.bias(), trace.static_force()
    if not trace.rest.any() or np.isfinite(moving).all(axis=1).sum() < 3 or not np.linalg.norm(static) > 0:
        return None
    return find_frame(
        static,
        moving,
        trace.indexed.recording.device,
        math.radians(trace.indexed.recording.experiment.slope_deg or 0.0),
        math.radians(settings.rest_leg_angle_deg),
    )


@dataclass(frozen=True)
class BodySensor:
    """A sensor in body axes: time (n,) [s], force (n, 3) [m/s^2], rate (n, 3) [rad/s] without bias."""

    trace: SensorTrace
    frame: Frame
    time: np.ndarray
    force: np.ndarray
    rate: np.ndarray

    @property
    def saturated(self) -> BodySensor:
        """The same with clipped readings of force in place of NaN."""
        return replace(self, force=self.trace.readings @ self.frame.rotation.T)

    def longest_step(self, settings: Settings) -> float:
        """Longest time between two samples that is interpolated [s]."""
        return settings.bridged_samples / self.trace.rate_hz

    def bias_error(self) -> float:
        """Standard error of the lateral bias, from the scatter of the still stand [rad/s]; 0 without one."""
        still = self.rate[self.trace.rest, LATERAL]
        still = still[np.isfinite(still)]
        return float(np.std(still) / math.sqrt(len(still))) if len(still) else 0.0


def on_grid(sensor: BodySensor, grid: np.ndarray, settings: Settings) -> np.ndarray:
    """Force and rate (m, 6) on a grid (m,); force and rate keep holes of their own."""
    step = sensor.longest_step(settings)
    return np.hstack([resample(sensor.time, part, grid, step) for part in (sensor.force, sensor.rate)])


def common_grid(sensors: Mapping[str, BodySensor], settings: Settings) -> np.ndarray:
    """Even grid over the time all sensors cover; empty without any."""
    first = max((sensor.time[0] for sensor in sensors.values()), default=0.0)
    last = min((sensor.time[-1] for sensor in sensors.values()), default=0.0)
    count = max(0, int((last - first) * settings.grid_rate_hz + ROUNDED) + 1) if sensors else 0
    return np.asarray(first + np.arange(count) / settings.grid_rate_hz)


def leg_angle(time: np.ndarray, lateral_rate: np.ndarray, rest: np.ndarray, rest_angle: float) -> np.ndarray:
    """Angle of the leg from the slope normal (n,) [rad], foot ahead positive.

    lateral_rate (n,) [rad/s] is that of the leg, its bias removed; holes are drawn over. `rest` (n,) marks the still
    stand, in whose mean the angle is `rest_angle` [rad].
    """
    turned = running_integral(filled(lateral_rate), time)
    return np.asarray(turned - (turned[rest].mean() if rest.any() else turned[0]) + rest_angle)


@dataclass(frozen=True)
class GridSignals:
    """What the sensors of one leg show while all of them record, on an even grid `time` (m,) [s].

    By place `signals` (m, 6), force and rate on body axes, and the leg's `angle` (m,) [rad] from the rate there; the
    other place, on the same leg, fills the rate's holes.
    """

    time: np.ndarray
    signals: Mapping[str, np.ndarray]
    angle: Mapping[str, np.ndarray]


def grid_signals(sensors: Mapping[str, BodySensor], settings: Settings) -> GridSignals:
    """What these sensors show together; of no common time there are no angles."""
    grid, angles = common_grid(sensors, settings), {}
    signals = {place: on_grid(sensor, grid, settings) for place, sensor in sensors.items()}
    for place, sensor in sensors.items() if len(grid) else ():
        rate = signals[place][:, 3 + LATERAL]
        for other in signals.values():
            rate = np.where(np.isfinite(rate), rate, other[:, 3 + LATERAL])
        still = sensor.time[sensor.trace.rest]
        rest = (grid >= still[0]) & (grid <= still[-1]) if len(still) else np.zeros(len(grid), dtype=bool)
        angles[place] = leg_angle(grid, rate, rest, math.radians(settings.rest_leg_angle_deg))
    return GridSignals(grid, signals, angles)
