"""What constraints differentiated twice describe if no impact first stops the landing foot.

They ask for s'' = 0 only, so they keep whatever s' the foot lands with: its slip and its descent. The paper names no
impact map. Here, integrated from the state before heel strike, the foot that has stood goes on rolling, and the landing
foot moves on as it came.
"""

from __future__ import annotations

import numpy as np

from stages.analytic.integration.integrator import STAGES, take_step
from stages.analytic.model.kinds import Rigid
from stages.analytic.model.walker import Walker
from stages.analytic.phases.flow import DOUBLE_STANCE, contact_directions, flow
from stages.analytic.phases.succession import in_contact
from stages.analytic.phases.transitions import foot_clearance
from stages.analytic.result import WithoutImpact
from stages.analytic.walk.recording import Segment, is_last

STEPS = 100


def without_impact(walker: Walker, segments: list[Segment]) -> WithoutImpact:
    """From the segments of a gait's steps, heel strike to heel strike: the last landing foot before and after."""
    single, begun = segments[-1], max((n + 1 for n, one in enumerate(segments[:-1]) if is_last(one)), default=0)
    p = walker.on(single.stance_leg).p
    duration = sum(segment.duration for segment in segments[begun:] if in_contact(segment.phase))
    if isinstance(p, Rigid) or not duration > 0.0:
        return WithoutImpact(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    state, new, stages = single.end.copy(), np.empty(walker.size), np.empty((STAGES, walker.size))

    def landing_foot(y: np.ndarray) -> tuple[float, float, float]:
        clearance, rate, _ = foot_clearance(y, p, y, 4)
        return float(np.dot(contact_directions(y, p)[1], y[4:8])), -float(rate), -float(clearance)

    slip, descent, _ = landing_foot(state)
    for _ in range(STEPS):  # far below a hundredth of the legs' own period: exact to round-off without error control
        flow(DOUBLE_STANCE, state, p, stages[0])
        take_step(DOUBLE_STANCE, state, duration / STEPS, p, stages, new)
        state, new = new, state
    slip_then, descent_then, depth = landing_foot(state)
    speed = walker.length / walker.time
    return WithoutImpact(
        duration=duration * walker.time,
        slip_at_landing=slip * speed,
        descent_at_landing=descent * speed,
        slip_at_end=slip_then * speed,
        descent_at_end=descent_then * speed,
        depth_at_end=depth * walker.length,
    )
