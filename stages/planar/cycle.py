"""A gait on penalty ground, as it is handed on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stages.biped.quantity import quantity


@dataclass(frozen=True)
class LimitCycle:
    """A gait at mid-stance; rows and columns are the numbers of `section_numbers`.

    Where the legs differ, derivative and multipliers are those of two steps, period and length the means of both.
    """

    section_state: np.ndarray = quantity(
        "m, rad, m/s, rad/s", "hip y, swing angle, both lengths, then the rates, (10,)", dimensions=("coordinate",)
    )
    period_s: float = quantity("s", "duration of one step", symbol="T")
    step_length_m: float = quantity("m", "advance of the hip in one step", symbol="s")
    monodromy_matrix: np.ndarray = quantity("-", "derivative of the step map in those units, shape (10, 10)")
    floquet_multipliers: np.ndarray = quantity(
        "1", "eigenvalues, largest first, real and imaginary part, (10, 2)", dimensions=("multiplier", "part")
    )
    residual: float = quantity("1", "how far the fixed point moves in one step, in the scales of the section")
    solver_steps: int = quantity("1", "solver steps of one step")
    steps_walked: int = quantity("1", "steps walked to find the gait and its derivative")
