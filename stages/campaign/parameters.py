"""Parameters of the synthetic campaign: how runs differ, what the sensors and the radio do."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

from stages.biped.accuracy.scales import GRAVITY, Following, followed, outsole, quickness, size
from stages.biped.accuracy.tolerances import CLOSER
from stages.biped.design import Biped
from stages.biped.quantity import Bound, Broken, parameter
from stages.ground.contact_law import OnGround
from stages.twin.parameters import Settings as TwinSettings

#: Noise that a second-order low pass (Butterworth) lets through, in cut-offs.
NOISE_BANDWIDTH = math.pi / (2 * math.sqrt(2))
POSITIVE, NOT_NEGATIVE, SHARE = Bound(above=0), Bound(minimum=0), Bound(minimum=0, below=1)


@dataclass(frozen=True)
class RunSettings:
    """How many runs there are and how they differ."""

    FILE: ClassVar[str] = "campaign"

    seed: int = parameter("1", "seed of every random draw", bound=NOT_NEGATIVE)
    runs: int = parameter("1", "number of runs", bound=Bound(minimum=1))
    steps: int = parameter("1", "heel strikes in a run", bound=Bound(minimum=4))
    rest_s: float = parameter("s", "time the robot stands still before the push", bound=Bound(minimum=0.5))
    push_s: float | None = parameter("s", "duration of the push; null: 0.4 s of Table 1's robot", bound=POSITIVE)
    push_sd: float = parameter("1", "spread of the initial rates, relative", bound=NOT_NEGATIVE)
    slope_sd_deg: float = parameter("deg", "spread of the ramp's inclination", bound=NOT_NEGATIVE)
    slope_reading_sd_deg: float = parameter("deg", "error of reading the inclination off", bound=NOT_NEGATIVE)
    stance_sd_deg: float = parameter("deg", "error of the still stand from normal to the ramp", bound=NOT_NEGATIVE)
    outsole: Following = parameter(
        "m", "mean thickness of the rubber outsole; null: 2 mm for Table 1's robot", bound=NOT_NEGATIVE)
    outsole_sd: Following = parameter(
        "m", "spread of the outsole's thickness; null: 0.2 mm for Table 1's robot", bound=NOT_NEGATIVE)
    tolerance_sd: float = parameter("1", "spread of masses, stiffness and damping, relative", bound=NOT_NEGATIVE)
    length_sd: Following = parameter(
        "m", "spread of each leg's length; null: 0.1 mm for Table 1's robot", bound=NOT_NEGATIVE)
    bare_runs: int | None = parameter(
        "1", "first runs that are made again without the outsole; null: as many as are fitted", bound=NOT_NEGATIVE)
    scale_sd: float = parameter("1", "error of the scale that the robot is weighed on, relative", bound=NOT_NEGATIVE)
    solver_tolerance: float | None = parameter(
        "1", "tolerance of the twin's solver; null: ten times twin.tolerance",
        bound=Bound(minimum=1e-11, maximum=1e-4), closer=CLOSER)
    motion_rate_hz: float = parameter("Hz", "rate of the simulated motion", bound=Bound(minimum=1000, maximum=1e5))

    def broken_rules(self) -> Iterator[Broken]:
        """Only runs that are made can be made again."""
        if self.bare_runs is not None and self.bare_runs > self.runs:
            yield Broken("bare_runs", f"<= runs = {self.runs}")

    def of(self, biped: Biped) -> RunSettings:
        """The runs of a robot, whose leg's length decides what is null."""
        rubber = outsole(biped)
        return followed(self, outsole=rubber, outsole_sd=0.1 * rubber, length_sd=1e-4 * size(biped))


