"""A robot calibrated from the sensors on its leg, as text and JSON."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from stages.analytic.errors import StepFailed
from stages.analytic.gait.design_point import DesignPoint
from stages.biped.question import Answer, Asking, WrongOption
from stages.calibration.errors import NotIdentified
from stages.calibration.estimation import each_run
from stages.calibration.estimation.asked import Asked, unit_of
from stages.calibration.estimation.campaign import CampaignFit, fit_campaign
from stages.calibration.estimation.equations import Model
from stages.calibration.estimation.first_guess import guessed_mid_stance
from stages.calibration.estimation.fit import fit_run
from stages.calibration.estimation.widening import widening
from stages.calibration.information.identifiability import HALF_WIDTH, scales_of
from stages.calibration.information.plan import first_model, free_names
from stages.calibration.information.words import described, listed, short
from stages.calibration.observation.measured_run import MeasuredRun
from stages.calibration.parameters import Parameters
from stages.calibration.recordings.from_ingest import run_of

#: Residuals this many times the sensors' noise are the model's.
NOISY = 1.2
#: Parameters that a model without frames gets wrong, however well it fits.
OF_SPRINGS = ("hip_mass", "foot_mass", "stiffness", "damping", "leg_inertia")


def calibrated(parameters: Parameters, asked: Asked, source: Path, asking: Asking) -> Answer:
    """Fit the runs of a lab's database and see how well they explain those held out.

    Raises WrongOption, NoGait, NotIdentified.
    """
    design = each_run.guess(parameters)
    names = asked.looked_for((*free_names(design), *(["biped.other_leg_length"] if design.biped.detailed else [])))
    names = tuple(dict.fromkeys(names))
    model = first_model(design, names, parameters)
    runs, refused = _runs(source, model, parameters, asking)
    for name in (*asked.held_out, *asked.fitted):
        if name not in {run.name for run in runs}:
            there = ", ".join(run.name for run in runs)
            raise WrongOption(f"{name}: no run of that name can be used; there are {there}")
    out = [run for run in runs if run.name in asked.held_out]
    fitted = [run for run in runs if run not in out and (not asked.fitted or run.name in asked.fitted)]
    if not out and not asked.fitted and len(fitted) > 3:
        fitted, out = fitted[::2], fitted[1::2]
    if not fitted:
        raise NotIdentified("every run is held out: none is left to fit")
    known = [[one.name, one.value, one.sd, one.source] for one in asked.known]
    answers = dict(asking.each(each_run.fitted, [each_run.as_plain(run) for run in fitted], list(names), known))
    asking.progress(0.9, "all runs together")
    try:
        fit = fit_campaign(design, fitted, model, asked.known, lambda all_runs: (
            (number, each_run.fit_of(answers[number], run, design, model)) for number, run in enumerate(all_runs)))
    except StepFailed as reason:
        raise NotIdentified(f"no run can be fitted: {reason}") from None
    found = design.with_values(dict(zip(model.shared, fit.design, strict=True)))
    held = [_explained(found, run, model) for run in out]
    return _answer(design, fit, model, refused, held, out)


def _runs(
    source: Path, model: Model, parameters: Parameters, asking: Asking
) -> tuple[list[MeasuredRun], list[str]]:
    """The runs of a database, and why others cannot be used. Raises WrongOption."""
    from stages.imu.errors import SourceRefused
    from stages.imu.run import trials
    from stages.imu.sources.source_sqlite import SqliteSource

    mid_stance_of = guessed_mid_stance(each_run.guess(parameters), model.layout)
    runs, refused = [], []
    try:
        with SqliteSource(source) as opened:
            for trial in trials(opened.runs(), parameters.ingest, asking.progress):
                run = run_of(trial, mid_stance_of, parameters.settings, parameters.limits.lever_arm)
                if isinstance(run, str):
                    refused.append(run)
                else:
                    runs.append(run)
    except SourceRefused as reason:
        raise WrongOption(str(reason)) from None
    if not runs:
        raise NotIdentified(f"no run can be used: {'; '.join(refused[:3]) or 'there is none'}")
    return runs, refused


def _explained(design: DesignPoint, run: MeasuredRun, model: Model) -> float:
    """Root mean square of a held-out run's residuals in sigmas, its start and sensors fitted; NaN where it falls."""
    try:
        fit = fit_run(design, run, replace(model, shared=()), ())
    except StepFailed:
        return math.nan
    return math.sqrt(fit.equations.chi2 / fit.equations.count)


