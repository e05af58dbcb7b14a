"""Contact sets measured from the rigid limit: the search, its choice, and the choice's family towards the limit.

Tried is a grid of round values of k_c, c_max, d and v_s. The exponent and v_d stay at their defaults: k_c does what the
exponent would do, and a standing foot never slips as fast as v_d. A set keeps the limit of cost
if its step takes no more evaluations of the rates than `cost_limit` times the starting set's; of one that is dearer the
parts are not measured.

Of the sets that keep the limit, the few nearest to the rigid limit over one step are compared between their cycles too.
Chosen is the least sum of both distances. In that measure errors of opposite sign do not cancel. Creep holds the hip
back and an impact of finite stiffness sends it on, so a set can be tuned until they cancel over one step; the next
design, slope or step shows them again. Therefore each part is measured by itself, see `stages.ground.contact_law`. The
part of creep is twice what half of it changes, that of the impact twice what half of it changes (both are of first
order); the rest is what the two leave. The parts add up to the difference, and the sum of their sizes is the distance:
never less than the difference itself.
"""

import dataclasses
import itertools
import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from stages.contact_study.one_step import (
    Apart,
    ConstraintModel,
    Scene,
    apart,
    constraint_model,
    cost,
    hips,
    in_impact,
    sizes,
    take_step,
)
from stages.contact_study.parameters import Parameters, Settings
from stages.contact_study.result import (
    PARTS,
    SEARCHED,
    TOO_DEAR,
    Candidates,
    Distance,
    HardLimit,
    RigidLimit,
)
from stages.ground.contact_law import ContactLaw, family_member, with_creep, with_impact
from stages.ground.laws import PointLaw
from stages.ground.slope import Friction
from stages.planar.limit_cycle import fixed_point
from stages.planar.run import STEP_FLOOR
from stages.planar.section import NoLimitCycle, section_numbers
from stages.studies.result import COMPLETED, as_columns

#: What is left of a part when it is measured.
HALF = 0.5
#: Two numbers that differ by less, relatively, are one.
ROUND_OFF = 1e-9
NOT_SOUGHT = "not sought"
#: Steps by which a walker comes nearer to a cycle: with multipliers of .64 to a fifteenth of the distance.
NEARER = 6
#: Share of the time that the search takes.
SHARE_OF_SEARCH = 0.7


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
        scene, time = self.scene, self.scene.compared[0]
        walked = take_step(scene, law, signals=())
        found, whole = unmeasured(law, COMPLETED, cost(scene, law, walked)), apart(scene, walked)
        if isinstance(whole, str):
            return dataclasses.replace(found, outcome=whole)
        size = sizes(time, whole.hip, in_impact(scene, time, whole.heel_strike))
        found = dataclasses.replace(
            found, hip_position=size[:2], hip_velocity=size[2:], end_position=whole.hip[-1, :2])
        if not worth(found):
            return found
        fewer = [apart(scene, take_step(scene, less, ())) for less in halves(law)]
        known = [one for one in fewer if isinstance(one, Apart)]
        if len(known) < len(fewer):
            return found
        impact = in_impact(scene, time, whole.heel_strike, *(one.heel_strike for one in known))
        split = [sizes(time, part, impact) for part in parts(whole.hip, *(one.hip for one in known))]
        position, velocity = (np.array(split)[:, each].max(axis=1) for each in (slice(0, 2), slice(2, 4)))
        score = step_score(position, velocity, self.settings)
        return dataclasses.replace(found, position_parts=position, velocity_parts=velocity, step_score=score)

    def between_cycles(self, found: Distance, *, split: bool) -> Distance:
        """The same set with the distance of its solved cycle from the limit's, with `split` in parts."""
        try:
            differences = [self._cycle(law) for law in (found.law, *(halves(found.law) if split else ()))]
        except NoLimitCycle as reason:
            return dataclasses.replace(found, cycle_outcome=str(reason))
        period, length = differences[0].tolist()
        known = dataclasses.replace(found, cycle_outcome=COMPLETED, period=period, step_length=length)
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
        upright = dataclasses.replace(self.scene.upright, mid_stance=self.limit.mid_stance)
        stepper = upright.stepper(law, self.scene.solver)
        try:
            found = fixed_point(stepper, section_numbers(stepper.start), self.derivative)
        except NoLimitCycle:
            found = fixed_point(stepper, stepper.walk(stepper.start, NEARER).numbers)
        self.derivative = found.derivative
        return np.array([found.step.period - self.limit.period, found.step.step_length - self.limit.length])


def halves(law: ContactLaw) -> tuple[ContactLaw, ContactLaw]:
    """The law with half its creep, and with half of what its finite stiffness does."""
    return with_creep(law, HALF), with_impact(law, HALF)


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


