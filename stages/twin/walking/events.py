"""Heel strikes and toe-offs of a twin's walk, located between the solver's steps."""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

from stages.planar.events import Events, located
from stages.twin.machine.contact import clearances, clearances_along
from stages.twin.walking.record import Record


def find_events(record: Record) -> Events:
    """First touch-down and last lift-off of each pair's lowest point while the ground acts on the pair.

    A pair that bounces at heel strike counts once. A pair still on the ground at the end has no toe-off yet.
    """
    feet = record.machine.feet
    depth = -clearances_along(record.position, feet)
    return located(record, depth, lambda pair, row: _crossing(record, feet, pair, row))


def _crossing(record: Record, feet: np.ndarray, pair: int, row: int) -> float:
    """Time between two recorded rows at which the pair's lowest point is at the ground's surface."""
    at = record.after(row)

    def height(time: float) -> float:
        return float(clearances(at(time)[0], feet)[0][pair])

    early, late = float(record.time[row]), float(record.time[row + 1])
    if height(early) * height(late) >= 0.0:
        return early if abs(height(early)) < abs(height(late)) else late
    return float(brentq(height, early, late, xtol=1e-14, rtol=8.9e-16))
