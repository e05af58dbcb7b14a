"""What the calibration needs to know."""

import math
from dataclasses import dataclass

from stages.biped.accuracy.scales import Following, followed, quickness, size
from stages.biped.accuracy.tolerances import CLOSER, Level
from stages.biped.design import Biped
from stages.biped.quantity import Bound, parameter
from stages.campaign.parameters import NOT_NEGATIVE, POSITIVE, Fitted, SensorSettings
from stages.ground.slope import Slope
from stages.imu.parameters import (
    Cover,
    Drawing,
    Limits,
    Parameters as IngestParameters,
    Settings as IngestSettings,
    filter_delay,
)
from stages.twin.parameters import Settings as TwinSettings


@dataclass(frozen=True)
class Settings(Fitted):
    """Which samples are used, how, and the priors of a fit."""

    tolerance: float = parameter(
        "1", "tolerance of a walk, in leg lengths and pendulum times",
        bound=Bound(minimum=1e-12, maximum=1e-4), closer=CLOSER)
    planned_steps: int = parameter("1", "steps of a run that is only planned", bound=Bound(minimum=2, maximum=1000))
    planned_runs: int = parameter("1", "runs that are planned", bound=Bound(minimum=1, maximum=10_000))
    settling_s: Following = parameter(
        "s", "time after the first mid-stance that is not used; null: 0.05 s of Table 1's robot", bound=NOT_NEGATIVE)
    before_strike_s: Following = parameter(
        "s", "left out before each measured strike; null: a sampling period and the low pass's delay",
        bound=NOT_NEGATIVE)
    after_strike_s: Following = parameter(
        "s", "left out after each measured heel strike; null: 0.03 s of Table 1's robot", bound=NOT_NEGATIVE)
    robust_sigmas: float = parameter("1", "residuals beyond so many times the noise pull less", bound=Bound(minimum=1))
    clock_sd: float = parameter("1", "standard error of a sensor's rate after the ingest, relative", bound=POSITIVE)
    foot_lag_sd_s: Following = parameter(
        "s", "standard error of the foot's times against the hip's; null: a fifth of a sampling period", bound=POSITIVE)
    mid_stance_sd_s: Following = parameter(
        "s", "spread of the time from the first heel strike to mid-stance about the gait's; null: 0.06 s of Table 1's "
        "robot", bound=POSITIVE)
    start_length_sd: Following = parameter(
        "m", "spread of the legs' lengths at mid-stance about the gait's; null: 1 mm of Table 1's robot",
        bound=POSITIVE)
    start_length_rate_sd: Following = parameter(
        "m/s", "spread of the rates of these lengths; null: 0.02 m/s of Table 1's robot", bound=POSITIVE)
    lever_arm_sd: Following = parameter(
        "m", "standard error of the foot sensor's place along the leg; null: 1 % of a leg", bound=POSITIVE)
    bandwidth_sd: float = parameter(
        "1", "standard error of a declared bandwidth of the sensors, relative", bound=POSITIVE)
    slope_reading_sd_deg: float = parameter("deg", "standard error of a ramp's inclination", bound=POSITIVE)
    tilt_sd_deg: float = parameter("deg", "standard deviation of a sensor's tilt after the ingest", bound=POSITIVE)
    held_out_runs: int = parameter("1", "next runs of each robot that are forecast", bound=Bound(minimum=0))
    fitted_steps: int = parameter("1", "steps of a run that it uses", bound=Bound(minimum=3))
    outsole: Following = parameter(
        "m", "thickness of the outsole, as a caliper shows it; null: campaign.outsole", bound=NOT_NEGATIVE)
    corrected_runs: int | None = parameter(
        "1", "runs of each robot that the twin corrects; null: all that are fitted", bound=Bound(minimum=0))
    discrepancy_runs: int = parameter(
        "1", "runs of further robots whose fits show the model's error; fewer than three show nothing",
        bound=Bound(minimum=0))
    begun_s: Following = parameter(
        "s", "first part of a run, from which the rest is forecast; null: 0.15 s of Table 1's robot", bound=POSITIVE)
    weighed_mass: float | None = parameter(
        "kg", "measured mass of a lab's own robot; null: not weighed", bound=POSITIVE)
    weighed_sd: float = parameter("1", "standard error of the scale, relative", bound=POSITIVE)
    own_clock_sd: float = parameter(
        "1", "standard error of a rate that only the sensor's own stamps show, relative", bound=POSITIVE,
        default=2e-3)

    @property
    def corrected(self) -> int:
        """How many runs of each robot the twin corrects."""
        return self.fitted_runs if self.corrected_runs is None else self.corrected_runs


