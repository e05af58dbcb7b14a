"""A periodic gait, named as the command line prints it."""

from __future__ import annotations

from dataclasses import dataclass
from math import sin

import numpy as np

from stages.biped.quantity import quantity


@dataclass(frozen=True)
class StanceState:
    """State of the walker by role of the legs, eq. (2); angles: stance hip ahead, swing foot ahead, positive."""

    stance_angle: float = quantity("rad", "stance leg angle, hip ahead positive", symbol="theta")
    stance_length: float = quantity("m", "stance leg length", symbol="L_1")
    swing_angle: float = quantity("rad", "swing leg angle, foot ahead positive", symbol="psi")
    swing_length: float = quantity("m", "swing leg length", symbol="L_2")
    stance_rate: float = quantity("rad/s", "stance leg rate", symbol="dtheta/dt")
    stance_length_rate: float = quantity("m/s", "stance leg length rate", symbol="dL_1/dt")
    swing_rate: float = quantity("rad/s", "swing leg rate", symbol="dpsi/dt")
    swing_length_rate: float = quantity("m/s", "swing leg length rate", symbol="dL_2/dt")

    def feet_apart(self, radii: tuple[float, float]) -> float:
        """How far the stance foot is ahead of the other [m], of feet of these radii [m]."""
        behind = (self.swing_length - radii[1]) * sin(self.swing_angle)
        return -(self.stance_length - radii[0]) * sin(self.stance_angle) - behind


@dataclass(frozen=True)
class Gait:
    """One periodic gait. A step runs from heel strike to heel strike of the other leg."""

    period_s: float = quantity("s", "duration of one step", symbol="T")
    step_frequency_hz: float = quantity("Hz", "steps per second", symbol="f")
    step_length_m: float = quantity("m", "advance of the hip in one step", symbol="s")
    speed_m_s: float = quantity("m/s", "mean walking speed", symbol="v")
    double_stance_s: float = quantity("s", "time with both feet on the ground in one step", symbol="t_DSP")
    floquet_multipliers: np.ndarray = quantity(
        "1", "multipliers of the step map, largest first, rows of real and imaginary part, shape (j, 2)",
        dimensions=("multiplier", "part")
    )
    stable: bool = quantity("1", "whether every multiplier lies inside the unit circle")
    fixed_point: StanceState = quantity("1", "state just after heel strike, legs already renamed")
