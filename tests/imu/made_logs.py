"""Walks of the stand-in, logs of them that know their own truth, and what is really wrong with an answer to one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from stages.campaign.parameters import Parameters, SensorSettings
from stages.campaign.result import LegTruth
from stages.campaign.run import MOUNTING, device, sensed_run
from stages.campaign.twin_run import TwinRun, draw_variation, generator
from stages.campaign.virtual_sensor import SensorMotion, low_pass
from stages.imu.parameters import filter_delay
from stages.imu.sources.cells import recording_from_columns
from stages.imu.sources.schema import Experiment, Recording
from stages.imu.strikes.step_times import OUTER, HeelStrikes, step_frequency
from stages.imu.trial.body import FORWARD, LATERAL, UP, angle_between
from stages.imu.trial.trial import Trial
from tests.imu.stand_in import walked
from tests.study import SLOPE

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
        return replace(super().take(keep), true_time=self.true_time[keep])  # type: ignore[return-value]


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
        return replace(self, recordings=made)


def replaced(one: TracedRecording, **fields: object) -> TracedRecording:
    """The recording with other fields."""
    return replace(one, **fields)


def with_errors(parameters: Parameters, times: float) -> Parameters:
    """The campaign with all errors of its sensors that many times as large."""
    sensor = parameters.sensor
    grown = {name: times * getattr(sensor, name) for name in ERRORS}
    return replace(parameters, given_sensor=replace(sensor, **grown))


def made_log(
    number: int, walked: TwinRun, parameters: Parameters, motions: dict[str, SensorMotion] | None = None
) -> Log:
    """Run `number` of the campaign as its sensors and their radio tell it; `motions` in the place of the walk's own."""
    felt = motions or {"hip": walked.hip, "foot": walked.foot}
    experiment, truth, sent = sensed_run(number, replace(walked, **felt), parameters)
    of_place = {"hip": truth.hip, "foot": truth.foot}
    recordings = tuple(
        TracedRecording(**vars(recording_from_columns(experiment, device(place, parameters), rows.table())),
                        true_time=of_place[place].sample_time) for place, rows in zip(MOUNTING, sent))  # fmt: skip
    rotations = {place: one.rotation.T for place, one in of_place.items()}
    return Log(
        experiment, recordings, felt, rotations, walked.heel_strike_time, walked.heel_strike_leg, walked.leg,
        parameters, number,
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


# --- Walks of the stand-in in the form of the campaign's, for tests that have no time for the twin.


STEPS, PERIOD_S, REST_S = 9, 0.48, 2.5


def stand_in_walks(count: int, parameters: Parameters) -> list[TwinRun]:
    """So many walks of different step period, with a still stand and a push before each."""
    walks = []
    for number in range(count):
        rng = generator(parameters.runs.seed, number, 0)
        variation = draw_variation(parameters.runs.of(parameters.biped), SLOPE, rng)
        walks.append(walked(STEPS, PERIOD_S * (1 + 0.01 * rng.normal()), REST_S, variation))
    return walks


# --- What is really wrong with a trial's answer, from the truth of a made log: by quantity, named as in the
# judgement.


STRIKE_S = 0.015
LEAST_FOUND = 0.9  # of the strikes, and of those found that are true
CLOCK_S = 0.005
FREQUENCY = 3e-3


def tolerances(log: Log) -> dict[str, float]:
    """From where on a quantity is wrong: beyond what a sensor with such errors can be blamed for.

    Four standard deviations of the sensor's own error, and what a user would mind on top.
    """
    sensor, runs = log.parameters.sensor, log.parameters.runs
    pitch = np.degrees(sensor.acceleration_bias_sd / 9.81) + runs.stance_sd_deg + runs.slope_reading_sd_deg
    gain = sensor.acceleration_gain_sd + sensor.acceleration_bias_sd / 9.81
    return {
        "clock": CLOCK_S,
        "step frequency": FREQUENCY,
        "foot lag": 0.01,
        "frame": 1.0 + 4 * pitch + 4 * 0.5 * sensor.acceleration_gain_sd,
        "rate": 0.05 + 4 * sensor.angular_rate_gain_sd,
        "force": 0.08 + 4 * gain,
        "leg angle": 0.5 + 4 * (runs.stance_sd_deg + 20 * sensor.angular_rate_gain_sd),
        "step length": 0.01 + 4 * sensor.angular_rate_gain_sd,
    }


def wrong_quantities(log: Log, trial: Trial) -> dict[str, float]:
    """Each wrong quantity of an answer with its error."""
    wrong: dict[str, float] = {}
    limit = tolerances(log)
    late = {}
    for place, sensor in trial.sensors.items():
        true = sensor.trace.indexed.recording.true_time  # type: ignore[attr-defined]
        late[place], spread = float(np.median(sensor.time - true)), float(np.std(sensor.time - true))
        if spread > limit["clock"]:
            wrong["clock"] = max(spread, wrong.get("clock", 0.0))
        angle = angle_between(sensor.frame.rotation, log.rotations[place])
        if angle > limit["frame"]:
            wrong[f"{place} frame"] = angle
        for what, off in signal_errors(log, place, true, sensor.force, sensor.rate).items():
            if off > limit[what]:
                wrong[f"{place} {what}"] = off
    if len(late) == 2 and abs(late["foot"] - late["hip"]) > limit["foot lag"]:
        wrong["foot lag"] = late["foot"] - late["hip"]
    wrong |= _wrong_strikes(log, trial, late)
    if late:
        lengths = trial.leg.step_length
        share = float(np.mean(trial.leg.step_length_error) / lengths.mean()) if len(lengths) else 0.0
        for what, off in leg_errors(log, trial, late["hip" if "hip" in late else "foot"]).items():
            if off > max(limit[what], 3 * share * (what == "step length")):  # what its error covers is not wrong
                wrong[what] = off
    true_frequency = step_frequency(HeelStrikes(log.strike_time[3:], log.strike_leg[3:]))[0]
    off = trial.frequency[0] / true_frequency - 1
    return wrong if abs(off) <= limit["step frequency"] else wrong | {"step frequency": off}


def _wrong_strikes(log: Log, trial: Trial, late: dict[str, float]) -> dict[str, float]:
    if not len(trial.strikes.time) or not late:
        return {"heel strikes": 1.0}
    first = "hip" if "hip" in late else "foot"
    at = trial.strikes.time - late[first]
    nearest = np.abs(at[:, None] - log.strike_time).argmin(axis=1)
    error = at - log.strike_time[nearest]
    hit = np.abs(error - np.median(error)) <= STRIKE_S
    least = min(len(set(nearest[hit].tolist())) / len(log.strike_time), float(hit.mean()))  # found, and right
    wrong = {}
    if least < LEAST_FOUND or abs(np.median(error)) > 3 * STRIKE_S:
        wrong["heel strikes"] = 1 - least
    if hit.any() and not (trial.strikes.leg[hit] == log.strike_leg[nearest[hit]]).all():
        wrong["legs"] = float(np.mean(trial.strikes.leg[hit] != log.strike_leg[nearest[hit]]))
    return wrong


def leg_errors(log: Log, trial: Trial, late: float) -> dict[str, float]:
    """Rms error of the leg's angle through the walk [deg], and mean error of the steps' length, relative.

    `late` [s] is how late the samples are dated, their low pass's delay taken off.
    """
    delay = filter_delay(log.recordings[0].device.bandwidth_hz)
    at = trial.leg.time - late - delay
    walking = (at > 0.1) & (at < log.leg.time[-1] - 0.1)
    off = (trial.leg.angle - np.interp(at, log.leg.time, log.leg.angle))[walking]
    errors = {"leg angle": float(np.degrees(np.sqrt(np.mean(off**2)))) if len(off) else 0.0}
    if len(trial.leg.step_length):
        strikes = log.strike_time + late + delay
        first, last = (np.abs(strikes - each[:, None]).argmin(axis=1)
                       for each in (trial.leg.stance_start, trial.leg.stance_end))  # fmt: skip
        true = log.leg.hip_at_strike[last, 0] - log.leg.hip_at_strike[first, 0]
        errors["step length"] = abs(float(trial.leg.step_length.mean() / true.mean() - 1)) if true.mean() > 0 else 1.0
    return errors


def signal_errors(log: Log, place: str, true_time: np.ndarray, force: np.ndarray, rate: np.ndarray) -> dict[str, float]:
    """Errors of scale of a place's lateral rate and of its force in the plane, relative, a change of sign included.

    Force: rms difference of the magnitudes in the plane, over gravity, whatever the frame. Samples and truth both stand
    behind the sensor's low pass.
    """
    truth = true_signals(log, place, true_time, log.parameters.sensor)
    known = np.isfinite(rate[:, LATERAL])
    scale = float(rate[known, LATERAL] @ truth[known, 3 + LATERAL] / (truth[known, 3 + LATERAL] ** 2).sum())
    seen = np.isfinite(force).all(axis=1)
    mine, real = (np.hypot(part[seen][:, FORWARD], part[seen][:, UP]) for part in (force, truth))
    return {"rate": abs(scale - 1), "force": float(np.sqrt(np.mean((mine - real) ** 2))) / 9.81}
