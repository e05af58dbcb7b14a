"""Before the walk: the robot is held still with its legs together, then rocked back and pushed by hand.

The inner leg, which carries the sensors, stands on its round foot and rolls. Its angle follows a quintic from rest to
the angle, rate and acceleration with which the walk begins.
"""

from __future__ import annotations

import numpy as np

from stages.biped.design import Biped
from stages.campaign.virtual_sensor import SensorMotion
from stages.ground.slope import Slope


def quintic(duration: float, end: tuple[float, float, float], time: np.ndarray) -> np.ndarray:
    """Value, rate and acceleration (3, n) of the quintic from rest at `end`'s zero to `end` at t = duration.

    `end` is (value, rate, acceleration); the quintic starts at zero with zero rate and acceleration.
    """
    powers = np.arange(3, 6)
    at_end = np.stack(
        [
            duration**powers,
            powers * duration ** (powers - 1.0),
            powers * (powers - 1) * duration ** (powers - 2.0),
        ]
    )
    c = np.linalg.solve(at_end, np.array(end))
    t = time[:, None]
    value = (c * t**powers).sum(axis=1)
    rate = (c * powers * t ** (powers - 1)).sum(axis=1)
    acceleration = (c * powers * (powers - 1) * t ** (powers - 2)).sum(axis=1)
    return np.stack([value, rate, acceleration])


def first_motion(angle: np.ndarray, rate: np.ndarray, grid: float, blow: float) -> tuple[float, float, float]:
    """Angle [rad], rate and acceleration with which a walk begins, of a leg's angle and rate (n,) on a grid [s].

    The acceleration is that of the first step of the grid, or the mean over a `blow` [s] if that is longer: a hand
    does not follow a jump of the rate.
    """
    end = max(1, round(blow / grid))
    return float(angle[0]), float(rate[0]), float((rate[end] - rate[0]) / (end * grid))


def stand_and_push(
    rest_angle: float, end: tuple[float, float, float], rest_s: float, push_s: float, grid: float
) -> tuple[np.ndarray, np.ndarray]:
    """Time (n,) [s], negative up to but without 0, and leg angle, rate, acceleration (3, n).

    rest_angle [rad] is held for `rest_s`; `end` is (angle, rate, acceleration) at time 0; `grid` is the time step [s].
    """
    count = round((rest_s + push_s) / grid)
    time = (np.arange(count) - count) * grid
    angle, rate, acceleration = end
    pushing = quintic(push_s, (angle - rest_angle, rate, acceleration), np.maximum(time + push_s, 0.0))
    pushing[0] += rest_angle
    return time, pushing


def rolling_leg(
    leg: tuple[np.ndarray, np.ndarray, np.ndarray], biped: Biped, slope: Slope, time: np.ndarray
) -> tuple[SensorMotion, SensorMotion]:
    """What hip and foot sensor feel while the leg rolls on its foot at its natural length.

    `leg` is angle, rate, acceleration (n,) of the leg, foot ahead positive [rad, s]. Rolling: the foot's centre moves
    by -r phi; the hip sits L - r from it (eq. 3, with theta = -phi).
    """
    phi, rate, acceleration = leg
    forward = np.stack([np.cos(phi), np.sin(phi)], axis=1)
    up = np.stack([-np.sin(phi), np.cos(phi)], axis=1)
    above_centre, apart = biped.leg_length - biped.foot_radius, biped.leg_length - biped.foot_com
    turn, pull = acceleration[:, None] * forward, (rate**2)[:, None] * up
    hip = -above_centre * turn - above_centre * pull
    hip[:, 0] -= biped.foot_radius * acceleration
    foot = hip + apart * turn + apart * pull
    gravity = np.array(slope.gravity_vector)

    def felt(movement: np.ndarray) -> SensorMotion:
        force = movement - gravity
        on_body = np.stack([(force * forward).sum(axis=1), (force * up).sum(axis=1), np.zeros(len(phi))], axis=1)
        return SensorMotion(time, on_body, np.stack([np.zeros(len(phi)), np.zeros(len(phi)), rate], axis=1))

    return felt(hip), felt(foot)


def joined(before: SensorMotion, after: SensorMotion) -> SensorMotion:
    """Two motions on the same grid, one after the other."""
    return SensorMotion(
        np.concatenate((before.time, after.time)),
        np.concatenate((before.specific_force, after.specific_force)),
        np.concatenate((before.angular_velocity, after.angular_velocity)),
    )
