"""A robot calibrated from the sensors on its leg, as text and JSON."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from stages.analytic.errors import StepFailed
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.model.walker import Vector
from stages.biped.question import Answer, Asking, WrongOption
from stages.calibration.errors import NotIdentified
from stages.calibration.estimation import each_run
from stages.calibration.estimation.asked import PARTS, Asked, unit_of
from stages.calibration.estimation.campaign import CampaignFit, fit_campaign
from stages.calibration.estimation.equations import Model
from stages.calibration.estimation.first_guess import guessed_mid_stance
from stages.calibration.estimation.foretold import Explained, explained
from stages.calibration.estimation.known import TOTAL_MASS, Known
from stages.calibration.information.identifiability import scales_of
from stages.calibration.information.plan import SLOPE, first_model, free_names
from stages.calibration.information.words import described, listed, short
from stages.calibration.intervals import left_out
from stages.calibration.intervals.discrepancy import Discrepancy
from stages.calibration.intervals.residual_structure import told_structure, widening
from stages.calibration.observation.measured_run import MeasuredRun
from stages.calibration.observation.unknowns import SIDES
from stages.calibration.parameters import Parameters
from stages.calibration.recordings.from_ingest import run_of
from stages.calibration.result import HALF_WIDTH, Result
from stages.calibration.study.blind_fit import trace
from stages.calibration.study.drawing import as_mounted, drawn_design, looked_for

#: Drawings whose numbers differ by less are the same.
SAME = 1e-6
ALONE = "intervals hold noise and residuals alone, and not what the model puts wrong in every step"


@dataclass(frozen=True)
class Judged:
    """A design (d,) with standard deviations (d,), as wide as Gaussian ones of the same 95 % intervals; what to say of
    them, and by how many runs they are told what the model puts wrong (0: they are not)."""

    values: Vector
    sd: Vector
    words: str
    other_runs: int = 0


def judged(
    names: Sequence[str], values: Vector, sd: Vector, known: Sequence[Known], design: DesignPoint,
    pull: float, told: tuple[Any, str],
) -> Judged:
    """What was found (d,) with noise `sd` (d,), less what fits of the study's runs miss on average and widened by
    their scatter, where the study has made fits of this kind; else as it is, and why.

    `pull`: by how much the fit moved clocks. `told` is the study's own calibration and its file, or none and why.
    """
    study, source = told
    why = source if study is None else unfit(names, known, design, study, source)
    if why:
        return Judged(values, sd, f"{ALONE}: {why}")
    term = Discrepancy.of(study.names, study.misses.shares, study.misses.pulls)
    order = [study.names.index(name) for name in names]
    off = term.expected(study.drawn, pull)[order]
    wide = np.sqrt(np.diag(term.spread(study.drawn, pull))[order])
    first, last = study.misses.runs[0], study.misses.runs[-1]
    largest = int(np.argmax(np.abs(off / values)))
    return Judged(
        values - off, np.hypot(sd, wide),
        f"intervals hold what the model puts wrong, by fits of {term.count} runs of other machines made by the Exudyn "
        f"twin ({source}, {first} to {last}): what they miss where clocks are pulled as far is taken off "
        f"({short(names[largest])} by {-100 * off[largest] / values[largest]:+.2f} %), their scatter is in the "
        "intervals. That holds for a robot as near to its drawing as those machines, on ground like the twin's",
        term.count)


def unfit(
    names: Sequence[str], known: Sequence[Known], design: DesignPoint, study: Result, source: str
) -> str:
    """Why a study's fits do not tell what these miss; nothing where they do."""
    if Discrepancy.told(study.names, study.misses) is None:
        return (f"{source} has {len(study.misses.runs) or 'no'} fits of other machines' runs, which is too few "
                "(calibration.discrepancy_runs)")
    if set(names) != set(study.names):
        return (f"{source} tells it of fits that look for {listed([short(name) for name in study.names])}; the bill of "
                "parts begins such a fit (design: parts)")
    if {one.name for one in known} != {TOTAL_MASS}:
        return f"{source} tells it of robots of which the mass is known and nothing else"
    other = [short(name) for name, drawn in zip(study.names, study.drawn, strict=True)
             if abs(design.value(name) - drawn) > SAME * abs(drawn)]
    return f"{source} is of a robot with another {listed(other)}" if other else ""


