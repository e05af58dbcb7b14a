"""The calibration stage: what the campaign's sensors can tell, and some of its runs fitted blind.

Inputs: the databases of the campaign, or a lab's own; the campaign itself is read for what its scale showed, and
for the truth once all is fitted. Settings: params/calibration.yaml, the sensors of params/campaign.yaml. Output:
`Result`.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np

from stages.analytic.gait.design_point import DesignPoint
from stages.biped.processes import Progress, ignore
from stages.calibration.estimation.equations import Model
from stages.calibration.information.experiments import weighed
from stages.calibration.information.identifiability import identifiability
from stages.calibration.information.plan import first_model, plan_of, planned_equations
from stages.calibration.information.words import described
from stages.calibration.parameters import Parameters
from stages.calibration.result import Failed, FittedRun, HeldOut, Result, Told
from stages.calibration.study.blind_fit import fitted_run, held_out, misses_of, side_by_side
from stages.calibration.study.drawing import (
    LAB,
    WITH_OUTSOLE,
    WITHOUT,
    Recorded,
    as_mounted,
    drawn_design,
    looked_for,
    recorded,
    table_value,
)
from stages.campaign.result import Result as Campaign
from stages.campaign.result import RunTruth


@dataclass(frozen=True)
class Inputs:
    """What the stage reads: the synthetic runs, those without an outsole, their truth; and a lab's own database."""

    measurements: Path
    without_outsole: Path
    campaign: Campaign
    database: Path | None = None


def run(parameters: Parameters, inputs: Inputs, progress: Progress = ignore) -> Result:
    """Say what runs can tell, fit some of them blind, and put the truth beside. Raises NoGait, SourceRefused."""
    progress(0.1, "what the sensors can tell")
    parameters = as_mounted(parameters)
    told, not_seen = _told(parameters)
    design = drawn_design(parameters)
    model = first_model(design, looked_for(design), parameters)
    fits: list[FittedRun] = []
    out: list[HeldOut] = []
    missed: list[FittedRun] = []
    truths = {one.name: one for one in (*inputs.campaign.runs, *inputs.campaign.bare)}
    failed: list[Failed] = []
    robots = list(_robots(parameters, inputs, design, model))
    for number, runs in enumerate(robots):
        progress(0.2 + 0.8 * number / len(robots), f"fitting blind, robot {number + 1} of {len(robots)}")
        mine: list[FittedRun] = []
        for one in islice(runs, parameters.settings.fitted_runs):
            fit = fitted_run(drawn_design(parameters, one.kind), one, model)
            if isinstance(fit, Failed):
                failed.append(fit)
            else:
                mine.append(fit)
        fits += mine
        for one in islice(runs, parameters.settings.held_out_runs if mine else 0):
            tell = held_out(drawn_design(parameters, one.kind), mine, one, model, parameters.settings.begun_s)
            if isinstance(tell, Failed):
                failed.append(tell)
            else:
                out.append(tell)
        if number == 0:  # the runs of the other robots are of the same machines
            more = [one for one in islice(runs, parameters.settings.discrepancy_runs) if one.run.name in truths]
            missed = [_judged(fit, truths[fit.name], model.shared) for fit in side_by_side(
                more, drawn_design(parameters, more[0].kind), model)] if more else []
    return Result(
        parameters.settings.planned_runs, told, not_seen, model.shared,
        tuple(design.unit(name) for name in model.shared),
        np.array([design.value(name) for name in model.shared]), model.own, model.layout.names,
        tuple(_judged(fit, truths.get(fit.name), model.shared) for fit in fits), tuple(out),
        misses_of(missed, design, model), tuple(failed))


def _told(parameters: Parameters) -> tuple[tuple[Told, ...], tuple[str, ...]]:
    """What a run on the design's own gait can tell, and which combinations no sensor sees."""
    plan = plan_of(parameters)
    equations, model = planned_equations(plan, parameters)
    names = (*model.shared, *model.own)
    units = [plan.design.unit(name) for name in names]
    plain = identifiability(plan.design, equations, model, ())
    known, runs = (weighed(plan),), parameters.settings.planned_runs
    one, all_runs = (identifiability(plan.design, equations, model, known, count) for count in (1, runs))
    told = tuple(
        Told(name, units[row], float(one.values[row]), float(one.sd[row]), float(all_runs.sd[row]),
             all_runs.partners[row].name, all_runs.partners[row].correlation)
        for row, name in enumerate(names)
    )
    return told, tuple(described(each, names, units, plain.values) for each in plain.unseen)


def _robots(
    parameters: Parameters, inputs: Inputs, design: DesignPoint, model: Model
) -> Iterator[Iterator[Recorded]]:
    """Runs of each kind of robot, robot by robot. Raises SourceRefused."""
    if inputs.database is not None:
        yield recorded(inputs.database, LAB, design, model, parameters, {})
        return
    for source, kind, made in ((inputs.measurements, WITH_OUTSOLE, inputs.campaign.runs),
                               (inputs.without_outsole, WITHOUT, inputs.campaign.bare)):
        weights = {one.name: one.weighed for one in made}
        yield recorded(source, kind, design, model, parameters, weights)


def _judged(fit: FittedRun, truth: RunTruth | None, names: Sequence[str]) -> FittedRun:
    """The fit with the robot's true numbers beside it: that of both legs on average, the length of the first."""
    if truth is None:
        return fit
    robot = truth.robot
    own = {"biped.leg_length": robot.leg(0).leg_length, "biped.hip_mass": robot.hip_mass}
    values = [own[name] if name in own else table_value(robot, name) for name in names]
    return dataclasses.replace(fit, truth=np.array(values))
