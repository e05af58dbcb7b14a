"""What a fit begins with: the robot as drawn, and runs of a database, from an early mid-stance to the last strike."""

import dataclasses
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.model.walker import Vector
from stages.biped.accuracy.scales import size
from stages.biped.design import Biped
from stages.biped.processes import Progress, ignore
from stages.biped.question import Asking, at_hand, refuse
from stages.calibration.estimation.first_guess import first_guess
from stages.calibration.estimation.least_squares import TOTAL_MASS, Known, NotIdentified
from stages.calibration.estimation.run_fit import Model
from stages.calibration.information.identifiability import EACH_RUNS, SLOPE, first_model, free_names
from stages.calibration.observation.measured_run import SIDES, Layout, MeasuredRun, Sampling, usable
from stages.calibration.parameters import Parameters, Settings
from stages.calibration.result import LAB
from stages.campaign.result import Result as Campaign
from stages.imu.parameters import filter_delay
from stages.imu.run import trials
from stages.imu.sources.opening import as_file
from stages.imu.sources.reading import run_of as as_read, runs
from stages.imu.trial.body import FORWARD, LATERAL, UP, BodySensor
from stages.imu.trial.sensor import SensorTrace
from stages.imu.trial.trial import Trial
from stages.twin.machine.machine import Build
from stages.twin.machine.projection import machine_of, project

Given = TypeVar("Given", bound=Parameters)
#: Whose runs the campaign has.
WITH_OUTSOLE, WITHOUT = "with outsole", "without outsole"
#: Standard error of the foot sensor's place in the campaign [m], of Table 1's robot.
MOUNTED = 1e-5
#: The drawing's places and moments of frames are kept, and the lower legs' inertia: sensors show them and the place of
#: mass together only, so that what a model lacks goes there (an inertia twice too large, masses off by a tenth).
KEPT = ("biped.frame_com", "biped.frame_offset", "biped.frame_inertia", "biped.leg_inertia")
#: The walk is followed from this heel strike on: the hand has let go before the first.
FROM = 1
#: Where the low pass of a sensor cuts off that does not say it, in its rates, before a fit looks for it.
USUAL_BANDWIDTH = 0.4
FEWEST_STRIKES = 4


def as_mounted(parameters: Given, database: Path | None = None) -> Given:
    """The same with the foot sensor where the drawing has it, as the campaign mounts it: else what the model puts wrong
    goes into its place. Where a lab's own `database` is fitted, its place is known as well as the settings say."""
    if database is not None:
        return parameters
    sd = MOUNTED * size(parameters.biped)
    return dataclasses.replace(parameters, given=dataclasses.replace(parameters.settings, lever_arm_sd=sd))


def guess(parameters: Parameters) -> DesignPoint:
    """The design a fit begins from: the drawing, with legs that may differ in length.

    A tenth of a millimetre makes the steps of either leg differ by hundredths of a second.
    """
    biped = parameters.biped
    if biped.other_leg_length is None:
        biped = dataclasses.replace(biped, other_leg_length=biped.leg_length)
    return DesignPoint(biped, parameters.slope)


def drawn_design(parameters: Parameters, kind: str = LAB) -> DesignPoint:
    """The design that the bill of parts makes, legs alike in what the biped has alike but for their length; a lab's
    detailed biped as it is.

    A robot of the `kind` with an outsole is drawn with it. Raises ValueError where the bill does not add up.
    """
    biped = parameters.biped
    if not biped.detailed or kind != LAB:
        rubber = parameters.settings.outsole if kind == WITH_OUTSOLE else 0.0
        whole = project(machine_of(biped, parameters.twin, Build(outsole=rubber)))
        first, other = (dataclasses.asdict(whole.leg(leg)) for leg in (0, 1))
        alike = [name for name in first if getattr(biped.leg(0), name) == getattr(biped.leg(1), name)]
        one: dict[str, Any] = dict.fromkeys(f"other_{name}" for name in alike)
        biped = dataclasses.replace(whole, **one, **{name: 0.5 * (first[name] + other[name]) for name in alike})
    return guess(dataclasses.replace(parameters, biped=biped))


def drawn_model(parameters: Parameters, database: Path | None) -> tuple[DesignPoint, Model]:
    """The design as drawn and the model that a study fits: to a lab's `database`, or else to the campaign's runs.

    Raises NoGait, ValueError.
    """
    drawn = drawn_design(parameters, LAB if database else WITHOUT)
    return drawn, first_model(drawn, looked_for(drawn), parameters)