@dataclass(frozen=True)
class Parameters:
    """All parameters the stage uses."""

    biped: Biped
    slope: Slope
    given_sensor: SensorSettings
    given: Settings
    ingest_settings: IngestSettings
    limits: Limits
    drawing: Drawing
    cover: Cover
    twin: TwinSettings
    level: Level = Level()

    @property
    def settings(self) -> Settings:
        """The settings: what is null follows the robot, and what the sensors' clocks decide their sampling period."""
        slow, long = 1 / quickness(self.biped, self.slope.gravity), size(self.biped)
        period = 1 / self.sensor.rate_hz
        late = period + filter_delay(self.sensor.bandwidth_hz)  # samples, moved by it, measure a strike before its time
        return followed(
            self.given, settling_s=0.05 * slow, before_strike_s=late, after_strike_s=0.03 * slow,
            foot_lag_sd_s=0.2 * period, mid_stance_sd_s=0.06 * slow, start_length_sd=1e-3 * long,
            start_length_rate_sd=0.02 * long / slow, lever_arm_sd=0.01 * self.biped.leg_length, begun_s=0.15 * slow,
            outsole=self.cover.of(self.biped))

    @property
    def priors(self) -> dict[str, float]:
        """Standard deviations of a run's unknowns before the fit, about zero, by kind; infinite: nothing is known.

        `clock` relative error of the sampling rate; `tilt` [rad] of the mounting in the plane of walking; gains
        relative; biases [m/s^2] and [rad/s]; `foot_lag` [s] what the foot's times are off against the hip's;
        `mid_stance` [s] the time from the first heel strike to mid-stance. There legs are longer by `stretch` [m], at
        `stretch_rate` [m/s], than in the gait. `foot_place` [m] of the foot sensor along the leg; `bandwidth` relative.
        """
        sensor, settings = self.sensor, self.settings
        gain, bias = sensor.acceleration_gain_sd, sensor.acceleration_bias_sd
        return {
            "stretch": settings.start_length_sd, "stretch_rate": settings.start_length_rate_sd,
            "mid_stance": settings.mid_stance_sd_s, "foot_lag": settings.foot_lag_sd_s,
            "foot_place": settings.lever_arm_sd, "bandwidth": settings.bandwidth_sd, "clock": settings.clock_sd,
            "tilt": math.radians(settings.tilt_sd_deg), "forward_gain": gain, "up_gain": gain,
            "rate_gain": sensor.angular_rate_gain_sd, "forward_bias": bias, "up_bias": bias,
            "rate_bias": math.radians(sensor.angular_rate_bias_sd_deg_s),
        }  # fmt: skip

    @property
    def ingest(self) -> IngestParameters:
        """What the ingest needs to know to read a lab's database."""
        return IngestParameters(
            self.ingest_settings, self.limits, self.drawing, self.biped, self.slope, self.cover, self.level)

    @property
    def sensor(self) -> SensorSettings:
        """The sensor of this robot."""
        return self.given_sensor.of(self.biped, self.slope.gravity)

    @property
    def noise(self) -> tuple[float, float, float]:
        """Standard deviation of a sample forward and up [m/s^2] and of the lateral rate [rad/s]."""
        force, rate = self.sensor.noise
        return force, force, rate