#: What is known of the sensors is said to be wrong beyond so many of its standard errors.
FAR_OFF = 3.0
#: A bandwidth that differs by this share is another one than a data sheet's.
OTHER_CUT = 0.15
#: Residuals this many times the sensors' noise are the model's.
NOISY = 1.2
#: What a parameter folder of another robot says of the twin: the bill of parts is that of this one.
PLANAR = {"twin.inertia": "planar"}
FRAME = "biped.frame_mass"
#: Parameters that a model without frames gets wrong, however well it fits.
OF_SPRINGS = ("hip_mass", "foot_mass", "stiffness", "damping", "leg_inertia")


def calibrated(parameters: Parameters, asked: Asked, source: Path, asking: Asking) -> Answer:
    """Fit the runs of a lab's database and see how well they explain those held out.

    Raises WrongOption, NoGait, NotIdentified.
    """
    if asked.design == PARTS:
        parameters = as_mounted(parameters)
        design = drawn_design(parameters)
        there: tuple[str, ...] = looked_for(design)
    else:
        design = each_run.guess(parameters)
        there = (*free_names(design), *(["biped.other_leg_length"] if design.biped.detailed else []))
    names = tuple(dict.fromkeys(asked.looked_for(there)))
    asked.check(names, design)
    model = first_model(design, names, parameters)
    runs, refused = _runs(source, design, model, parameters, asking)
    for name in (*asked.held_out, *asked.fitted):
        if name not in {run.name for run in runs}:
            usable = ", ".join(run.name for run in runs)
            raise WrongOption(f"{name}: no run of that name can be used; there are {usable}")
    for one in set(asked.held_out) & set(asked.fitted):
        raise WrongOption(f"{one}: cannot be both fitted and held out")
    out = [run for run in runs if run.name in asked.held_out]
    fitted = [run for run in runs if run not in out and (not asked.fitted or run.name in asked.fitted)]
    if not out and not asked.fitted and len(fitted) > 3:
        fitted, out = fitted[::2], fitted[1::2]
    if not fitted:
        raise NotIdentified("every run is held out: none is left to fit")
    known = [[one.name, one.value, one.sd, one.source] for one in asked.known]
    answers = dict(asking.each(each_run.fitted, [each_run.as_plain(run) for run in fitted],
                               dataclasses.asdict(design.biped), list(names), known, parameters.settings.lever_arm_sd))
    asking.progress(0.9, "all runs together")
    try:
        fit = fit_campaign(design, fitted, model, asked.known, lambda all_runs: (
            (number, each_run.fit_of(answers[number], run, design, model)) for number, run in enumerate(all_runs)))
    except StepFailed as reason:
        raise NotIdentified(f"the runs cannot be fitted: {reason}") from None
    others = {name: float(np.mean(fit.own[:, place])) for place, name in enumerate(model.own) if name != SLOPE}
    found = design.with_values(dict(zip(model.shared, fit.design, strict=True)) | others)
    held = [_explained(found, run, model, parameters.settings.begun_s) for run in out]
    sigmas, wider = widening(fit.equations)
    told = judged(fit.names, fit.design, np.sqrt(np.diag(fit.covariance)) * wider, asked.known, design,
                  float(np.mean([model.layout.pull(one) for one in fit.unknowns])), asking.result())
    causes = left_out.causes(design, fit, model, asked.known)
    told = dataclasses.replace(told, sd=left_out.widened(told.sd, causes))
    left = _left(fit.names, told.values, told.sd)
    if asked.design == PARTS:
        left = _as_table_1(left, design)
    elif not design.biped.frame_mass:
        left |= PLANAR
    return _answer(design, fit, model, refused, held, out, (sigmas, wider), told, causes, left)


def _runs(
    source: Path, design: DesignPoint, model: Model, parameters: Parameters, asking: Asking
) -> tuple[list[MeasuredRun], list[str]]:
    """The runs of a database, and why others cannot be used. Raises WrongOption."""
    from stages.imu.errors import SourceRefused
    from stages.imu.run import trials
    from stages.imu.sources.source_sqlite import SqliteSource

    mid_stance_of = guessed_mid_stance(design, model.layout)
    runs, refused = [], []
    try:
        with SqliteSource(source) as opened:
            for trial in trials(opened.runs(), parameters.ingest.read, asking.progress):
                run = run_of(trial, mid_stance_of, parameters.settings, parameters.ingest.read.limits.lever_arm)
                if isinstance(run, str):
                    refused.append(run)
                else:
                    runs.append(run)
    except SourceRefused as reason:
        raise WrongOption(str(reason)) from None
    if not runs:
        raise NotIdentified(f"no run can be used: {'; '.join(refused[:3]) or 'there is none'}")
    return runs, refused


