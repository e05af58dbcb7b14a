"""Peaks of the ground's normal force and of the penetration, between the solver's steps too."""

from __future__ import annotations

from functools import partial
from math import nan

import numpy as np

from stages.biped.between_steps import largest
from stages.ground.contact_law import ContactLaw
from stages.ground.friction import normal_force
from stages.planar.trajectory import Trajectory, foot_kinematics


def peaks(
    trajectory: Trajectory, contact: ContactLaw, radii: tuple[float, float], start: float, end: float
) -> np.ndarray:
    """Largest normal force [N], NaN where none is recorded, and penetration [m] from start to end [s], of each leg's
    foot (2, 2 legs).

    Between the solver's steps by the contact law from the motion there, which is known to the steps' own order.
    """
    steps = trajectory.time[(trajectory.time > start) & (trajectory.time < end)]
    times = np.concatenate([[start], steps, [end]])
    recorded = trajectory.ground_reaction.shape[1] > 0

    def of_foot(time: np.ndarray, leg: int, kind: int) -> np.ndarray:
        depth, rate, _ = foot_kinematics(*trajectory.at(time), leg, radii[leg])
        touches = trajectory.in_play(time)[:, leg]
        if recorded:  # there may be no ground between stepping blocks
            touches &= np.interp(time, trajectory.time, trajectory.ground_reaction[:, leg, 1]) > 0.0
        depth = np.where(touches, depth, 0.0)
        return np.asarray(normal_force(contact, depth, rate) if kind == 0 else depth)

    found = np.full((2, 2), nan)
    for leg in (0, 1):
        for kind in (0, 1) if recorded else (1,):
            found[kind, leg] = largest(times, of_foot(times, leg, kind), partial(of_foot, leg=leg, kind=kind))[1]
    return found
