"""The ingest: from a database of measurements to curves that can be compared.

Knows nothing of where the measurements come from, synthetic or not: it reads the database, read-only, and its settings.
"""

import math
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from stages.biped.processes import Progress, ignore
from stages.biped.walk import SENSOR_SIGNALS
from stages.imu.parameters import Parameters
from stages.imu.result import Result, Run, RunReport, SensorReport, SensorSignals, origin_of, stepping
from stages.imu.sources.databases import SqliteSource
from stages.imu.sources.opening import SourceRefused
from stages.imu.sources.schema import Experiment, Recording
from stages.imu.trial.body import BodySensor
from stages.imu.trial.trial import Trial, read_trials
from stages.imu.trial.walk import ensemble_of

#: Why numbers have no errors by closer solvers, where the recordings are not synthetic.
ONCE = "it reads recordings, and solves nothing"


@dataclass(frozen=True)
class Inputs:
    """What the stage reads: SQLite databases, the synthetic one and, if it is named, a lab's own. The campaign stays
    closed: by it the synthetic one is also given as closer solvers made it.
    """

    measurements: Path
    campaign: Path
    database: Path | None = None


def run(parameters: Parameters, inputs: Inputs, progress: Progress = ignore) -> Result:
    """Ingest the lab's own database, or the synthetic one.

    Raises SourceRefused, in one sentence.
    """
    with SqliteSource(inputs.database or inputs.measurements) as source:
        return collect(trials(source.runs(), parameters, progress))


def again(parameters: Parameters, inputs: Inputs, result: Result) -> tuple[Result, Result] | str:
    """The synthetic runs that closer solvers made once more, as they were and as these made them; or why there are
    none. Raises SourceRefused.
    """
    if inputs.database is not None:
        return ONCE
    anew = run(parameters, inputs)
    names = {one.report.name for one in result.runs} & {one.report.name for one in anew.runs}
    return (alone(result, names), alone(anew, names)) if names else "no run made once more can be used"


def alone(imu: Result, names: Collection[str]) -> Result:
    """The ingest of the runs of these names, in one order."""
    return as_result(
        sorted((run for run in imu.runs if run.report.name in names), key=lambda run: run.report.name),
        [report for report in imu.reports if report.run in names])  # fmt: skip


def trials(
    runs: Iterable[tuple[Experiment, tuple[Recording, ...]]], parameters: Parameters, progress: Progress = ignore
) -> Iterator[Trial]:
    """Each walk of each run of a source as a trial, one at a time; by its name a run is found, so none has another's.
    """
    names = set[str]()
    for number, (experiment, recordings) in enumerate(runs):
        name, again = experiment.name, 1
        while name in names:
            again += 1
            name = f"{experiment.name} ({again})"
        names.add(name)
        progress(1 - 1 / (1 + number / 10), f"run {name}")
        yield from read_trials(replace(experiment, name=name), recordings, parameters)


def collect(found: Iterable[Trial]) -> Result:
    """All trials as one result. Raises SourceRefused if none can be used."""
    read = [(trial.reports, run_of(trial) if trial.accepted else trial.report()) for trial in found]
    reports = tuple(report for of_sensors, _ in read for report in of_sensors)
    runs = tuple(one for _, one in read if isinstance(one, Run))
    rejected = tuple(one for _, one in read if isinstance(one, RunReport))
    if not runs:
        raise SourceRefused(f"no run can be used; the first was turned down: {_first_reason(rejected, reports)}")
    return as_result(runs, reports, rejected)


def as_result(
    runs: Sequence[Run], reports: Sequence[SensorReport], rejected: Sequence[RunReport] = ()
) -> Result:
    """Runs that are used, at least one, and what they have in common."""
    strides = np.concatenate([one.strides for one in runs])
    frequency, spread = frequency_of(runs)
    return Result(
        origin=origin_of(one.report for one in runs),
        signals=SENSOR_SIGNALS,
        reports=tuple(reports),
        runs=tuple(runs),
        rejected=tuple(rejected),
        ensemble=ensemble_of(strides),
        step_frequency=frequency,
        step_frequency_spread=spread,
    )


def frequency_of(runs: Sequence[Run]) -> tuple[float, float]:
    """Mean step frequency [Hz] of the runs whose legs land in turn, or of all if there are none, and their spread."""
    found = np.array([one.report.step_frequency for one in stepping(runs) or runs])
    return float(np.mean(found)), float(np.std(found, ddof=1)) if len(found) > 1 else math.nan


def _first_reason(rejected: Sequence[RunReport], reports: Sequence[SensorReport]) -> str:
    """The first sensor's first reason, or the first run's: one sentence, to be put right before the next."""
    reasons = next((report.reasons for report in reports if not report.accepted and report.reasons), ())
    if not reasons:
        return f"{rejected[0].name}: {rejected[0].reason}" if rejected else "no run at all"
    more = f" (and {len(reasons) - 1} more)" if len(reasons) > 1 else ""
    return reasons[0] + more


def run_of(trial: Trial) -> Run:
    """A trial as it is stored, its times counted from the first heel strike."""
    start = float(trial.strikes.time[0])
    return Run(
        report=trial.report(),
        start=start,
        hip=signals_of(trial.sensors.get("hip"), start),
        foot=signals_of(trial.sensors.get("foot"), start),
        heel_strike_time=trial.strikes.time - start,
        heel_strike_leg=trial.strikes.leg,
        strides=trial.strides,
        leg=replace(
            trial.leg,
            time=trial.leg.time - start,
            stance_start=trial.leg.stance_start - start,
            stance_end=trial.leg.stance_end - start,
        ),
    )


def signals_of(sensor: BodySensor | None, start: float) -> SensorSignals:
    """A sensor as it is stored; empty arrays for one that is missing."""
    if sensor is None:
        none, vectors = np.empty(0), np.empty((0, 3))
        return SensorSignals(none, none, none, none, none, vectors, vectors, np.full((3, 3), np.nan))
    indexed = sensor.trace.indexed
    return SensorSignals(
        segment=indexed.segment,
        index=indexed.index,
        packet=indexed.recording.packet,
        position=indexed.recording.position,
        time=sensor.time - start,
        specific_force=sensor.force,
        angular_velocity=sensor.rate,
        rotation=sensor.frame.rotation,
    )
