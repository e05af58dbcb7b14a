"""Numbers of claims that follow from the walks: how a foot lands, its friction in double stance, where feet stand."""

from __future__ import annotations

import numpy as np

from stages.biped.walk import Walk

#: Points of a double stance between its samples.
POINTS = 2001


def contact_place(walk: Walk, leg: int, radius: float) -> np.ndarray:
    """Place [m] down the slope of the point of a leg's foot that is nearest to the ground, (n,)."""
    centre = walk.leg_length[:, leg] - radius
    return np.asarray(walk.hip_position[:, 0] + centre * np.sin(walk.leg_angle[:, leg]))


def landing_velocity(walk: Walk, radius: float) -> tuple[float, float]:
    """Slip and descent [m/s] with which the first foot lands, just before its heel strike; NaN if none does.

    From the two samples before the strike on the straight through them: s' of eqs. (3) and (4).
    """
    if not len(walk.heel_strike_time):
        return float("nan"), float("nan")
    strike, leg = walk.heel_strike_time[0], int(walk.heel_strike_leg[0])
    rows = np.flatnonzero(walk.time < strike - 1e-9)[-2:]
    if len(rows) < 2:
        return float("nan"), float("nan")
    angle, rate = walk.leg_angle[rows, leg], walk.leg_rate[rows, leg]
    centre, stretch = walk.leg_length[rows, leg] - radius, walk.leg_length_rate[rows, leg]
    forward = walk.hip_velocity[rows, 0] + stretch * np.sin(angle) + centre * np.cos(angle) * rate
    upward = walk.hip_velocity[rows, 1] - stretch * np.cos(angle) + centre * np.sin(angle) * rate
    ahead = (strike - walk.time[rows[1]]) / (walk.time[rows[1]] - walk.time[rows[0]])
    slip, climb = (two[1] + ahead * (two[1] - two[0]) for two in (forward + radius * rate, upward))
    return abs(float(slip)), -float(climb)


def outside_the_cone(walk: Walk, friction: float) -> tuple[float, float]:
    """Shares of the last double stance, of its time and of the tangential impulse on the trailing foot, in which that
    foot needs more than `friction`; 0 where there is no double stance."""
    for strike, leg in zip(walk.heel_strike_time[::-1], walk.heel_strike_leg[::-1]):
        after = walk.toe_off_time[(walk.toe_off_time >= strike) & (walk.toe_off_leg != leg)]
        if not len(after):
            continue
        inside = np.flatnonzero((walk.time >= strike) & (walk.time <= after[0]))
        if len(inside) < 2:
            return 0.0, 0.0
        time = np.linspace(walk.time[inside[0]], walk.time[inside[-1]], POINTS)
        force = walk.ground_reaction[inside, 1 - int(leg)]
        tangential, normal = (np.interp(time, walk.time[inside], force[:, axis]) for axis in (0, 1))
        outside, size = np.abs(tangential) > friction * np.maximum(normal, 0.0), np.abs(tangential)
        return float(outside.mean()), float(size[outside].sum() / size.sum()) if size.sum() > 0 else 0.0
    return 0.0, 0.0


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
