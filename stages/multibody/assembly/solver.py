"""Runs an assembly through Exudyn's solvers and says how it ended: never a hang, never a silent NaN."""

from __future__ import annotations

import math
from typing import Any, Protocol

import numpy as np

from stages.multibody.assembly.quiet_exudyn import SOLVER_ERRORS, exudyn
from stages.multibody.parameters import Settings
from stages.multibody.walking.scuffing import Walker, Watch
from stages.planar.run import COMPLETED, DIVERGED, RUNNING, SOLVER_FAILED, STALLED, Run
from stages.planar.state import PlanarState
from stages.planar.trajectory import Trajectory

SOLVER = exudyn.DynamicSolverType
FIRST_STEP = 1e-9  # an explicit solver reports no acceleration at its start; the one after this step stands in for it
SMALLEST_STEP = 1e-13
LAST_SOLVER = "dynamicSolver"  # under which Exudyn keeps it
EVERY_STEP = 1e-12
#: Evaluations of the rates in a step of Exudyn's DOPRI5, also in one that its error control rejects: seven stages, none
#: of them kept from the step before.
EVALUATIONS = 7
#: Evaluations of the contact's force, by whose differences Exudyn finds its part of a Jacobian.
JACOBIAN = 7
DESCENT = 1.0  # m/s, an upper bound for how fast a foot comes down, to refine the step in time


class Assembly(Walker, Protocol):
    """A multibody system of the planar biped."""

    mbs: Any
    exact_acceleration: bool

    def start(self, state: PlanarState) -> None:
        """Make `state` the initial one."""

    def recording(self) -> dict[str, np.ndarray]:
        """Signals of the last solver call, named as in `Trajectory`."""

    def joint_drift(self) -> float:
        """Largest violation of a joint seen in the last solver call [m]."""


def integrate(
    assembly: Assembly, state: PlanarState, watch: Watch, settings: Settings, duration: float | None = None
) -> Run:
    """Integrate from `state` at t = 0 until the watch ends the run, the solver fails or the duration [s] is over."""
    assembly.start(state)
    if watch.lanes:  # the ground itself ends between blocks
        assembly.set_in_play(0, True)
        assembly.set_in_play(1, True)
    assembly.mbs.SetPreStepUserFunction(watch)
    limit = watch.longest_step * (watch.heel_strikes_wanted + 2) if duration is None else duration
    segments: list[dict[str, np.ndarray]] = []
    drift, further = 0.0, 0
    explicit = settings.assembly == "tree"
    fine = False
    if not explicit:
        watch.refine = lambda now: fine == _impact_is_near(watch, now, settings)
    moment = 0.0
    while watch.outcome == RUNNING:
        fine = not explicit and _impact_is_near(watch, moment, settings)
        wanted, kind = _simulation_settings(settings, moment, limit, fine)
        assembly.mbs.sys.pop(LAST_SOLVER, None)
        try:
            assembly.mbs.SolveDynamic(wanted, solverType=kind, updateInitialValues=not explicit)
        except SOLVER_ERRORS as error:
            if watch.outcome == RUNNING:
                watch.outcome, watch.message = SOLVER_FAILED, first_sentence(error)
        further += further_evaluations(assembly.mbs, explicit)
        segments.append(assembly.recording())
        drift = max(drift, assembly.joint_drift())
        reached = float(segments[-1]["time"][-1])
        if watch.outcome == RUNNING and reached >= limit * (1.0 - 1e-9):
            watch.outcome = STALLED if duration is None else COMPLETED
        if watch.outcome == RUNNING and not (math.isfinite(reached) and reached > moment):
            watch.outcome, watch.message = SOLVER_FAILED, f"the solver stopped at t = {reached:.6g} s without a word"
        moment = reached
    trajectory = _trajectory(segments, watch, state, assembly.exact_acceleration)
    if not np.all(np.isfinite(segments[-1]["position"])):
        watch.outcome = DIVERGED
    steps = len(trajectory.time) - 1
    evaluations = (EVALUATIONS if explicit else 1) * steps + further
    return Run(watch.outcome, watch.message, trajectory, watch.heel_strikes, steps, evaluations, drift)