@dataclass(frozen=True)
class SensorSettings:
    """The synthetic sensor."""

    FILE: ClassVar[str] = "campaign"

    rate_hz: Following = parameter("Hz", "nominal sampling rate; null: 2.5 times the bandwidth", bound=POSITIVE)
    rate_error_sd_ppm: float = parameter("ppm", "spread of the sensor's clock rate", bound=NOT_NEGATIVE)
    bandwidth_hz: Following = parameter(
        "Hz", "cut-off of the second-order low pass; null: 0.4 times the rate, 40 Hz for Table 1's", bound=POSITIVE)
    accelerometer_range_g: Following = parameter(
        "g", "full scale of the accelerometer; null: four times ground.gravity", bound=POSITIVE)
    gyroscope_range_deg_s: Following = parameter(
        "deg/s", "full scale of the gyroscope; null: 2000 deg/s for Table 1's robot", bound=POSITIVE)
    bits: int = parameter("1", "resolution of a count", bound=Bound(minimum=8, maximum=32))
    misalignment_sd_deg: float = parameter("deg", "spread of the mounting about each axis", bound=NOT_NEGATIVE)
    acceleration_gain_sd: float = parameter("1", "spread of the accelerometer's gain", bound=NOT_NEGATIVE)
    angular_rate_gain_sd: float = parameter("1", "spread of the gyroscope's gain", bound=NOT_NEGATIVE)
    acceleration_bias_sd: float = parameter("m/s^2", "spread of the accelerometer's bias", bound=NOT_NEGATIVE)
    angular_rate_bias_sd_deg_s: float = parameter("deg/s", "spread of the gyroscope's bias", bound=NOT_NEGATIVE)
    acceleration_noise_density: float = parameter("m/s^2/Hz^0.5", "accelerometer noise", bound=NOT_NEGATIVE)
    angular_rate_noise_density_deg_s: float = parameter("deg/s/Hz^0.5", "gyroscope noise", bound=NOT_NEGATIVE)

    def broken_rules(self) -> Iterator[Broken]:
        """The low pass cuts off below half the sampling rate."""
        if self.bandwidth_hz is not None and self.rate_hz is not None and self.bandwidth_hz >= self.rate_hz / 2:
            yield Broken("bandwidth_hz", f"< rate_hz / 2 = {self.rate_hz / 2:g} Hz")

    @property
    def noise(self) -> tuple[float, float]:
        """Standard deviation of a sample of the specific force [m/s^2] and of the angular rate [rad/s]."""
        root = math.sqrt(NOISE_BANDWIDTH * self.bandwidth_hz)
        return self.acceleration_noise_density * root, math.radians(self.angular_rate_noise_density_deg_s) * root

    def of(self, biped: Biped, gravity: float) -> SensorSettings:
        """The sensor of a robot, whose time and gravity [m/s^2] decide what is null."""
        quick, rate, bandwidth = quickness(biped, gravity), self.rate_hz, self.bandwidth_hz
        return followed(
            self,
            rate_hz=100.0 * quick if bandwidth is None else 2.5 * bandwidth,
            bandwidth_hz=40.0 * quick if rate is None else 0.4 * rate,
            accelerometer_range_g=4.0 * (gravity / GRAVITY),
            gyroscope_range_deg_s=2000.0 * quick,
        )


@dataclass(frozen=True)
class RadioSettings:
    """The synthetic radio link, phone and server."""

    FILE: ClassVar[str] = "campaign"

    batch_size: int = parameter("1", "samples in a packet", bound=Bound(minimum=1))
    counter_modulus: int = parameter("1", "packet numbers before the counter wraps", bound=Bound(minimum=256))
    connection_interval_s: float = parameter("s", "time between two connections, 0: at once", bound=NOT_NEGATIVE)
    latency_s: float = parameter("s", "smallest delay of a packet", bound=NOT_NEGATIVE)
    jitter_s: float = parameter("s", "mean of the exponential delay on top", bound=NOT_NEGATIVE)
    stall_share: float = parameter("1", "share of packets that stall", bound=SHARE)
    stall_s: float = parameter("s", "mean length of a stall", bound=NOT_NEGATIVE)
    loss_share: float = parameter("1", "share of packets that are lost", bound=SHARE)
    upload_interval_s: float = parameter("s", "time between two uploads of the phone", bound=POSITIVE)


@dataclass(frozen=True)
class Measured:
    """Whether a lab's own measurements take the campaign's place."""

    FILE: ClassVar[str] = "imu"

    database: str | None = parameter(
        "-", "SQLite file of a lab's own measurements, from the study's folder; null: the synthetic ones"
    )


@dataclass(frozen=True)
class Fitted:
    """How many runs the calibration wants of each robot."""

    FILE: ClassVar[str] = "calibration"

    fitted_runs: int = parameter("1", "runs of each robot that the stage fits", bound=Bound(minimum=1))


@dataclass(frozen=True)
class Parameters(OnGround):
    """All the campaign depends on."""

    twin: TwinSettings
    runs: RunSettings
    given_sensor: SensorSettings
    radio: RadioSettings
    measured: Measured
    fitted: Fitted

    @property
    def sensor(self) -> SensorSettings:
        """The sensor of this robot."""
        return self.given_sensor.of(self.biped, self.slope.gravity)

    @property
    def push_s(self) -> float:
        """Duration of the push [s]."""
        return self.runs.push_s or 0.4 / quickness(self.biped, self.slope.gravity)

    @property
    def bare_runs(self) -> int:
        """How many runs are made again without the outsole."""
        return min(self.fitted.fitted_runs, self.runs.runs) if self.runs.bare_runs is None else self.runs.bare_runs
