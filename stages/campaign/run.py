"""The synthetic measurement campaign: walks of the twin through a sensor model into a database. Nothing is measured."""

import tempfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

import numpy as np

from stages.biped.accuracy.scales import scales_of
from stages.biped.between_steps import refined_times, time_above
from stages.biped.processes import Progress, each_in_a_process, ignore
from stages.biped.walk import StanceState
from stages.campaign.parameters import Parameters
from stages.campaign.result import (
    BARE,
    DATABASE,
    WITHOUT_OUTSOLE,
    Result,
    RunTruth,
    SensorErrors,
    SensorTruth,
    SetSpike,
)
from stages.campaign.twin_run import NoWalk, TwinRun, first_state, generator, walk_twin
from stages.campaign.virtual_sensor import (
    STANDARD_GRAVITY,
    Readings,
    SensorMotion,
    Transmitted,
    draw_errors,
    low_pass,
    read,
    transmit,
)
from stages.ground.contact_law import family_member
from stages.imu.parameters import filter_delay
from stages.imu.sources.schema import DatabaseWriter, Device, Experiment, Row
from stages.planar.signals import IMU
from stages.twin.machine.projection import machine_of, project
from stages.twin.result import Result as Twin
from stages.twin.walking.record import find_events, sample
from stages.twin.walking.simulate import rolling_start, simulate_twin


