"""One step of the penalty model from the constraint model's mid-stance, and how far the two differ over it."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from stages.biped.design import Biped
from stages.biped.gait import StanceState
from stages.biped.walk import Walk
from stages.contact_study.result import OneStep
from stages.ground.contact_law import ContactLaw
from stages.ground.slope import Slope
from stages.penalty.settings import Settings
from stages.penalty.walk import simulate
from stages.planar.events import find_events
from stages.planar.run import COMPLETED, Run
from stages.planar.sampling import ground_reaction
from stages.planar.signals import GROUND_REACTION, SIGNALS
from stages.planar.state import rolling_state
from stages.planar.trajectory import foot_kinematics

NO_HEEL_STRIKE = "no heel strike"
STANDING, LANDING = 0, 1


@dataclass(frozen=True)
class Scene:
    """What all runs share: the machine, the solver, the tolerance at which costs are told, the constraint model's walk
    and the time an impact is given [s].
    """

    biped: Biped
    slope: Slope
    solver: Settings
    cost_tolerance: float
    walk: Walk
    mid_stance: StanceState
    period: float
    impact_window: float

    @property
    def heel_strike(self) -> float:
        """Time of the constraint model's heel strike [s]."""
        return float(self.walk.heel_strike_time[0])

    @property
    def time(self) -> np.ndarray:
        """The constraint model's samples within one step [s], (n,)."""
        return np.asarray(self.walk.time[self.walk.time <= self.period])


def take_step(scene: Scene, law: ContactLaw, signals: Collection[str] = SIGNALS) -> Run:
    """Walk for one step period; the standing foot starts at its static penetration."""
    start = rolling_state(scene.biped, law, scene.mid_stance, scene.walk.standing_force)
    solver = scene.solver if GROUND_REACTION in signals else dataclasses.replace(scene.solver, between=0)
    return simulate(scene.biped, scene.slope, law, start, solver, duration=scene.period, signals=signals)


def cost(scene: Scene, law: ContactLaw, walked: Run | None = None) -> int:
    """Evaluations of the rates that a step takes at the tolerance of costs, whether it is finished or not.

    `walked` is the step as the scene has it, without signals, if that was walked already.
    """
    if walked is not None and scene.solver.tolerance == scene.cost_tolerance:
        return walked.evaluations
    coarse = dataclasses.replace(scene, solver=dataclasses.replace(scene.solver, tolerance=scene.cost_tolerance))
    return take_step(coarse, law, signals=()).evaluations


def landing_force(scene: Scene, run: Run, since_heel_strike: np.ndarray) -> np.ndarray:
    """Tangential and normal force on the landing foot, (n, 2) [N], at times [s] from the analytic heel strike.

    NaN after the end of a run that ended early.
    """
    time = scene.heel_strike + since_heel_strike
    force = ground_reaction(run.trajectory, np.minimum(time, run.trajectory.time[-1]), scene.biped.foot_radii)
    return np.where((time <= run.trajectory.time[-1])[:, None], force[:, LANDING], np.nan)


def unfinished(outcome: str, message: str, law: ContactLaw, evaluations: int) -> OneStep:
    """The row of a step that ended early: the reason, and nothing to compare."""
    nothing, pair = float("nan"), np.full(2, np.nan)
    return OneStep(
        outcome=outcome,
        message=message,
        law=law,
        hip_position=pair,
        hip_velocity=pair,
        impact_velocity=pair,
        end_position=pair,
        normal_force=nothing,
        friction_force=nothing,
        peak_force=nothing,
        penetration=nothing,
        creep_velocity=nothing,
        heel_strike_lead=nothing,
        evaluations=evaluations,
    )


@dataclass(frozen=True)
class HipCurve:
    """The hip (n, 4): x, y [m] and their rates [m/s], on a scene's samples, and the moment of heel strike [s]."""

    hip: np.ndarray
    heel_strike: float

    def minus(self, walk: Walk) -> np.ndarray:
        """Difference from a constraint model's walk on the same samples, (n, 4)."""
        samples = slice(len(self.hip))
        return np.asarray(self.hip - np.column_stack([walk.hip_position[samples], walk.hip_velocity[samples]]))


def hip_curve(scene: Scene, run: Run) -> HipCurve | str:
    """The hip of a run, or why there is none."""
    strikes = find_events(run.trajectory, scene.biped.foot_radii).heel_strike_time
    if not run.completed or not len(strikes):
        return NO_HEEL_STRIKE if run.completed else run.outcome
    position, velocity = run.trajectory.at(np.minimum(scene.time, run.trajectory.time[-1]))
    return HipCurve(np.column_stack([position[:, :2], velocity[:, :2]]), float(strikes[0]))


def in_impact(scene: Scene, *heel_strikes: float) -> np.ndarray:
    """Samples from the first heel strike of all models to the end of the impact of the last one, (n,)."""
    all_strikes = (scene.heel_strike, *heel_strikes)
    return (scene.time >= min(all_strikes)) & (scene.time <= max(all_strikes) + scene.impact_window)


def measure(scene: Scene, law: ContactLaw, run: Run) -> OneStep:
    """Differences of a step from the constraint model, on that model's samples."""
    curve = hip_curve(scene, run)
    if isinstance(curve, str):
        return unfinished(curve, run.message, law, cost(scene, law))
    trajectory, radii, time = run.trajectory, scene.biped.foot_radii, scene.time
    difference = curve.minus(scene.walk)
    position, velocity = difference[:, :2], difference[:, 2:]
    force = ground_reaction(trajectory, time, radii) - scene.walk.ground_reaction[: len(time)]
    impact = in_impact(scene, curve.heel_strike)
    rows = trajectory.position, trajectory.velocity
    columns = [foot_kinematics(*rows, leg, radii[leg]) for leg in (STANDING, LANDING)]
    held = trajectory.in_play(trajectory.time)
    depth = np.where(held, np.column_stack([column[0] for column in columns]), 0.0)
    before = trajectory.time < min(curve.heel_strike, scene.heel_strike)
    slip, span = np.abs(columns[STANDING][2][before]), trajectory.time[before]
    return OneStep(
        outcome=COMPLETED,
        message="",
        law=law,
        hip_position=np.abs(position).max(axis=0),
        hip_velocity=np.abs(velocity[~impact]).max(axis=0),
        impact_velocity=np.abs(velocity[impact]).max(axis=0, initial=0.0),
        end_position=position[-1],
        normal_force=float(np.sqrt(np.mean(force[~impact, :, 1] ** 2))),
        friction_force=float(np.sqrt(np.mean(force[~impact, :, 0] ** 2))),
        peak_force=float(trajectory.ground_reaction[:, LANDING, 1].max()),
        penetration=float(depth.max()),
        creep_velocity=float(np.trapezoid(slip, span) / (span[-1] - span[0])),
        heel_strike_lead=scene.heel_strike - curve.heel_strike,
        evaluations=cost(scene, law),
    )
