"""The robot of a fit as a file keeps it, alone or gone on from the file of an earlier fit of the same robot.

Earlier runs are a quadratic about what they told, by shares of the parameters, which the new runs' sums of squares are
added to. What differs from run to run is by the formulas for mean and variance of two samples together.
"""

from __future__ import annotations

import contextlib
from dataclasses import dataclass, replace

import numpy as np

from stages.analytic.errors import StepFailed
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.model.walker import Vector
from stages.calibration.estimation.campaign import CampaignFit
from stages.calibration.estimation.least_squares import Known, combinations, covariance_of, information_of
from stages.calibration.estimation.run_fit import Model, design_sizes
from stages.calibration.following.change import Comparison
from stages.calibration.following.robot_file import OF_MOUNTING, FittedRobot
from stages.calibration.information.identifiability import SLOPE
from stages.calibration.intervals.model_error import Judged

#: A ramp that is set again, and a leg that is put on again, differ by these shares at least.
OF_SLOPE, OF_LEG = 0.03, 3e-4
#: Two runs or more tell how a mounting differs between them; with fewer the fit's own error is taken so many times.
ONE_RUN = 2.0
#: Shares of which runs tell less than this, in one over their square, are left where known values have them.
TOLD = 1.0


def earlier_runs(robot: FittedRobot) -> tuple[Known, ...]:
    """What a robot's own runs told of it."""
    moved = np.where(robot.estimate > 0.0, robot.middle / robot.estimate, 1.0)
    return combinations(robot.names, robot.middle, robot.information / np.outer(moved, moved),
                        design_sizes(robot.design, robot.names))  # fmt: skip


@dataclass(frozen=True)
class Spread:
    """Mean and standard deviation of `count` values, floats or arrays; of one zero."""

    count: int
    mean: Vector
    sd: Vector

    @classmethod
    def of(cls, values: np.ndarray) -> Spread:
        """That of values (count, ...)."""
        return cls(len(values), values.mean(axis=0), values.std(axis=0, ddof=min(1, len(values) - 1)))

    def and_of(self, count: int, mean: Vector, sd: Vector) -> Spread:
        """The same of these values and others together."""
        whole = self.count + count
        square = (self.count - 1) * self.sd**2 + (count - 1) * sd**2
        square = square + self.count * count / whole * (self.mean - mean) ** 2
        return Spread(whole, (self.count * self.mean + count * mean) / whole, np.sqrt(square / (whole - 1)))


def judged_again(fit: CampaignFit, before: FittedRobot, wider: float) -> Judged:
    """A fit that went on: what was taken off the earlier one for the model's error, and the error's own part of the
    intervals, are those of this one too."""
    values = np.array([before.design.value(name) for name in before.names])
    told = before.information + information_of(before.known, before.names)
    alone = before.wider**2 * np.diag(covariance_of(told, design_sizes(before.design, before.names)))
    of_model = np.sqrt(np.maximum(np.diag(before.covariance) - alone, 0.0))
    sd = np.hypot(wider * np.sqrt(np.diag(fit.covariance)), of_model)
    return Judged(fit.design - (before.estimate - values), sd,
                  f"intervals contain of the model's error what those of the fit with {before.runs} runs do")


def widened_again(sigmas: float, wider: float, runs: int, before: FittedRobot) -> tuple[float, float]:
    """Size of the residuals and the factor on intervals of `runs` runs and those before together."""
    both = np.array([[sigmas, wider], [before.sigmas, before.wider]])
    size, factor = np.sqrt(np.average(both**2, axis=0, weights=[runs, before.runs]))
    return float(size), float(factor)


