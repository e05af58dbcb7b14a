"""The constraint model with rolling feet and with Coulomb's transition: a step from a common state, and their gaits.

The second is what the penalty model tends to as its contact hardens: the same friction, no depth, no creep. What sets
it apart from rolling feet is therefore what no contact parameter can remove.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from stages.analytic.gait.gait_search import find_gait, step_length
from stages.analytic.model.walker import Walker
from stages.analytic.walk.recording import Segment, crossing_state, walk_on
from stages.analytic.walk.sampling import sample_segment, sample_walk, signal_scales
from stages.biped.design import Biped
from stages.biped.gait import StanceState
from stages.biped.largest import SAME
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
        float(point.steps[0].period * walker.time),
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
