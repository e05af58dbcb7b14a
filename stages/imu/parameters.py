"""Settings of the ingest."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from stages.biped.quantity import Bound, parameter

POSITIVE, NOT_NEGATIVE = Bound(above=0), Bound(minimum=0)


@dataclass(frozen=True)
class Settings:
    """How measurements are judged, aligned and cut."""

    FILE: ClassVar[str] = "imu"

    database: str | None = parameter(
        "-", "SQLite file of a lab's own measurements, from the study's folder; null: the synthetic ones", file=True
    )
    gravity: float = parameter("m/s^2", "gravity where the measurement was made", symbol="g", bound=POSITIVE)
    rest_leg_angle_deg: float = parameter(
        "deg", "inner leg's angle from the slope normal in the still stand, foot ahead positive", bound=Bound(-90, 90)
    )
    rest_window_s: float = parameter("s", "shortest stretch that counts as a still stand", bound=Bound(minimum=0.1))
    rest_rate_deg_s: float = parameter("deg/s", "largest rms angular rate of a still stand", bound=POSITIVE)
    rest_acceleration: float = parameter("m/s^2", "largest rms specific force change of a still stand", bound=POSITIVE)
    grid_rate_hz: float = parameter("Hz", "rate of the common time grid", bound=Bound(minimum=10, maximum=10000))
    bridged_samples: float = parameter(
        "1", "longest distance of two samples interpolated, in sampling periods", bound=Bound(minimum=1, below=2)
    )
    skipped_steps: int = parameter("1", "first heel strikes left out of ensemble and frequency", bound=NOT_NEGATIVE)
    fewest_steps: int = parameter("1", "heel strikes a run must have to be used", bound=Bound(minimum=3))
    phase_points: int = parameter("1", "points of a registered stride", bound=Bound(minimum=11))
    slowest_step_hz: float = parameter("Hz", "lowest step frequency looked for", bound=POSITIVE)
    fastest_step_hz: float = parameter("Hz", "highest step frequency looked for", bound=POSITIVE)
    rate_tolerance: float = parameter("1", "largest relative error of a sensor's rate", bound=POSITIVE)
    clock_tolerance_s: float = parameter("s", "largest disagreement of two halves of a clock fit", bound=POSITIVE)
    loss_tolerance: float = parameter("1", "largest share of lost packets", bound=Bound(minimum=0, maximum=1))


@dataclass(frozen=True)
class Parameters:
    """All the ingest depends on besides the measurements."""

    settings: Settings