def fitted_robot(
    design: DesignPoint, model: Model, fit: CampaignFit, told: Judged, widening: tuple[float, float],
    known: tuple[Known, ...], of_parts: bool, before: FittedRobot | None = None,
) -> FittedRobot:
    """The robot that a fit found, which began with a `design`, what was `known`, and the robot `before`.

    A combination of parameters that no sensor shows keeps the spread that a design's have.
    """
    runs, layout, d, (sigmas, wider) = len(fit.runs), model.layout, len(fit.names), widening
    found, at = (model.robot(design, values, fit.own.mean(axis=0)) for values in (told.values, fit.design))
    earlier = () if before is None else earlier_runs(before)
    of_runs = sum((one.eliminated(d)[0] for one in fit.equations), information_of(earlier, fit.names, at))
    weighed = information_of(known, fit.names)
    off = weighed @ fit.design - sum((one.row(fit.names) * one.value / one.sd**2 for one in known), np.zeros(d))
    sizes = design_sizes(found, fit.names)
    spread = np.linalg.inv((of_runs + weighed) * sizes * sizes[:, None] + np.eye(d)) * sizes * sizes[:, None]
    alone = wider * np.sqrt(np.diag(spread))
    more = wider * np.where(np.isfinite(told.sd), told.sd, alone) / alone
    share = np.where(fit.design > 0.0, fit.design, sizes)
    values, vectors = np.linalg.eigh(of_runs * share * share[:, None])
    seen = vectors[:, values > TOLD]
    pulled = seen @ ((seen.T @ (off * share)) / values[values > TOLD])  # the runs alone would have it there
    middle = np.where(fit.design > 0.0, fit.design * np.exp(pulled), fit.design + sizes * pulled)
    variances = [np.diag(one.others(np.eye(len(layout.names)))) for one in fit.equations]
    places = [layout.place(name) for name in OF_MOUNTING]
    of_fit = np.sqrt(np.mean(variances, axis=0))[places]
    own, mounted = Spread.of(fit.own), Spread.of(fit.unknowns[:, places])
    size = Spread.of(np.sqrt([one.chi2 / one.count for one in fit.equations]))
    late = Spread.of(np.concatenate([
        run.strikes[1 : 1 + len(one.predicted.strikes)] - one.predicted.strikes[:, 0][: len(run.strikes) - 1]
        for run, one in zip(fit.runs, fit.equations, strict=True)]))  # fmt: skip
    if before is not None:
        own = own.and_of(before.runs, np.array([before.design.value(name) for name in before.own]), before.own_sd)
        mounted = mounted.and_of(before.runs, *before.mounting.T)
        size = size.and_of(before.runs, np.array(before.sigmas), np.array(before.sigmas_sd))
        strikes = late.count * before.runs // runs
        late = late.and_of(strikes, np.array(before.late), np.array(before.late_sd))
        found = model.robot(found, told.values, own.mean)
    least = [(OF_SLOPE if name == SLOPE else OF_LEG) * abs(found.value(name)) for name in model.own]
    mounting = np.maximum(mounted.sd, of_fit if mounted.count > 1 else ONE_RUN * of_fit)
    robot = FittedRobot(
        found, fit.names, spread * np.outer(more, more), model.own, np.maximum(own.sd, least),
        np.column_stack([mounted.mean, mounting]), sigmas, wider, float(late.mean), float(late.sd), of_runs, middle,
        fit.design, known, own.count, float(size.sd), of_parts, {})  # fmt: skip
    return replace(robot, usual=_usual(robot, model, fit, before))


def _usual(
    robot: FittedRobot, model: Model, fit: CampaignFit, before: FittedRobot | None
) -> dict[str, tuple[float, float]]:
    """By how much parts look changed in the robot's own runs, for what the model lacks, and how that differs.

    Nothing of a run that the robot, corrected for the model's error, does not walk.
    """
    comparison, shifts = Comparison(robot, model), list[np.ndarray]()
    for run, unknowns in zip(fit.runs, fit.unknowns, strict=True):
        with contextlib.suppress(StepFailed):
            shifts.append(comparison.shifts(comparison.as_this(run, unknowns)[0]))
    if not shifts:
        return {} if before is None else dict(before.usual)
    found = np.array(shifts)
    spread = Spread.of(found[:, :, 0])
    spread = replace(spread, sd=np.sqrt(np.maximum(spread.sd**2 - (found[:, :, 1] ** 2).mean(axis=0), 0.0)))
    if before is not None:
        earlier = [before.usual.get(part.name, (0.0, 0.0)) for part in comparison.parts]
        spread = spread.and_of(before.runs, *np.array(earlier).T)
    return {part.name: (float(mean), float(sd))
            for part, mean, sd in zip(comparison.parts, spread.mean, spread.sd, strict=True)}
