"""Friction that a gait needs in single stance, cheaply."""

from __future__ import annotations

import numpy as np

from stages.analytic.errors import StepFailed
from stages.analytic.gait.gait_report import record_steps
from stages.analytic.gait.poincare import FixedPoint
from stages.analytic.model.walker import Walker
from stages.analytic.walk.recording import Segment, is_last, states_at
from stages.analytic.walk.sampling import accelerations_and_forces
from stages.analytic.walk.validity import friction_used


def friction_needed(walker: Walker, point: FixedPoint, tolerance: float) -> float:
    """Largest |tangential| / normal in single stance, at the integrator's steps, amid them, and at heel strike.

    Infinite where the ground would pull. `validity.assess` samples three times as densely. NaN where the step cannot be
    taken again.
    """
    try:
        segments = record_steps(walker, point, tolerance)
    except StepFailed:
        return float("nan")
    return max(needed_in(walker.on(each.stance_leg), each) for each in segments if is_last(each))


def needed_in(walker: Walker, single: Segment) -> float:
    """The same in one single stance; `walker` is the one in its step."""
    edges = np.append(single.times, single.duration)
    amid = states_at(single.phase, single.times, single.states, (edges[1:] + edges[:-1]) / 2, walker.p)
    states = np.concatenate([single.states, amid, single.end[None]])
    return friction_used(accelerations_and_forces(single.phase, states, walker.p)[:, 4:6])
