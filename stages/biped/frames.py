"""Frames of the study and what a sensor feels in them.

Slope frame: x down-slope, y normal to the ground, z = x cross y. Body axes of a leg at angle phi (positive with the
foot ahead of the hip, right-handed about z): forward (cos phi, sin phi), upward along the leg (-sin phi, cos phi).
"""

from __future__ import annotations

import numpy as np


def leg_axes(leg_angle: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Unit vectors forward and upward of a leg in the slope frame, each of shape (n, 2), from its angle (n,) [rad]."""
    cos, sin = np.cos(leg_angle), np.sin(leg_angle)
    return np.stack([cos, sin], axis=-1), np.stack([-sin, cos], axis=-1)


def specific_force(acceleration: np.ndarray, leg_angle: np.ndarray, gravity: tuple[float, float]) -> np.ndarray:
    """What an accelerometer on a leg measures: acceleration minus gravity on the leg's axes, shape (n, 2) [m/s^2].

    `acceleration` (n, 2) and `gravity` in the slope frame, `leg_angle` (n,) [rad].
    """
    forward, upward = leg_axes(leg_angle)
    felt = acceleration - np.asarray(gravity)
    return np.stack([(felt * forward).sum(axis=-1), (felt * upward).sum(axis=-1)], axis=-1)
