"""A robot calibrated from the sensors on its leg, as text, JSON and a picture."""

import contextlib
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from stages.analytic.derivatives.numbers import changes_of
from stages.analytic.errors import StepFailed
from stages.analytic.gait.design_point import DesignPoint
from stages.biped.quantity import count_of
from stages.biped.question import Answer, Asking, refuse
from stages.calibration.estimation.campaign import ODD, CampaignFit, fit_campaign, two_kinds
from stages.calibration.estimation.held_out import explained, trace
from stages.calibration.estimation.least_squares import Known, NotIdentified, covariance_of, information_of
from stages.calibration.estimation.request import DECLARED, PARTS, Request
from stages.calibration.estimation.run_fit import Model, RunFit, design_sizes
from stages.calibration.following.change import Comparison
from stages.calibration.following.fitted import earlier_fits, earlier_runs, fit_of, fitted_alone, fitted_robot
from stages.calibration.following.robot_file import NAME, FittedRobot, plain_of
from stages.calibration.following.score_test import LEVEL
from stages.calibration.following.track import with_forecasts
from stages.calibration.information.identifiability import (
    KNOWN_EVERYWHERE,
    SLOPE,
    described,
    first_model,
    free_names,
    listed,
    short,
)
from stages.calibration.intervals.left_out import FRICTION, OTHER, Cause, causes, in_words, widened, with_all
from stages.calibration.intervals.model_error import Judged, judged, structure_in_words, widening
from stages.calibration.observation.measured_run import SIDES, MeasuredRun
from stages.calibration.parameters import Parameters
from stages.calibration.recordings import drawn_design, guess, looked_for, none_of, read_runs
from stages.calibration.reports import change_report
from stages.calibration.reports.parameters_left import OTHER_LENGTH, parameters_left
from stages.calibration.result import HALF_WIDTH, HeldOut

#: What is known of the sensors is said to be wrong beyond so many of its standard errors.
FAR_OFF = 3.0
#: A bandwidth that differs by this share is another one than a data sheet's.
OTHER_CUT = 0.15
#: Residuals this many times the sensors' noise are the model's.
NOISY = 1.2
#: So many runs show two robots, two runs of each.
FEWEST_OF_TWO = 4
#: Parameters that a model without frames gets wrong, however well it fits.
OF_SPRINGS = ("hip_mass", "foot_mass", "stiffness", "damping", "leg_inertia")


@dataclass(frozen=True)
class Calibrated:
    """What came out, from a `design` by the `parameters`: the fit and why runs are left out of it, how well the robot
    explains those held out (None where it does not walk them), residuals in noises and the factor on intervals, values
    with intervals, what the model leaves out, whether the bill of parts was begun with, what was `known`, the robot
    `before` and which runs are another's, whether runs are of two `kinds`, and runs not fitted that show, too, how
    runs differ."""

    design: DesignPoint
    model: Model
    fit: CampaignFit
    estimate: Judged
    parameters: Parameters
    sigmas: float = 1.0
    wider: float = 1.0
    refused: Sequence[str] = ()
    held_out: dict[str, HeldOut | None] = field(default_factory=dict)
    causes: Sequence[Cause] = ()
    of_parts: bool = False
    known: tuple[Known, ...] = ()
    before: FittedRobot | None = None
    changed: Sequence[str] = ()
    kinds: Sequence[str] = ()
    others: Sequence[MeasuredRun] = ()


