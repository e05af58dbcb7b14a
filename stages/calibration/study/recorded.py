"""Runs of the study's databases as the blind fit takes them: their samples, and what the scale showed."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from stages.analytic.gait.design_point import DesignPoint
from stages.calibration.estimation.equations import Model
from stages.calibration.estimation.first_guess import guessed_mid_stance
from stages.calibration.estimation.known import TOTAL_MASS, Known
from stages.calibration.observation.measured_run import MeasuredRun
from stages.calibration.parameters import Parameters
from stages.calibration.recordings.from_ingest import FEWEST_STRIKES, run_of
from stages.imu.run import trials
from stages.imu.sources.source_sqlite import SqliteSource


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
