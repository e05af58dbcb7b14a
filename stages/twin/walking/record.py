"""What the solver left behind, its values between the steps, and the heel strikes and toe-offs in it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stages.ground.contact_law import ContactLaw
from stages.ground.slope import Slope
from stages.planar.run import COMPLETED, Recorded
from stages.planar.sampling import Events, located
from stages.twin.machine.contact import SLIDE, clearances, clearances_along
from stages.twin.machine.kinematics import pair_axes, point_motion
from stages.twin.machine.machine import Machine
from stages.twin.result import Snapshots


@dataclass(frozen=True)
class Record(Recorded):
    """A machine's run on its ground: coordinates, rates and accelerations (n, 11) are those of `SpatialTree`.

    `outcome` and `reason` tell how it ended; `evaluations` of the rates count rejected steps too.
    """

    machine: Machine
    slope: Slope
    contact: ContactLaw
    outcome: str
    reason: str
    heel_strikes: int
    evaluations: int
    wall_time: float

    @property
    def completed(self) -> bool:
        """Whether it walked as many steps as it was asked to."""
        return self.outcome == COMPLETED

    @property
    def steps(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Coordinates, rates and accelerations at the solver's steps, each (n, 11)."""
        return self.position, self.velocity, self.acceleration

    def ground(self, time: np.ndarray) -> np.ndarray:
        """1 where the ground acts on a pair, else 0, and its heights under the pairs [m], (n, 4)."""
        return np.hstack([self.in_play(time), self.under(time)])


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


def find_events(record: Record) -> Events:
    """First touch-down and last lift-off of each pair's lowest point while the ground acts on the pair.

    A pair that bounces at heel strike counts once. A pair still on the ground at the end has no toe-off yet.
    """
    feet = record.machine.feet

    def depth_at(position: np.ndarray, velocity: np.ndarray, leg: int) -> float:
        return -float(clearances(position, feet)[0][leg])

    return located(record, -clearances_along(record.position, feet), depth_at, within=1e-14)