def looked_for(design: DesignPoint) -> tuple[str, ...]:
    """What the fit looks for: masses, lengths and springs that are there, and of each run its `EACH_RUNS`."""
    there = [name for name in free_names(design) if name not in KEPT and design.value(name) != 0.0]
    own = [name for name in EACH_RUNS if name != SLOPE]
    return tuple(dict.fromkeys([*there, *own]))


def table_value(design: Biped, name: str) -> float:
    """A parameter of a design as Table 1 counts it: what frames weigh is part of the hip."""
    if name == "biped.hip_mass":
        return design.hip_mass + design.leg(0).frame_mass + design.leg(1).frame_mass
    key = name.partition(".")[2]
    first, other = (vars(design) | vars(design.leg(index)) for index in (0, 1))
    return 0.5 * (float(first[key]) + float(other[key]))


#: A run, with what is known of the robot beside it.
Recorded = tuple[MeasuredRun, tuple[Known, ...]]


def sources(
    measurements: Path, without_outsole: Path, campaign: Campaign, database: Path | None
) -> list[tuple[str, Path, dict[str, float], bytes]]:
    """Each kind of robot that has runs, their database, what the campaign's scale showed [kg] by their names, and a
    database of those that closer solvers made once more, if any.
    """
    if database is not None:
        return [(LAB, database, {}, b"")]
    made = ((WITH_OUTSOLE, measurements, campaign.runs), (WITHOUT, without_outsole, campaign.bare))
    return [(kind, source, {one.name: one.weighed for one in runs}, campaign.files.get(source.name, b""))
            for kind, source, runs in made if runs]  # fmt: skip


def recorded(
    source: Path, design: DesignPoint, model: Model, parameters: Parameters, weighed: Mapping[str, float],
    anew: bytes = b"",
) -> Iterator[Recorded]:  # fmt: skip
    """Runs of a database that can be used, one at a time, each cut to the steps that are fitted.

    `weighed` [kg] by the runs' names; for other runs the settings say it. Runs of the database `anew`, if any, take the
    place of those of their names. Raises SourceRefused, and NotIdentified where none can be used.
    """
    settings, refused, used = parameters.settings, list[str](), False
    closer = dict[str, MeasuredRun]()
    if anew:
        with as_file(anew, source.name) as path:
            closer = {one.name: one for one in read_runs(path, design, model, parameters) if not isinstance(one, str)}
    for run in read_runs(source, design, model, parameters):
        if isinstance(run, str):
            refused.append(run)
        else:
            used, run = True, closer.get(run.name, run)
            mass, sd = weighed.get(run.name, settings.weighed_mass), settings.weighed_sd
            known = () if mass is None else (Known(TOTAL_MASS, mass, sd * mass, "weighed"),)
            yield first_steps(run, settings.fitted_steps), known
    if not used:
        raise none_of("used", refused)


def none_of(done: str, refused: Sequence[str]) -> NotIdentified:
    """That no run can be so `done`, and why the first ones cannot."""
    return NotIdentified(f"no run can be {done}: {'; '.join(refused[:3]) or 'there is none'}")


def first_steps(run: MeasuredRun, steps: int) -> MeasuredRun:
    """The run up to the heel strike that ends so many steps, or to its last one."""
    steps = max(steps, FEWEST_STRIKES - 1)
    if steps >= len(run.strikes) - 1:
        return run
    return dataclasses.replace(run.upto(float(run.strikes[steps])), strikes=run.strikes[: steps + 1])


def read_runs(
    source: Path, design: DesignPoint, model: Model, parameters: Parameters, progress: Progress = ignore,
    reading: Callable[..., Iterator[Any]] = at_hand,
) -> Iterator[MeasuredRun | str]:  # fmt: skip
    """Runs of a database, one at a time, or why one cannot be used. Raises SourceRefused, and what `reading` raises."""
    ingest = parameters.ingest
    for trial in trials(map(as_read, reading(runs, source)), ingest, progress):
        yield run_of(trial, design, model.layout, parameters.settings, ingest.limits.lever_arm)


