"""What the solver left behind, and its values between the steps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stages.ground.contact_law import ContactLaw
from stages.ground.slope import Slope
from stages.multibody.walking.scuffing import COMPLETED
from stages.twin.machine.machine import Machine


@dataclass(frozen=True)
class Record:
    """A machine's run on its ground, at the solver's own steps.

    Time (n,), coordinates, rates and accelerations (n, 11) are those of `SpatialTree`.

    `switches` lists (time, pair, whether the ground acts from then on); `outcome` and `reason` tell how it ended.
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
        held = np.tile(np.array(self.in_play_at_start, dtype=float), (len(time), 1))
        for moment, pair, acts in self.switches:
            held[time >= moment, pair] = float(acts)
        return held

    def at(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates and rates at given times, each (m, 11), by quintic Hermite interpolation between the steps."""
        i = np.clip(np.searchsorted(self.time, time, side="right") - 1, 0, len(self.time) - 2)
        h = (self.time[i + 1] - self.time[i])[:, None]
        s = (time - self.time[i])[:, None] / h
        start, rise = self.position[i], self.position[i + 1] - self.position[i]
        a1, b1 = self.velocity[i] * h, self.velocity[i + 1] * h
        a2, b2 = 0.5 * self.acceleration[i] * h**2, 0.5 * self.acceleration[i + 1] * h**2
        c3 = 10 * rise - 6 * a1 - 4 * b1 - 3 * a2 + b2
        c4 = -15 * rise + 8 * a1 + 7 * b1 + 3 * a2 - 2 * b2
        c5 = 6 * rise - 3 * a1 - 3 * b1 - a2 + b2
        position = start + s * (a1 + s * (a2 + s * (c3 + s * (c4 + s * c5))))
        velocity = (a1 + s * (2 * a2 + s * (3 * c3 + s * (4 * c4 + s * 5 * c5)))) / h
        return position, velocity

    def acceleration_at(self, time: np.ndarray) -> np.ndarray:
        """Accelerations at given times (m, 11), linear between the steps: they have kinks."""
        i = np.clip(np.searchsorted(self.time, time, side="right") - 1, 0, len(self.time) - 2)
        s = ((time - self.time[i]) / (self.time[i + 1] - self.time[i]))[:, None]
        return np.asarray((1.0 - s) * self.acceleration[i] + s * self.acceleration[i + 1])