def calibrated(
    parameters: Parameters, request: Request, source: Path, asking: Asking, before: FittedRobot | None = None
) -> Answer:
    """Fit the runs of a lab's database, from a robot where it was fitted `before`, and see how well they explain those
    held out.

    Raises WrongOption, NoGait, NotIdentified.
    """
    of_parts = request.design == PARTS if before is None else before.of_parts
    if before is None:
        design, names, all_known = _looked_for(parameters, request)
    else:
        design, names, all_known = before.began, (*before.names, *before.own), before.known
        parameters = before.read_by(parameters)
    model = first_model(design, names, parameters)
    had = before.learned if before else ()
    runs, refused = _runs(source, design, model, parameters, asking, [plain_of(one.run) for one in had])
    fitted, out = _split(runs, request, 3 if before is None else len(runs))
    near, given = (before.uncorrected, earlier_runs(before)) if before else (design, ())
    changed = _changed(before, fitted, parameters) if before else []
    answers = list(asking.each(
        fitted_alone, [*map(plain_of, fitted)], plain_of(near.biped), list(names),
        [*map(plain_of, (*all_known, *given))], parameters.settings.lever_arm_sd, before is not None))
    asking.progress(0.9, "all runs together")
    try:
        fits = [*(earlier_fits(before, model) if before else ()),
                *(fit_of(answer, run, design, model) for answer, run in zip(answers, fitted, strict=True))]
        fit = fit_campaign(design, [*(one.run for one in had), *fitted], model, all_known, enumerate(fits))
    except StepFailed as reason:
        raise NotIdentified(f"the runs cannot be fitted: {reason}") from None
    found = model.robot(design, fit.design, fit.own.mean(axis=0)).with_value(SLOPE, design.value(SLOPE))
    held = {run.name: _explained(found, run, model, parameters.settings.begun_s) for run in out}
    sigmas, wider = widening(fit.equations)
    estimate = judged(fit.names, fit.design, np.sqrt(np.diag(fit.covariance)) * wider, all_known, design,
                      parameters.settings.lever_arm_sd,
                      float(np.mean([model.layout.pull(one) for one in fit.unknowns])), asking.result())
    others = causes(design, fit, model, all_known, asking.progress)
    estimate = replace(estimate, sd=widened(estimate.sd, others))
    return answered(Calibrated(
        design, model, fit, estimate, parameters, sigmas, wider, refused, held, others, of_parts, all_known,
        before, changed, [] if before else _kinds(fitted, fits, design, model, all_known),
        [] if request.held_out else _alike(out, held)))


def _looked_for(parameters: Parameters, request: Request) -> tuple[DesignPoint, tuple[str, ...], tuple[Known, ...]]:
    """The design that a first fit begins with, the names of what it looks for, and what is known. Raises WrongOption.
    """
    of_parts = request.design == PARTS
    design = _with_more(drawn_design(parameters) if of_parts else guess(parameters), request)
    there = looked_for(design) if of_parts else (
        *free_names(design), *([OTHER_LENGTH] if design.biped.detailed else []))
    names = tuple(dict.fromkeys([*request.looked_for(there), *request.also]))
    request.check(names, design)
    return design, names, request.known


def _changed(before: FittedRobot, runs: Sequence[MeasuredRun], parameters: Parameters) -> list[str]:
    """Which of further runs are not of the robot `before`, as `same` tests it, and what has changed."""
    comparison = Comparison(before, before.fitted_by(parameters))
    lines = []
    for run in runs:
        with contextlib.suppress(StepFailed):  # which its own fit says, too
            verdict = comparison.verdict(comparison.held(run))
            if verdict.probability * len(runs) < LEVEL:
                lines.append(f"{run.name}: {change_report.sentence(verdict)}")
    return lines


def _kinds(
    runs: Sequence[MeasuredRun], fits: Sequence[RunFit | str], design: DesignPoint, model: Model,
    known: Sequence[Known],
) -> list[str]:  # fmt: skip
    """Whether the runs are of two robots, by the fit of each alone, in words."""
    d, sizes = len(model.shared), design_sizes(design, model.shared)
    rested = [(run.name, fit.design, np.diag(covariance_of(
        information_of(known, model.shared) + fit.equations.eliminated(d)[0], sizes)))
        for run, fit in zip(runs, fits, strict=True) if isinstance(fit, RunFit) and fit.converged]  # fmt: skip
    if len(rested) < FEWEST_OF_TWO:
        return []
    names, values, variances = map(np.array, zip(*rested, strict=True))
    found = two_kinds(values, variances)
    if found is None:
        return []
    place, kind = found
    few, others = sorted((kind, ~kind), key=np.sum)
    name, value, usual = model.shared[place], *(values[of, place].mean() for of in (few, others))
    these, those = (listed(names[of].tolist()) for of in (few, others))
    return [f"the runs come apart as of two robots, or sensors were moved: {these} have {short(name)} {value:.4g} "
            f"{design.unit(name)} each alone, {those} have {usual:.4g}"]


def _with_more(design: DesignPoint, request: Request) -> DesignPoint:
    """The design with one leg's own numbers and friction at the hip where the request looks for them. Raises
    WrongOption."""
    refuse(*((name not in (*OTHER, FRICTION), f"also: {short(name)} is not looked for; known are "
              f"{', '.join(map(short, (*OTHER, FRICTION)))}") for name in request.also),
           (bool(request.also) and design.biped.legs != "compliant", "also: only a robot with compliant legs has them"))
    return with_all(design, [name for name in request.also if name != FRICTION or not design.value(name)])


