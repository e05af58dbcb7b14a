"""Heel strikes and toe-offs of a recorded run, located between the solver's steps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from stages.multibody.walking.trajectory import Trajectory, foot_kinematics


@dataclass(frozen=True)
class Events:
    """Times [s] and legs (in the twin: pairs of legs) of heel strikes and toe-offs."""

    heel_strike_time: np.ndarray
    heel_strike_leg: np.ndarray
    toe_off_time: np.ndarray
    toe_off_leg: np.ndarray


def find_events(trajectory: Trajectory, radius: float) -> Events:
    """First touch-down and last lift-off of each foot between two moments at which it went out of play.

    A foot that bounces at heel strike therefore counts once. A leg that is still on the ground at the end has no
    toe-off yet.
    """
    touch_downs: list[tuple[float, int]] = []
    lift_offs: list[tuple[float, int]] = []
    for leg in (0, 1):
        depth = foot_kinematics(trajectory.position, trajectory.velocity, leg, radius)[0]
        for start, end, ended in _episodes(trajectory, leg):
            inside = np.flatnonzero((trajectory.time >= start) & (trajectory.time <= end))
            touching = depth[inside] > 0.0
            if not touching.any():
                continue
            first, last = inside[np.argmax(touching)], inside[len(inside) - 1 - np.argmax(touching[::-1])]
            if first > inside[0]:
                touch_downs.append((_crossing(trajectory, leg, radius, first - 1), leg))
            if ended and last < inside[-1]:
                lift_offs.append((_crossing(trajectory, leg, radius, last), leg))
    touch_downs.sort()
    lift_offs.sort()
    return Events(
        np.array([time for time, _ in touch_downs]),
        np.array([leg for _, leg in touch_downs], dtype=np.int64),
        np.array([time for time, _ in lift_offs]),
        np.array([leg for _, leg in lift_offs], dtype=np.int64),
    )


def _episodes(trajectory: Trajectory, leg: int) -> list[tuple[float, float, bool]]:
    """Spans in which the ground acts on a foot: start, end, and whether the span ended before the record did."""
    changes = [(time, acts) for time, who, acts in trajectory.switches if who == leg]
    spans, begin = [], 0.0 if trajectory.in_play_at_start[leg] else None
    for time, acts in changes:
        if acts:
            begin = time
        elif begin is not None:
            spans.append((begin, time, True))
            begin = None
    if begin is not None:
        spans.append((begin, float(trajectory.time[-1]), False))
    return spans


def _crossing(trajectory: Trajectory, leg: int, radius: float, row: int) -> float:
    """Time between two recorded rows at which the foot's lowest point is at the ground's surface."""

    def depth(time: float) -> float:
        position, velocity = trajectory.at(np.array([time]))
        return float(foot_kinematics(position, velocity, leg, radius)[0][0])

    early, late = float(trajectory.time[row]), float(trajectory.time[row + 1])
    if depth(early) == 0.0:
        return early
    return float(brentq(depth, early, late, xtol=1e-15, rtol=8.9e-16))
