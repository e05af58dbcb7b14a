"""Numbers of claims that follow from the walks: where feet stand."""

from __future__ import annotations

import numpy as np

from stages.biped.walk import Walk


def contact_place(walk: Walk, leg: int, radius: float) -> np.ndarray:
    """Place [m] down the slope of the point of a leg's foot that is nearest to the ground, (n,)."""
    centre = walk.leg_length[:, leg] - radius
    return np.asarray(walk.hip_position[:, 0] + centre * np.sin(walk.leg_angle[:, leg]))


def block_reach(walk: Walk, radius: float, step: float, sets: int) -> tuple[float, float]:
    """How far [m] standing feet come from the middles of blocks `step` [m] apart, and how far they roll on average.

    The first block's middle is where the first foot stands at the start. NaN with fewer steps than there are sets.
    """
    places = [contact_place(walk, leg, radius) for leg in (0, 1)]
    origin, reaches, spans = places[0][0], [], []
    for number, (strike, leg) in enumerate(zip(walk.heel_strike_time, walk.heel_strike_leg), 1):
        after = walk.toe_off_time[(walk.toe_off_time > strike) & (walk.toe_off_leg == leg)]
        if number == sets or not len(after):
            break
        edges = np.interp([strike, after[0]], walk.time, places[int(leg)]) - origin - number * step
        reaches.append(np.abs(edges).max())
        spans.append(np.ptp(edges))
    enough = len(reaches) == sets - 1
    return (float(max(reaches)), float(np.mean(spans))) if enough else (float("nan"), float("nan"))
