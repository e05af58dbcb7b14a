"""How the penalty walker is integrated."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Settings:
    """Tolerance, absolute and relative alike, in the design's scales; moments between two steps of the integrator that
    are recorded too; the time without a heel strike after which a walk counts as stalled [s], None: by its size; the
    steps after which the solver is stuck.
    """

    tolerance: float
    between: int = 0
    longest_step: float | None = None
    most_solver_steps: int = 500_000