def database_bytes(devices: Sequence[Device], runs: Iterable[tuple[Experiment, Sequence[Transmitted]]]) -> bytes:
    """The content of the database file: same rows, same bytes (for one version of SQLite).

    `runs` gives each experiment with what its devices sent, in the order of `devices`.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / DATABASE
        with DatabaseWriter(path) as writer:
            identities = [writer.device(device) for device in devices]
            for experiment, sent in runs:
                writer.experiment(experiment, _interleaved(identities, sent))
        return path.read_bytes()


def _interleaved(identities: Sequence[int], sent: Sequence[Transmitted]) -> list[Row]:
    """Rows of all devices as they reach the server: by server stamp, within a device in order."""
    rows = [(identity, tuple(row)) for identity, one in zip(identities, sent, strict=True)
            for row in one.table().tolist()]  # fmt: skip
    arrived = np.concatenate([one.server_stamp for one in sent])
    return [rows[place] for place in np.argsort(arrived, kind="stable")]  # stable: keeps the order of a device


#: Members of the contact set's family towards the rigid limit, the softest first; share 1 is the set itself.
SHARES = (4.0, 2.0, 1.0, 0.5)
#: Heel strikes of each walk; the steps between them are looked at.
STRIKES = 3


def spike(share: float, state: StanceState, normal_force: float, parameters: Parameters) -> SetSpike:
    """Peaks and time above range of a short walk on one member of the family, begun at the same mid-stance."""
    law = family_member(parameters.contact, share)
    settings = parameters.twin.with_tolerance(parameters.runs.solver_tolerance)
    settings = replace(settings, signals=(IMU,))
    machine = machine_of(parameters.biped, settings)
    start = rolling_start(machine, law, state, normal_force)
    record = simulate_twin(machine, parameters.slope, law, start, settings, steps=STRIKES)
    strikes = find_events(record).heel_strike_time
    if not record.completed or len(strikes) < STRIKES:
        return SetSpike(share, law.contact_stiffness, float("nan"), float("nan"), float("nan"))
    pendulum_time = scales_of(parameters.biped, parameters.slope.gravity).time
    time = refined_times(float(record.time[-1]), settings.sampling_rate_hz, strikes, pendulum_time)
    walk = sample(record, time, settings).walk
    inside = (time >= strikes[0]) & (time <= strikes[-1])
    hip, foot = (
        np.abs(force[inside]).max(axis=1) for force in (walk.hip_specific_force, walk.foot_specific_force)
    )
    full_scale = parameters.sensor.accelerometer_range_g * STANDARD_GRAVITY
    return SetSpike(
        share=share,
        contact_stiffness=law.contact_stiffness,
        hip_peak=float(hip.max()),
        foot_peak=float(foot.max()),
        time_above_range=time_above(time[inside], np.maximum(hip, foot), full_scale) / (len(strikes) - 1),
    )


SYNTHETIC = "synthetic"
NOT_NEEDED = "not needed"
FIRST_RUN_AT = 1_600_000_000.0  # s, what the phone's clock shows at the first run: any date does
BETWEEN_RUNS = 120.0  # s
SENSOR_STREAM = 1000  # numbers of the random streams of the sensors; those of the attempts lie below
SCALE_STREAM, BARE_STREAM = 1500, 1000  # that of the scale; what runs without an outsole add to theirs
AROUND_STRIKE = (-0.03, 0.15)  # pendulum times, where the spike of a heel strike is looked for

#: Sensor axis nearest to the body's forward and upward axis, for each place.
MOUNTING = {"hip": ("+y", "-x"), "foot": ("-z", "+x")}


#: Runs that are made once more, closer, for the errors of all, beside one without the outsole.
FEW = 3


@dataclass(frozen=True)
class Inputs:
    """What the stage reads."""

    twin: Twin
    missing: Mapping[str, str] = field(default_factory=dict)


def run(parameters: Parameters, inputs: Inputs, progress: Progress = ignore) -> Result:
    """Walk, sense, send, store. The twin gives the state in which its own walk begins.

    The result is the truth; its file is what a lab would have. Where a lab's own database is named there is neither:
    the result says so, and its file has no rows. Raises NoWalk if the twin falls at every attempt.
    """
    if parameters.measured.database is not None:
        return Result(NOT_NEEDED, (), (), (), databases((), 0, parameters))
    if "twin" in inputs.missing:
        raise NoWalk(inputs.missing["twin"])
    try:
        truths, spikes, files = made(
            parameters, inputs, parameters.runs.runs, parameters.bare_runs, SHARES, progress)
    except NoWalk as falls:
        alone = inputs.twin.reason  # that of the walk without a push, which begins in the gait
        raise NoWalk(f"{falls}; {f'from the gait itself it {alone}' if alone else 'try a smaller push_sd'}") from falls
    return Result(SYNTHETIC, truths[: parameters.runs.runs], truths[parameters.runs.runs :], spikes, files)


def again(parameters: Parameters, inputs: Inputs, result: Result) -> Result:
    """The result at closer settings: its first runs and the hardest contact, and the others as they were. Its files
    hold these runs alone, for who fits them.
    """
    if not result.runs:
        return replace(result, files={})
    usual, bare = min(FEW, len(result.runs)), min(1, len(result.bare))
    truths, spikes, files = made(parameters, inputs, usual, bare, SHARES[-1:])
    return replace(
        result, runs=(*truths[:usual], *result.runs[usual:]), bare=(*truths[usual:], *result.bare[bare:]),
        spikes=(*result.spikes[:-1], *spikes), files=files)


def made(
    parameters: Parameters, inputs: Inputs, usual: int, bare: int, shares: Iterable[float], progress: Progress = ignore
) -> tuple[tuple[RunTruth, ...], tuple[SetSpike, ...], dict[str, bytes]]:
    """Truths of the first runs, so many `usual` ones and then `bare` ones; spikes on members of the contact's family;
    and the databases. Raises NoWalk.
    """
    state, normal_force = first_state(inputs.twin.walk)
    wanted = [*((number, False) for number in range(usual)), *((number, True) for number in range(bare))]
    one = partial(synthetic_run, state=state, normal_force=normal_force, parameters=parameters)
    runs = {}
    for place, run in each_in_a_process(one, wanted):
        runs[place] = run
        progress(len(runs) / (len(wanted) + 1), f"synthetic run {len(runs)} of {len(wanted)}")
    found = [runs[place] for place in range(len(wanted))]
    return (tuple(truth for _, truth, _ in found),
            tuple(spike(share, state, normal_force, parameters) for share in shares),
            databases([(experiment, sent) for experiment, _, sent in found], usual, parameters))  # fmt: skip


def databases(
    sent: Sequence[tuple[Experiment, Sequence[Transmitted]]], usual: int, parameters: Parameters
) -> dict[str, bytes]:
    """The databases of what was sent in runs, so many `usual` ones first and then those without the outsole."""
    devices = [device(place, parameters) for place in MOUNTING]
    return {DATABASE: database_bytes(devices, sent[:usual]), WITHOUT_OUTSOLE: database_bytes(devices, sent[usual:])}


def device(place: str, parameters: Parameters) -> Device:
    """The synthetic sensor at a place, as the database describes it."""
    sensor, radio = parameters.sensor, parameters.radio
    forward, up = MOUNTING[place]
    return Device(
        place=place,
        rate_hz=sensor.rate_hz,
        accelerometer_unit="counts",
        gyroscope_unit="counts",
        name=f"{SYNTHETIC} sensor at the {place}",
        bandwidth_hz=sensor.bandwidth_hz,
        accelerometer_range_g=sensor.accelerometer_range_g,
        gyroscope_range_deg_s=sensor.gyroscope_range_deg_s,
        bits=sensor.bits,
        batch_size=radio.batch_size,
        counter_modulus=radio.counter_modulus,
        forward_axis=forward,
        up_axis=up,
    )


def synthetic_run(
    which: tuple[int, bool], state: StanceState, normal_force: float, parameters: Parameters
) -> tuple[Experiment, RunTruth, tuple[Transmitted, ...]]:
    """One run, by its number and whether it is that without the outsole: its experiment, truth, and what was sent."""
    number, bare = which
    return sensed_run(number, walk_twin(number, state, normal_force, parameters, bare=bare), parameters, bare=bare)


def sensed_run(
    number: int, walked: TwinRun, parameters: Parameters, *, bare: bool = False
) -> tuple[Experiment, RunTruth, tuple[Transmitted, ...]]:
    """A walk of the twin as two sensors and their radio show it: experiment, truth, and what was sent."""
    variation = walked.variation
    name = f"{SYNTHETIC} {BARE if bare else ''}run {number + 1:02d}"
    experiment = Experiment(name, SYNTHETIC, variation.slope_read_deg)
    clock_start = FIRST_RUN_AT + BETWEEN_RUNS * (number + (parameters.runs.runs if bare else 0))
    truths, sent = {}, []
    for stream, (place, motion) in enumerate((("hip", walked.hip), ("foot", walked.foot))):
        rng = generator(parameters.runs.seed, number, SENSOR_STREAM + stream + (BARE_STREAM if bare else 0))
        errors = draw_errors(parameters.sensor, device(place, parameters), rng)
        readings = read(motion, errors, parameters.sensor, rng)
        sent.append(transmit(readings, clock_start, parameters.sensor.rate_hz, parameters.radio, rng))
        truths[place] = sensor_truth(place, motion, walked, errors, readings, sent[-1], parameters)
    robot = project(machine_of(parameters.biped, parameters.twin, variation.build))
    scale = generator(parameters.runs.seed, number, SCALE_STREAM + (BARE_STREAM if bare else 0))
    truth = RunTruth(
        name=experiment.name,
        clock_start=clock_start,
        slope_deg=variation.slope_deg,
        stance_push=variation.stance_push,
        swing_push=variation.swing_push,
        outsole=variation.build.outsole,
        robot=robot,
        weighed=float(robot.total_mass * (1 + parameters.runs.scale_sd * scale.normal())),
        failed_attempts=walked.attempts - 1,
        heel_strike_time=walked.heel_strike_time,
        heel_strike_leg=walked.heel_strike_leg,
        leg=walked.leg,
        hip=truths["hip"],
        foot=truths["foot"],
    )
    return experiment, truth, tuple(sent)


def sensor_truth(
    place: str,
    motion: SensorMotion,
    walked: TwinRun,
    errors: SensorErrors,
    readings: Readings,
    sent: Transmitted,
    parameters: Parameters,
) -> SensorTruth:
    """The truth about one sensor, with the spike of the inner pair's heel strikes before and behind the sensor."""
    smooth = low_pass(motion.specific_force, parameters.runs.motion_rate_hz, parameters.sensor.bandwidth_hz)
    size = parameters.sensor.accelerometer_range_g * STANDARD_GRAVITY / 2 ** (parameters.sensor.bits - 1)
    strikes = walked.heel_strike_time[walked.heel_strike_leg == 0]
    pendulum_time = scales_of(parameters.biped, parameters.slope.gravity).time
    return SensorTruth(
        **vars(errors),
        place=place,
        low_pass_delay=filter_delay(parameters.sensor.bandwidth_hz),
        packet=sent.packet,
        position=sent.position,
        sample_time=readings.time[sent.row],
        lost_packets=len(readings.time) // parameters.radio.batch_size - len(sent.row) // parameters.radio.batch_size,
        peak=peak(motion.time, motion.specific_force, strikes, pendulum_time),
        peak_filtered=peak(motion.time, smooth, strikes, pendulum_time),
        peak_sampled=peak(readings.time, readings.acceleration * size, strikes, pendulum_time),
    )


def peak(time: np.ndarray, force: np.ndarray, strikes: np.ndarray, pendulum_time: float) -> float:
    """Median over the strikes [s] of the greatest magnitude of a force (n, 3) shortly after each."""
    before, after = (pendulum_time * end for end in AROUND_STRIKE)
    magnitude = np.linalg.norm(force, axis=1)
    spans = [magnitude[(time >= strike + before) & (time <= strike + after)] for strike in strikes]
    return float(np.median([span.max() for span in spans if len(span)]))
