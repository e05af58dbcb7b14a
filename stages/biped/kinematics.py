"""Motion of the hip and of points on the legs, eqs. (7) and (8), and what a sensor measures in the frames of the study.

Slope frame: x down-slope, y normal to the ground, z = x cross y. Body axes of a leg at angle phi (positive with the
foot ahead of the hip, right-handed about z): forward (cos phi, sin phi), upward along the leg (-sin phi, cos phi).

All arrays have one row a sample. Angles as in the paper: theta of the stance leg positive with the hip ahead, psi of
the swing leg positive with the foot ahead. Symbols of eq. (7) are used as locals.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Motion:
    """Position [m], velocity [m/s] and acceleration [m/s^2] of a point in the slope frame, each (n, 2), or (n, 3)."""

    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray

    def __add__(self, other: Motion) -> Motion:
        return Motion(
            self.position + other.position, self.velocity + other.velocity, self.acceleration + other.acceleration
        )


@dataclass(frozen=True)
class Coordinate:
    """A scalar coordinate with its first and second rate, each of shape (n,)."""

    value: np.ndarray
    rate: np.ndarray
    second_rate: np.ndarray


def polar_motion(distance: Coordinate, angle: Coordinate) -> Motion:
    """Motion of distance * (sin angle, cos angle): polar coordinates about the y axis."""
    up = np.stack([np.sin(angle.value), np.cos(angle.value)], axis=-1)
    across = np.stack([np.cos(angle.value), -np.sin(angle.value)], axis=-1)
    d, w = distance, angle
    return Motion(
        d.value[:, None] * up,
        d.rate[:, None] * up + (d.value * w.rate)[:, None] * across,
        (d.second_rate - d.value * w.rate**2)[:, None] * up
        + (d.value * w.second_rate + 2 * d.rate * w.rate)[:, None] * across,
    )


def rolling_centre(angle: Coordinate, radius: float, origin: np.ndarray) -> Motion:
    """Centre of a foot that rolls without slip, at x = origin for angle 0; `origin` (n,) [m]."""
    along = np.array([1.0, 0.0])
    return Motion(
        np.stack([origin + radius * angle.value, np.full_like(angle.value, radius)], axis=-1),
        radius * angle.rate[:, None] * along,
        radius * angle.second_rate[:, None] * along,
    )


def shifted(length: Coordinate, offset: float) -> Coordinate:
    """The coordinate `length` minus a constant."""
    return Coordinate(length.value - offset, length.rate, length.second_rate)


def constant(value: float, like: Coordinate) -> Coordinate:
    """A coordinate that does not change."""
    zero = np.zeros_like(like.value)
    return Coordinate(zero + value, zero, zero)


def hip_motion(theta: Coordinate, stance_length: Coordinate, radius: float, origin: np.ndarray) -> Motion:
    """Motion of the hip above a rolling stance foot, eqs. (7) and (8)."""
    return rolling_centre(theta, radius, origin) + polar_motion(shifted(stance_length, radius), theta)


def stance_mass_motion(theta: Coordinate, foot_com: float, radius: float, origin: np.ndarray) -> Motion:
    """Motion of the stance leg's mass, which sits `foot_com` above the bottom of the rolling foot."""
    return rolling_centre(theta, radius, origin) + polar_motion(constant(foot_com - radius, theta), theta)


def swing_point_motion(hip: Motion, psi: Coordinate, distance: Coordinate) -> Motion:
    """Motion of the point at `distance` from the hip along the swing leg: hip + distance (sin psi, -cos psi)."""
    down = Coordinate(np.pi - psi.value, -psi.rate, -psi.second_rate)
    return hip + polar_motion(distance, down)


def leg_axes(leg_angle: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Unit vectors forward and upward of a leg in the slope frame, each of shape (n, 2), from its angle (n,) [rad]."""
    cos, sin = np.cos(leg_angle), np.sin(leg_angle)
    return np.stack([cos, sin], axis=-1), np.stack([-sin, cos], axis=-1)


def specific_force(acceleration: np.ndarray, leg_angle: np.ndarray, gravity: tuple[float, float]) -> np.ndarray:
    """What an accelerometer on a leg measures: acceleration minus gravity on the leg's axes, shape (n, 2) [m/s^2].

    `acceleration` (n, 2) and `gravity` in the slope frame, `leg_angle` (n,) [rad].
    """
    forward, upward = leg_axes(leg_angle)
    sensed = acceleration - np.asarray(gravity)
    return np.stack([(sensed * forward).sum(axis=-1), (sensed * upward).sum(axis=-1)], axis=-1)
