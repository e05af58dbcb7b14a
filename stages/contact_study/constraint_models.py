"""The constraint model with rolling feet and with Coulomb's transition: a step from a common state, and their gaits.

The second is what the penalty model tends to as its contact hardens: the same friction, no depth, no creep. What sets
it apart from rolling feet is therefore what no contact parameter can remove.
"""

from __future__ import annotations

from dataclasses import dataclass

from stages.analytic.gait.gait_search import find_gait, step_length
from stages.analytic.walk.recording import crossing_state, walk_on
from stages.analytic.walk.sampling import sample_walk
from stages.biped.design import Biped
from stages.biped.gait import StanceState
from stages.biped.walk import Walk
from stages.ground.friction_coefficients import Friction
from stages.ground.slope import Slope


@dataclass(frozen=True)
class ConstraintModel:
    """A step from the common mid-stance state; period [s] and length [m] of the model's gait, and its mid-stance."""

    walk: Walk
    period: float
    length: float
    mid_stance: StanceState


def constraint_model(
    biped: Biped, slope: Slope, friction: Friction | None, start: StanceState, tolerance: float, rate: float
) -> ConstraintModel:
    """The model, whose trailing foot slips if there is `friction`, walked from `start` and sampled at `rate` [Hz].

    Raises NoGait or StepFailed.
    """
    walker, point = find_gait(biped, slope, tolerance, friction)
    return ConstraintModel(
        sample_walk(walker, walk_on(walker, walker.from_stance(start), 1, tolerance), rate),
        float(point.steps[0].period * walker.time),
        float(step_length(walker, point) * walker.length),
        walker.stance_state(crossing_state(walker, point.z, tolerance)),
    )
