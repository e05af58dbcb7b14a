"""Contact sets measured from the rigid limit: the search, its choice, and the choice's family towards the limit.

Tried is a grid of round values of k_c, c_max, d and v_s. The exponent and v_d stay at their defaults: k_c does what the
exponent would do, and a standing foot never slips as fast as v_d. A set keeps the limit of cost
if its step takes no more solver steps than so many of the starting set's. The less a foot creeps the more it costs, so
of sets that differ in v_s alone none below the first that is too dear is walked.

Of the sets that keep the limit, the few nearest to the rigid limit over one step are compared between their cycles too.
Chosen is the least sum of both distances, see `stages.contact_study.distance`.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from stages.contact_study.constraint_models import ConstraintModel, constraint_model
from stages.contact_study.distance import Ruler, hard_limit
from stages.contact_study.limit_result import SEARCHED, TOO_DEAR, Candidates, Distance, RigidLimit
from stages.contact_study.one_step import Scene
from stages.contact_study.parameters import Parameters, Settings
from stages.contact_study.result import VARIED
from stages.ground.contact_law import ContactLaw
from stages.ground.friction_coefficients import Friction
from stages.ground.hardening import family_member
from stages.planar.run import STEP_FLOOR


def grid(default: ContactLaw, settings: Settings) -> Iterator[ContactLaw]:
    """All contact laws of the search."""
    options = (
        settings.searched_stiffness,
        settings.searched_damping,
        settings.searched_depth,
        settings.searched_stiction_velocity,
    )
    for values in itertools.product(*options):
        changes: dict[str, Any] = dict(zip(SEARCHED, values))
        yield dataclasses.replace(default, **changes)


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
    return finalists[0] if finalists else default, tuple(finalists), columns(tried)


def columns(tried: list[Distance]) -> Candidates:
    """The sets tried as columns."""

    def column(name: str) -> np.ndarray:
        return np.array([getattr(one, name) for one in tried])

    return Candidates(
        **{key: np.array([getattr(one.law, key) for one in tried]) for key in SEARCHED},
        outcome=tuple(one.outcome for one in tried),
        hip_position=column("hip_position"),
        hip_velocity=column("hip_velocity"),
        position_parts=column("position_parts"),
        velocity_parts=column("velocity_parts"),
        evaluations=column("evaluations"),
        score=column("step_score"),
    )


SHARE_OF_SEARCH = 0.7


def from_rigid_limit(
    parameters: Parameters, scene: Scene, said: Callable[[float], None]
) -> tuple[RigidLimit, Candidates]:
    """The search and its choice, all measured from the rigid limit. Raises NoGait or StepFailed if there is none."""
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
    """Whether two laws have the same values of all parameters that the study varies."""
    return all(getattr(one, key) == getattr(other, key) for key in VARIED)
