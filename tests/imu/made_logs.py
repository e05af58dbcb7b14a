"""Logs of the campaign's runs that know their own truth: what a lab would have, and what each sample really is."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from stages.campaign.parameters import Parameters, SensorSettings
from stages.campaign.result import LegTruth
from stages.campaign.run import BETWEEN_RUNS, FIRST_RUN_AT, MOUNTING, SENSOR_STREAM, SYNTHETIC, device
from stages.campaign.twin_run import TwinRun, generator
from stages.campaign.virtual_sensor import SensorMotion, draw_errors, low_pass, read, transmit
from stages.imu.sources.schema import Experiment, Recording
from stages.imu.strikes.step_times import OUTER

#: Spreads of a sensor that grow with its errors.
ERRORS = (
    *("rate_error_sd_ppm", "misalignment_sd_deg", "acceleration_gain_sd", "angular_rate_gain_sd"),
    *("acceleration_bias_sd", "angular_rate_bias_sd_deg_s"),
    *("acceleration_noise_density", "angular_rate_noise_density_deg_s"),
)


@dataclass(frozen=True)
class TracedRecording(Recording):
    """A recording that knows when each of its rows was really sampled (n,) [s]."""

    true_time: np.ndarray = field(default_factory=lambda: np.empty(0))

    def take(self, keep: np.ndarray) -> TracedRecording:
        return dataclasses.replace(super().take(keep), true_time=self.true_time[keep])  # type: ignore[return-value]


@dataclass(frozen=True)
class Log:
    """One run as a lab has it, with the motion that its sensors really felt, by place."""

    experiment: Experiment
    recordings: tuple[TracedRecording, ...]
    motions: dict[str, SensorMotion]
    rotations: dict[str, np.ndarray]
    strike_time: np.ndarray
    strike_leg: np.ndarray
    leg: LegTruth
    parameters: Parameters
    number: int

    def changed(self, place: str, change: Callable[[TracedRecording], TracedRecording]) -> Log:
        """The log with the recordings of one place ("both": of all) changed."""
        made = tuple(change(one) if place in (one.device.place, "both") else one for one in self.recordings)
        return dataclasses.replace(self, recordings=made)


def replaced(one: TracedRecording, **fields: object) -> TracedRecording:
    """The recording with other fields."""
    return dataclasses.replace(one, **fields)


def with_errors(parameters: Parameters, times: float) -> Parameters:
    """The campaign with all errors of its sensors that many times as large."""
    sensor = parameters.sensor
    grown = {name: times * getattr(sensor, name) for name in ERRORS}
    return dataclasses.replace(parameters, given_sensor=dataclasses.replace(sensor, **grown))


def made_log(
    number: int, walked: TwinRun, parameters: Parameters, motions: dict[str, SensorMotion] | None = None
) -> Log:
    """Run `number` of the campaign as its sensors and their radio tell it; `motions` in the place of the walk's own."""
    felt = motions or {"hip": walked.hip, "foot": walked.foot}
    experiment = Experiment(f"{SYNTHETIC} run {number + 1:02d}", SYNTHETIC, walked.variation.slope_read_deg)
    recordings, rotations = [], {}
    for stream, place in enumerate(MOUNTING):
        rng = generator(parameters.runs.seed, number, SENSOR_STREAM + stream)
        said = device(place, parameters)
        errors = draw_errors(parameters.sensor, said, rng)
        readings = read(felt[place], errors, parameters.sensor, rng)
        start = FIRST_RUN_AT + BETWEEN_RUNS * number
        sent = transmit(readings, start, parameters.sensor.rate_hz, parameters.radio, rng)
        stamps = (sent.device_stamp, sent.phone_stamp, sent.server_stamp)
        columns = [column.astype(float) for column in (sent.packet, sent.position, *stamps)]
        values = (sent.acceleration.astype(float), sent.angular_rate.astype(float))
        recordings.append(TracedRecording(*columns, *values, experiment, said, true_time=readings.time[sent.row]))
        rotations[place] = errors.rotation.T
    return Log(
        experiment, tuple(recordings), felt, rotations, walked.heel_strike_time, walked.heel_strike_leg,
        walked.leg, parameters, number,
    )  # fmt: skip


def on_outer_leg(motion: SensorMotion, walked: TwinRun) -> SensorMotion:
    """What a sensor feels on the outer leg: the inner leg's walk a step later, the stand and the push as they are."""
    outer = walked.heel_strike_time[walked.heel_strike_leg == OUTER]
    inner = walked.heel_strike_time[walked.heel_strike_leg != OUTER]
    step = float(np.median(np.diff(np.sort(np.concatenate((outer, inner))))))
    walking = motion.time >= 0
    later = np.minimum(motion.time[walking] + step, motion.time[-1])

    def shifted(value: np.ndarray) -> np.ndarray:
        moved = value.copy()
        moved[walking] = np.column_stack([np.interp(later, motion.time, axis) for axis in value.T])
        return moved

    return SensorMotion(motion.time, shifted(motion.specific_force), shifted(motion.angular_velocity))


def true_signals(log: Log, place: str, at: np.ndarray, sensor: SensorSettings) -> np.ndarray:
    """Specific force and rate on body axes (n, 6) behind the sensor's low pass at true times (n,) [s]."""
    motion = log.motions[place]
    rate = 1 / (motion.time[1] - motion.time[0])
    both = np.hstack((motion.specific_force, motion.angular_velocity))
    smooth = low_pass(both, rate, sensor.bandwidth_hz)
    return np.column_stack([np.interp(at, motion.time, axis) for axis in smooth.T])
