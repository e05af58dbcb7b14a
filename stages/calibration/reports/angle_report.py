"""A robot calibrated from its encoders, as text, JSON and pictures, and what of its file the fit contradicts."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from stages.biped.design import Biped
from stages.biped.question import Answer, at_hand
from stages.calibration.angles.fit import AngleFit, HeldOut, fit_robot, held_out
from stages.calibration.angles.recording import HELD, DrivenStep, read_steps
from stages.calibration.angles.robot import FARTHEST_ZERO, OF_ROBOT, ZEROS, AngleSetup, setup_of
from stages.calibration.angles.same import FittedEncoders
from stages.calibration.estimation.least_squares import covariance_of
from stages.calibration.following.encoders import with_noise
from stages.calibration.following.robot_file import NAME
from stages.calibration.information.identifiability import listed, short
from stages.calibration.intervals.model_error import correlation_length
from stages.calibration.reports.parameters_left import PLANAR, with_errors
from stages.calibration.result import HALF_WIDTH
from stages.ground.slope import Slope

#: What angles are taken to be right to at first [rad]; parts of a step that residuals are given by.
NOISE, PARTS = 4e-3, 5
#: A number is not reported if its standard deviation is more of these changes than this.
DETERMINED = 10.0
#: More outliers than this share are remarked.
FEW = 1e-3
VISCOUS, COULOMB = "biped.hip_damping", "biped.hip_friction"


@dataclass(frozen=True)
class Calibrated:
    """What came out: fit, held-out errors of the robot as drawn and as fitted, and what the residuals say; whether the
    robot is `refuted`, as the recording contradicts what came with it or the fit is not at rest; else what
    the `robot` is followed and compared by."""

    setup: AngleSetup
    fit: AngleFit
    drawn: HeldOut
    found: HeldOut
    sd: dict[str, float]
    remarks: list[str]
    refuted: bool
    robot: FittedEncoders | None = None


def calibrated(
    biped: Biped, slope: Slope, about: Mapping[str, Any] | None, source: Path,
    reading: Callable[..., Iterator[Any]] = at_hand,
) -> Calibrated:  # fmt: skip
    """Fit the steps of a recording and predict the others. Raises WrongOption, NotIdentified."""
    setup = setup_of(about, biped, slope)
    fitted, out = setup.split(read_steps(source, setup.columns, setup.left_out, setup.markers, reading))
    sizes, low = setup.sizes(), setup.low()
    first = fit_robot(setup.robot, fitted, setup.free, sizes, low, setup.known, NOISE)
    worth = NOISE * math.sqrt(max(1.0, correlation_length(list(first.residuals.values())))) * first.size
    fit = fit_robot(first.robot, fitted, setup.free, sizes, low, setup.known, worth, first.starts)
    judged = out or fitted
    drawn, found = (held_out(robot, judged, setup.begun) for robot in (setup.robot, fit.robot))
    size = np.array([sizes[name] for name in setup.free])
    spread = np.sqrt(np.diag(fit.covariance(size)))
    sd = dict(zip(setup.free, spread.tolist(), strict=True))
    remarks = [] if out else ["no step was held out: errors are those of the fitted steps"]
    if not fit.converged:
        remarks.append(f"the fit did not come to rest in {fit.iterations} iterations: there are no intervals")
    remarks += _samples(fitted + out)
    against = contradictions(setup, fit, sd, fitted)
    remarks += [words for words, _ in against]
    unclear = [short(name) for name in setup.free if not sd[name] < DETERMINED * sizes[name]]
    if unclear:
        remarks.append(f"not determined by these steps: {listed(unclear)}; give known values for some of them")
    remarks += _friction(setup, fit, fitted, sizes, low)
    remarks += _structure(found)
    wrong = refuted(against) or not fit.converged
    left = None if wrong else with_noise(FittedEncoders.of(setup, fit), fitted)
    return Calibrated(setup, fit, drawn, found, sd, remarks, wrong, left)


def _samples(steps: Sequence[DrivenStep]) -> Iterator[str]:
    """What is wrong with the samples of steps."""
    odd, count = sum(one.outliers for one in steps), sum(2 * len(one.stance) for one in steps)
    if odd > FEW * count:
        yield (f"{odd} of {count} angles ({100 * odd / count:.1f} %) are outliers among their neighbours, and "
               "were bridged: look after the encoders")
    held = 1.0 - sum(float(one.weights.sum()) for one in steps) / count
    if held > HELD / 2:
        yield f"{100 * held:.0f} % of the angles repeat the row before, or their rows are lost: they count for nothing"


def _friction(
    setup: AngleSetup, fit: AngleFit, steps: Sequence[DrivenStep], sizes: Mapping[str, float], low: Mapping[str, float]
) -> list[str]:
    """What friction would be if it could be negative."""
    at_bound = [name for name in setup.free if name in low and fit.robot.value(name) <= low[name] + 1e-12]
    said = []
    for name in at_bound:
        free = {other: least for other, least in low.items() if other != name}
        without = fit_robot(fit.robot, steps, setup.free, sizes, free, setup.known, fit.noise, fit.starts)
        sentence = (f"{short(name)} is at its bound {low[name]:g} {fit.robot.unit(name)}; without the bound it would "
                    f"be {without.robot.value(name):.2g}")
        if name == VISCOUS:
            sentence += (f" beside {short(COULOMB)} {without.robot.value(COULOMB):.2g} N m: friction falls with speed, "
                         "and the law of Coulomb and viscous friction has no such part")
        said.append(sentence)
    return said


def _structure(found: HeldOut) -> list[str]:
    """Whether residuals are noise, and where in a step they are large."""
    every = list(found.residuals.values())
    length = correlation_length(every)
    lag = sum(float((one[1:] * one[:-1]).sum()) for one in every) / sum(float((one**2).sum()) for one in every)
    by_part = np.array([[np.sqrt((part**2).mean(axis=0)) for part in np.array_split(one, PARTS)] for one in every])
    parts = np.sqrt(np.nanmean(by_part**2, axis=0))[:, 1]
    said = [f"residuals of a step hang together (correlation {lag:.2f} from sample to sample, {length:.0f} samples are "
            f"worth one): they are the model's, not noise, and intervals count steps, not samples"] if lag > 0.3 else []
    return [*said, "by fifths of a step, rms between the legs: " + ", ".join(f"{1e3 * value:.1f}" for value in parts)
            + f" mrad (largest in fifth {int(np.argmax(parts)) + 1})"]


#: From how many of its standard errors on a value is said to be contradicted, and from how many it settles the matter.
SAID, SETTLED = 3.0, 10.0


#: A contradiction in a sentence, and of how many standard errors.
Contradiction = tuple[str, float]


def refuted(found: Sequence[Contradiction]) -> bool:
    """Whether robot and recording do not belong together: two contradict each other, or one beyond doubt."""
    return len(found) >= 2 or any(errors > SETTLED for _, errors in found)


def contradictions(
    setup: AngleSetup, fit: AngleFit, sd: dict[str, float], steps: Sequence[DrivenStep]
) -> list[Contradiction]:
    """All of a fit whose information counts samples as what they are worth, `sd` by the scatter of its steps."""
    return [*_turned(steps), *_known(setup, fit), *_zeros(setup, fit), *_signs(setup, fit, sd)]


def _known(setup: AngleSetup, fit: AngleFit) -> Iterator[Contradiction]:
    """Known values against all else: what is found less what is known has the variance of the known one, less that of
    both together."""
    size = np.array([setup.sizes()[name] for name in fit.names])
    covariance = covariance_of(fit.information, size)
    for one in setup.known:
        row = one.row(fit.names)
        value = fit.robot.value(one.name)
        variance = one.sd**2 - float(row @ np.where(np.isfinite(covariance), covariance, 0.0) @ row)
        off = abs(value - one.value) / math.sqrt(max(variance, 1e-6 * one.sd**2))
        if row.any() and off > SAID:
            yield (f"{short(one.name)} is known as {one.value:.4g} {setup.robot.unit(one.name)} with a "
                                f"standard error of {one.sd:.2g}; these steps contradict that by {off:.1f} standard "
                                f"errors (found {value:.4g})", off)  # fmt: skip


def _zeros(setup: AngleSetup, fit: AngleFit) -> Iterator[Contradiction]:
    known = {one.name for one in setup.known}
    for name in (name for name in ZEROS if name in fit.names and name not in known):
        off = fit.robot.value(name) - setup.robot.value(name)
        if abs(off) > FARTHEST_ZERO:
            yield (f"{name} comes out {math.degrees(off):+.1f} degrees off: more than an encoder is "
                                "mounted wrong by; legs may be exchanged, or a sign turned", 0.0)  # fmt: skip


def _signs(setup: AngleSetup, fit: AngleFit, sd: dict[str, float]) -> Iterator[Contradiction]:
    for name in fit.names:
        drawn, found = setup.robot.value(name), fit.robot.value(name)
        if drawn * found < 0.0 and abs(found) > SAID * sd[name]:
            yield (f"{short(name)} comes out with the other sign ({found:.4g} for {drawn:.4g} "
                                f"{setup.robot.unit(name)}): a column or a value has its sign turned",
                                abs(found - drawn) / sd[name])  # fmt: skip


def _turned(steps: Sequence[DrivenStep]) -> Iterator[Contradiction]:
    """Where both feet are on level ground, legs of one length enclose twice the stance angle."""
    ends = np.array([[2.0 * one.stance[at], one.between[at]] for one in steps for at in (0, -1)])
    slope = float(ends[:, 0] @ ends[:, 1] / (ends[:, 0] @ ends[:, 0]))
    if slope < 0.0:
        yield (f"near heel strikes the angle between the legs is {slope:+.2f} times twice the stance "
                            "angle, where with both feet on the ground it is about +1: one of the columns stance "
                            "angle, hip angle and standing pair is turned", math.inf)  # fmt: skip
    if sum(one.stance[-1] < one.stance[0] for one in steps) > len(steps) / 2:
        yield ("the stance angle grows through a step, as of a robot that walks backwards: if this one does not, the "
               "signs of both angles and the signal are turned, and so are the zeros and torque_offset found", 0.0)


def answered(result: Calibrated) -> Answer:
    """The answer to `calibrate`."""
    fit, setup = result.fit, result.setup
    rows = [[short(name), f"{setup.robot.value(name):.5g}", f"{fit.robot.value(name):.5g}",
             f"+- {HALF_WIDTH * sd:.2g}" if math.isfinite(sd) else "not determined", fit.robot.unit(name)]
            for name, sd in result.sd.items()] if fit.converged else []  # fmt: skip
    between, stance = fit.rms()
    forecast, held = result.found, len(result.found.residuals)
    errors = [
        ["fit", *(f"{1e3 * value:.2f}" for value in (*result.drawn.fit, *forecast.fit))],
        [f"forecast from {setup.begun:g} s", *(f"{1e3 * value:.1f}" for value in (*result.drawn.predicted,
                                                                                *forecast.predicted))],
    ]
    return Answer(
        lines=[f"{len(fit.starts)} steps fitted: rms {1e3 * between:.2f} mrad between the legs, {1e3 * stance:.2f} "
               "mrad of the stance leg", *result.remarks],
        tables=[
            *([("The robot, 95 % intervals", ["number", "nominal", "fitted", "95 %", "unit"], rows)] if rows else []),
            (f"Errors on {held} steps that were not fitted, mrad",
             ["", "nominal, hip", "nominal, stance", "fitted, hip", "fitted, stance"], errors),
        ],
        plain={
            "numbers": {name: {"drawn": setup.robot.value(name), "found": fit.robot.value(name),
                               "sd": float(result.sd[name]) if fit.converged else None,
                               "unit": fit.robot.unit(name)} for name in setup.free},
            "fixed": {name: value for name, value in fit.robot.numbers.items() if name not in setup.free},
            "fitted_steps": sorted(fit.starts), "held_out_steps": held, "begun_s": setup.begun,
            "rms_fitted_rad": {"hip": between, "stance": stance},
            "held_out_rad": {"fit": {"hip": forecast.fit[0], "stance": forecast.fit[1]},
                             "foretold": {"hip": forecast.predicted[0], "stance": forecast.predicted[1]},
                             "drawn_fit": {"hip": result.drawn.fit[0], "stance": result.drawn.fit[1]}},
            "remarks": result.remarks, "converged": fit.converged,
        },
        files={NAME: result.robot.content()} if result.robot else {},
        parameters=parameters_left_of_angles(result.robot) if result.robot else {},
        draw=partial(_draw, result),
        no=result.refuted,
    )  # fmt: skip


def parameters_left_of_angles(robot: FittedEncoders) -> dict[str, Any]:
    """Parameters as a folder keeps them: those that the file gives, and those found with their errors."""
    setup, design = robot.setup, robot.setup.robot.design
    units = {field.name: field.metadata["unit"] for field in fields(Biped)}
    found = [row for row, name in enumerate(setup.free) if name not in OF_ROBOT]
    names = [setup.free[row] for row in found]
    left = {f"biped.{key}": {"value": value, "unit": units[key]} for key, value in setup.given.items()}
    left |= with_errors(design, names, [*map(design.value, names)], robot.covariance[np.ix_(found, found)])
    return left if design.biped.frame_mass else left | PLANAR


def _draw(result: Calibrated, save: Any) -> None:
    """Residuals of held-out steps over the step, each step a line, and their rms."""
    import matplotlib.pyplot as plt

    from stages.drawing import style

    with style.drawing():
        figure, axes = plt.subplots(2, 1, figsize=(style.TWO_COLUMNS, 4.0), sharex=True)
        for axis, column, title in zip(axes, (1, 0), ("angle between the legs", "stance angle"), strict=True):
            for one in result.found.residuals.values():
                axis.plot(np.linspace(0, 100, len(one)), 1e3 * one[:, column], color=style.MEASURED, linewidth=0.5)
            grid = np.linspace(0, 100, 101)
            every = np.array([np.interp(grid, np.linspace(0, 100, len(one)), one[:, column])
                              for one in result.found.residuals.values()])
            axis.plot(grid, 1e3 * every.mean(axis=0), color=style.ANALYTIC, label="mean")
            axis.set(ylabel="measured less model [mrad]",
                     title=f"{title}, {len(result.found.residuals)} steps that were not fitted")  # fmt: skip
            axis.legend()
        axes[-1].set_xlabel("part of the step [%]")
        save(figure)
