"""What a solver left behind, step by step, and its values in between."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from stages.biped.between_steps import acting, hermite, hermite_from
from stages.planar.state import PlanarState


@dataclass(frozen=True)
class Trajectory:
    """Signals at the solver's own steps, in the slope frame.

    The columns of `position`, `velocity` and `acceleration` are hip x, hip y, angles of leg 0 and 1, lengths of leg 0
    and 1. `ground_reaction` is (n, 2 legs, 2), `foot_acceleration` that of the inner foot's mass centre, (n, 2);
    (n, 0, 2) and (n, 0) where they are not among the signals recorded.
    `in_play_at_start` tells for each leg whether the ground acted on its foot at first; `switches` lists the changes:
    (time, leg, in play).
    """

    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    foot_acceleration: np.ndarray
    ground_reaction: np.ndarray
    in_play_at_start: tuple[bool, bool]
    switches: tuple[tuple[float, int, bool], ...]
    exact_acceleration: bool

    def in_play(self, time: np.ndarray) -> np.ndarray:
        """Whether the ground acts on each foot at the given times, shape (n, 2)."""
        return acting(self.in_play_at_start, self.switches, time)

    def state_at(self, time: float) -> PlanarState:
        """State at a time [s] within the record."""
        position, velocity = (row[0].tolist() for row in self.at(np.array([time])))
        held = self.in_play(np.array([time]))[0]
        return PlanarState(
            hip_position=(position[0], position[1]),
            hip_velocity=(velocity[0], velocity[1]),
            leg_angle=(position[2], position[3]),
            leg_rate=(velocity[2], velocity[3]),
            leg_length=(position[4], position[5]),
            leg_length_rate=(velocity[4], velocity[5]),
            in_play=(bool(held[0]), bool(held[1])),
        )

    def at(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Position and velocity at the given times [s], each (n, 6), by Hermite interpolation between the steps.

        Quintic when the accelerations are exact, cubic when they ring, as those of an implicit solver do.
        """
        return hermite(self.time, self.position, self.velocity, self._known_acceleration, time)

    def after(self, row: int) -> Callable[[float], tuple[np.ndarray, np.ndarray]]:
        """The same at one time after another between a row and the next, each (6,)."""
        return hermite_from(row, self.time, self.position, self.velocity, self._known_acceleration)

    @property
    def _known_acceleration(self) -> np.ndarray | None:
        return self.acceleration if self.exact_acceleration else None


def foot_kinematics(
    position: np.ndarray, velocity: np.ndarray, leg: int, radius: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Penetration [m], its rate [m/s] and slip velocity [m/s] of one leg's foot from columns as in `Trajectory`, or one
    of their rows.
    """
    angle, rate = position[..., 2 + leg], velocity[..., 2 + leg]
    reach, reach_rate = position[..., 4 + leg] - radius, velocity[..., 4 + leg]
    sine, cosine = np.sin(angle), np.cos(angle)
    penetration = radius - (position[..., 1] - reach * cosine)
    penetration_rate = -(velocity[..., 1] - reach_rate * cosine + reach * rate * sine)
    centre_velocity = velocity[..., 0] + reach_rate * sine + reach * rate * cosine
    return penetration, penetration_rate, centre_velocity + radius * rate
