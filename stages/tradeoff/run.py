"""The tradeoff stage: what each way of computing the same walk costs and how accurate it is.

Inputs: the analytic gait, for the mid-stance from which all walk. Settings: params/tradeoff.yaml. Output: `Result`.
Cost is counted in evaluations; clock times, which differ from run to run, are kept by benchmarks/tradeoff.py.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from stages.analytic.result import Result as Analytic
from stages.biped.progress import Progress, ignore
from stages.tradeoff.parameters import Parameters
from stages.tradeoff.plan import Plan, plans
from stages.tradeoff.result import COMPLETED, ERRORS, UNKNOWN, Errors, Reference, Result, Row
from stages.tradeoff.way import Walked, Way, WayFailed, hip_error


@dataclass(frozen=True)
class Inputs:
    """What the stage reads."""

    analytic: Analytic


def run(parameters: Parameters, inputs: Inputs, progress: Progress = ignore) -> Result:
    """Measure all ways of the resolution chosen.

    A way that does not walk to the end is a row that says why. Raises WayFailed if a reference itself fails.
    """
    references, rows = [], []
    for number, plan in enumerate(plans(parameters, inputs.analytic)):
        progress(min(0.9, 0.2 * number), plan.reference.model)
        reference, measured = measure(plan)
        references.append(reference)
        rows += measured
    return Result(parameters.settings.walked_steps, tuple(references), tuple(rows))


def measure(plan: Plan) -> tuple[Reference, list[Row]]:
    """A model's reference, with what shows it converged, and the rows of its ways. Raises WayFailed."""
    truth = plan.reference.walk()
    leading = multiplier_of(plan.reference)
    second = errors_of(plan.second, truth, leading)[0]
    other, name = UNKNOWN, "none"
    if plan.independent is not None:
        other = errors_of(plan.independent, truth, leading)[0]
        name = f"{plan.independent.name}, {plan.independent.text}"
    reference = Reference(plan.reference.model, f"{plan.reference.name}, {plan.reference.text}", truth.period, leading,
                          truth.peak_force, plan.second.text, second, name, other)
    doubt = doubt_of(plan, truth, leading, second, other)
    return reference, [row_of(way, truth, leading, doubt) for way in plan.ways]


def doubt_of(plan: Plan, truth: Walked, leading: float, second: Errors, other: Errors) -> Errors:
    """How far the reference may be off: by the second or another way at no looser tolerance, or the spacing."""
    ways = [way for way in (plan.second, plan.independent) if way is not None]
    tight = float(ways[-1].setting["tolerance"]) <= float(ways[0].setting["tolerance"])
    sizes = np.spacing([np.abs(truth.hip).max(), truth.period, leading, truth.peak_force])
    apart = [[float(getattr(one, name)) for name in ERRORS] for one in ((second, other) if tight else (second,))]
    return Errors(*map(float, np.fmax.reduce(np.array([sizes, *apart]))))


def row_of(way: Way, truth: Walked, leading: float, doubt: Errors = UNKNOWN) -> Row:
    """One way against the reference, which may itself be off by `doubt`."""
    errors, cost, outcome = UNKNOWN, math.nan, COMPLETED
    try:
        errors, cost = errors_of(way, truth, leading)
    except WayFailed as reason:
        outcome = str(reason)
    errors = Errors(*(max(getattr(errors, name), getattr(doubt, name)) for name in ERRORS))  # NaN stays
    setting = way.setting
    step = setting.get("largest_step", setting.get("rolling_step", math.nan))
    return Row(way.model, way.name, way.text, way.mark, outcome, errors, cost,
               float(setting.get("tolerance", math.nan)), float(step), doubt)


def errors_of(way: Way, truth: Walked, leading: float) -> tuple[Errors, float]:
    """Errors of a way and its cost. Raises WayFailed."""
    walked = way.walk()
    return Errors(hip_error(walked, truth), abs(walked.period - truth.period), abs(multiplier_of(way) - leading),
                  abs(walked.peak_force - truth.peak_force)), walked.cost


def multiplier_of(way: Way) -> float:
    """The leading multiplier's magnitude; NaN where it is not measured."""
    return way.multiplier() if way.multiplier is not None else math.nan
