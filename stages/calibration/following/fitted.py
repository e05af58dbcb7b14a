"""The robot of a fit as a file keeps it, and fits of single runs: those that a fit with more runs goes on from, and
those that are parts of an answer, with plain argument and answer, so that they are kept and go anywhere.

All runs are fitted together again, from where they were: one about which two numbers are known well bends so much that
what it held of one design is half a standard error off about another.
"""

import contextlib
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from scipy.special import digamma, polygamma

from stages.analytic.errors import StepFailed
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.model.walker import Vector
from stages.biped.design import Biped
from stages.calibration.estimation.campaign import CampaignFit
from stages.calibration.estimation.least_squares import Known, combinations, information_of
from stages.calibration.estimation.run_fit import (
    Model,
    RunFit,
    begun,
    design_sizes,
    fit_near,
    fit_run,
    run_equations,
)
from stages.calibration.following.change import Comparison
from stages.calibration.following.robot_file import IN_A_ROW, OF_MOUNTING, FittedRobot, Learned, restored
from stages.calibration.information.identifiability import SLOPE, first_model
from stages.calibration.intervals.model_error import Judged
from stages.calibration.observation.measured_run import SIDES, MeasuredRun
from stages.calibration.parameters import Parameters

#: A ramp that is set again, and a leg that is put on again, differ by these shares at least.
OF_SLOPE, OF_LEG = 0.03, 3e-4
#: Two runs or more show how a mounting differs between them; with fewer the fit's own error is taken so many times.
ONE_RUN = 2.0
#: Degrees of freedom of what is known well.
SURE = 1e6


def earlier_runs(robot: FittedRobot) -> tuple[Known, ...]:
    """What a robot's own runs showed of it: a further run's own fit then finds little but its start."""
    return combinations(robot.names, robot.estimate, robot.information, design_sizes(robot.began, robot.names))


def earlier_fits(before: FittedRobot, model: Model) -> list[RunFit]:
    """The fits of a robot's own runs as they ended. Raises StepFailed."""
    return [RunFit(before.estimate, one.own, one.unknowns,
                   run_equations(before.uncorrected, one.own, one.unknowns, one.run, model), 0, True, "")
            for one in before.learned]  # fmt: skip


def fitted_alone(
    parameters: Parameters, drawn: dict[str, Any], names: list[str], known: list[Any], place: float, near: bool,
    plain: Any,
) -> dict[str, Any]:  # fmt: skip
    """The fit of one run from the design `drawn` (its biped's fields), in plain values; or why there is none. Run and
    known values are as `plain_of` has them.

    `place` [m] is the standard error of the foot sensor's; `near`: the design is the robot's, not a drawing.
    """
    parameters = replace(parameters, given=replace(parameters.settings, lever_arm_sd=place))
    design = DesignPoint(Biped(**drawn), parameters.slope)
    model = first_model(design, names, parameters)
    try:
        run, priors = restored(MeasuredRun, plain), [restored(Known, one) for one in known]
        fit = fit_near(design, begun(design, run, model).unknowns, run, model, priors) if near else fit_run(
            design, run, model, priors)
    except StepFailed as reason:
        return {"why_none": str(reason)}
    return {"design": fit.design.tolist(), "own": fit.own.tolist(), "unknowns": fit.unknowns.tolist(),
            "evaluations": fit.evaluations, "converged": fit.converged, "why": fit.why}


def fit_of(answer: Mapping[str, Any], run: MeasuredRun, design: DesignPoint, model: Model) -> RunFit | str:
    """The fit of an answer, with its equations."""
    if "why_none" in answer:
        return str(answer["why_none"])
    values, own, unknowns = (np.array(answer[key]) for key in ("design", "own", "unknowns"))
    there = model.robot(design, values)
    return RunFit(values, own, unknowns, run_equations(there, own, unknowns, run, model), answer["evaluations"],
                  answer["converged"], answer["why"])


