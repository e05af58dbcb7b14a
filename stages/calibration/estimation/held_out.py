"""A run that was not fitted: how well a robot explains it, and how well it predicts it from its beginning."""

import contextlib
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from stages.analytic.errors import StepFailed
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.model.walker import Vector
from stages.calibration.estimation.least_squares import Known
from stages.calibration.estimation.run_fit import Equations, Model, RunFit, fit_near, fit_run, one_step, run_equations
from stages.calibration.information.identifiability import SLOPE
from stages.calibration.observation.measured_run import SIDES, MeasuredRun
from stages.calibration.result import FittedRun, HeldOut, Trace

#: The run that a robot with a design, with a run's unknowns, makes when it is sampled like another. Raises StepFailed.
Simulator = Callable[[DesignPoint, Vector, MeasuredRun], MeasuredRun]


def corrected(
    design: DesignPoint, fit: RunFit | FittedRun, run: MeasuredRun, model: Model, known: Sequence[Known],
    simulate: Simulator,
) -> tuple[Vector, Vector]:
    """One correction step of a run's fit: what is to be taken off the shared parameters (d,), and off the run's own
    (o,). Raises StepFailed where the simulator or the model does not walk."""
    there = model.robot(design, fit.design, fit.own)
    made = simulate(there, fit.unknowns, run)
    read = {name: (there.value(name), sd) for name, (_, sd) in run.own.items()}  # its ramp and its weight are known to
    weighed = [replace(one, value=one.of(there)) for one in known]  # be what they are, as well as the robot's were
    again = fit_near(there, fit.unknowns, replace(made, own=read), model, weighed)
    return again.design - fit.design, again.own - fit.own


def trace(run: MeasuredRun, equations: Equations, side: str) -> Trace:
    """What a sensor showed and what the fit says it should have."""
    residual = equations.residuals[side] * equations.noise[side]
    return Trace(run.sampling.of(side), run.samples[side], equations.predicted.samples[side][:, :, 0], residual)


#: Columns of a sensor's samples that are forces, and that which is the rate.
FORCE, RATE = slice(0, 2), slice(2, 3)


def explained(
    design: DesignPoint, run: MeasuredRun, model: Model, begun: float, kind: str = "",
    near: tuple[Vector, Vector, Vector] | None = None,
) -> HeldOut:
    """Errors on a run of that `kind` of robot; `design` is kept, also what other runs had for themselves, but for the
    ramp. It is predicted with the start and the sensors of its first `begun` seconds. A fit `near` the run's own takes
    one step from there.

    Raises StepFailed where it does not walk the run at all.
    """
    alone = replace(model, shared=(), own=(SLOPE,))
    whole = one_step(design, near, run, alone, ()) if near else fit_run(design, run, alone, ())
    shown, forecast = whole.equations, (np.nan, np.nan)
    since = min(float(run.sampling.of(side)[0]) for side in SIDES) + begun
    with contextlib.suppress(StepFailed):
        first = run.upto(since)
        start = fit_near(design, near[-1], first, alone, ()) if near else fit_run(design, first, alone, ())
        shown = run_equations(design, start.own, start.unknowns, run, alone)
        forecast = rms_of(shown.residuals, run, model, since)
    hip, foot = (trace(run, shown, side) for side in SIDES)
    return HeldOut(
        run.name, kind, begun, float(np.sqrt(whole.equations.chi2 / whole.equations.count)),
        *rms_of(whole.equations.residuals, run, model), *forecast, model.noise[0], model.noise[2], whole.own,
        whole.unknowns, hip, foot, run.strikes)


def rms_of(
    residuals: dict[str, np.ndarray], run: MeasuredRun, model: Model, since: float = 0.0
) -> tuple[float, float]:
    """Root mean squares of force [m/s^2] and rate [rad/s] from residuals in noises, of samples after `since` [s]."""
    rows = [residuals[side][run.sampling.of(side) > since] * model.noise_at(run.sampling, side) for side in SIDES]
    every = np.concatenate(rows)
    force, rate = (float(np.sqrt(np.nanmean(every[:, columns] ** 2))) for columns in (FORCE, RATE))
    return force, rate
