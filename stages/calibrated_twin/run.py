"""The calibrated twin: the blind fits corrected by one step of the Exudyn twin, and the twin with the numbers found.

Inputs: the calibration's fits, the databases they are of, and the campaign for the truth, which is put beside at the
end. Settings: params/calibration.yaml and what the twin needs. Output: `Result`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from stages.analytic.derivatives.gait import gait_derivatives
from stages.analytic.errors import NoGait, StepFailed
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.gait_search import gait_near
from stages.analytic.model.walker import Vector
from stages.biped.processes import Progress, ignore
from stages.biped.walk import Walk
from stages.calibrated_twin.parameters import Parameters
from stages.calibrated_twin.result import CORRECTED, Check, Number, Pair, Result, Robot
from stages.calibrated_twin.robot import TwinRobot
from stages.calibration.estimation.held_out import corrected, rms_of
from stages.calibration.estimation.run_fit import fit_near
from stages.calibration.information.identifiability import FINE, SLOPE
from stages.calibration.intervals.model_error import SPARE, Discrepancy
from stages.calibration.observation.measured_run import SIDES, MeasuredRun
from stages.calibration.recordings import (
    WITH_OUTSOLE,
    WITHOUT,
    Recorded,
    as_mounted,
    drawn_design,
    drawn_model,
    recorded,
    sources,
)
from stages.calibration.result import FittedRun, HeldOut, Result as Calibration
from stages.campaign.result import BARE, Result as Campaign
from stages.twin.machine.projection import machine_of

AS_FOUND = "as found"
HIP, FRAME = "biped.hip_mass", "biped.frame_mass"
#: The twin's ramp is known [deg].
SURE_DEG = 1e-4


@dataclass(frozen=True)
class Inputs:
    """What the stage reads."""

    calibration: Calibration
    measurements: Path
    without_outsole: Path
    campaign: Campaign
    database: Path | None = None


def run(parameters: Parameters, inputs: Inputs, progress: Progress = ignore) -> Result:
    """Correct, check, walk. Raises NoGait where the drawn design does not walk, SourceRefused."""
    work = _Work(as_mounted(parameters, inputs.database), *at_rest(inputs))
    robots: dict[str, Fitted] = {}
    for number, kind in enumerate(dict.fromkeys(fit.kind for fit in work.inputs.calibration.fits)):
        progress(0.1 + 0.3 * number, f"the twin with the numbers found, {kind}")
        robots[kind] = work.corrected(kind)
    names = work.model.shared
    pairs = (pairs_of(robots[WITH_OUTSOLE], robots[WITHOUT], names, work.near)
             if WITH_OUTSOLE in robots and WITHOUT in robots else ())
    checks: list[Check] = []
    for one in work.inputs.calibration.held_out:
        progress(0.8, f"{one.name}, held out")
        checks += work.checked(one, robots[one.kind])
    walk = work.walk(next(iter(robots.values()))) if robots else None
    return Result(tuple(robot_of(one, names, work.near) for one in robots.values()), pairs, tuple(checks),
                  tuple(work.reasons), walk)


def at_rest(inputs: Inputs) -> tuple[Inputs, list[str]]:
    """Inputs without fits that did not come to rest, which describe no robot, and why each of those did not."""
    calibration = inputs.calibration
    fits = tuple(fit for fit in calibration.fits if fit.converged)
    held = tuple(one for one in calibration.held_out if one.kind in {fit.kind for fit in fits})
    reasons = [f"{fit.name}: the fit did not come to rest: {fit.why}" for fit in calibration.fits if not fit.converged]
    return replace(inputs, calibration=replace(calibration, fits=fits, held_out=held)), reasons


class _Work:
    """The model that was fitted, the twin, the runs by name, and the reasons why something could not be done."""

    def __init__(self, parameters: Parameters, inputs: Inputs, reasons: list[str]) -> None:
        self.parameters, self.inputs, self.reasons = parameters, inputs, reasons
        drawn, self.model = drawn_model(parameters, inputs.database)
        self.near = self.model.layout.strike
        twin = parameters.twin.with_tolerance(parameters.runs.solver_tolerance)
        self.robot = TwinRobot(machine_of(parameters.biped, twin), parameters.contact, twin, parameters.settings,
                               self.model.layout, parameters.runs.motion_rate_hz)
        wanted: tuple[FittedRun | HeldOut, ...] = (*inputs.calibration.fits, *inputs.calibration.held_out)
        self.runs: dict[str, Recorded] = {}
        for kind, source, weighed, anew in sources(
                inputs.measurements, inputs.without_outsole, inputs.campaign, inputs.database):
            left = {one.name for one in wanted if one.kind == kind}
            for run, known in recorded(source, drawn, self.model, parameters, weighed, anew) if left else ():
                self.runs[run.name] = run, known
                left.discard(run.name)
                if not left:
                    break

    def corrected(self, kind: str) -> Fitted:
        """Fits of a kind, and corrections of the first that the twin walks."""
        fits, drawn = self.inputs.calibration.of_kind(kind), drawn_design(self.parameters, kind)
        corrections: dict[int, tuple[Vector, Vector]] = {}
        for place, fit in enumerate(fits):
            if len(corrections) == self.parameters.settings.corrected:
                break
            run, known = self.runs[fit.name]
            try:
                corrections[place] = corrected(drawn, fit, run, self.model, known, self.robot.run)
            except StepFailed as reason:
                self.reasons.append(f"{fit.name}: not corrected: {reason}")
        study = self.inputs.calibration
        pull = float(np.mean([self.model.layout.pull(fit.unknowns) for fit in fits]))
        return Fitted(kind, drawn, fits, corrections, study.drawn, pull,
                      Discrepancy.from_misses(study.misses))

    def checked(self, held: HeldOut, fitted: Fitted) -> list[Check]:
        """A held-out run walked by the twin: with numbers and start as the model has them, then with both corrected.

        The start's correction is that of the run itself: what the model's fit misses of the twin's own.
        """
        run, _ = self.runs[held.name]
        own = np.mean([fit.own for fit in fitted.fits], axis=0)
        own[list(self.model.own).index(SLOPE)] = held.own[0]
        found = self.model.robot(fitted.drawn, fitted.found, own)
        done: list[Check] = []
        try:
            done.append(self._check(AS_FOUND, found, held.unknowns, held, run))
            if fitted.corrections:
                own_bias = np.mean([own_bias for _, own_bias in fitted.corrections.values()], axis=0)
                better = self.model.robot(fitted.drawn, fitted.found - fitted.by_twin, own - own_bias)
                made = self.robot.run(better, held.unknowns, run)
                alone = replace(self.model, shared=(), own=(SLOPE,))
                sure = {SLOPE: (better.value(SLOPE), SURE_DEG)}
                again = fit_near(found, held.unknowns, replace(made, own=sure), alone, ())
                start = 2.0 * held.unknowns - again.unknowns
                done.append(self._check(CORRECTED, better, start, held, run))
        except StepFailed as reason:
            self.reasons.append(f"{held.name}: {reason}")
        return done

    def _check(
        self, numbers: str, design: DesignPoint, unknowns: Vector, held: HeldOut, run: MeasuredRun
    ) -> Check:
        """How far the twin is from a run. Raises StepFailed."""
        made = self.robot.run(design, unknowns, run)
        residuals = {side: np.where(run.used[side], run.samples[side] - made.samples[side], np.nan)
                     / self.model.noise_at(run.sampling, side) for side in SIDES}  # fmt: skip
        count = min(len(made.strikes), len(run.strikes))
        late = float(np.abs(made.strikes[:count] - run.strikes[:count]).max())
        return Check(held.name, held.kind, numbers, late, *rms_of(residuals, run, self.model))

    def walk(self, fitted: Fitted) -> Walk | None:
        """The twin's walk on the nominal ramp with a robot's corrected numbers, begun in that robot's gait."""
        design = design_of(fitted.drawn, self.model.shared, fitted.found - fitted.bias)
        try:
            steps, priors = self.parameters.settings.fitted_steps, self.parameters.priors
            return self.robot.settled(design, self.near, steps, priors)
        except (NoGait, StepFailed) as reason:
            self.reasons.append(f"the calibrated twin: {reason}")
            return None