def _explained(design: DesignPoint, run: MeasuredRun, model: Model, begun: float) -> Explained | None:
    """How well the robot explains and foretells a run held out; None where it does not walk it."""
    try:
        return explained(design, run, model, begun)
    except StepFailed:
        return None


def _answer(
    design: DesignPoint, fit: CampaignFit, model: Model, refused: Sequence[str], held: Sequence[Explained | None],
    out: Sequence[MeasuredRun], widened: tuple[float, float], told: Judged, causes: Sequence[left_out.Cause],
    left: dict[str, Any],
) -> Answer:
    """The answer; `widened` the residuals' size in noises and the factor on intervals, `told` values with intervals,
    `left` what a folder of parameters keeps."""
    (sigmas, wider), values, sd = widened, told.values, told.sd
    units = [unit_of(name) for name in fit.names]
    lines = [f"{len(fit.runs)} runs fitted, residuals {sigmas:.2f} times the sensors' noise"
             + ("" if fit.converged else f"; not at rest, so there are no intervals: {fit.why}")]
    lines += [f"left out: {name}: {why}" for name, why in fit.left_out.items()] + list(refused)
    blind = np.flatnonzero(np.isinf(sd))
    if len(blind):
        share = np.zeros(len(fit.names))
        share[blind] = 1.0
        lines.append(described(share, fit.names, units, values))
    if wider > NOISY:
        lines.append(f"residuals are not noise alone (size {sigmas:.2f}, and neighbours hang together): intervals are "
                     f"{wider:.1f} times as wide as noise would have them")
    lines += told_structure(fit.runs, fit.equations)
    lines += [*_of_sensors(fit, model), *left_out.in_words(causes, design)]
    lines.append(told.words)
    if not design.biped.frame_mass:
        springs = [short(name) for name in fit.names if short(name) in OF_SPRINGS]
        if springs:
            lines.append(f"the model has no frames above the springs: where the robot has, {listed(springs)} come out "
                         "wrong by several percent though the fit is good, and their intervals do not hold that. Give "
                         "frame_mass, frame_com and frame_inertia in biped.yaml")
    if held:
        known = [one.sigmas for one in held if one is not None]
        fell = f"; {len(held) - len(known)} could not be walked" if len(known) < len(held) else ""
        lines.append(f"{len(out)} runs held out: residuals {np.median(known):.2f} times the noise (median), their own "
                     f"start and sensors fitted{fell}" if known else "no run held out could be walked")
    scales = scales_of(design, fit.names)
    rows: list[list[Any]] = []
    for row, name in enumerate(fit.names if fit.converged else ()):
        half = HALF_WIDTH * sd[row]
        rows.append([short(name), f"{design.value(name):.6g}", f"{values[row]:.6g}",
                     f"+- {half:.2g}" if math.isfinite(half) else "not seen",
                     f"{100 * (values[row] - design.value(name)) / scales[row]:+.2f} %", units[row]])
    slopes = fit.own[:, 0]
    lines.append(f"ramp: {slopes.mean():.3f} deg on average, {slopes.std():.3f} deg apart")
    for place, name in enumerate(model.own[1:], 1):
        lines.append(f"{short(name)}, for each run: {fit.own[:, place].mean():.6g} on average, "
                     f"{fit.own[:, place].std():.2g} {design.unit(name)} apart")
    return Answer(
        lines=lines,
        tables=[*([("The robot, 95 % intervals", ["parameter", "drawn", "found", "interval", "change", "unit"], rows)]
                  if rows else []), *_tables(held, out, model)],
        plain={
            "parameters": {name: {"drawn": design.value(name), "found": float(values[row]),
                                  "sd": float(sd[row]) if math.isfinite(sd[row]) and fit.converged else None,
                                  "unit": units[row]}
                           for row, name in enumerate(fit.names)},
            "runs": [run.name for run in fit.runs], "left_out": fit.left_out, "refused": list(refused),
            "model_error": told.words, "model_error_runs": told.other_runs,
            "left_out_causes": {one.name: {"found": one.value, "sd": one.sd, "standard_errors": one.sigmas,
                                           "explains": one.explains} for one in causes},
            "residuals_in_sigmas": sigmas, "intervals_widened": wider, "converged": fit.converged, "why": fit.why,
            "slopes_deg": slopes.tolist(), "walks": fit.evaluations,
            "held_out": {run.name: _plain(one) for run, one in zip(out, held, strict=True)},
        },
        draw=lambda save: _draw(fit, model, save),
        parameters=left if fit.converged else {},
        no=not fit.converged,
    )  # fmt: skip


