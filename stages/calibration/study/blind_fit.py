"""The study's robots fitted blind: from what the databases hold, the drawing and the scale, and from nothing else."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial

import numpy as np

from stages.analytic.errors import StepFailed
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.model.walker import Vector
from stages.biped.processes import each_in_a_process
from stages.calibration.estimation.campaign import covariance_of
from stages.calibration.estimation.equations import Equations, Model, eliminated
from stages.calibration.estimation.fit import RunFit, design_sizes, fit_run
from stages.calibration.estimation.foretold import explained
from stages.calibration.estimation.known import Known, information_of
from stages.calibration.information.plan import SLOPE
from stages.calibration.intervals.residual_structure import widening
from stages.calibration.observation.measured_run import MeasuredRun
from stages.calibration.observation.unknowns import SIDES
from stages.calibration.result import Failed, FittedRun, HeldOut, Misses, Trace
from stages.calibration.study.drawing import Recorded


def fitted_run(design: DesignPoint, one: Recorded, model: Model) -> FittedRun | Failed:
    """A run's own fit, without a look at any truth."""
    try:
        fit = fit_run(design, one.run, model, one.known)
    except StepFailed as reason:
        return Failed(one.run.name, one.kind, str(reason))
    sigmas, wider = widening([fit.equations])
    seen = information(fit.equations, one.known, model)
    covariance = wider**2 * covariance_of(seen, design_sizes(design, model.shared))
    return FittedRun(
        name=one.run.name, kind=one.kind, design=fit.design, own=fit.own, unknowns=fit.unknowns, covariance=covariance,
        truth=np.full(len(fit.design), math.nan), sigmas=sigmas, wider=wider, walks=fit.evaluations,
        converged=fit.converged, why=fit.why, hip=trace(one.run, fit.equations, model, "hip"),
        foot=trace(one.run, fit.equations, model, "foot"), strikes=one.run.strikes,
    )  # fmt: skip


def side_by_side(runs: Sequence[Recorded], design: DesignPoint, model: Model) -> list[FittedRun]:
    """Those of the runs' own fits that came to rest, in their order, each made in a process of its own."""
    done = dict(each_in_a_process(partial(fitted_run, design, model=model), runs))
    return [fit for _, fit in sorted(done.items()) if isinstance(fit, FittedRun) and fit.converged]


def misses_of(fits: Sequence[FittedRun], design: DesignPoint, model: Model) -> Misses:
    """By how much fits miss the truth that stands beside them, in shares of a design's values."""
    drawn = np.array([design.value(name) for name in model.shared])
    shares = [(fit.design - fit.truth) / drawn for fit in fits]
    pulls = [model.layout.pull(fit.unknowns) for fit in fits]
    return Misses(tuple(fit.name for fit in fits), np.array(shares).reshape(-1, len(drawn)), np.array(pulls))


def information(equations: Equations, known: Sequence[Known], model: Model) -> np.ndarray:
    """What a run and what is known beside it tell of the shared parameters, (d, d)."""
    return np.asarray(eliminated(equations, len(model.shared))[0] + information_of(known, model.shared))


def trace(run: MeasuredRun, equations: Equations, model: Model, side: str) -> Trace:
    """What a sensor showed and what the fit says it should have."""
    residual = equations.residuals[side] * np.asarray(model.noise)
    return Trace(getattr(run.sampling, side), run.samples[side], equations.predicted.samples[side], residual)


def held_out(
    design: DesignPoint, fits: Sequence[FittedRun], one: Recorded, model: Model, begun: float
) -> HeldOut | Failed:
    """How well the robot of other runs' fits explains a run, and foretells it from its beginning."""
    robot = design.with_values({
        **dict(zip(model.shared, mean_of([fit.design for fit in fits]), strict=True)),
        **{name: float(value) for name, value in zip(model.own, mean_of([fit.own for fit in fits]), strict=True)
           if name != SLOPE},
    })  # fmt: skip
    try:
        tell = explained(robot, one.run, model, begun)
    except StepFailed as reason:
        return Failed(one.run.name, one.kind, str(reason))
    hip, foot = (trace(one.run, tell.ahead or tell.own.equations, model, side) for side in SIDES)
    return HeldOut(one.run.name, one.kind, begun, tell.sigmas, *tell.fit, *tell.foretold, model.noise[0],
                   model.noise[2], tell.own.own, tell.own.unknowns, hip, foot, one.run.strikes)


def mean_of(rows: Sequence[Vector]) -> Vector:
    """Mean of vectors."""
    return np.asarray(np.mean(rows, axis=0))


def as_fit(fitted: FittedRun, equations: Equations) -> RunFit:
    """A stored fit with its equations, as a correction takes it."""
    return RunFit(fitted.design, fitted.own, fitted.unknowns, equations, fitted.walks, fitted.converged, fitted.why)
