"""Motion of points fixed to the twin's bodies, from the coordinates of its tree.

Axes of a pair of legs: forward, up the leg, along the hip axis; all in the slope frame. Shapes are (n, 3).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stages.twin.machine.contact import HINGE, PITCH, ROLL, YAW


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


@dataclass(frozen=True)
class PointMotion:
    """Position [m], velocity [m/s] and acceleration [m/s^2] of a point in the slope frame, each (n, 3)."""

    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray


def point_motion(
    q: np.ndarray, v: np.ndarray, a: np.ndarray, axes: Axes, place: np.ndarray, slide: int | None = None
) -> PointMotion:
    """Motion of a point given by its place (3,) in the drawing, on a frame or on the foot with this slide."""
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
    return PointMotion(q[:, :3] + arm, v[:, :3] + turning + sliding, acceleration)
