"""Poses of the twin for a figure in space."""

from __future__ import annotations

import numpy as np

from stages.twin.machine.contact import SLIDE
from stages.twin.machine.kinematics import pair_axes, point_motion
from stages.twin.result import Snapshots
from stages.twin.walking.record import Record


def snapshots(record: Record, times: np.ndarray) -> Snapshots:
    """Poses at given times [s]."""
    machine = record.machine
    q, v = record.at(times)
    none = np.zeros_like(q)
    axes = [pair_axes(q, v, none, pair) for pair in (0, 1)]
    tops, ups, centres = [], [], []
    for leg, slide in enumerate(SLIDE):
        pair, lane = axes[leg // 2], machine.lane[leg]
        low = np.array([0.0, machine.radius[leg] - machine.length[leg], lane])
        tops.append(point_motion(q, v, none, pair, np.array([0.0, 0.0, lane])).position)
        centres.append(point_motion(q, v, none, pair, low, slide).position)
        ups.append(pair.upward)
    return Snapshots(
        time=times,
        hip=q[:, :3].copy(),
        hip_axis=axes[0].lateral,
        leg_top=np.stack(tops, axis=1),
        leg_up=np.stack(ups, axis=1),
        foot_centre=np.stack(centres, axis=1),
        foot_radius=machine.radius.copy(),
        foot_width=2.0 * machine.half_width,
    )
