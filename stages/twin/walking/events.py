"""Heel strikes and toe-offs of a twin's walk, located between the solver's steps."""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

from stages.multibody.walking.events import Events
from stages.twin.machine.contact import clearances, clearances_along
from stages.twin.walking.record import Record


def find_events(record: Record) -> Events:
    """First touch-down and last lift-off of each pair's lowest point while the ground acts on the pair.

    A pair that bounces at heel strike counts once. A pair still on the ground at the end has no toe-off yet.
    """
    feet = record.machine.feet
    lowest = clearances_along(record.position, feet)
    strikes: list[tuple[float, int]] = []
    lift_offs: list[tuple[float, int]] = []
    for pair in (0, 1):
        for start, end, ended in _episodes(record, pair):
            inside = np.flatnonzero((record.time >= start) & (record.time <= end))
            touching = lowest[inside, pair] < 0.0
            if not touching.any():
                continue
            first, last = inside[np.argmax(touching)], inside[len(inside) - 1 - np.argmax(touching[::-1])]
            if first > inside[0]:
                strikes.append((_crossing(record, feet, pair, first - 1), pair))
            if ended and last < inside[-1]:
                lift_offs.append((_crossing(record, feet, pair, last), pair))
    columns = []
    for events in (sorted(strikes), sorted(lift_offs)):
        columns += [np.array([time for time, _ in events]), np.array([pair for _, pair in events], dtype=np.int64)]
    return Events(*columns)


def _episodes(record: Record, pair: int) -> list[tuple[float, float, bool]]:
    """Spans in which the ground acts on a pair: start, end, and whether the span ended before the record did."""
    spans: list[tuple[float, float, bool]] = []
    begin: float | None = 0.0 if record.in_play_at_start[pair] else None
    for time, which, acts in record.switches:
        if which != pair:
            continue
        if acts:
            begin = time
        elif begin is not None:
            spans.append((begin, time, True))
            begin = None
    return spans if begin is None else [*spans, (begin, float(record.time[-1]), False)]


def _crossing(record: Record, feet: np.ndarray, pair: int, row: int) -> float:
    """Time between two recorded rows at which the pair's lowest point is at the ground's surface."""

    def height(time: float) -> float:
        return float(clearances(record.at(np.array([time]))[0][0], feet)[0][pair])

    early, late = float(record.time[row]), float(record.time[row + 1])
    if height(early) * height(late) >= 0.0:
        return early if abs(height(early)) < abs(height(late)) else late
    return float(brentq(height, early, late, xtol=1e-14, rtol=8.9e-16))
