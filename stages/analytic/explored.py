"""What is kept of explorations: families of gaits over a parameter, and starts with where they lead."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stages.biped.quantity import quantity

#: Multipliers as near to the unit circle as this are on it.
ON_CIRCLE = 1e-7
#: How a walk ends, in words; a walk is known by its number here.
ENDINGS = (
    "reaches the gait", "walks on, elsewhere", "falls forward", "falls or rocks back", "stands still or rocks",
    "ends otherwise", "no such start",
)  # fmt: skip
REACHES, WALKS_ON, FORWARD, BACK, STILL, OTHERWISE, NO_START = range(len(ENDINGS))


@dataclass(frozen=True)
class Basin:
    """Map over angle and rate of the stance leg just after heel strike, the other section coordinates as the gait's."""

    stance_angle: np.ndarray = quantity(
        "rad", "stance angle at the start, foot ahead positive, (n,)", dimensions=("stance_angle",))
    stance_rate: np.ndarray = quantity("rad/s", "stance rate at the start, (m,)", dimensions=("stance_rate",))
    steps: np.ndarray = quantity(
        "1", "steps made until the walk reaches a gait or ends, at most `most_steps`, (n, m)",
        dimensions=("stance_angle", "stance_rate"))
    reached: np.ndarray = quantity(
        "1", "number of the gait that is reached, -1: none, (n, m)", dimensions=("stance_angle", "stance_rate"))
    ending: np.ndarray = quantity(
        "1", "how the walk ends, the place in `endings`, (n, m)", dimensions=("stance_angle", "stance_rate"))
    gait_angle: float = quantity("rad", "stance angle of the first gait, foot ahead positive")
    gait_rate: float = quantity("rad/s", "stance rate of the first gait")
    most_steps: int = quantity("1", "most steps of a walk")
    near: float = quantity("1", "a walk is at a gait within this, in all section coordinates")
    endings: tuple[str, ...] = quantity("-", "how a walk ends, in words", default=ENDINGS)

    @property
    def share(self) -> float:
        """Part of the starts that reach a gait."""
        return float((self.ending == REACHES).mean())


@dataclass(frozen=True)
class Turn:
    """A gait where its family turns back, doubles its period, or is left by a torus."""

    kind: str = quantity("-", "turning point, period doubling or torus")
    value: float = quantity("1", "value of the parameter, in its unit")
    multiplier: float = quantity("1", "real part of the multiplier that is nearest to the one of its kind: 1, -1")
    step_duration: np.ndarray = quantity("s", "duration of each step of the cycle, (cycle,)")
    stance_angle: np.ndarray = quantity("rad", "stance angle at heel strike, foot ahead positive, (cycle,)")


@dataclass(frozen=True)
class RecordedFamily:
    """Gaits of `cycle` steps over a parameter, n in order along the curve.

    Where the legs differ, steps are counted in pairs: a gait has `cycle` strides.
    """

    cycle: int = quantity("1", "steps after which the gait repeats")
    ended: str = quantity("-", "why the family ends, down and up the parameter, or away from the doubling")
    value: np.ndarray = quantity("1", "value of the parameter, in its unit, (n,)", dimensions=("gait",))
    step_duration: np.ndarray = quantity(
        "s", "duration of each step of the cycle, (n, cycle)", dimensions=("gait", "step"))
    stance_angle: np.ndarray = quantity(
        "rad", "stance angle at each heel strike, foot ahead positive, (n, cycle)", dimensions=("gait", "step"))
    double_stance: np.ndarray = quantity(
        "s", "time of each step with both feet on the ground, (n, cycle)", dimensions=("gait", "step"))
    floquet_multipliers: np.ndarray = quantity(
        "1", "multipliers of the whole cycle, largest first, rows of real and imaginary part, (n, j, 2)",
        dimensions=("gait", "multiplier", "part"))
    turns: tuple[Turn, ...] = quantity("-", "turning points, period doublings and tori")

    @property
    def steps(self) -> int:
        """Steps after which the gait repeats."""
        return int(self.step_duration.shape[1])

    @property
    def stable(self) -> np.ndarray:
        """Whether every multiplier lies inside the unit circle, (n,); at a turn one is on it."""
        magnitude = np.hypot(self.floquet_multipliers[..., 0], self.floquet_multipliers[..., 1])
        inside: np.ndarray = magnitude.max(axis=1) < 1.0 - ON_CIRCLE
        return inside
