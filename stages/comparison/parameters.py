"""Settings of the comparison."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from stages.biped.quantity import Bound, parameter
from stages.ground.friction_coefficients import Friction


@dataclass(frozen=True)
class Limits:
    """What the figures show too: how far the paper's models differ, and how a stride is cut."""

    FILE: ClassVar[str] = "comparison"

    position_limit: float = parameter("m", "largest hip difference the paper states", bound=Bound(above=0))
    velocity_limit: float = parameter("m/s", "largest hip velocity difference the paper states", bound=Bound(above=0))
    phase_points: int = parameter("1", "points of a stride", bound=Bound(minimum=11, maximum=100_001))


@dataclass(frozen=True)
class Settings(Limits):
    """What counts as agreement."""

    frequency_tolerance: float = parameter(
        "1", "largest relative difference of step frequencies called equal", bound=Bound(above=0, maximum=1)
    )
    similarity_limit: float = parameter(
        "1",
        "rms difference over range below which two curves are called nearly identical",
        bound=Bound(above=0, maximum=1),
    )
    enclosure_share: float = parameter(
        "1",
        "share of the stride from which the measurements are said to enclose a curve",
        bound=Bound(above=0, maximum=1),
    )
    skipped_steps: int = parameter(
        "1", "heel strikes of the twin left out where runs are compared with it", bound=Bound(minimum=0, maximum=100)
    )


@dataclass(frozen=True)
class Parameters:
    """Parameters of the comparison stage."""

    friction: Friction
    settings: Settings
