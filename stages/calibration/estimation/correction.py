"""What the model itself puts wrong, told by a simulator that is nearer to the robot: one step that takes it out.

The simulator is given the numbers that were found and makes the same run. The model is fitted to that, as it was to the
robot's. By as much as it then misses the numbers that the simulator had, it missed the robot's: fit and miss both go by
the model's exact derivatives, the residuals are the simulator's. Where the simulator is the model the step is nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.model.walker import Vector
from stages.calibration.estimation.equations import Model
from stages.calibration.estimation.fit import RunFit, fit_near
from stages.calibration.estimation.known import Known
from stages.calibration.observation.measured_run import MeasuredRun

#: The run that a robot with a design, with a run's unknowns, makes when it is sampled like another. Raises StepFailed.
Simulator = Callable[[DesignPoint, Vector, MeasuredRun], MeasuredRun]


@dataclass(frozen=True)
class Corrected:
    """The shared parameters (d,), the run's own (o,) and its unknowns (k,), corrected; `bias` (d,) is what was taken
    off the shared ones, `own_bias` and `unknowns_bias` off the others; `made` the simulator's run, `again` its fit."""

    design: Vector
    own: Vector
    unknowns: Vector
    bias: Vector
    own_bias: Vector
    unknowns_bias: Vector
    made: MeasuredRun
    again: RunFit


def corrected(
    design: DesignPoint, fit: RunFit, run: MeasuredRun, model: Model, known: Sequence[Known], simulate: Simulator
) -> Corrected:
    """One correction step of a run's fit. Raises StepFailed where the simulator or the model does not walk."""
    there = design.with_values(
        dict(zip((*model.shared, *model.own), (*fit.design, *fit.own), strict=True)))
    made = simulate(there, fit.unknowns, run)
    read = {name: (there.value(name), sd) for name, (_, sd) in run.own.items()}  # its ramp and its weight are known to
    weighed = [replace(one, value=one.of(there)) for one in known]  # be what they are, as well as the robot's were
    again = fit_near(there, fit.unknowns, replace(made, own=read), model, weighed)
    bias, own_bias = again.design - fit.design, again.own - fit.own
    unknowns_bias = again.unknowns - fit.unknowns
    return Corrected(fit.design - bias, fit.own - own_bias, fit.unknowns - unknowns_bias, np.asarray(bias),
                     np.asarray(own_bias), np.asarray(unknowns_bias), made, again)
