"""Heel strikes and toe-offs of a recorded run, located between the solver's steps."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy.optimize import brentq

from stages.planar.trajectory import Trajectory, foot_kinematics


@dataclass(frozen=True)
class Events:
    """Times [s] and legs (in the twin: pairs of legs) of heel strikes and toe-offs."""

    heel_strike_time: np.ndarray
    heel_strike_leg: np.ndarray
    toe_off_time: np.ndarray
    toe_off_leg: np.ndarray


class Recorded(Protocol):
    """What events need of a run at the solver's own steps; `switches` as in `Trajectory`."""

    @property
    def time(self) -> np.ndarray:
        """Times of the steps (n,) [s]."""

    @property
    def in_play_at_start(self) -> tuple[bool, bool]:
        """On which legs the ground acts at first."""

    @property
    def switches(self) -> tuple[tuple[float, int, bool], ...]:
        """Changes of that: time [s], leg, whether the ground acts from then on."""


def find_events(trajectory: Trajectory, radii: tuple[float, float]) -> Events:
    """Heel strikes and toe-offs of both feet, of these radii [m]."""
    rows = trajectory.position, trajectory.velocity
    depth = np.column_stack([foot_kinematics(*rows, leg, radii[leg])[0] for leg in (0, 1)])
    return located(trajectory, depth, lambda leg, row: _crossing(trajectory, leg, radii[leg], row))


def located(run: Recorded, depth: np.ndarray, crossing: Callable[[int, int], float]) -> Events:
    """First touch-down and last lift-off of each leg between two moments at which it went out of play.

    `depth` (n, 2) [m] of its lowest point under the ground; `crossing` (leg, row) finds when [s] from the row to
    the next this point is at the surface. A foot that bounces at heel strike counts once. A leg still on the ground
    at the end has no toe-off yet.
    """
    touch_downs: list[tuple[float, int]] = []
    lift_offs: list[tuple[float, int]] = []
    for leg in (0, 1):
        for start, end, ended in _episodes(run, leg):
            inside = np.flatnonzero((run.time >= start) & (run.time <= end))
            touching = depth[inside, leg] > 0.0
            if not touching.any():
                continue
            first, last = inside[np.argmax(touching)], inside[len(inside) - 1 - np.argmax(touching[::-1])]
            if first > inside[0]:
                touch_downs.append((crossing(leg, first - 1), leg))
            if ended and last < inside[-1]:
                lift_offs.append((crossing(leg, last), leg))
    columns = []
    for events in (sorted(touch_downs), sorted(lift_offs)):
        columns += [np.array([time for time, _ in events]), np.array([leg for _, leg in events], dtype=np.int64)]
    return Events(*columns)


def _episodes(run: Recorded, leg: int) -> list[tuple[float, float, bool]]:
    """Spans in which the ground acts on a leg: start, end, and whether the span ended before the record did."""
    spans: list[tuple[float, float, bool]] = []
    begin = 0.0 if run.in_play_at_start[leg] else None
    for time, who, acts in run.switches:
        if who != leg:
            continue
        if acts:
            begin = time
        elif begin is not None:
            spans.append((begin, time, True))
            begin = None
    return spans if begin is None else [*spans, (begin, float(run.time[-1]), False)]


def _crossing(trajectory: Trajectory, leg: int, radius: float, row: int) -> float:
    """Time between two recorded rows at which the foot's lowest point is at the ground's surface."""
    at = trajectory.after(row)

    def depth(time: float) -> float:
        return float(foot_kinematics(*at(time), leg, radius)[0])

    early, late = float(trajectory.time[row]), float(trajectory.time[row + 1])
    if depth(early) == 0.0:
        return early
    return float(brentq(depth, early, late, xtol=1e-15, rtol=8.9e-16))