def _runs(
    source: Path, design: DesignPoint, model: Model, parameters: Parameters, asking: Asking, had: list[dict[str, Any]]
) -> tuple[list[MeasuredRun], list[str]]:
    """The runs of a database, and why others cannot be used; none of those that a robot `had`. Raises WrongOption,
    NotIdentified."""
    found = [f"{run.name}: the robot has learned from it" if isinstance(run, MeasuredRun) and plain_of(run) in had
             else run for run in read_runs(source, design, model, parameters, asking.progress, asking.reading)]
    runs = [run for run in found if isinstance(run, MeasuredRun)]
    refused = [run for run in found if isinstance(run, str)]
    if not runs:
        raise none_of("used", refused)
    return runs, refused


def _split(
    runs: Sequence[MeasuredRun], request: Request, few: int
) -> tuple[list[MeasuredRun], list[MeasuredRun]]:
    """Runs that are fitted, and those held out: every other one of more than a `few` where the file does not say.
    Raises WrongOption, NotIdentified."""
    names, both = [run.name for run in runs], set(request.held_out) & set(request.fitted)
    refuse(*((name not in names, f"--with: {key}: no run {name!r} can be used; there are {', '.join(names)}")
             for key in ("held_out", "fitted") for name in getattr(request, key)),
           *((True, f"--with: {one}: cannot be both fitted and held out") for one in both))  # fmt: skip
    out = [run for run in runs if run.name in request.held_out]
    fitted = [run for run in runs if run not in out and (not request.fitted or run.name in request.fitted)]
    if not out and not request.fitted and len(fitted) > few:
        fitted, out = fitted[::2], fitted[1::2]
    if not fitted:
        raise NotIdentified("every run is held out: none is left to fit")
    return fitted, out


def _explained(design: DesignPoint, run: MeasuredRun, model: Model, begun: float) -> HeldOut | None:
    """How well the robot explains and predicts a run held out; None where it does not walk it."""
    try:
        return explained(design, run, model, begun)
    except StepFailed:
        return None


def _alike(out: Sequence[MeasuredRun], held: dict[str, HeldOut | None]) -> list[MeasuredRun]:
    """Of runs held out those that the robot walks, with no more than the usual residuals."""
    sizes = {name: one.sigmas**2 for name, one in held.items() if one}
    return [run for run in out if run.name in sizes and sizes[run.name] <= ODD * np.median([*sizes.values()])]


def answered(result: Calibrated) -> Answer:
    """The answer to `calibrate`."""
    fit, estimate, design = result.fit, result.estimate, result.design
    units = [str(DECLARED[name]["unit"]) for name in fit.names]
    found = {name: {"drawn": design.value(name), "found": float(estimate.values[row]),
                    "sd": float(estimate.sd[row]) if fit.converged else None, "unit": units[row]}
             for row, name in enumerate(fit.names)}  # fmt: skip
    robot = _robot(result) if fit.converged else None
    return Answer(
        lines=_lines(result, units),
        tables=_tables(result, units),
        plain={
            "parameters": found,
            "runs": [run.name for run in fit.runs], "left_out": fit.left_out, "refused": list(result.refused),
            "changed": list(result.changed),
            "model_error": estimate.words, "model_error_runs": estimate.other_runs,
            "left_out_causes": {one.name: {"found": one.value, "sd": one.sd, "standard_errors": one.sigmas,
                                           "explains": one.explains} for one in result.causes},
            "residuals_in_sigmas": result.sigmas, "intervals_widened": result.wider, "converged": fit.converged,
            "why": fit.why, "slopes_deg": fit.own[:, 0].tolist(), "walks": fit.evaluations,
            "held_out": {name: _plain(one) for name, one in result.held_out.items()},
        },
        draw=partial(_draw, fit),
        files={NAME: robot.content()} if robot else {},
        parameters=parameters_left(result, robot) if robot else {},
        no=not fit.converged,
    )  # fmt: skip


def _robot(result: Calibrated) -> FittedRobot:
    """The robot as its file keeps it."""
    found = fitted_robot(result.design, result.model, result.fit, result.estimate, (result.sigmas, result.wider),
                         result.known, result.of_parts, result.others)  # fmt: skip
    return with_forecasts(found, result.model, result.parameters.settings, result.others)


