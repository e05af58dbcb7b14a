"""The robot of a fit as a file keeps it, and the fits of its runs that a fit with more runs goes on from.

All runs are fitted together again, from where they were: one about which two numbers are known well bends so much that
what it told about one design is half a standard error off about another.
"""

from __future__ import annotations

import contextlib
from dataclasses import replace

import numpy as np

from stages.analytic.errors import StepFailed
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.model.walker import Vector
from stages.calibration.estimation.campaign import CampaignFit
from stages.calibration.estimation.least_squares import Known, combinations, information_of
from stages.calibration.estimation.run_fit import Model, RunFit, design_sizes, run_equations
from stages.calibration.following.change import Comparison
from stages.calibration.following.robot_file import OF_MOUNTING, FittedRobot, Learned
from stages.calibration.information.identifiability import SLOPE
from stages.calibration.intervals.model_error import Judged

#: A ramp that is set again, and a leg that is put on again, differ by these shares at least.
OF_SLOPE, OF_LEG = 0.03, 3e-4
#: Two runs or more tell how a mounting differs between them; with fewer the fit's own error is taken so many times.
ONE_RUN = 2.0


def earlier_runs(robot: FittedRobot) -> tuple[Known, ...]:
    """What a robot's own runs told of it: a further run's own fit then finds little but its start."""
    return combinations(robot.names, robot.estimate, robot.information, design_sizes(robot.began, robot.names))


def earlier_fits(before: FittedRobot, model: Model) -> list[RunFit]:
    """The fits of a robot's own runs as they ended. Raises StepFailed."""
    return [RunFit(before.estimate, one.own, one.unknowns,
                   run_equations(before.uncorrected, one.own, one.unknowns, one.run, model), 0, True, "")
            for one in before.learned]  # fmt: skip


def fitted_robot(
    design: DesignPoint, model: Model, fit: CampaignFit, told: Judged, widening: tuple[float, float],
    known: tuple[Known, ...], of_parts: bool,
) -> FittedRobot:
    """The robot that a fit found, which began with a `design` and what was `known`.

    A combination of parameters that no sensor shows keeps the spread that a design's have.
    """
    layout, d, (sigmas, wider) = model.layout, len(fit.names), widening
    found = model.robot(design, told.values, fit.own.mean(axis=0))
    of_runs = sum((one.eliminated(d)[0] for one in fit.equations), np.zeros((d, d)))
    sizes = design_sizes(found, fit.names)
    spread = np.linalg.inv((of_runs + information_of(known, fit.names)) * sizes * sizes[:, None] + np.eye(d))
    spread = spread * sizes * sizes[:, None]
    alone = wider * np.sqrt(np.diag(spread))
    more = wider * np.where(np.isfinite(told.sd), told.sd, alone) / alone
    variances = [np.diag(one.others(np.eye(len(layout.names)))) for one in fit.equations]
    places = [layout.place(name) for name in OF_MOUNTING]
    of_fit = np.sqrt(np.mean(variances, axis=0))[places]
    size = np.sqrt([one.chi2 / one.count for one in fit.equations])
    late = np.concatenate([
        run.strikes[1 : 1 + len(one.predicted.strikes)] - one.predicted.strikes[:, 0][: len(run.strikes) - 1]
        for run, one in zip(fit.runs, fit.equations, strict=True)])  # fmt: skip
    least = [(OF_SLOPE if name == SLOPE else OF_LEG) * abs(found.value(name)) for name in model.own]
    mounted = fit.unknowns[:, places]
    mounting = np.maximum(_sd(mounted), of_fit if len(fit.runs) > 1 else ONE_RUN * of_fit)
    robot = FittedRobot(
        found, fit.names, spread * np.outer(more, more), model.own, np.maximum(_sd(fit.own), least),
        np.column_stack([mounted.mean(axis=0), mounting]), sigmas, wider, float(late.mean()), float(_sd(late)),
        of_runs, fit.design, known, len(fit.runs), float(_sd(size)), of_parts, {}, design)  # fmt: skip
    comparison, shifts = Comparison(robot, model), []
    for run, own, unknowns in zip(fit.runs, fit.own, fit.unknowns, strict=True):
        with contextlib.suppress(StepFailed):
            there = model.robot(design, fit.design, own)
            shifts.append(comparison.shifts(comparison.evidence(run, there, unknowns)))
    return replace(robot, learned=tuple(map(Learned, fit.runs, fit.own, fit.unknowns)),
                   usual=_usual(comparison, np.array(shifts)) if shifts else {})  # fmt: skip


def _sd(values: np.ndarray) -> Vector:
    """Standard deviations of values (count, ...); of one zero."""
    return np.asarray(values.std(axis=0, ddof=min(1, len(values) - 1)))


def _usual(comparison: Comparison, shifts: np.ndarray) -> dict[str, tuple[float, float]]:
    """By how much parts look changed in the robot's own runs, (r, c, 2) with errors, for what the model lacks, and how
    that differs between them."""
    apart = np.sqrt(np.maximum(_sd(shifts[:, :, 0]) ** 2 - (shifts[:, :, 1] ** 2).mean(axis=0), 0.0))
    return {part.name: (float(mean), float(one))
            for part, mean, one in zip(comparison.parts, shifts[:, :, 0].mean(axis=0), apart, strict=True)}
