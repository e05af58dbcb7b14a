"""Settings of the ingest, and what a sensor's low pass delays."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

from stages.biped.accuracy.scales import GRAVITY, Following, followed, outsole, quickness
from stages.biped.accuracy.tolerances import Level
from stages.biped.design import Biped
from stages.biped.quantity import Bound, Broken, parameter
from stages.ground.slope import Slope

POSITIVE, NOT_NEGATIVE = Bound(above=0), Bound(minimum=0)


def filter_delay(bandwidth_hz: float | None) -> float:
    """Delay of a second-order Butterworth low pass far below its cut-off, sqrt(2) / (2 pi f_c) [s]."""
    return 0.0 if bandwidth_hz is None else math.sqrt(2) / (2 * math.pi * bandwidth_hz)


@dataclass(frozen=True)
class Settings:
    """How measurements are judged, aligned and cut."""

    FILE: ClassVar[str] = "imu"

    database: str | None = parameter(
        "-", "SQLite file of a lab's own measurements, from the study's folder; null: the synthetic ones", file=True
    )
    gravity: Following = parameter(
        "m/s^2", "gravity where the measurement was made; null: ground.gravity", symbol="g", bound=POSITIVE)
    rest_leg_angle_deg: float = parameter(
        "deg", "inner leg's angle from the slope normal in the still stand, foot ahead positive", bound=Bound(-90, 90)
    )
    rest_window_s: float = parameter("s", "shortest stretch that counts as a still stand", bound=Bound(minimum=0.1))
    rest_rate_deg_s: Following = parameter(
        "deg/s", "largest rms angular rate of a still stand; null: 3 deg/s for Table 1's robot", bound=POSITIVE)
    rest_acceleration: Following = parameter(
        "m/s^2", "largest rms specific force change of a still stand; null: 0.3 m/s^2 at 9.81 m/s^2", bound=POSITIVE)
    grid_rate_hz: Following = parameter(
        "Hz", "rate of the common time grid; null: 200 Hz for Table 1's robot", bound=Bound(minimum=10, maximum=10000))
    bridged_samples: float = parameter(
        "1", "longest distance of two samples interpolated, in sampling periods", bound=Bound(minimum=1, below=2)
    )
    skipped_steps: int = parameter("1", "first heel strikes left out of ensemble and frequency", bound=NOT_NEGATIVE)
    fewest_steps: int = parameter("1", "heel strikes a run must have to be used", bound=Bound(minimum=3))
    phase_points: int = parameter("1", "points of a registered stride", bound=Bound(minimum=11))
    slowest_step_hz: Following = parameter(
        "Hz", "lowest step frequency looked for; null: 0.8 Hz for Table 1's robot", bound=POSITIVE)
    fastest_step_hz: Following = parameter(
        "Hz", "highest step frequency looked for; null: 4 Hz for Table 1's robot", bound=POSITIVE)
    rate_tolerance: float = parameter("1", "largest relative error of a sensor's rate", bound=POSITIVE)
    clock_tolerance_s: float = parameter("s", "largest difference of the smallest delays in time", bound=POSITIVE)
    loss_tolerance: float = parameter("1", "largest share of lost packets", bound=Bound(minimum=0, maximum=1))

    @property
    def slowest_stride_hz(self) -> float:
        """Lowest frequency looked for at which a leg swings to and fro [Hz]."""
        return 0.5 * self.slowest_step_hz


@dataclass(frozen=True)
class Limits:
    """From where on a trial's evidence speaks against it."""

    FILE: ClassVar[str] = "imu"

    lever_arm: Following = parameter(
        "m", "distance of the foot sensor below the hip sensor; null: by biped.yaml, to the leg's mass centre",
        symbol="d", bound=POSITIVE,
    )
    lever_arm_tolerance: float = parameter("1", "largest relative departure of the lever arm from it", bound=POSITIVE)
    lever_direction_deg: float = parameter("deg", "largest angle of the lever arm from the leg's line", bound=POSITIVE)
    forward_gain_tolerance: float = parameter(
        "1", "largest relative difference of the accelerometers' gains forward", bound=POSITIVE)
    smallest_agreement: float = parameter(
        "1", "smallest squared correlation of the foot's and the hip's lateral rate", bound=Bound(above=0, below=1)
    )
    usual_agreement: float = parameter(
        "1", "smallest squared correlation without a remark", bound=Bound(above=0, below=1)
    )
    agreement_by_motion: float = parameter(
        "1", "smallest such correlation by which motion alone brings two clocks together", bound=Bound(above=0, below=1)
    )
    rate_tolerance_of_places: float = parameter("1", "largest relative difference of these two rates", bound=POSITIVE)
    rate_gain_tolerance: float = parameter(
        "1", "largest relative departure of two gyroscopes from how gravity turns without a remark", bound=POSITIVE)
    leg_length_tolerance: float = parameter(
        "1", "largest relative departure of the standing leg from its nominal length without a remark", bound=POSITIVE)
    rate_scale_tolerance: float = parameter("1", "largest relative error of a gyroscope that is used", bound=POSITIVE)
    smallest_overlap: float = parameter(
        "1", "smallest share of the longer recording that both sensors cover", bound=Bound(minimum=0, maximum=1)
    )
    usual_overlap: float = parameter(
        "1", "smallest such share without a remark", bound=Bound(minimum=0, maximum=1)
    )
    mounting_deg: float = parameter("deg", "largest angle to the declared mounting", bound=Bound(above=0, maximum=90))
    swing_residual_deg: float = parameter("deg", "largest angle of the swing axis off level", bound=POSITIVE)
    swing_share: float = parameter(
        "1", "smallest share of the motion about the swing axis", bound=Bound(minimum=0, maximum=1)
    )
    third_moment: float = parameter("1", "smallest skewness of the lateral rate that shows forward", bound=POSITIVE)
    turning: float = parameter(
        "1", "smallest signed R2 of the forward force, foot less hip, with how a rate changes",
        bound=Bound(minimum=-1, below=1),
    )
    strike_symmetry_deg: float = parameter("deg", "largest mean of the leg's angles at both landings", bound=POSITIVE)
    gravity_tolerance: float = parameter("1", "largest relative departure of the specific force's mean from gravity",
                                         bound=POSITIVE)  # fmt: skip
    gravity_direction_deg: float = parameter("deg", "largest angle of that mean from gravity", bound=POSITIVE)
    turned_deg: float = parameter("deg", "largest turn within a walk of the swing axis on a sensor, and of gravity "
                                  "beside its rate, without a remark", bound=POSITIVE)  # fmt: skip
    hidden_strikes: float = parameter("1", "largest share of heel strikes in holes without a remark",
                                      bound=Bound(minimum=0, maximum=1))  # fmt: skip
    spacing: float = parameter("1", "largest departure of a step from the median, relative", bound=POSITIVE)
    clipped_share: float = parameter("1", "largest share of samples at full scale", bound=Bound(minimum=0, maximum=1))
    unusable_share: float = parameter("1", "largest share of rows without number or stamp",
                                      bound=Bound(minimum=0, maximum=1))  # fmt: skip


