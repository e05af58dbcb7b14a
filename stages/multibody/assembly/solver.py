"""Runs an assembly through Exudyn's solvers and says how it ended: never a hang, never a silent NaN."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from stages.multibody.assembly.system import SOLVER_ERRORS, System, exudyn
from stages.multibody.parameters import Settings
from stages.multibody.walking.watch import Watch
from stages.planar.run import DIVERGED, RUNNING, SOLVER_FAILED, STALLED

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


#: Settings of the solver that goes on from a time [s], and its kind.
Plan = Callable[[float], tuple[Any, Any]]


def solve(
    assembly: System, watch: Watch, plan: Plan, end: float, at_end: str = STALLED
) -> tuple[dict[str, np.ndarray], int, float]:
    """Integrate from t = 0 until the watch ends the run, the solver fails or the `end` [s] is reached.

    Signals at the solver's own steps by name, evaluations of rates or residuals, largest violation of a joint [m].
    """
    assembly.mbs.SetPreStepUserFunction(watch)
    segments: list[dict[str, np.ndarray]] = []
    drift, moment, further, explicit = 0.0, 0.0, 0, True
    while watch.outcome == RUNNING:
        wanted, kind = plan(moment)
        explicit = kind == SOLVER.DOPRI5
        assembly.mbs.sys.pop(LAST_SOLVER, None)
        try:
            assembly.mbs.SolveDynamic(wanted, solverType=kind, updateInitialValues=not explicit)
        except SOLVER_ERRORS as error:
            if watch.outcome == RUNNING:
                watch.outcome, watch.message = SOLVER_FAILED, first_sentence(error)
        further += further_evaluations(assembly.mbs, explicit)
        segments.append(assembly.recording())
        drift = max(drift, assembly.drift)
        reached = float(segments[-1]["time"][-1])
        if watch.outcome == RUNNING and reached >= end * (1.0 - 1e-9):
            watch.end(at_end, watch.words.late)
        if watch.outcome == RUNNING and not (math.isfinite(reached) and reached > moment):
            watch.outcome, watch.message = SOLVER_FAILED, f"the solver stopped at t = {reached:.6g} s without a word"
        moment = reached
    if not (np.isfinite(segments[-1]["position"]).all() and np.isfinite(segments[-1]["velocity"]).all()):
        watch.outcome = DIVERGED
    rows = _joined(segments, assembly.exact_acceleration)
    steps = len(rows["time"]) - 1
    return rows, (EVALUATIONS if explicit else 1) * steps + further, drift


def further_evaluations(mbs: Any, explicit: bool) -> int:
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


def stepped_plan(settings: Settings, watch: Watch, end: float) -> Plan:
    """Implicit steps to the end [s]: fine ones around heel strikes, for which the watch pauses the solver."""
    fine = False

    def impact_is_near(now: float) -> bool:
        recent = watch.heel_strikes > 0 and now - watch.last_heel_strike < settings.impact_window
        return recent or watch.approach < 3.0 * DESCENT * settings.rolling_step

    def plan(moment: float) -> tuple[Any, Any]:
        nonlocal fine
        fine = impact_is_near(moment)
        wanted = _silent_settings(settings.impact_step if fine else settings.rolling_step, end, moment)
        wanted.timeIntegration.adaptiveStep = False
        wanted.timeIntegration.newton.useModifiedNewton = True
        trapezoidal = settings.implicit_solver == "trapezoidal"
        return wanted, SOLVER.TrapezoidalIndex2 if trapezoidal else SOLVER.GeneralizedAlpha

    watch.refine = lambda now: fine == impact_is_near(now)
    return plan


def explicit_plan(tolerance: float, largest_step: float, end: float) -> Plan:
    """Explicit steps to the end [s], see `explicit_settings`."""

    def plan(moment: float) -> tuple[Any, Any]:
        return explicit_settings(tolerance, largest_step, end, moment), SOLVER.DOPRI5

    return plan


def explicit_settings(tolerance: float, largest_step: float, end: float, start: float = 0.0) -> Any:
    """Exudyn's settings for DOPRI5 with error control from start to end [s].

    The acceleration at a step's end is that of its last stage, which lies there: requested once more it would be the
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


def _joined(segments: list[dict[str, np.ndarray]], exact: bool) -> dict[str, np.ndarray]:
    """Join the segments, each from where the last ended; stop before the first value that is not finite."""
    joined = {name: np.concatenate([segment[name] for segment in segments]) for name in segments[0]}
    time, motion = joined["time"], np.column_stack([joined["position"], joined["velocity"]])
    later = np.concatenate([[True], np.diff(np.maximum.accumulate(time)) > 0.0])
    keep = later & np.logical_and.accumulate(np.isfinite(motion).all(axis=1))
    kept = {name: values[keep] for name, values in joined.items()}
    for name in {"acceleration", "foot_acceleration"} & kept.keys() if exact and keep.sum() > 1 else ():
        kept[name][0] = kept[name][1]
    return kept


def first_sentence(error: Exception) -> str:
    """What a solver's error says, without where in Python it was raised."""
    text = " ".join(str(error).split())
    return text.split("[Python file")[0].strip()[:300]
