"""What the multibody stage hands on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stages.biped.quantity import quantity
from stages.biped.walk import Walk
from stages.multibody.assembly.inventory import Inventory
from stages.multibody.walking.energy import EnergyBalance


@dataclass(frozen=True)
class Cycle:
    """The settled gait: means over the last four steps, or fewer; NaN if there is no whole step."""

    period_s: float = quantity("s", "duration of one step", symbol="T")
    step_frequency_hz: float = quantity("Hz", "steps per second", symbol="f")
    step_length_m: float = quantity("m", "advance of the hip from heel strike to heel strike", symbol="s")
    speed_m_s: float = quantity("m/s", "mean walking speed", symbol="v")
    double_stance_s: float = quantity("s", "time from heel strike to toe-off", symbol="t_DSP")
    peak_normal_force: float = quantity("N", "largest normal force on a foot; NaN if not recorded", symbol="F_N")
    largest_penetration: float = quantity("m", "deepest penetration of a foot", symbol="p")
    period_change: float = quantity("s", "largest difference between the periods of these steps")


@dataclass(frozen=True)
class FrictionVariation:
    """The settled gait with one transition velocity changed; NaN if the walk ended early."""

    name: str = quantity("-", "parameter changed")
    factor: float = quantity("1", "factor on its value")
    period_s: float = quantity("s", "settled step period", symbol="T")
    step_length_m: float = quantity("m", "settled step length", symbol="s")


@dataclass(frozen=True)
class Facts:
    """How the run was made."""

    assembly: str = quantity("-", "assembly of the model")
    solver: str = quantity("-", "name of the solver")
    exudyn_version: str = quantity("-", "version and build of Exudyn")
    solver_steps: int = quantity("1", "number of solver steps")
    smallest_step: float = quantity("s", "smallest solver step after the first millisecond")
    joint_drift: float = quantity("m", "largest violation of a joint, zero in minimal coordinates")


@dataclass(frozen=True)
class Result:
    """A walk of the multibody model and what is said of it."""

    outcome: str = quantity("-", "completed, or why the walk ended early")
    message: str = quantity("-", "what the solver said if it failed")
    steps: int = quantity("1", "heel strikes")
    walk: Walk = quantity("1", "the walk from the analytic gait's mid-stance; a signal left out has no rows")
    penetration: np.ndarray = quantity("m", "penetration of each foot in contact, else 0, (n, 2) or (0, 2)", symbol="p")
    slip_velocity: np.ndarray = quantity("m/s", "slip of each foot in contact, else 0, (n, 2); or (0, 2)", symbol="v")
    cycle: Cycle = quantity("1", "the settled cycle")
    energy: EnergyBalance = quantity("1", "energy balance over the last whole step")
    friction_variations: tuple[FrictionVariation, ...] = quantity("-", "settled gait at other transition velocities")
    facts: Facts = quantity("1", "how the run was made")
    inventory: Inventory = quantity("-", "what the scene held, counted in the assembled system")

    def summary(self) -> str:
        """One line of what was found."""
        if self.outcome != "completed":
            return f"{self.outcome} after {self.steps} steps {self.message}".rstrip()
        cycle = self.cycle
        return (
            f"{self.steps} steps: {cycle.step_frequency_hz:.3f} Hz, step {1e3 * cycle.step_length_m:.1f} mm, "
            f"peak force {cycle.peak_normal_force:.0f} N, energy closed to {self.energy.relative_residual:.0e}"
        )