@dataclass(frozen=True)
class Fitted:
    """Fits of one kind of robot as `drawn`, the corrections of some of them by their places, and what fits of other
    machines' runs miss, where enough show it, in shares of `scales` (d,). A correction is to be taken off the
    shared parameters (d,), and off the run's own (o,)."""

    kind: str
    drawn: DesignPoint
    fits: Sequence[FittedRun]
    corrections: dict[int, tuple[Vector, Vector]]
    scales: Vector
    pull: float = 0.0
    discrepancy: Discrepancy | None = None

    @property
    def by_twin(self) -> Vector:
        """What the model puts wrong, (d,), mean of the corrected runs; zero where there is none."""
        if not self.corrections:
            return np.zeros(len(self.scales))
        return np.asarray(np.mean([bias for bias, _ in self.corrections.values()], axis=0))

    @property
    def bias(self) -> Vector:
        """What the model puts wrong, (d,): by the other machines' runs, else by the twin's correction."""
        return self.by_twin if self.discrepancy is None else self.discrepancy.expected(self.scales, self.pull)

    def corrected(self, place: int) -> Vector:
        """A run's parameters less the bias by the twin, (d,)."""
        return np.asarray(self.fits[place].design - self.by_twin)

    @property
    def found(self) -> Vector:
        """Mean of the runs' parameters, (d,)."""
        return np.asarray(np.mean([one.design for one in self.fits], axis=0))

    @property
    def covariance(self) -> np.ndarray:
        """Of the mean of the corrected parameters, (d, d): what fits of other machines' runs scatter, noise with it.

        Where they do not show it: that of the fits, and the whole of the bias, which moves as one.
        """
        if self.discrepancy is not None:
            return self.discrepancy.spread(self.scales, self.pull)
        noise = np.sum([one.covariance for one in self.fits], axis=0) / len(self.fits) ** 2
        return np.asarray(noise + np.outer(self.bias, self.bias))