def _lines(result: Calibrated, units: Sequence[str]) -> list[str]:
    """What is to be said beside the tables."""
    fit, estimate, design, model = result.fit, result.estimate, result.design, result.model
    before = f", after {result.before.runs} before" if result.before else ""
    lines = [f"{count_of(len(fit.runs), 'run')} fitted{before}, residuals {result.sigmas:.2f} times the sensors' noise"
             + ("" if fit.converged else f"; not at rest, so there are no intervals: {fit.why}")]
    lines += [f"left out: {name}: {why}" for name, why in fit.left_out.items()] + list(result.refused)
    lines += [*result.changed, *result.kinds]
    if fit.chi2 > ODD * fit.alone * fit.count:
        lines.append(f"all together leave {math.sqrt(fit.chi2 / fit.count / fit.alone):.1f} times the residuals that "
                     "runs leave alone: they are not of one robot, or sensors were moved")
    blind = np.isinf(estimate.sd).astype(float)
    if blind.any():
        lines.append(described(blind, fit.names, units, estimate.values))
    if result.wider > NOISY:
        lines.append(f"residuals are not noise alone (size {result.sigmas:.2f}, and neighbours hang together): "
                     f"intervals are {result.wider:.1f} times as wide as noise would have them")
    lines += [*structure_in_words(fit.runs, fit.equations), *_of_sensors(fit, model), *in_words(result.causes, design),
              estimate.words, *_contradicted(result.known, fit, design), *_beyond_intervals(fit, design)]  # fmt: skip
    known = [one.sigmas for one in result.held_out.values() if one is not None]
    if result.held_out and not known:
        lines.append("no run held out could be walked")
    elif known:
        fell = len(result.held_out) - len(known)
        lines.append(f"{count_of(len(result.held_out), 'run')} held out: residuals {np.median(known):.2f} times the "
                     "noise (median), their own start and sensors fitted"
                     + (f"; {fell} could not be walked" if fell else ""))
    slopes, several = fit.own[:, 0], len(fit.runs) > 1
    lines.append(f"ramp: {slopes.mean():.3f} deg" + f" on average, {slopes.std():.3f} deg apart" * several)
    return lines + [
        f"{short(name)}, for each run: {fit.own[:, place].mean():.6g} {design.unit(name)}"
        + f" on average, {fit.own[:, place].std():.2g} {design.unit(name)} apart" * several
        for place, name in enumerate(model.own[1:], 1)]


def _contradicted(known: Iterable[Known], fit: CampaignFit, design: DesignPoint) -> Iterator[str]:
    """Which known parameters the runs move further than their errors allow."""
    found = dict(zip(fit.names, fit.design, strict=True))
    stated = [(one, found[one.name]) for one in known if one.name in found]
    read = [(*run.own[SLOPE], own[0]) for run, own in zip(fit.runs, fit.own, strict=True) if SLOPE in run.own]
    if read:
        value, sd, slope = map(float, np.mean(read, axis=0))
        stated.append((Known(SLOPE, value, sd), slope))
    for one, value in stated:
        off = abs(value - one.value) / one.sd
        if off > FAR_OFF:
            yield (f"{short(one.name)} is known as {one.value:.6g} {design.unit(one.name)} with a standard error of "
                   f"{one.sd:.2g}; these runs contradict that by {off:.1f} standard errors (found "
                   f"{value:.6g})")


def _beyond_intervals(fit: CampaignFit, design: DesignPoint) -> Iterator[str]:
    """What no interval holds: frames that the model has not, and gravity."""
    springs = [short(name) for name in fit.names if short(name) in OF_SPRINGS and not design.biped.frame_mass]
    if springs and design.biped.legs == "compliant":
        yield (f"the model has no frames above the springs: where the robot has, {listed(springs)} come out "
               "wrong by several percent though the fit is good, and their intervals do not hold that. Give "
               "frame_mass, frame_com and frame_inertia in biped.yaml")
    if not {*KNOWN_EVERYWHERE} & {*fit.names}:
        yield (f"gravity is taken to be {design.slope.gravity:g} m/s^2: fitted lengths are off by the share that "
               "it is, which no interval holds. Give yours as known, with its uncertainty")