def named_runs(
    source: Path, design: DesignPoint, model: Model, parameters: Parameters, names: Sequence[str], asking: Asking
) -> tuple[dict[str, MeasuredRun], list[str]]:
    """The runs of these names, or all, by name, and why others cannot be used. Raises WrongOption."""
    found = list(read_runs(source, design, model, parameters, asking.progress, asking.reading))
    by_name = {run.name: run for run in found if isinstance(run, MeasuredRun)}
    refuse(*((name not in by_name, f"--run: no run {name} can be used; there are {', '.join(by_name) or 'none'}")
             for name in names))  # fmt: skip
    return ({name: run for name, run in by_name.items() if name in names or not names},
            [run for run in found if isinstance(run, str)])


def mid_stance_of(design: DesignPoint, layout: Layout, strikes: Vector, first_leg: int) -> float:
    """When mid-stance is [s] after the first of heel strikes (s,) [s] that a leg begins with, as `first_guess` has it.
    """
    return float(first_guess(design, strikes, first_leg, layout)[layout.place("mid_stance")])


def run_of(
    trial: Trial, design: DesignPoint, layout: Layout, settings: Settings, below_hip: float | None = None
) -> MeasuredRun | str:
    """A run of the ingest from its first mid-stance on; or why it cannot be used.

    The foot sensor sits `below_hip` [m]; where that is not known, at the foot's mass centre.
    """
    name = trial.experiment.name
    if not trial.accepted:
        why = next(one.sentence for one in trial.verdict.findings if one.refused)
        return f"{name}: turned down by the ingest: {why}"
    if len(trial.sensors) < 2:
        return f"{name}: has not both sensors"
    strikes = trial.strikes.time[FROM:]
    if len(strikes) < FEWEST_STRIKES:
        return f"{name}: has {len(trial.strikes.time)} heel strikes, {FEWEST_STRIKES + FROM} are needed"
    run = measured(name, trial.sensors, strikes, trial.strikes.leg[FROM:], trial.experiment.slope_deg, design, layout,
                   settings, below_hip)  # fmt: skip
    if all(used.any() for used in first_steps(run, settings.fitted_steps).used.values()):
        return run
    return (f"{name}: no sample of a sensor is left between heel strikes (settling_s, before_strike_s and "
            "after_strike_s of calibration)")


def rate_sd(trace: SensorTrace, settings: Settings) -> float:
    """Relative standard error of a sensor's rate: as usual, or by its own stamps if these show more, or if none does as
    oscillators scatter."""
    if math.isnan(trace.clock.clock_error_s):
        return max(settings.clock_sd, settings.own_clock_sd)
    return max(settings.clock_sd, trace.rate_error)


def measured(
    name: str, sensors: Mapping[str, BodySensor], strikes: Vector, legs: np.ndarray, slope: float | None,
    design: DesignPoint, layout: Layout, settings: Settings, below_hip: float | None,
) -> MeasuredRun:  # fmt: skip
    """A run of both sensors from the mid-stance after the first of heel strikes (s,) [s] of the `legs` (s,) on.

    `slope` [deg] as it was read off, if it was.
    """
    begin, end = float(strikes[0]), float(strikes[-1])
    first_leg = int(legs[0])
    first = mid_stance_of(design, layout, strikes - begin, first_leg) + settings.settling_s
    times, samples, used = {}, {}, {}
    for side in SIDES:
        sensor = sensors[side]
        since = sensor.time - begin
        kept = (since >= first) & (sensor.time <= end)
        order = np.argsort(since[kept], kind="stable")
        values = np.column_stack([sensor.force[:, FORWARD], sensor.force[:, UP], sensor.rate[:, LATERAL]])[kept][order]
        times[side], samples[side] = since[kept][order], np.nan_to_num(values)
        mask = usable(times[side], strikes - begin, first, settings.before_strike_s, settings.after_strike_s)
        used[side] = mask & np.isfinite(values)
    declared = {side: sensors[side].trace.indexed.recording.device.bandwidth_hz for side in SIDES}
    sampling = Sampling(
        times["hip"], times["foot"], {side: filter_delay(one) for side, one in declared.items()},
        {side: one or USUAL_BANDWIDTH * sensors[side].trace.rate_hz for side, one in declared.items()}, first_leg,
        below_hip=below_hip, rate_sd={side: rate_sd(sensors[side].trace, settings) for side in SIDES})  # fmt: skip
    own = {} if slope is None or math.isnan(slope) else {SLOPE: (slope, settings.slope_reading_sd_deg)}
    return MeasuredRun(name, sampling, samples, used, strikes - begin, own)
