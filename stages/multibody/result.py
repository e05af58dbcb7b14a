"""What the multibody stage hands on."""

from dataclasses import dataclass

import numpy as np

from stages.biped.accuracy.estimate import ErrorEstimate
from stages.biped.quantity import LEFT, count_of, quantity
from stages.biped.walk import Walk, largest_of_a_step
from stages.multibody.assembly.inventory import Inventory
from stages.planar.energy import EnergyBalance
from stages.planar.run import LimitCycle


def in_newtons(force: float) -> str:
    """A force [N] in whole newtons, or in three digits where these are fewer."""
    return f"{force:.3g} N" if force < 100 else f"{force:.0f} N"


@dataclass(frozen=True)
class Cycle:
    """The gait as the fixed point of the step map from mid-stance to mid-stance, with its multipliers.

    Where no fixed point is found: means over the last four steps of the walk, or fewer; NaN without a whole step.
    """

    solved: bool = quantity("1", "whether this is a fixed point, else means over the walk's last steps")
    period_s: float = quantity("s", "duration of one step", symbol="T")
    step_frequency_hz: float = quantity("Hz", "steps per second", symbol="f")
    step_length_m: float = quantity("m", "advance of the hip in one step", symbol="s")
    speed_m_s: float = quantity("m/s", "mean walking speed", symbol="v")
    double_stance_s: float = quantity("s", "time from heel strike to toe-off", symbol="t_DSP")
    peak_normal_force: float = quantity("N", "largest normal force on a foot; NaN if not recorded", symbol="F_N")
    largest_penetration: float = quantity("m", "deepest penetration of a foot", symbol="p")
    floquet_multipliers: np.ndarray = quantity(
        "1", "multipliers of the step map, largest first, rows of real and imaginary part, (10, 2), or (0, 2)",
        dimensions=("multiplier", "part"), unordered="eigenvalues")
    steps: int = quantity("1", "steps that these multipliers are of: two where the legs differ")
    residual: float = quantity(
        "1", "how far the fixed point moves in one step, in the scales of the section", without_error=LEFT)
    period_change: float = quantity("s", "largest difference between the periods of the walk's last four steps")

    @property
    def largest_multiplier(self) -> float:
        """Magnitude of the largest multiplier, of one step; NaN without a fixed point."""
        return largest_of_a_step(self.floquet_multipliers, self.steps)


@dataclass(frozen=True)
class Facts:
    """How the run was made."""

    assembly: str = quantity("-", "assembly of the model")
    solver: str = quantity("-", "name of the solver")
    exudyn_version: str = quantity("-", "version and build of Exudyn")
    solver_steps: int = quantity("1", "number of solver steps")
    smallest_step: float = quantity("s", "smallest solver step after the first millisecond",
                                    without_error="the solver chooses it; no number of the walk")
    joint_drift: float = quantity("m", "largest violation of a joint, zero in minimal coordinates")


@dataclass(frozen=True)
class Result:
    """A walk of the multibody model and what is said of it."""

    outcome: str = quantity("-", "completed, or why the walk ended early")
    message: str = quantity("-", "what the solver said if it failed")
    steps: int = quantity("1", "heel strikes")
    walk: Walk = quantity("1", "the walk from the analytic gait's mid-stance; a signal left out has no rows")
    penetration: np.ndarray = quantity(
        "m", "penetration of each foot in contact, else 0, (n, 2) or (0, 2)", symbol="p", dimensions=("time", "leg")
    )
    slip_velocity: np.ndarray = quantity(
        "m/s", "slip of each foot in contact, else 0, (n, 2); or (0, 2)", symbol="v", dimensions=("time", "leg")
    )
    settled: bool = quantity("1", "whether the walk has settled on a stable cycle")
    unsettled: str = quantity("-", "why it has not, else empty")
    cycle: Cycle = quantity("1", "the gait, solved for")
    mid_stance: LimitCycle | None = quantity("-", "the gait's fixed point, with the derivative of its step")
    energy: EnergyBalance = quantity("1", "energy balance over the last whole step")
    errors: tuple[ErrorEstimate, ...] = quantity("-", "errors of the walk, where an accuracy was requested")
    facts: Facts = quantity("1", "how the run was made")
    inventory: Inventory = quantity("-", "what the scene held, counted in the assembled system")

    def summary(self) -> str:
        """One line of what was found."""
        if self.outcome != "completed":
            return f"{self.outcome} after {count_of(self.steps, 'step')}: {self.message}".removesuffix(": ")
        cycle = self.cycle
        found = (
            f"{cycle.step_frequency_hz:.3f} Hz, step {1e3 * cycle.step_length_m:.1f} mm, "
            f"peak force {in_newtons(cycle.peak_normal_force)}"
        )
        if not self.settled:
            kind = "its cycle" if cycle.solved else "mean of the last steps"
            return f"{self.steps} steps, does not settle: {self.unsettled}; {kind} {found}"
        return (
            f"{self.steps} steps: {found}, |multiplier| {cycle.largest_multiplier:.3f}, "
            f"energy closed to {self.energy.relative_residual:.0e}"
        )
