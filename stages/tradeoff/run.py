"""The tradeoff stage: what each way of computing the same walk costs and how accurate it is.

Inputs: the analytic gait, for the mid-stance from which all walk. Settings: params/tradeoff.yaml. Output: `Result`.
Cost is counted in evaluations; clock times, which differ from run to run, are kept by benchmarks/tradeoff.py.

For each model there is a reference, a second way nearly as tight, an independent one, and the rest. The paper's own
settings are RK23 and BDF (MATLAB's ode23 and ode15s) at 1e-7 for the constraint model, and for the multibody model a
variable-order implicit solver at 1e-6 with finer steps around heel strike (section 3.5). Exudyn has no such solver;
implicit steps by phase on bodies and joints stand in for it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from stages.analytic.errors import StepFailed
from stages.analytic.model.stiffness import attainable_tolerance
from stages.analytic.result import Inputs, Result as Analytic
from stages.biped.design import BeyondModel, Biped, require_own_strikes
from stages.biped.processes import Progress, ignore
from stages.studies.result import COMPLETED
from stages.studies.walks import Upright
from stages.tradeoff import constraint_ways
from stages.tradeoff.constraint_ways import compiled_way, readable_rates, scipy_way
from stages.tradeoff.parameters import Parameters
from stages.tradeoff.penalty_ways import PENALTY, TWIN, Scene, joints_way, penalty_way, tree_way, twin_way
from stages.tradeoff.result import ERRORS, UNKNOWN, Errors, Reference, Result, Row
from stages.tradeoff.way import Walked, Way, hip_error
from stages.twin.machine.projection import machine_of, project
from stages.twin.machine.tree import ConnectorTree

PAPER, DEFAULT = "paper", "default"
TRAPEZOIDAL, ALPHA = "trapezoidal", "generalized_alpha"
#: Why the stage is not run once more at closer settings of solvers.
ONCE = "it measures the errors of solvers"
#: Tolerance of the compiled penalty walker where it confirms a reference.
TIGHT = 1e-12
DOP853, PAIR = ("DOP853",), ("RK23", "BDF")
#: Tolerances of SciPy's methods on the compiled terms, by resolution, and of the paper's pair of methods.
OF_SCIPY: dict[str, dict[tuple[str, ...], tuple[float, ...]]] = {
    "few": {DOP853: (1e-8,), PAIR: (1e-7,)},
    "coarse": {DOP853: (1e-6, 1e-8), ("RK45",): (1e-6,), PAIR: (1e-7,)},
    "full": {
        DOP853: (1e-4, 1e-6, 1e-8, 1e-10, 1e-12), ("RK45",): (1e-4, 1e-6, 1e-8, 1e-10), ("Radau",): (1e-4, 1e-6, 1e-8),
        ("LSODA",): (1e-6, 1e-8, 1e-10), PAIR: (1e-4, 1e-5, 1e-6, 1e-7, 1e-8),
    },
}  # fmt: skip


def run(parameters: Parameters, inputs: Inputs, progress: Progress = ignore) -> Result:
    """Measure all ways of the resolution chosen.

    A way that does not walk to the end is a row that says why. Raises StepFailed if a reference itself fails.
    """
    references, rows = [], []
    for number, plan in enumerate(plans(parameters, inputs.analytic)):
        progress(min(0.9, 0.2 * number), plan.reference.model)
        reference, measured = measure(plan)
        references.append(reference)
        rows += measured
    return Result(parameters.settings.walked_steps, tuple(references), tuple(rows))


def measure(plan: Plan) -> tuple[Reference, list[Row]]:
    """A model's reference, with what shows it converged, and the rows of its ways. Raises StepFailed."""
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
    except StepFailed as reason:
        outcome = str(reason)
    errors = Errors(*(max(getattr(errors, name), getattr(doubt, name)) for name in ERRORS))  # NaN stays
    setting = way.setting
    step = setting.get("largest_step", setting.get("rolling_step", math.nan))
    return Row(way.model, way.name, way.text, way.mark, outcome, errors, cost,
               float(setting.get("tolerance", math.nan)), float(step), doubt)