#: Errors in time are of one robot at 100 Hz (`in_time` of stages/imu/trial/walk.py has the others').
SCALED = ", scaled from Table 1's"


@dataclass(frozen=True)
class Drawing:
    """What the ingest must know of the robot to turn angles into lengths, and how well."""

    FILE: ClassVar[str] = "imu"

    leg_length: Following = parameter(
        "m", "leg from the hip to the bottom of the foot, outsole included; null: of biped.yaml and campaign.outsole",
        symbol="L", bound=POSITIVE)  # fmt: skip
    foot_radius: Following = parameter(
        "m", "radius of the foot, outsole included; null: of biped.yaml and campaign.outsole", symbol="r",
        bound=NOT_NEGATIVE)  # fmt: skip
    leg_length_error: float = parameter("1", "standard error of the leg's length, relative", bound=NOT_NEGATIVE)
    rolling_error: float = parameter("1", "what a step departs from rolling on a rigid leg, relative, standard "
                                     "deviation", bound=NOT_NEGATIVE)  # fmt: skip
    gain_error: float = parameter(
        "1", "standard error of an accelerometer's gain, and so of a gyroscope's, relative", bound=NOT_NEGATIVE)
    swept_error: float = parameter("1", "relative standard error of gain and length by gravity's turning at one "
                                   "sensor, from soft legs", bound=NOT_NEGATIVE)  # fmt: skip
    sag: Following = parameter("m", "how much shorter a leg is while it stands; null: by the weight on its spring",
                               bound=NOT_NEGATIVE)  # fmt: skip
    onset_error_s: float = parameter(
        "s", f"standard error of when a leg's impacts begin, the same for all of a run{SCALED}",
        bound=NOT_NEGATIVE)
    strike_scatter_s: float = parameter(
        "s", f"standard deviation of single strikes about that{SCALED}", bound=NOT_NEGATIVE)
    toe_off_error_s: float = parameter(
        "s", f"standard error of when the foot is let go{SCALED}", bound=NOT_NEGATIVE)
    stand_error_deg: float = parameter("deg", "standard error of rest_leg_angle_deg", bound=NOT_NEGATIVE)

    def broken_rules(self) -> Iterator[Broken]:
        """The foot is smaller than the leg."""
        if self.foot_radius is not None and self.leg_length is not None and self.foot_radius >= self.leg_length:
            yield Broken("foot_radius", f"< leg_length = {self.leg_length:g} m")


@dataclass(frozen=True)
class Cover:
    """What lies under the foot of Table 1."""

    FILE: ClassVar[str] = "campaign"

    outsole: Following = parameter(
        "m", "mean thickness of the rubber outsole; null: 2 mm for Table 1's robot", bound=NOT_NEGATIVE)

    def of(self, biped: Biped) -> float:
        """Its thickness under a robot [m]."""
        return outsole(biped) if self.outsole is None else self.outsole


@dataclass(frozen=True)
class Parameters:
    """All the ingest depends on besides the measurements, with nothing left null."""

    settings: Settings
    limits: Limits
    drawing: Drawing
    biped: Biped
    slope: Slope
    cover: Cover
    level: Level = Level()

    def __post_init__(self) -> None:
        """What is null follows the robot and its ground."""
        biped, gravity, quick = self.biped, self.slope.gravity, self.quick
        rubber = self.cover.of(biped)
        settings = followed(self.settings, gravity=gravity, rest_rate_deg_s=3.0 * quick,
                            rest_acceleration=0.3 * (gravity / GRAVITY), grid_rate_hz=200.0 * quick,
                            slowest_step_hz=0.8 * quick, fastest_step_hz=4.0 * quick)  # fmt: skip
        weight = 0.0 if biped.legs == "rigid" else (biped.total_mass - biped.foot_mass) * gravity
        drawing = followed(self.drawing, leg_length=biped.leg_length + rubber, foot_radius=biped.foot_radius + rubber,
                           sag=weight / biped.stiffness)
        limits = followed(self.limits, lever_arm=biped.leg_length - biped.foot_com)
        for name, value in (("settings", settings), ("limits", limits), ("drawing", drawing)):
            object.__setattr__(self, name, value)

    @property
    def quick(self) -> float:
        """How quick the robot is, in Table 1's."""
        return quickness(self.biped, self.slope.gravity)
