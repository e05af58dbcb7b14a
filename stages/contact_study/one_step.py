"""One step from the constraint model's mid-stance: of that model, of the penalty model, and how far they differ.

The constraint model is walked with rolling feet and with Coulomb's transition. The second is what the penalty model
tends to as its contact hardens: the same friction, no depth, no creep. What sets it apart from rolling feet is
therefore what no contact parameter can remove.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from stages.analytic.gait.gait_search import find_gait, step_length
from stages.analytic.model.walker import Walker
from stages.analytic.walk.recording import Segment, crossing_state, walk_on
from stages.analytic.walk.sampling import sample_segment, sample_walk, signal_scales
from stages.biped.between_steps import SAME, largest_magnitudes, sampled_at
from stages.biped.design import Biped
from stages.biped.walk import StanceState, Walk
from stages.contact_study.result import OneStep
from stages.ground.contact_law import ContactLaw
from stages.ground.slope import Friction, Slope
from stages.penalty.walk import Settings
from stages.planar.run import COMPLETED, Run, foot_kinematics
from stages.planar.sampling import find_events, ground_reaction, peaks
from stages.planar.signals import GROUND_REACTION, SIGNALS
from stages.studies.walks import Upright

NO_HEEL_STRIKE = "no heel strike"
STANDING, LANDING = 0, 1


@dataclass(frozen=True)
class ConstraintModel:
    """A step from the common mid-stance state; period [s] and length [m] of the model's gait, and its mid-stance."""

    walk: Walk
    period: float
    length: float
    mid_stance: StanceState
    walker: Walker
    segments: list[Segment]

    def hip(self, middle: float, times: np.ndarray) -> np.ndarray:
        """The hip's x, y [m] and their rates [m/s] at times [s], (n, 4), by the phase that lasts at `middle` [s]."""
        walker, scales = self.walker, signal_scales(self.walker)
        phase = [one for one in self.segments if one.start * walker.time < middle][-1]
        found = sample_segment(walker, phase, times / walker.time - phase.start)
        return np.column_stack([scales[name] * found[name] for name in ("hip_position", "hip_velocity")])


def constraint_model(
    biped: Biped, slope: Slope, friction: Friction | None, start: StanceState, tolerance: float, rate: float
) -> ConstraintModel:
    """The model, whose trailing foot slips if there is `friction`, walked from `start` and sampled at `rate` [Hz].

    Raises NoGait or StepFailed.
    """
    walker, point = find_gait(biped, slope, tolerance, friction)
    segments = walk_on(walker, walker.from_stance(start), 1, tolerance)
    return ConstraintModel(
        sample_walk(walker, segments, rate),
        float(point.period * walker.time),
        float(step_length(walker, point) * walker.length),
        walker.stance_state(crossing_state(walker, point.z, tolerance)),
        walker,
        segments,
    )


def hips(models: Sequence[ConstraintModel], wanted: np.ndarray) -> tuple[np.ndarray, list[np.ndarray]]:
    """The hips of models at wanted rising times [s], and on both sides of each phase's end among them: times (m,), of
    which two are equal there, and each model's hip (m, 4).
    """
    first, last = wanted[0], wanted[-1]
    ends = np.unique([phase.start * model.walker.time for model in models for phase in model.segments])
    ends = ends[(ends > first) & (ends < last) & (np.diff(ends, prepend=-np.inf) > SAME * (last - first))]
    pieces = list(pairwise([first, *ends, last]))
    times = [np.concatenate([[begin], wanted[(wanted > begin) & (wanted < end)], [end]]) for begin, end in pieces]
    return np.concatenate(times), [
        np.concatenate([model.hip((begin + end) / 2, each) for (begin, end), each in zip(pieces, times, strict=True)])
        for model in models]  # fmt: skip


@dataclass(frozen=True)
class Scene:
    """What all runs share: the machine, the solver, the tolerance at which costs are given, the constraint model's walk
    and the time an impact is given [s]; the model that walked it, where it is not known by its samples alone.
    """

    biped: Biped
    slope: Slope
    solver: Settings
    cost_tolerance: float
    walk: Walk
    mid_stance: StanceState
    period: float
    impact_window: float
    model: ConstraintModel | None = None

    @property
    def upright(self) -> Upright:
        """Where all runs begin."""
        return Upright(self.biped, self.slope, self.mid_stance, self.walk.standing_force)

    @property
    def heel_strike(self) -> float:
        """Time of the constraint model's heel strike [s]."""
        return float(self.walk.heel_strike_time[0])

    @cached_property
    def compared(self) -> tuple[np.ndarray, np.ndarray]:
        """Times [s] at which hips are compared, (m,): samples, both sides of the constraint model's events, and the
        step's end; that model's hip there, x, y [m] and their rates [m/s], (m, 4)."""
        times = np.unique(np.append(self.time, self.period))
        if self.model is not None:
            times, (hip,) = hips([self.model], times)
            return times, hip
        events = np.concatenate([self.walk.heel_strike_time, self.walk.toe_off_time])
        rows = np.column_stack([self.walk.hip_position, self.walk.hip_velocity])
        return sampled_at(self.walk.time, rows, events, times)

    @property
    def time(self) -> np.ndarray:
        """The constraint model's samples within one step [s], (n,)."""
        return np.asarray(self.walk.time[self.walk.time <= self.period])


