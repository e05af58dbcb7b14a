"""How far a contact set is from the rigid limit, by a measure in which errors of opposite sign do not cancel.

Creep holds the hip back and an impact of finite stiffness sends it on, so a set can be tuned until they cancel over
one step; the next design, slope or step shows them again. Therefore each part is measured by itself, see
`stages.ground.hardening`. The part of creep is twice what half of it changes, that of the impact twice what half of it
changes (both are of first order); the rest is what the two leave. The parts add up to the difference, and the sum of
their sizes is the distance: never less than the difference itself.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np

from stages.contact_study.constraint_models import ConstraintModel, hips
from stages.contact_study.limit_result import COMPLETED, PARTS, Distance, HardLimit
from stages.contact_study.one_step import HipCurve, Scene, cost, hip_curve, in_impact, sizes, take_step
from stages.contact_study.parameters import Settings
from stages.ground.contact_law import ContactLaw
from stages.ground.hardening import with_creep, with_impact
from stages.penalty.step_map import PenaltyStepper
from stages.planar.limit_cycle import fixed_point
from stages.planar.section import NoLimitCycle, section_numbers
from stages.planar.state import PlanarState, rolling_state

#: What is left of a part when it is measured.
HALF = 0.5
NOT_SOUGHT = "not sought"
#: Steps by which a walker comes nearer to a cycle: with multipliers of .64 to a fifteenth of the distance.
NEARER = 6


def parts(difference: np.ndarray, less_creep: np.ndarray, less_impact: np.ndarray) -> np.ndarray:
    """A difference from the limit split into `PARTS`, (3, ...), from what is left with half of creep and of impact."""
    creep, impact = ((difference - less) / (1.0 - HALF) for less in (less_creep, less_impact))
    return np.array([creep, impact, difference - creep - impact])


def step_score(position: np.ndarray, velocity: np.ndarray, settings: Settings) -> float:
    """Sizes of all parts, (3,) [m] and [m/s], in the limits of position and velocity, added."""
    return float(position.sum() / settings.position_limit + velocity.sum() / settings.velocity_limit)


def cycle_score(period: np.ndarray, length: np.ndarray, speed: float, settings: Settings) -> float:
    """Sizes of all parts of period and length, (3,) [s] and [m], as ways of the hip in the limit of position, added."""
    return float((speed * np.abs(period) + np.abs(length)).sum() / settings.position_limit)


def hard_limit(scene: Scene, rolling: ConstraintModel, coulomb: ConstraintModel) -> HardLimit:
    """What sets the limit apart from rolling feet; `scene` holds the limit's own walk."""
    time, (limit, rolls) = hips([coulomb, rolling], np.unique(scene.compared[0]))
    difference = limit - rolls
    found = sizes(time, difference, in_impact(scene, time, float(rolling.walk.heel_strike_time[0])))
    return HardLimit(
        hip_position=found[:2],
        hip_velocity=found[2:],
        end_position=difference[-1, :2],
        period=coulomb.period - rolling.period,
        step_length=coulomb.length - rolling.length,
        limit_period=coulomb.period,
        limit_step_length=coulomb.length,
    )


class Ruler:
    """Walks contact sets beside the limit; `scene` holds the limit's own walk."""

    def __init__(self, scene: Scene, limit: ConstraintModel, settings: Settings) -> None:
        self.scene, self.limit, self.settings = scene, limit, settings
        self.derivative: np.ndarray | None = None

    def over_a_step(self, law: ContactLaw, worth: Callable[[Distance], bool] = lambda found: True) -> Distance:
        """Distance over one step; in parts if the set is `worth` two steps more."""
        scene = self.scene
        walked = take_step(scene, law, signals=())
        evaluations = cost(scene, law, walked)
        curve = hip_curve(scene, walked)
        if isinstance(curve, str):
            return unmeasured(law, curve, evaluations)
        time, difference = scene.compared[0], curve.minus(scene)
        whole = sizes(time, difference, in_impact(scene, time, curve.heel_strike))
        found = dataclasses.replace(
            unmeasured(law, COMPLETED, evaluations),
            hip_position=whole[:2],
            hip_velocity=whole[2:],
            end_position=difference[-1, :2],
        )
        if not worth(found):
            return found
        fewer = [hip_curve(scene, take_step(scene, less(law, HALF), ())) for less in (with_creep, with_impact)]
        known = [one for one in fewer if isinstance(one, HipCurve)]
        if len(known) < len(fewer):
            return found
        split = parts(difference, *(one.minus(scene) for one in known))
        impact = in_impact(scene, time, curve.heel_strike, *(one.heel_strike for one in known))
        found_parts = np.array([sizes(time, one, impact) for one in split])
        position, velocity = found_parts[:, :2].max(axis=1), found_parts[:, 2:].max(axis=1)
        score = step_score(position, velocity, self.settings)
        return dataclasses.replace(found, position_parts=position, velocity_parts=velocity, step_score=score)

    def between_cycles(self, found: Distance, *, split: bool) -> Distance:
        """The same set with the distance of its solved cycle from the limit's, with `split` in parts."""
        laws = [found.law, *((less(found.law, HALF) for less in (with_creep, with_impact)) if split else ())]
        try:
            differences = [self._cycle(law) for law in laws]
        except NoLimitCycle as reason:
            return dataclasses.replace(found, cycle_outcome=str(reason))
        period, length = differences[0]
        known = dataclasses.replace(found, cycle_outcome=COMPLETED, period=float(period), step_length=float(length))
        if not split:
            return known
        periods, lengths = parts(*differences).T
        score = cycle_score(periods, lengths, self.limit.length / self.limit.period, self.settings)
        return dataclasses.replace(known, period_parts=periods, length_parts=lengths, cycle_score=score)

    def _cycle(self, law: ContactLaw) -> np.ndarray:
        """Period [s] and length [m] of a set's cycle less the limit's, (2,). Raises NoLimitCycle.

        The step's derivative is kept from the set before. If it does not lead to the cycle, the walker comes nearer by
        some steps of its own, and a derivative is made there.
        """
        scene = self.scene
        start: PlanarState = rolling_state(scene.biped, law, self.limit.mid_stance, scene.walk.standing_force)
        stepper = PenaltyStepper(scene.biped, scene.slope, law, start, scene.solver)
        numbers = section_numbers(start)
        try:
            found = fixed_point(stepper, numbers, self.derivative)
        except NoLimitCycle:
            found = fixed_point(stepper, stepper.walk(start, NEARER).numbers)
        self.derivative = found.derivative
        return np.array([found.step.duration - self.limit.period, found.step.length - self.limit.length])


def unmeasured(law: ContactLaw, outcome: str, evaluations: int) -> Distance:
    """A set of which nothing is known but its outcome and cost."""
    nothing, pair, three = float("nan"), np.full(2, np.nan), np.full(len(PARTS), np.nan)
    return Distance(
        law=law,
        outcome=outcome,
        evaluations=evaluations,
        hip_position=pair,
        hip_velocity=pair,
        end_position=pair,
        position_parts=three,
        velocity_parts=three,
        step_score=float("inf"),
        cycle_outcome=NOT_SOUGHT,
        period=nothing,
        step_length=nothing,
        period_parts=three,
        length_parts=three,
        cycle_score=float("inf"),
    )