def fitted_robot(
    design: DesignPoint, model: Model, fit: CampaignFit, judged: Judged, widening: tuple[float, float],
    known: tuple[Known, ...], of_parts: bool, held_out: Sequence[MeasuredRun] = (),
) -> FittedRobot:
    """The robot that a fit found, which began with a `design` and what was `known`; runs `held_out` show, too, how
    parts usually look changed.

    A combination of parameters that no sensor shows keeps the spread that a design's have. Heel strikes are as the
    model has them, until runs are followed.
    """
    layout, d, (sigmas, wider) = model.layout, len(fit.names), widening
    found = model.robot(design, judged.values, fit.own.mean(axis=0))
    of_runs = sum((one.eliminated(d)[0] for one in fit.equations), np.zeros((d, d)))
    sizes = design_sizes(found, fit.names)
    spread = np.linalg.inv((of_runs + information_of(known, fit.names)) * sizes * sizes[:, None] + np.eye(d))
    spread = spread * sizes * sizes[:, None]
    alone = wider * np.sqrt(np.diag(spread))
    more = wider * np.where(np.isfinite(judged.sd), judged.sd, alone) / alone
    variances = [np.diag(one.others(np.eye(len(layout.names)))) for one in fit.equations]
    places = [layout.place(name) for name in OF_MOUNTING]
    of_fit = np.sqrt(np.mean(variances, axis=0))[places]
    size = np.sqrt([one.chi2 / one.count for one in fit.equations])
    least = [(OF_SLOPE if name == SLOPE else OF_LEG) * abs(found.value(name)) for name in model.own]
    mounted = fit.unknowns[:, places]
    mounting = np.maximum(_sd(mounted), of_fit if len(fit.runs) > 1 else ONE_RUN * of_fit)
    robot = FittedRobot(
        found, fit.names, spread * np.outer(more, more), model.own, np.maximum(_sd(fit.own), least),
        np.column_stack([mounted.mean(axis=0), mounting]), sigmas, wider, 0.0, 0.0,
        of_runs, fit.design, known, len(fit.runs), float(_sd(size)), of_parts, {}, design,
        tuple(map(Learned, fit.runs, fit.own, fit.unknowns)),
        unexplained=max(unexplained((run.sampling.of(side), one.residuals[side] / wider) for side in SIDES)
                        for run, one in zip(fit.runs, fit.equations, strict=True)))  # fmt: skip
    comparison = Comparison(robot, model)
    return _with_usual(robot, comparison, [*_shifts(comparison, model, fit, held_out)])


def unexplained(sides: Iterable[tuple[Vector, np.ndarray]]) -> float:
    """The mean square that all of `IN_A_ROW` residuals of a run have somewhere: by times (m,) and (m, 3) of each of its
    `sides`, in standard deviations, NaN where nothing is used."""
    times, left = map(np.concatenate, zip(*sides, strict=True))
    used = np.isfinite(left).any(axis=1)
    squares = np.nanmean(left[used] ** 2, axis=1)[np.argsort(times[used], kind="stable")]
    return max((float(squares[at : at + IN_A_ROW].min()) for at in range(len(squares) - IN_A_ROW + 1)), default=0.0)


def _shifts(
    comparison: Comparison, model: Model, fit: CampaignFit, held_out: Iterable[MeasuredRun]
) -> Iterator[np.ndarray]:
    """How parts look changed in the runs of a fit and in others, (c, 2) as `Comparison.shifts` has it, as far as they
    walk."""
    fitted = [partial(comparison.evidence, run, model.robot(comparison.robot.began, fit.design, own), unknowns)
              for run, own, unknowns in zip(fit.runs, fit.own, fit.unknowns, strict=True)]
    for shown in (*fitted, *(partial(comparison.alike, run) for run in held_out)):
        with contextlib.suppress(StepFailed):
            yield comparison.shifts(shown())


def _with_usual(robot: FittedRobot, comparison: Comparison, shifts: Sequence[np.ndarray]) -> FittedRobot:
    """A robot that knows how parts look changed in its runs, by the shifts (c, 2) of each, if there are any."""
    if not shifts:
        return robot
    looks, errors = np.array(shifts).transpose(2, 0, 1)
    by_chance = (errors**2).mean(axis=0)
    apart, freedom = np.zeros(len(by_chance)), np.full(len(by_chance), SURE)
    if len(shifts) > 1:
        of_design = np.array(["." in part.moves[0] for part in comparison.parts])
        ratios, freedom = _moderated(_sd(looks) ** 2 / by_chance, len(shifts) - 1, of_design)
        apart = np.sqrt(np.maximum(ratios - 1.0, 0.0) * by_chance)
    rows = zip(comparison.parts, looks.mean(axis=0).tolist(), apart.tolist(), freedom.tolist(), strict=True)
    return replace(robot, usual={part.name: tuple(row) for part, *row in rows}, compared=len(shifts))


def _moderated(ratios: Vector, freedom: int, typical: np.ndarray) -> tuple[Vector, Vector]:
    """Ratios of variances (c,) that are known with so much `freedom` each, drawn towards what those that are `typical`
    (c,) have in common, and the freedom then (c,) (G. K. Smyth, Stat. Appl. Genet. Mol. Biol. 3, 2004, 3).

    Others are not drawn upwards: sensors stay where they are whatever a model lacks."""
    logs = np.log(np.maximum(ratios[typical], 1e-9)) - digamma(0.5 * freedom) + math.log(0.5 * freedom)
    halves = np.geomspace(0.05, 0.5 * SURE, 4000)  # of the common one's freedom
    prior = 2.0 * float(np.interp(polygamma(1, 0.5 * freedom) - logs.var(ddof=1), -polygamma(1, halves), halves))
    common = math.exp(logs.mean() + digamma(0.5 * prior) - math.log(0.5 * prior))
    drawn = np.where(typical | (ratios > common), prior, 0.0)
    return (drawn * common + freedom * ratios) / (drawn + freedom), drawn + freedom


def _sd(values: np.ndarray) -> Vector:
    """Standard deviations of values (count, ...); of one zero."""
    return np.asarray(values.std(axis=0, ddof=min(1, len(values) - 1)))
