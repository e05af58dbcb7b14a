"""The criterion by which a contact set is chosen, and the search that applies it.

Score: largest hip displacement and hip velocity difference from the constraint model and rms difference of the normal
forces, each in its limit, added. A choice must keep two limits, of penetration and of cost,
both in those of the starting set. Chosen is the least score
on a grid of round values of k_c, c_max, d and v_s: a descent from Adams' defaults ends elsewhere, since creep and the
slip at heel strike move the hip in opposite directions. The exponent and v_d stay at their defaults: k_c does what the
exponent would do, and a standing foot never slips as fast as v_d.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from stages.contact_study.parameters import Settings
from stages.contact_study.result import SEARCHED, Candidates, OneStep
from stages.ground.contact_law import ContactLaw
from stages.multibody.walking.scuffing import STEP_FLOOR

#: Outcome of a set that takes more solver steps than a choice may take: the search gives it up.
TOO_DEAR = "too dear"


def score(step: OneStep, settings: Settings) -> float:
    """Differences from the constraint model, each in its limit, added; infinite if the step was not finished."""
    if not step.completed:
        return math.inf
    return float(
        step.hip_position.max() / settings.position_limit
        + step.hip_velocity.max() / settings.velocity_limit
        + step.normal_force / settings.force_limit
    )


def excess(step: OneStep, settings: Settings, default: OneStep) -> float:
    """The larger part by which a step breaks the limits of penetration and cost; infinite if it was not finished."""
    if not step.completed:
        return math.inf
    deep = step.penetration / (settings.penetration_limit * default.penetration)
    dear = step.solver_steps / (settings.cost_limit * default.solver_steps)
    return max(0.0, deep - 1.0, dear - 1.0)


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
    default: OneStep,
    settings: Settings,
    try_law: Callable[[ContactLaw], OneStep],
    said: Callable[[float], None] = lambda fraction: None,
) -> tuple[ContactLaw, Candidates]:
    """The chosen law and all sets tried; `default` is the starting set's step, `said` hears the fraction done.

    If no set keeps the limits, the one that breaks them least is chosen.
    """
    laws = list(grid(default.law, settings))
    steps = []
    for index, law in enumerate(laws):
        said(index / len(laws))
        steps.append(try_law(law))
    excesses = np.array([excess(step, settings, default) for step in steps])
    scores = np.array([score(step, settings) for step in steps])
    best = laws[int(np.lexsort((scores, excesses))[0])]
    return best, Candidates(
        **{key: np.array([getattr(law, key) for law in laws]) for key in SEARCHED},
        outcome=tuple(TOO_DEAR if step.outcome == STEP_FLOOR else step.outcome for step in steps),
        hip_position=np.array([step.hip_position.max() for step in steps]),
        hip_velocity=np.array([step.hip_velocity.max() for step in steps]),
        normal_force=np.array([step.normal_force for step in steps]),
        penetration=np.array([step.penetration for step in steps]),
        solver_steps=np.array([step.solver_steps for step in steps], dtype=np.int64),
        excess=excesses,
        score=scores,
    )
