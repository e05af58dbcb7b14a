"""The penalty model's solver as the budget uses it."""

from __future__ import annotations

from stages.multibody.parameters import Settings


class NotWalked(Exception):
    """A model on the path does not take the step; the message says why."""


def solver_settings(largest_step: float, tolerance: float) -> Settings:
    """The explicit solver of the tree assembly; what belongs to the other assembly is not used."""
    return Settings(
        assembly="tree",
        steps=1,
        sampling_rate_hz=1000.0,
        tolerance=tolerance,
        largest_step=largest_step,
        implicit_solver="trapezoidal",
        rolling_step=1e-4,
        impact_step=1e-5,
        impact_window=0.02,
        longest_step=3.0,
        most_solver_steps=500_000,
    )
