"""Contact sets measured from the rigid limit: the search, its choice, and the choice's family towards the limit."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np

from stages.contact_study.choice import choose
from stages.contact_study.constraint_models import ConstraintModel, constraint_model
from stages.contact_study.distance import Ruler, hard_limit
from stages.contact_study.limit_result import Candidates, Distance, RigidLimit
from stages.contact_study.one_step import Scene
from stages.contact_study.parameters import Parameters
from stages.contact_study.result import VARIED
from stages.ground.contact_law import ContactLaw
from stages.ground.friction_coefficients import Friction
from stages.ground.hardening import family_member

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