def _answer(
    design: DesignPoint, fit: CampaignFit, model: Model, refused: Sequence[str], held: Sequence[float],
    out: Sequence[MeasuredRun],
) -> Answer:
    sigmas, wider = widening(fit.equations)
    units = [unit_of(name) for name in fit.names]
    sd = np.sqrt(np.diag(fit.covariance)) * wider
    lines = [f"{len(fit.runs)} runs fitted, residuals {sigmas:.2f} times the sensors' noise"
             + ("" if fit.converged else f"; not at rest: {fit.why}")]
    lines += [f"left out: {name}: {why}" for name, why in fit.left_out.items()] + list(refused)
    blind = np.flatnonzero(np.isinf(sd))
    if len(blind):
        share = np.zeros(len(fit.names))
        share[blind] = 1.0
        lines.append(described(share, fit.names, units, fit.design))
    if wider > NOISY:
        lines.append(f"residuals are not noise alone (size {sigmas:.2f}, and neighbours hang together): intervals are "
                     f"{wider:.1f} times as wide as noise would have them")
    if not design.biped.frame_mass:
        springs = [short(name) for name in fit.names if short(name) in OF_SPRINGS]
        if springs:
            lines.append(f"the model has no frames above the springs: where the robot has, {listed(springs)} come out "
                         "wrong by several percent though the fit is good, and their intervals do not hold that. Give "
                         "frame_mass, frame_com and frame_inertia in biped.yaml")
    if held:
        known = [one for one in held if math.isfinite(one)]
        fell = f"; {len(held) - len(known)} could not be walked" if len(known) < len(held) else ""
        lines.append(f"{len(out)} runs held out: residuals {np.median(known):.2f} times the noise (median), their own "
                     f"start and sensors fitted{fell}" if known else "no run held out could be walked")
    scales = scales_of(design, fit.names)
    rows: list[list[Any]] = []
    for row, name in enumerate(fit.names):
        half = HALF_WIDTH * sd[row]
        rows.append([short(name), f"{design.value(name):.6g}", f"{fit.design[row]:.6g}",
                     f"+- {half:.2g}" if math.isfinite(half) else "not seen",
                     f"{100 * (fit.design[row] - design.value(name)) / scales[row]:+.2f} %", units[row]])
    slopes = fit.own[:, 0]
    lines.append(f"ramp: {slopes.mean():.3f} deg on average, {slopes.std():.3f} deg apart")
    for place, name in enumerate(model.own[1:], 1):
        lines.append(f"{short(name)}, for each run: {fit.own[:, place].mean():.6g} on average, "
                     f"{fit.own[:, place].std():.2g} {design.unit(name)} apart")
    return Answer(
        lines=lines,
        tables=[("The robot, 95 % intervals", ["parameter", "drawn", "found", "interval", "change", "unit"], rows)],
        plain={
            "parameters": {name: {"drawn": design.value(name), "found": float(fit.design[row]),
                                  "sd": float(sd[row]) if math.isfinite(sd[row]) else None, "unit": units[row]}
                           for row, name in enumerate(fit.names)},
            "runs": [run.name for run in fit.runs], "left_out": fit.left_out, "refused": list(refused),
            "residuals_in_sigmas": sigmas, "intervals_widened": wider, "converged": fit.converged, "why": fit.why,
            "slopes_deg": slopes.tolist(), "walks": fit.evaluations,
            "held_out": {run.name: (one if math.isfinite(one) else None) for run, one in zip(out, held, strict=True)},
        },
        parameters={name: float(value) for name, value in zip(fit.names, fit.design, strict=True)},
    )  # fmt: skip
