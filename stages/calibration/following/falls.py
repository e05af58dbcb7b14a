"""Whether a robot will fall: states drawn from what is known of one at its next heel strike walk on, step by step.

Of the robot itself and its ground only the mean is walked. A fall is what the step map says: a step that has no end.
"""

from __future__ import annotations

import numpy as np

from stages.analytic.errors import StepFailed
from stages.analytic.gait.poincare import poincare_map
from stages.analytic.model.walker import Vector, Walker
from stages.analytic.phases.section import section_coordinates
from stages.analytic.phases.succession import single_stance, succeed
from stages.calibration.following.present import landing
from stages.calibration.observation.prediction import Walked

#: Steps that are looked ahead; states that are drawn, and how many of them first: where these do alike, so do all.
STEPS, DRAWN, FIRST = 3, 60, 8
#: Falls are found with steps that are solved to this.
LOOSE = 1e-5


def falls(walked: Walked, moved: Vector, covariance: np.ndarray, steps: int = STEPS) -> Vector:
    """Probabilities (steps,) to fall in the first, the first two and so on of the steps after a walk's first strike.

    The walk's unknowns are `moved` (n,) from its own, with a covariance; NaN where it does not come to a strike.
    """
    if not any(one.ends_step for one in walked.stretches):
        return np.full(steps, np.nan)
    leg, mean, spread = landing(walked, 0, moved, covariance)
    values, vectors = np.linalg.eigh(spread)
    spread = vectors * np.sqrt(np.maximum(values, 0.0))
    chance = np.random.default_rng(0).normal(size=(DRAWN, len(mean)))
    walker, other = walked.walker.on(leg), walked.walker.on(1 - leg)
    last = np.array([_last(mean + spread @ one, walker, other, steps) for one in chance[:FIRST]])
    if np.ptp(last) > 0:
        more = [_last(mean + spread @ one, walker, other, steps) for one in chance[FIRST:]]
        last = np.append(last, more)
    return np.asarray((last[:, None] <= np.arange(steps)).mean(axis=0))


def _last(before: Vector, walker: Walker, other: Walker, steps: int) -> int:
    """Whole steps, so many at most, after a state (size,) just before a heel strike."""
    state, taken = before.copy(), 0
    _, decided = succeed(int(single_stance(state, walker.p)), state, walker.p, None)
    try:
        z = section_coordinates(state, other.p)
        while decided and taken < steps:
            z, other, taken = poincare_map(other, z, LOOSE).z, other.exchanged, taken + 1
    except StepFailed:
        pass
    return taken
