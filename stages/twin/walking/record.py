"""What the solver left behind, and its values between the steps."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from stages.biped.between_steps import acting, hermite, hermite_from
from stages.ground.contact_law import ContactLaw
from stages.ground.slope import Slope
from stages.planar.run import COMPLETED
from stages.twin.machine.contact import SLIDE
from stages.twin.machine.kinematics import pair_axes, point_motion
from stages.twin.machine.machine import Machine
from stages.twin.result import Snapshots


@dataclass(frozen=True)
class Record:
    """A machine's run on its ground, at the solver's own steps.

    Time (n,), coordinates, rates and accelerations (n, 11) are those of `SpatialTree`.

    `switches` lists (time, pair, whether the ground acts from then on); `outcome` and `reason` tell how it ended;
    `evaluations` of the rates count rejected steps too.
    """

    machine: Machine
    slope: Slope
    contact: ContactLaw
    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    in_play_at_start: tuple[bool, bool]
    switches: tuple[tuple[float, int, bool], ...]
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

    def in_play(self, time: np.ndarray) -> np.ndarray:
        """1 where the ground acts on a pair, else 0, shape (n, 2)."""
        return acting(self.in_play_at_start, self.switches, time).astype(float)

    def at(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates and rates at given times, each (m, 11), by quintic Hermite interpolation between the steps."""
        return hermite(self.time, self.position, self.velocity, self.acceleration, time)

    def after(self, row: int) -> Callable[[float], tuple[np.ndarray, np.ndarray]]:
        """The same at one time after another between a row and the next, each (11,)."""
        return hermite_from(row, self.time, self.position, self.velocity, self.acceleration)


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