def take_step(scene: Scene, law: ContactLaw, signals: Collection[str] = SIGNALS) -> Run:
    """Walk for one step period; the standing foot starts at its static penetration."""
    solver = scene.solver if GROUND_REACTION in signals else replace(scene.solver, between=0)
    return scene.upright.walk(law, solver, duration=scene.period, signals=signals)


def cost(scene: Scene, law: ContactLaw, walked: Run | None = None) -> int:
    """Evaluations of the rates that a step takes at the tolerance of costs, whether it is finished or not.

    `walked` is the step as the scene has it, without signals, if that was walked already.
    """
    if walked is not None and scene.solver.tolerance == scene.cost_tolerance:
        return walked.evaluations
    coarse = replace(scene, solver=replace(scene.solver, tolerance=scene.cost_tolerance))
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


class Apart(NamedTuple):
    """A run's hip less that of a scene's constraint model at the scene's times (m, 4), x, y [m] and their rates [m/s],
    and the moment of the run's heel strike [s]."""

    hip: np.ndarray
    heel_strike: float


def apart(scene: Scene, run: Run) -> Apart | str:
    """How far a run's hip is from the constraint model's, or why there is none to compare."""
    strikes = find_events(run.trajectory, scene.biped.foot_radii).heel_strike_time
    if not run.completed or not len(strikes):
        return NO_HEEL_STRIKE if run.completed else run.outcome
    times, hip = scene.compared
    position, velocity = run.trajectory.at(np.minimum(times, run.trajectory.time[-1]))
    return Apart(np.column_stack([position[:, :2], velocity[:, :2]]) - hip, float(strikes[0]))


def in_impact(scene: Scene, time: np.ndarray, *heel_strikes: float) -> np.ndarray:
    """Which times are from the first heel strike of all models to the end of the impact of the last one, (n,)."""
    all_strikes = (scene.heel_strike, *heel_strikes)
    return (time >= min(all_strikes)) & (time <= max(all_strikes) + scene.impact_window)


def sizes(time: np.ndarray, difference: np.ndarray, impact: np.ndarray) -> np.ndarray:
    """Largest magnitudes of a difference (m, 4) at times as in `largest_magnitudes`: x, y, and their rates at the times
    outside the impact, (4,)."""
    return np.concatenate([largest_magnitudes(time, difference[:, :2]), np.abs(difference[~impact, 2:]).max(axis=0)])


def forces_apart(scene: Scene, run: Run, heel_strike: float) -> np.ndarray:
    """Root mean square over a step's time, outside of the impact, of what friction and normal force of both feet differ
    by from the constraint model's, (2,) [N]; `heel_strike` is the run's [s].

    At the samples and at the run's own steps: these show how a foot bounces, and neither are even in time.
    """
    walk, own = scene.walk, run.trajectory.time
    events = np.concatenate([walk.heel_strike_time, walk.toe_off_time])
    time, ideal = sampled_at(walk.time, walk.ground_reaction.reshape(-1, 4), events,
                             np.union1d(scene.time, own[own <= scene.time[-1]]))  # fmt: skip
    force = ground_reaction(run.trajectory, time, scene.biped.foot_radii) - ideal.reshape(-1, 2, 2)
    squares, inside = (force**2).mean(axis=1), in_impact(scene, time, heel_strike)
    spans = np.diff(time) * ~(inside[1:] | inside[:-1])
    found: np.ndarray = np.sqrt(spans @ (squares[1:] + squares[:-1]) / (2.0 * spans.sum()))
    return found


def measure(scene: Scene, law: ContactLaw, run: Run) -> OneStep:
    """Differences of a step from the constraint model."""
    found = apart(scene, run)
    if isinstance(found, str):
        return unfinished(found, run.message, law, cost(scene, law))
    trajectory, radii = run.trajectory, scene.biped.foot_radii
    difference, impact = found.hip, in_impact(scene, scene.compared[0], found.heel_strike)
    whole = sizes(scene.compared[0], difference, impact)
    friction, normal = forces_apart(scene, run, found.heel_strike).tolist()
    _, _, slip = foot_kinematics(trajectory.position, trajectory.velocity, STANDING, radii[STANDING])
    before = trajectory.time < min(found.heel_strike, scene.heel_strike)
    span = trajectory.time[before]
    forces, depths = peaks(trajectory, law, radii, 0.0, float(trajectory.time[-1]))
    return OneStep(
        outcome=COMPLETED,
        message="",
        law=law,
        hip_position=whole[:2],
        hip_velocity=whole[2:],
        impact_velocity=np.abs(difference[impact, 2:]).max(axis=0, initial=0.0),
        end_position=difference[-1, :2],
        normal_force=normal,
        friction_force=friction,
        peak_force=float(forces[LANDING]),
        penetration=float(depths.max()),
        creep_velocity=float(np.trapezoid(np.abs(slip[before]), span) / (span[-1] - span[0])),
        heel_strike_lead=scene.heel_strike - found.heel_strike,
        evaluations=cost(scene, law),
    )
