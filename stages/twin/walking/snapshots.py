"""Poses of the twin for a figure in space."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stages.biped.quantity import quantity
from stages.twin.machine.contact import SLIDE
from stages.twin.machine.kinematics import pair_axes, point_motion
from stages.twin.walking.record import Record


@dataclass(frozen=True)
class Snapshots:
    """Poses at k times; legs: inner left, inner right, outer left, outer right; feet are cylinders about `hip_axis`."""

    time: np.ndarray = quantity("s", "times, shape (k,)", symbol="t")
    hip: np.ndarray = quantity("m", "middle of the hip axis, shape (k, 3)", dimensions=("time", "direction"))
    hip_axis: np.ndarray = quantity("1", "direction of the hip axis, shape (k, 3)", dimensions=("time", "direction"))
    leg_top: np.ndarray = quantity(
        "m", "where each leg meets the hip axis, shape (k, 4, 3)", dimensions=("time", "leg", "direction")
    )
    leg_up: np.ndarray = quantity(
        "1", "direction up each leg, shape (k, 4, 3)", dimensions=("time", "leg", "direction")
    )
    foot_centre: np.ndarray = quantity(
        "m", "centre of each foot's cylinder, shape (k, 4, 3)", dimensions=("time", "leg", "direction")
    )
    foot_radius: np.ndarray = quantity("m", "radius of each foot, shape (4,)", dimensions=("leg",))
    foot_width: float = quantity("m", "width of each foot")


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