def errors_of(way: Way, truth: Walked, leading: float) -> tuple[Errors, float]:
    """Errors of a way and its cost. Raises StepFailed."""
    walked = way.walk()
    return Errors(hip_error(walked, truth), abs(walked.period - truth.period), abs(multiplier_of(way) - leading),
                  abs(walked.peak_force - truth.peak_force)), walked.cost


def multiplier_of(way: Way) -> float:
    """The leading multiplier's magnitude; NaN where it is not measured."""
    return way.multiplier() if way.multiplier is not None else math.nan


@dataclass(frozen=True)
class Plan:
    """One model's ways. The reference is shown converged by `second` (same way) and `independent` (another way)."""

    reference: Way
    second: Way
    independent: Way | None
    ways: tuple[Way, ...]


def plans(parameters: Parameters, analytic: Analytic) -> Iterator[Plan]:
    """All plans; `analytic` gives the mid-stance and the force of its first sample. Few are those that claims rest on.

    Of a design with details the constraint model's alone. Raises StepFailed, BeyondModel for a hip that rubs.
    """
    if parameters.biped.hip_friction > 0:
        raise BeyondModel("SciPy's ways, beside which the constraint model's are measured, do not know hip_friction")
    require_own_strikes(parameters.biped, "the study of speed against accuracy")
    if parameters.biped.detailed:
        yield detailed_plan(parameters, parameters.biped)
        return
    yield from constraint_plans(parameters, analytic)
    if parameters.settings.resolution == "full":
        yield projected_plan(parameters)
    yield from penalty_plans(parameters, analytic)
    if parameters.settings.resolution != "few":
        yield twin_plan(parameters, analytic)


def constraint_plans(parameters: Parameters, analytic: Analytic) -> Iterator[Plan]:
    """Rolling trailing foot, then limited friction, which rigid legs do not need."""
    resolution, steps = parameters.settings.resolution, parameters.settings.walked_steps
    few, full = resolution == "few", resolution == "full"
    kinds = (None,) if few or parameters.biped.legs == "rigid" else (None, parameters.contact.coefficients)
    for friction in kinds:
        at = constraint_ways.scene(parameters.biped, parameters.slope, friction, analytic.mid_stance, steps)
        independent, others = scipy_way(at, DOP853, 1e-12), scipy_ways(at, resolution) if friction is None else []
        if friction is None and not few:
            independent = scipy_way(at, DOP853, 1e-12 if full else 1e-10, readable_rates, multiplier=True)
        yield constraint_plan(parameters, at, independent, others)


def constraint_plan(
    parameters: Parameters, at: constraint_ways.Scene, independent: Way, others: Sequence[Way]
) -> Plan:
    """The compiled way at all tolerances, the default one among them, and other ways."""
    usual = parameters.constraint.tolerance
    tolerances = sorted({usual, *(10.0**-n for n in range(3, 14))}, reverse=True)
    compiled = [compiled_way(at, value, DEFAULT if value == usual else "") for value in tolerances]
    finest = attainable_tolerance(at.walker.p, 1e-14)  # at smaller ones walks are the same
    return Plan(compiled_way(at, finest), compiled_way(at, 10 * finest), independent, (*compiled, *others))


def projected_plan(parameters: Parameters) -> Plan:
    """A design with frames and legs that differ, whose steps alternate: the twin as it projects into the plane."""
    return detailed_plan(parameters, project(machine_of(parameters.biped, parameters.twin)))


def detailed_plan(parameters: Parameters, biped: Biped) -> Plan:
    """The constraint model of a design with details, by its own ways."""
    at = constraint_ways.detailed_scene(biped, parameters.slope, parameters.settings.walked_steps)
    others = [scipy_way(at, DOP853, value) for value in OF_SCIPY["full"][DOP853]]
    return constraint_plan(parameters, at, scipy_way(at, DOP853, 1e-12, readable_rates), others)


def scipy_ways(at: constraint_ways.Scene, resolution: str) -> list[Way]:
    """SciPy's methods on the compiled terms, the paper's pair of methods, and the readable path."""
    ways = [scipy_way(at, methods, value, mark=PAPER if methods == PAIR and value == 1e-7 else "")
            for methods, values in OF_SCIPY[resolution].items() for value in values]
    readable = (1e-6, 1e-8, 1e-10) if resolution == "full" else ()
    return ways + [scipy_way(at, DOP853, value, readable_rates) for value in readable]