def further_evaluations(mbs: Any, explicit: bool = True) -> int:
    """Evaluations in the last solver call beyond those of each step; none known where that ended with an error.

    Explicit: of the rates, in steps that error control rejected. Implicit: of the residual, one where the call begins,
    and one after each Newton iteration beside that of every step; a Newton iteration solves one linear system, as every
    evaluation of explicit rates does.
    """
    solver = mbs.sys.get(LAST_SOLVER)
    if solver is None:
        return 0
    if explicit:
        return EVALUATIONS * int(solver.it.rejectedAutomaticStepSizeSteps)
    return 1 + int(solver.it.newtonStepsCount) + JACOBIAN * int(solver.it.newtonJacobiCount)


def _impact_is_near(watch: Watch, now: float, settings: Settings) -> bool:
    soon = watch.approach < 3.0 * DESCENT * settings.rolling_step
    recent = watch.heel_strikes > 0 and now - watch.last_heel_strike < settings.impact_window
    return soon or recent


def _simulation_settings(settings: Settings, start: float, end: float, fine: bool) -> tuple[Any, Any]:
    if settings.assembly == "tree":
        return explicit_settings(settings.tolerance, settings.largest_step, end, start), SOLVER.DOPRI5
    wanted = _silent_settings(settings.impact_step if fine else settings.rolling_step, end, start)
    wanted.timeIntegration.adaptiveStep = False
    wanted.timeIntegration.newton.useModifiedNewton = True
    trapezoidal = settings.implicit_solver == "trapezoidal"
    return wanted, SOLVER.TrapezoidalIndex2 if trapezoidal else SOLVER.GeneralizedAlpha


def explicit_settings(tolerance: float, largest_step: float, end: float, start: float = 0.0) -> Any:
    """Exudyn's settings for DOPRI5 with error control from start to end [s].

    The acceleration at a step's end is that of its last stage, which lies there: asked for once more it would be the
    same to the last bit.
    """
    wanted = _silent_settings(largest_step, end, start)
    integration = wanted.timeIntegration
    integration.absoluteTolerance = tolerance
    integration.relativeTolerance = 0.0  # Exudyn's error scale takes signed values: a relative part could vanish
    integration.initialStepSize = FIRST_STEP
    integration.minimumStepSize = SMALLEST_STEP
    integration.explicit.computeEndOfStepAccelerations = False
    return wanted


def _silent_settings(step: float, end: float, start: float) -> Any:
    wanted = exudyn.SimulationSettings()
    wanted.solution.file.write = False
    wanted.solution.sensors.writePeriod = EVERY_STEP
    integration = wanted.timeIntegration
    integration.verboseMode = 0
    integration.startTime, integration.endTime = start, end
    integration.numberOfSteps = math.ceil((end - start) / step)
    return wanted


def _trajectory(segments: list[dict[str, np.ndarray]], watch: Watch, state: PlanarState, exact: bool) -> Trajectory:
    """Join the segments, each from where the last ended; stop before the first value that is not finite."""
    joined = {name: np.concatenate([segment[name] for segment in segments]) for name in segments[0]}
    keep = valid_rows(joined["time"], joined["position"], joined["velocity"])
    kept = {name: values[keep] for name, values in joined.items()}
    if exact and len(kept["time"]) > 1:
        for name in ("acceleration", "foot_acceleration"):
            kept[name][0] = kept[name][1]
    return Trajectory(**kept, in_play_at_start=state.in_play, switches=tuple(watch.switches), exact_acceleration=exact)


def valid_rows(time: np.ndarray, position: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """Which rows (n,) of a record go on in time, before the first value that is not finite."""
    later = np.concatenate([[True], np.diff(np.maximum.accumulate(time)) > 0.0])
    finite = np.isfinite(position).all(axis=1) & np.isfinite(velocity).all(axis=1)
    return np.asarray(later & np.logical_and.accumulate(finite))


def first_sentence(error: Exception) -> str:
    """What a solver's error says, without where in Python it was raised."""
    text = " ".join(str(error).split())
    return text.split("[Python file")[0].strip()[:300]