def design_of(drawn: DesignPoint, names: Sequence[str], values: Vector) -> DesignPoint:
    """The robot with legs alike on the nominal ramp."""
    biped = replace(drawn.biped, other_leg_length=None)
    return DesignPoint(biped, drawn.slope).with_values(dict(zip(names, values.tolist(), strict=True)))


def frequency(
    design: DesignPoint, names: Sequence[str], covariance: np.ndarray, near: Vector
) -> tuple[float, float]:
    """Step frequency [Hz] of the gait of a design `near` another's, and its standard error; NaN where it has none."""
    try:
        walker, point = gait_near(design, near, FINE)
    except NoGait:
        return math.nan, math.nan
    value = len(point.steps) / (sum(step.period for step in point.steps) * walker.time)
    found = gait_derivatives(design, point, tuple(names), FINE)
    slope = value * found.elasticities()["step_frequency_hz"] / found.changes.scales
    return value, float(np.sqrt(slope @ covariance @ slope))


def robot_of(fitted: Fitted, names: Sequence[str], near: Vector) -> Robot:
    """A robot's numbers, as Table 1 counts them: frames belong to the hip. `near` is where a similar one's gait begins.
    """
    drawn, corrected, covariance = fitted.drawn, fitted.found - fitted.bias, fitted.covariance
    by_twin = fitted.found - fitted.by_twin
    truth = np.mean([one.truth for one in fitted.fits], axis=0)
    sd = np.sqrt(np.diag(covariance))
    values = np.array([drawn.value(name) for name in names])
    numbers = []
    for row, name in enumerate(names):
        times, more = (2.0, drawn.biped.hip_mass) if name == FRAME else (1.0, 0.0)
        of = [times * float(each[row]) + more for each in (values, fitted.found, by_twin, corrected, truth)]
        numbers.append(Number(HIP if name == FRAME else name, drawn.unit(name), of[0], of[1], of[2],
                              of[3], times * float(sd[row]), of[4]))
    value, value_sd = frequency(design_of(drawn, names, corrected), names, covariance, near)
    known = np.isfinite(truth).all()
    true = frequency(design_of(drawn, names, truth), names, covariance, near)[0] if known else math.nan
    first = fitted.fits[0].covariance
    biases = np.array([bias for bias, _ in fitted.corrections.values()]).reshape(-1, len(names))
    spread = np.sqrt(np.diag(first))
    others = fitted.discrepancy.count if fitted.discrepancy else 0
    return Robot(fitted.kind, len(fitted.fits), len(fitted.corrections), others, tuple(numbers),
                 first / np.outer(spread, spread), biases, value, value_sd, true)


def pairs_of(usual: Fitted, bare: Fitted, names: Sequence[str], near: Vector) -> tuple[Pair, ...]:
    """What the outsole does, by each run that was made with it and without. `near` as for `robot_of`.

    What is wrong in both alike is not in the difference. How much else is, three other pairs of known machines show;
    where there are fewer, all that the corrections differ by counts, beside the errors of both fits.
    """
    without = {one.name.replace(BARE, ""): place for place, one in enumerate(bare.fits)}
    length, mass = names.index("biped.leg_length"), names.index("biped.foot_mass")
    both = [(place, without[one.name]) for place, one in enumerate(usual.fits) if one.name in without]
    missed = {pair: (usual.corrected(pair[0]) - usual.fits[pair[0]].truth)
              - (bare.corrected(pair[1]) - bare.fits[pair[1]].truth) for pair in both}
    found = []
    for place, other in both:
        one = usual.fits[place]
        ends = usual.corrected(place), bare.corrected(other)
        others = np.array([miss for pair, miss in missed.items() if pair != (place, other) and np.isfinite(miss).all()])
        if len(others) > SPARE:
            term = Discrepancy.of(others)
            ends, shared = (ends[0] - term.mean, ends[1]), term.spread(np.ones(len(names)))
        else:
            apart = usual.by_twin - bare.by_twin
            shared = one.covariance + bare.fits[other].covariance + np.outer(apart, apart)
        drawn = usual.drawn, bare.drawn
        (with_it, sd), (without_it, _) = (
            frequency(design_of(of, names, each), names, shared, near) for of, each in zip(drawn, ends, strict=True))
        true = [one.truth, bare.fits[other].truth]
        known = np.isfinite(true).all()
        designs = [design_of(of, names, each) for of, each in zip(drawn, true, strict=True)] if known else []
        real = [frequency(each, names, shared, near)[0] for each in designs] or [math.nan, math.nan]
        found.append(Pair(
            name=one.name, longer=float((ends[0] - ends[1])[length]), longer_sd=float(np.sqrt(shared[length, length])),
            true_longer=float((true[0] - true[1])[length]), heavier=float((ends[0] - ends[1])[mass]),
            slower=with_it / without_it - 1, slower_sd=sd / without_it, true_slower=real[0] / real[1] - 1))  # fmt: skip
    return tuple(found)
