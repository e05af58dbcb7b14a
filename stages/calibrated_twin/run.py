"""The calibrated twin: the blind fits corrected by one step of the Exudyn twin, and the twin with the numbers found.

Inputs: the calibration's fits, the databases they are of, and the campaign for the truth, which is put beside at the
end. Settings: params/calibration.yaml and what the twin needs. Output: `Result`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from stages.analytic.errors import NoGait, StepFailed
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.gait_search import find_gait
from stages.analytic.model.walker import Vector
from stages.biped.processes import Progress, ignore
from stages.biped.walk import Walk
from stages.calibrated_twin.parameters import Parameters
from stages.calibrated_twin.result import CORRECTED, Check, Result
from stages.calibrated_twin.robot import TwinRobot
from stages.calibrated_twin.told import Fitted, design_of, pairs_of, robot_of
from stages.calibration.estimation.held_out import Corrected, corrected, rms_of
from stages.calibration.estimation.run_fit import Model, RunFit, fit_near, run_equations
from stages.calibration.information.planned import FINE, SLOPE, first_model
from stages.calibration.intervals.model_error import Discrepancy
from stages.calibration.observation.measured_run import SIDES
from stages.calibration.recordings import (
    LAB,
    WITH_OUTSOLE,
    WITHOUT,
    Recorded,
    as_mounted,
    drawn_design,
    looked_for,
    recorded,
)
from stages.calibration.result import HeldOut
from stages.calibration.result import Result as Calibration
from stages.campaign.result import Result as Campaign
from stages.twin.machine.machine import build

AS_FOUND = "as found"
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
    inputs, reasons = at_rest(inputs)
    work = _Work(as_mounted(parameters), inputs)
    robots = []
    for number, kind in enumerate(dict.fromkeys(fit.kind for fit in inputs.calibration.fits)):
        progress(0.1 + 0.3 * number, f"the twin with the numbers found, {kind}")
        fitted, why = work.corrected(kind)
        robots.append(fitted)
        reasons += why
    names = work.model.shared
    by_kind = {one.kind: one for one in robots}
    pairs = (pairs_of(by_kind[WITH_OUTSOLE], by_kind[WITHOUT], names, work.near)
             if WITH_OUTSOLE in by_kind and WITHOUT in by_kind else ())
    checks: list[Check] = []
    for one in inputs.calibration.held_out:
        progress(0.8, f"{one.name}, held out")
        done, why = work.checked(one, by_kind[one.kind])
        checks += done
        reasons += why
    walk, why = work.walk(robots[0]) if robots else (None, [])
    return Result(tuple(robot_of(one, names, work.near) for one in robots), pairs, tuple(checks),
                  tuple(reasons + why), walk)


def at_rest(inputs: Inputs) -> tuple[Inputs, list[str]]:
    """Inputs without fits that did not come to rest, which tell of no robot, and why each of those did not."""
    calibration = inputs.calibration
    fits = tuple(fit for fit in calibration.fits if fit.converged)
    held = tuple(one for one in calibration.held_out if one.kind in {fit.kind for fit in fits})
    reasons = [f"{fit.name}: the fit did not come to rest: {fit.why}" for fit in calibration.fits if not fit.converged]
    return replace(inputs, calibration=replace(calibration, fits=fits, held_out=held)), reasons


class _Work:
    """The model that was fitted, the twin, and the runs by name."""

    def __init__(self, parameters: Parameters, inputs: Inputs) -> None:
        self.parameters, self.inputs = parameters, inputs
        drawn = drawn_design(parameters)
        gait = find_gait(drawn.biped, drawn.slope, FINE)
        self.near = gait[1].z
        self.model: Model = first_model(drawn, looked_for(drawn), parameters, gait)
        twin = parameters.twin.with_tolerance(parameters.runs.solver_tolerance)
        self.robot = TwinRobot(build(parameters.biped, twin), parameters.contact, twin, parameters.settings,
                               self.model.layout, parameters.runs.motion_rate_hz)
        weighed = {one.name: one.weighed for one in (*inputs.campaign.runs, *inputs.campaign.bare)}
        sources = (((inputs.database, LAB),) if inputs.database is not None else
                   ((inputs.measurements, WITH_OUTSOLE), (inputs.without_outsole, WITHOUT)))  # fmt: skip
        wanted = [(one.name, one.kind) for one in inputs.calibration.fits]
        wanted += [(one.name, one.kind) for one in inputs.calibration.held_out]
        self.runs: dict[str, Recorded] = {}
        for source, kind in sources:
            left = {name for name, of in wanted if of == kind}
            for one in recorded(source, kind, drawn, self.model, parameters, weighed) if left else ():
                self.runs[one.run.name] = one
                left.discard(one.run.name)
                if not left:
                    break

    def corrected(self, kind: str) -> tuple[Fitted, list[str]]:
        """Fits of a kind, and corrections of the first that the twin walks."""
        fits, drawn = self.inputs.calibration.of_kind(kind), drawn_design(self.parameters, kind)
        reasons: list[str] = []
        corrections: dict[int, Corrected] = {}
        for place, fit in enumerate(fits):
            if len(corrections) == self.parameters.settings.corrected:
                break
            one = self.runs[fit.name]
            at = self.model.robot(drawn, fit.design)
            stored = RunFit(fit.design, fit.own, fit.unknowns, run_equations(
                at, fit.own, fit.unknowns, one.run, self.model), fit.walks, fit.converged, fit.why)
            try:
                corrections[place] = corrected(drawn, stored, one.run, self.model, one.known, self.robot.run)
            except StepFailed as reason:
                reasons.append(f"{fit.name}: not corrected: {reason}")
        told = self.inputs.calibration
        pull = float(np.mean([self.model.layout.pull(fit.unknowns) for fit in fits]))
        return Fitted(kind, drawn, fits, corrections, told.drawn, pull,
                      Discrepancy.told(self.model.shared, told.misses)), reasons

    def checked(self, held: HeldOut, fitted: Fitted) -> tuple[list[Check], list[str]]:
        """A held-out run walked by the twin: with numbers and start as the model has them, then with both corrected.

        The start's correction is that of the run itself: what the model's fit misses of the twin's own.
        """
        one = self.runs[held.name]
        own = np.mean([fit.own for fit in fitted.fits], axis=0)
        own[list(self.model.own).index(SLOPE)] = held.own[0]
        found = self.model.robot(fitted.drawn, fitted.found, own)
        done: list[Check] = []
        try:
            done.append(self._check(AS_FOUND, found, held.unknowns, held, one))
            if fitted.corrections:
                own_bias = np.mean([each.own_bias for each in fitted.corrections.values()], axis=0)
                better = self.model.robot(fitted.drawn, fitted.found - fitted.by_twin, own - own_bias)
                made = self.robot.run(better, held.unknowns, one.run)
                alone = replace(self.model, shared=(), own=(SLOPE,))
                sure = {SLOPE: (better.value(SLOPE), SURE_DEG)}
                again = fit_near(found, held.unknowns, replace(made, own=sure), alone, ())
                start = 2.0 * held.unknowns - again.unknowns
                done.append(self._check(CORRECTED, better, start, held, one))
        except StepFailed as reason:
            return done, [f"{held.name}: {reason}"]
        return done, []

    def _check(
        self, numbers: str, design: DesignPoint, unknowns: Vector, held: HeldOut, one: Recorded
    ) -> Check:
        """How far the twin is from a run. Raises StepFailed."""
        made = self.robot.run(design, unknowns, one.run)
        residuals = {side: np.where(one.run.used[side], one.run.samples[side] - made.samples[side], np.nan)
                     / np.asarray(self.model.noise) for side in SIDES}  # fmt: skip
        count = min(len(made.strikes), len(one.run.strikes))
        late = float(np.abs(made.strikes[:count] - one.run.strikes[:count]).max())
        return Check(held.name, held.kind, numbers, late, *rms_of(residuals, one.run, self.model))

    def walk(self, fitted: Fitted) -> tuple[Walk | None, list[str]]:
        """The twin's walk on the nominal ramp with a robot's corrected numbers, begun in that robot's gait."""
        design = design_of(fitted.drawn, self.model.shared, fitted.found - fitted.bias)
        try:
            steps, priors = self.parameters.settings.fitted_steps, self.parameters.priors
            return self.robot.settled(design, self.near, steps, priors), []
        except (NoGait, StepFailed) as reason:
            return None, [f"the calibrated twin: {reason}"]