def grid(default: ContactLaw, settings: Settings) -> Iterator[ContactLaw]:
    """All contact laws of the search; of those that differ in what they do not use alone, the first."""
    options = (
        settings.searched_stiffness,
        settings.searched_damping,
        settings.searched_depth,
        settings.searched_stiction_velocity,
    )
    once: dict[PointLaw, ContactLaw] = {}
    for values in itertools.product(*options):
        changes: dict[str, Any] = dict(zip(SEARCHED, values))
        law = dataclasses.replace(default, **changes)
        once.setdefault(law.numbers, law)
    yield from once.values()


def choose(
    default: Distance,
    settings: Settings,
    over_a_step: Callable[[ContactLaw, Callable[[Distance], bool]], Distance],
    between_cycles: Callable[[Distance], Distance],
    said: Callable[[float], None] = lambda fraction: None,
) -> tuple[Distance, tuple[Distance, ...], Candidates]:
    """The chosen set, those compared between cycles, best first, and all tried; `said` hears the fraction done.

    `default` is the starting set: it is the choice if no other walks and keeps the limit of cost.
    """
    laws = list(grid(default.law, settings))
    dear = settings.cost_limit * default.evaluations
    tried: list[Distance] = []
    for index, law in enumerate(laws):
        said(index / len(laws))
        found = over_a_step(law, lambda one: one.evaluations <= dear)
        if found.outcome == STEP_FLOOR or found.evaluations > dear:
            found = dataclasses.replace(found, outcome=TOO_DEAR)
        tried.append(found)
    eligible = sorted((one for one in tried if np.isfinite(one.step_score)), key=lambda one: one.step_score)
    finalists = sorted(map(between_cycles, eligible[: settings.finalists]), key=lambda one: (one.score, one.step_score))
    rows = [{**vars(one), "score": one.step_score, **{key: getattr(one.law, key) for key in SEARCHED}} for one in tried]
    return finalists[0] if finalists else default, tuple(finalists), as_columns(Candidates, rows)


def from_rigid_limit(
    parameters: Parameters, scene: Scene, said: Callable[[float], None]
) -> tuple[RigidLimit, Candidates]:
    """The search and its choice, all measured from the rigid limit. Raises NoGait or StepFailed if there is none,
    BeyondModel for a hip that rubs."""
    settings = parameters.settings

    def constraints(friction: Friction | None) -> ConstraintModel:
        return constraint_model(
            parameters.biped, parameters.slope, friction, scene.mid_stance, parameters.constraint_tolerance,
            settings.sampling_rate_hz,
        )  # fmt: skip

    rolling, coulomb = constraints(None), constraints(parameters.contact.coefficients)
    beside = dataclasses.replace(scene, walk=coulomb.walk, model=coulomb)
    ruler = Ruler(beside, coulomb, settings)
    law = parameters.default_set.law(parameters.contact)
    default = ruler.over_a_step(law)
    chosen, finalists, candidates = choose(
        default,
        settings,
        ruler.over_a_step,
        lambda found: ruler.between_cycles(found, split=True),
        lambda done: said(SHARE_OF_SEARCH * done),
    )
    family: list[Distance] = []
    for share in settings.family_shares:
        said(SHARE_OF_SEARCH + (1 - SHARE_OF_SEARCH) * len(family) / len(settings.family_shares))
        law = family_member(chosen.law, share)
        family.append(chosen if share == 1.0 else ruler.between_cycles(ruler.over_a_step(law), split=False))
    ground = parameters.contact
    return RigidLimit(
        hard=hard_limit(beside, rolling, coulomb),
        default=ruler.between_cycles(default, split=False),
        chosen=chosen,
        ground=chosen if same_set(ground, chosen.law) else ruler.between_cycles(ruler.over_a_step(ground), split=True),
        most_evaluations=settings.cost_limit * default.evaluations,
        finalists=finalists,
        family_share=np.array(settings.family_shares),
        family=tuple(family),
    ), candidates


def same_set(one: ContactLaw, other: ContactLaw) -> bool:
    """Whether two laws are one: what a law does not use may differ, and all by round-off of a robot's scales."""
    mine, theirs = one.numbers, other.numbers
    if (type(mine.normal), type(mine.friction)) != (type(theirs.normal), type(theirs.friction)):
        return False
    pairs = zip((*mine.normal, *mine.friction, mine.stiction_velocity),
                (*theirs.normal, *theirs.friction, theirs.stiction_velocity), strict=True)  # fmt: skip
    return all(math.isclose(number, another, rel_tol=ROUND_OFF) for number, another in pairs)