def _at_both(hip: float, foot: float) -> str:
    """A frequency [Hz] of both sensors, or that of each."""
    return f"{hip:.1f} Hz" if math.isclose(hip, foot) else f"{hip:.1f} Hz at the hip and {foot:.1f} Hz at the foot"


def _of_sensors(fit: CampaignFit, model: Model) -> list[str]:
    """What the runs say of the sensors against what was stated of them; of sensors of other bandwidths each by its own
    runs."""
    said, alike = [], dict[tuple[float, ...], list[int]]()
    for number, run in enumerate(fit.runs):
        stated = tuple(run.sampling.bandwidth_hz[side] for side in SIDES) if run.sampling.declared else ()
        alike.setdefault(stated, []).append(number)
    for stated, mine in alike.items():
        share = float(fit.unknowns[mine, model.layout.place("bandwidth")].mean())
        drawn = [float(np.mean([fit.runs[number].sampling.bandwidth_hz[side] for number in mine])) for side in SIDES]
        cut = _at_both(*(one * math.exp(share) for one in drawn))
        if not stated:
            said.append(f"the sensors' bandwidth is not declared: the fit takes a second-order low pass of {cut}, "
                        "which may be wrong where the model is. Give it (bandwidth_hz of the devices)")
        elif abs(share) > OTHER_CUT:
            said.append(f"bandwidth: the sensors' low pass cuts off at {cut}, where {_at_both(*drawn)} is declared, "
                        "or stiff legs rebound, which looks like that")
    place = model.layout.place("foot_place")
    higher = float(fit.unknowns[:, place].mean())
    if abs(higher) > FAR_OFF * model.layout.prior[place]:
        said.append(f"lever arm: the foot sensor sits {1e3 * abs(higher):.1f} mm {'higher' if higher > 0 else 'lower'} "
                    "on the leg than imu.lever_arm has it; measure it")
    return said


def _tables(result: Calibrated, units: Sequence[str]) -> list[tuple[str, list[str], list[list[str]]]]:
    """The robot with its intervals, none of a fit that is not at rest; and errors on runs that were held out."""
    names, design, values = result.fit.names, result.design, result.estimate.values
    half = HALF_WIDTH * result.estimate.sd
    changes = 100 * (values - [design.value(name) for name in names]) / changes_of(design, names).scales
    walked, noise = {name: one for name, one in result.held_out.items() if one is not None}, result.model.noise
    tables: list[tuple[str, list[str], list[list[str]]]] = []
    if result.fit.converged:
        tables.append((
            "The robot, 95 % intervals", ["parameter", "nominal", "fitted", "interval", "change", "unit"],
            [[short(name), f"{design.value(name):.6g}", f"{values[row]:.6g}",
              f"+- {half[row]:.2g}" if math.isfinite(half[row]) else "not determined",
              f"{changes[row]:+.2f} %" if design.value(name) else "from 0", units[row]]
             for row, name in enumerate(names)]))
    if walked:
        begun = next(iter(walked.values())).begun
        tables.append((
            f"Errors on runs held out, rms: start and sensors fitted, and forecast from the first {begun:g} s; noise "
            f"is {noise[0]:.3f} m/s^2 and {1e3 * noise[2]:.2f} mrad/s",
            ["run", "fit, m/s^2", "fit, mrad/s", "forecast, m/s^2", "forecast, mrad/s"],
            [[name, f"{one.fit_force:.3f}", f"{1e3 * one.fit_rate:.2f}", f"{one.foretold_force:.3f}",
              f"{1e3 * one.foretold_rate:.2f}"] for name, one in walked.items()]))
    return tables


def _plain(one: HeldOut | None) -> dict[str, Any] | None:
    """Errors as JSON; none where the robot does not walk the run."""
    if one is None:
        return None
    fit, predicted = (
        {"force_m_s2": force, "rate_rad_s": rate}
        for force, rate in ((one.fit_force, one.fit_rate), (one.foretold_force, one.foretold_rate)))
    return {"sigmas": one.sigmas, "fit": fit, "foretold": predicted, "begun_s": one.begun}


def _draw(fit: CampaignFit, save: Any) -> None:
    """The first run's samples, fit and residuals."""
    from stages.calibration.reports.sensor_picture import fit_picture
    from stages.drawing import style

    run, equations = fit.runs[0], fit.equations[0]
    with style.drawing():
        save(fit_picture({side: trace(run, equations, side) for side in SIDES}, run.strikes))
