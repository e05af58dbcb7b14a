"""What the study's blind fit begins with, and what a lab has: the robot as drawn, and the recordings."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from stages.analytic.gait.design_point import DesignPoint
from stages.biped.accuracy.scales import size
from stages.biped.design import Biped
from stages.calibration.estimation.each_run import guess
from stages.calibration.estimation.equations import Model
from stages.calibration.estimation.first_guess import guessed_mid_stance
from stages.calibration.estimation.known import TOTAL_MASS, Known
from stages.calibration.information.plan import EACH_RUNS, SLOPE, free_names
from stages.calibration.observation.measured_run import MeasuredRun
from stages.calibration.parameters import Parameters
from stages.calibration.recordings.from_ingest import FEWEST_STRIKES, run_of
from stages.imu.run import trials
from stages.imu.sources.source_sqlite import SqliteSource
from stages.twin.machine.machine import Build, build
from stages.twin.machine.projection import project

Given = TypeVar("Given", bound=Parameters)
#: Whose runs the study has.
WITH_OUTSOLE, WITHOUT, LAB = "with outsole", "without outsole", "lab"
#: Standard error of the foot sensor's place in the campaign [m], of Table 1's robot.
MOUNTED = 1e-5
#: The drawing's places and moments of frames are kept, and the lower legs' inertia: sensors tell them and the place of
#: mass together only, so that what a model lacks goes there (an inertia twice too large, masses off by a tenth).
KEPT = ("biped.frame_com", "biped.frame_offset", "biped.frame_inertia", "biped.leg_inertia")


def as_mounted(parameters: Given) -> Given:
    """The same with the foot sensor where the drawing has it, as the campaign mounts it: else what the model puts wrong
    goes into its place."""
    sd = MOUNTED * size(parameters.biped)
    return dataclasses.replace(parameters, settings=dataclasses.replace(parameters.settings, lever_arm_sd=sd))


def drawn_design(parameters: Parameters, kind: str = "") -> DesignPoint:
    """The design that the bill of parts makes, legs alike but for their length; a detailed biped as it is.

    A robot of the `kind` with an outsole is drawn with it. Raises ValueError where the bill does not add up.
    """
    biped = parameters.biped
    if not biped.detailed:
        rubber = parameters.settings.outsole if kind == WITH_OUTSOLE else 0.0
        whole = project(build(biped, parameters.twin, Build(outsole=rubber)))
        first, other = (dataclasses.asdict(whole.leg(leg)) for leg in (0, 1))
        alike = {name: 0.5 * (first[name] + other[name]) for name in first}
        biped = Biped(legs=whole.legs, hip_mass=whole.hip_mass, hip_damping=whole.hip_damping, **alike)
    return guess(dataclasses.replace(parameters, biped=biped))


def looked_for(design: DesignPoint) -> tuple[str, ...]:
    """What the fit looks for: masses, lengths and springs that are there, and of each run its `EACH_RUNS`."""
    there = [name for name in free_names(design) if name not in KEPT and design.value(name) != 0.0]
    own = [name for name in EACH_RUNS if name != SLOPE and design.biped.legs == "compliant"]
    return tuple(dict.fromkeys([*there, *own]))


def table_value(design: Biped, name: str) -> float:
    """A parameter of a design as Table 1 counts it: what frames weigh is part of the hip."""
    if name == "biped.hip_mass":
        return design.hip_mass + design.leg(0).frame_mass + design.leg(1).frame_mass
    key = name.partition(".")[2]
    return 0.5 * (float(getattr(design.leg(0), key)) + float(getattr(design.leg(1), key)))


@dataclass(frozen=True)
class Recorded:
    """A run, of what `kind` of robot, with what is known of the robot beside it."""

    kind: str
    run: MeasuredRun
    known: tuple[Known, ...]


def recorded(
    source: Path, kind: str, design: DesignPoint, model: Model, parameters: Parameters, weighed: Mapping[str, float]
) -> Iterator[Recorded]:
    """Runs of a database that can be used, one at a time, each cut to the steps that are fitted.

    `weighed` [kg] by the runs' names; for other runs the settings say it. Raises SourceRefused.
    """
    settings = parameters.settings
    mid_stance_of = guessed_mid_stance(design, model.layout)
    with SqliteSource(source) as opened:
        for trial in trials(opened.runs(), parameters.ingest.read):
            run = run_of(trial, mid_stance_of, settings, parameters.ingest.read.limits.lever_arm)
            if isinstance(run, str):
                continue
            mass = weighed.get(run.name, settings.weighed_mass)
            sd = settings.weighed_sd
            known = () if mass is None else (Known(TOTAL_MASS, mass, sd * mass, "weighed"),)
            yield Recorded(kind, first_steps(run, settings.fitted_steps), known)


def first_steps(run: MeasuredRun, steps: int) -> MeasuredRun:
    """The run up to the heel strike that ends so many steps, or to its last one."""
    steps = max(steps, FEWEST_STRIKES - 1)
    if steps >= len(run.strikes) - 1:
        return run
    return dataclasses.replace(run.upto(float(run.strikes[steps])), strikes=run.strikes[: steps + 1])
