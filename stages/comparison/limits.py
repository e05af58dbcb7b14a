"""Limits that the figures show too."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from stages.biped.quantity import Bound, parameter


@dataclass(frozen=True)
class Limits:
    """What the figures show too: how far the paper's models differ, and how a stride is cut."""

    FILE: ClassVar[str] = "comparison"

    position_limit: float = parameter("m", "largest hip difference the paper states", bound=Bound(above=0))
    velocity_limit: float = parameter("m/s", "largest hip velocity difference the paper states", bound=Bound(above=0))
    phase_points: int = parameter("1", "points of a stride", bound=Bound(minimum=11, maximum=100_001))