def scene(model: str, parameters: Parameters, analytic: Analytic) -> Scene:
    """A model on the study's ground, where the constraint model's mid-stance is pressed into it."""
    upright = Upright(parameters.biped, parameters.slope, analytic.mid_stance, analytic.walk.standing_force)
    steps = parameters.settings.walked_steps
    return Scene(model, upright, parameters.contact, parameters.planar, parameters.twin, steps)


def penalty_plans(parameters: Parameters, analytic: Analytic) -> Iterator[Plan]:
    """The study's ground with all ways; in full other grounds as well, with the tree."""
    resolution = parameters.settings.resolution
    full, few, settings, ground = resolution == "full", resolution == "few", parameters.planar, parameters.contact
    at = scene(PENALTY, parameters, analytic)
    loose, rolling, impact = parameters.twin.largest_step, settings.rolling_step, settings.impact_step
    by_phase = joints_way(at, TRAPEZOIDAL, rolling, impact, multiplier=full, mark=PAPER)
    powers = range(3, 10) if full else (4, 6) if few else (3, 4, 6, 8)
    ways = [tree_way(at, 10.0**-n, loose, multiplier=full) for n in powers]
    ways += [tree_way(at, settings.tolerance, settings.largest_step, multiplier=full, mark=DEFAULT), by_phase]
    ways += [penalty_way(at, 10.0**-n, multiplier=full) for n in (range(3, 13) if full else (3, 4, 6, 8, 10))]
    if full:
        ways += [tree_way(at, 1e-3, 2.5 * loose, multiplier=True), tree_way(at, 1e-4, 0.25 * loose, multiplier=True)]
        ways += [joints_way(at, TRAPEZOIDAL, 2 * rolling, impact, multiplier=True),
                 joints_way(at, TRAPEZOIDAL, rolling / 2, impact / 2, multiplier=True),
                 joints_way(at, ALPHA, rolling, impact), joints_way(at, ALPHA, rolling / 2, impact / 2)]
    tight = [tree_way(at, value, loose / 2, multiplier=full)
             for value in ((1e-11, 1e-10) if full else (1e-9, 1e-8) if few else (1e-10, 1e-9))]
    yield Plan(tight[0], tight[1], penalty_way(at, TIGHT, multiplier=full), tuple(ways))
    if not full:
        return
    for name, change in (
        ("k_c / 10", {"contact_stiffness": ground.contact_stiffness / 10}),
        ("k_c x 10", {"contact_stiffness": ground.contact_stiffness * 10}),
        ("restitution", {"normal_force": "restitution"}),
    ):
        at = replace(at, model=f"{PENALTY}, {name}", contact=replace(ground, **change))
        yield Plan(tree_way(at, 1e-10, loose), tree_way(at, 1e-9, loose), penalty_way(at, TIGHT),
                   (*(tree_way(at, value, loose) for value in (1e-4, 1e-6, 1e-8)),
                    *(penalty_way(at, value) for value in (1e-4, 1e-6, 1e-8))))


def twin_plan(parameters: Parameters, analytic: Analytic) -> Plan:
    """The twin; independent is a ground of Exudyn's own connectors, on the same solver: there is no other for it."""
    full, settings = parameters.settings.resolution == "full", parameters.twin
    at = scene(TWIN, parameters, analytic)
    usual, loose = (settings.tolerance, settings.largest_step), settings.largest_step
    powers = range(4, 10) if full else range(3, 8)
    chosen = {(10.0**-n, loose) for n in powers} | {usual}
    ways = [twin_way(at, *pair, mark=f"{PAPER}, {DEFAULT}" if pair == usual and usual[0] == 1e-6 else
                DEFAULT if pair == usual else "") for pair in sorted(chosen, reverse=True)]
    if full:
        ways.append(twin_way(at, 1e-4, 2.5 * loose))
    tight = [twin_way(at, value, loose) for value in ((1e-10, 1e-9) if full else (1e-8, 1e-7))]
    independent = twin_way(at, 1e-8 if full else 1e-7, loose, ConnectorTree)
    return Plan(tight[0], tight[1], independent, tuple(ways))
