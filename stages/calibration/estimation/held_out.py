"""A run that was not fitted: how well a robot explains it, and how well it foretells it from its beginning."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from stages.analytic.errors import StepFailed
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.model.walker import Vector
from stages.calibration.estimation.first_guess import first_guess
from stages.calibration.estimation.least_squares import Known
from stages.calibration.estimation.run_fit import Equations, Model, RunFit, fit_near, fit_run, run_equations
from stages.calibration.information.identifiability import SLOPE
from stages.calibration.observation.measured_run import SIDES, MeasuredRun
from stages.calibration.result import Trace

#: The run that a robot with a design, with a run's unknowns, makes when it is sampled like another. Raises StepFailed.
Simulator = Callable[[DesignPoint, Vector, MeasuredRun], MeasuredRun]


@dataclass(frozen=True)
class Corrected:
    """The shared parameters (d,) corrected; `bias` (d,) is what was taken off them, `own_bias` (o,) is to be taken off
    the run's own."""

    design: Vector
    bias: Vector
    own_bias: Vector


def corrected(
    design: DesignPoint, fit: RunFit, run: MeasuredRun, model: Model, known: Sequence[Known], simulate: Simulator
) -> Corrected:
    """One correction step of a run's fit. Raises StepFailed where the simulator or the model does not walk."""
    there = model.robot(design, fit.design, fit.own)
    made = simulate(there, fit.unknowns, run)
    read = {name: (there.value(name), sd) for name, (_, sd) in run.own.items()}  # its ramp and its weight are known to
    weighed = [replace(one, value=one.of(there)) for one in known]  # be what they are, as well as the robot's were
    again = fit_near(there, fit.unknowns, replace(made, own=read), model, weighed)
    bias = again.design - fit.design
    return Corrected(fit.design - bias, bias, again.own - fit.own)


def trace(run: MeasuredRun, equations: Equations, model: Model, side: str) -> Trace:
    """What a sensor showed and what the fit says it should have."""
    residual = equations.residuals[side] * np.asarray(model.noise)
    return Trace(run.sampling.of(side), run.samples[side], equations.predicted.samples[side][:, :, 0], residual)


#: Columns of a sensor's samples that are forces, and that which is the rate.
FORCE, RATE = slice(0, 2), slice(2, 3)


@dataclass(frozen=True)
class Explained:
    """Root mean square errors of the specific force [m/s^2] and of the rate [rad/s] of both sensors: `fit` with the
    run's own start and sensors fitted on all of it, `foretold` with them from its first `begun` seconds and errors over
    the rest, as the equations `ahead` have it; NaN where the robot does not walk so far. `sigmas`: of the fit, in
    sensors' noises."""

    fit: tuple[float, float]
    foretold: tuple[float, float]
    sigmas: float
    begun: float
    own: RunFit
    ahead: Equations | None


def explained(design: DesignPoint, run: MeasuredRun, model: Model, begun: float) -> Explained:
    """Errors on a run; `design` is kept, also what other runs had for themselves, but for the ramp.

    Raises StepFailed where it does not walk the run at all.
    """
    alone = replace(model, shared=(), own=(SLOPE,))
    begin = first_guess(design, run.strikes, run.sampling.first_leg, model.layout)
    whole = fit_run(design, run, alone, (), begin)
    first = min(float(run.sampling.of(side)[0]) for side in SIDES)
    ahead: Equations | None
    try:
        start = fit_run(design, run.upto(first + begun), alone, (), begin)
        ahead = run_equations(design, start.own, start.unknowns, run, alone)
        foretold = rms_of(ahead.residuals, run, model, first + begun)
    except StepFailed:
        ahead, foretold = None, (np.nan, np.nan)
    return Explained(rms_of(whole.equations.residuals, run, model), foretold,
                     float(np.sqrt(whole.equations.chi2 / whole.equations.count)), begun, whole,
                     ahead)


def rms_of(
    residuals: dict[str, np.ndarray], run: MeasuredRun, model: Model, since: float = 0.0
) -> tuple[float, float]:
    """Root mean squares of force [m/s^2] and rate [rad/s] from residuals in noises, of samples after `since` [s]."""
    rows = [residuals[side][run.sampling.of(side) > since] * np.asarray(model.noise) for side in SIDES]
    every = np.concatenate(rows)
    force, rate = (float(np.sqrt(np.nanmean(every[:, columns] ** 2))) for columns in (FORCE, RATE))
    return force, rate