def _of_sensors(fit: CampaignFit, model: Model) -> list[str]:
    """What the runs say of the sensors against what was told of them."""
    said = []
    places = [model.layout.place(name) for name in ("bandwidth", "foot_place")]
    share, higher = fit.unknowns[:, places].mean(axis=0)
    of_place = model.layout.believed[places[1]]
    drawn = float(np.mean([run.sampling.bandwidth_hz for run in fit.runs]))
    cut = f"{drawn * math.exp(share):.1f} Hz"
    if not all(run.sampling.declared for run in fit.runs):
        said.append(f"the sensors' bandwidth is not declared: the fit takes a second-order low pass of {cut}, which "
                    "may be wrong where the model is. Give it (bandwidth_hz of the devices)")
    elif abs(share) > OTHER_CUT:
        said.append(f"bandwidth: the sensors' low pass cuts off at {cut}, where {drawn:.1f} Hz is declared")
    if abs(higher) > FAR_OFF * of_place:
        said.append(f"lever arm: the foot sensor sits {1e3 * higher:+.1f} mm higher on the leg than imu.lever_arm "
                    "has it; measure it")
    return said


def _left(names: Sequence[str], values: np.ndarray, sd: np.ndarray) -> dict[str, Any]:
    """Parameters as a folder keeps them: with their standard errors, where these are finite."""
    return {name: {"value": float(value), **({"uncertainty": float(own)} if math.isfinite(own) else {})}
            for name, value, own in zip(names, values, sd, strict=True)}


def _as_table_1(left: dict[str, Any], design: DesignPoint) -> dict[str, Any]:
    """The same of a robot from the bill of parts as Table 1 counts it, which all stages take: frames are the hip's."""
    frame = left.pop(FRAME, {"value": design.biped.frame_mass})
    hip = {"value": design.biped.hip_mass + 2.0 * frame["value"]}
    hip |= {"uncertainty": 2.0 * frame["uncertainty"]} if "uncertainty" in frame else {}
    return {"biped.leg_inertia": design.biped.leg_inertia, "biped.hip_mass": hip, **left, **PLANAR}


def _tables(
    held: Sequence[Explained | None], out: Sequence[MeasuredRun], model: Model
) -> list[tuple[str, list[str], list[list[Any]]]]:
    """Errors on runs that were held out."""
    rows: list[list[Any]] = [
        [run.name, f"{one.fit[0]:.3f}", f"{1e3 * one.fit[1]:.2f}", f"{one.foretold[0]:.3f}",
         f"{1e3 * one.foretold[1]:.2f}"]
        for run, one in zip(out, held, strict=True) if one is not None
    ]
    if not rows:
        return []
    begun = next(one.begun for one in held if one is not None)
    title = (f"Errors on runs held out, rms: start and sensors fitted, and foretold from the first {begun:g} s; noise "
             f"is {model.noise[0]:.3f} m/s^2 and {1e3 * model.noise[2]:.2f} mrad/s")
    return [(title, ["run", "fit, m/s^2", "fit, mrad/s", "foretold, m/s^2", "foretold, mrad/s"], rows)]


def _plain(one: Explained | None) -> dict[str, Any] | None:
    """Errors as JSON knows them; none where the robot does not walk the run."""
    if one is None:
        return None

    def pair(values: tuple[float, float]) -> dict[str, float | None]:
        force, rate = (value if math.isfinite(value) else None for value in values)
        return {"force_m_s2": force, "rate_rad_s": rate}

    return {"sigmas": one.sigmas, "fit": pair(one.fit), "foretold": pair(one.foretold), "begun_s": one.begun}


def _draw(fit: CampaignFit, model: Model, save: Any) -> None:
    """The first run's samples, fit and residuals."""
    from stages.calibration.reports.sensor_picture import fit_picture
    from stages.drawing import style

    run, equations = fit.runs[0], fit.equations[0]
    with style.drawing():
        save(fit_picture({side: trace(run, equations, model, side) for side in SIDES}, run.strikes))
