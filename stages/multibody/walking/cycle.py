"""The settled gait of a multibody walk: means over its last steps."""

from __future__ import annotations

import numpy as np

from stages.biped.walk import Walk
from stages.multibody.assembly.solver import Run
from stages.multibody.result import Cycle
from stages.multibody.walking.trajectory import foot_kinematics

SETTLED_STEPS = 4


def settled_cycle(walked: Run, walk: Walk, radius: float) -> Cycle:
    """Measures over the last four whole steps, or fewer if there are no more; peaks at the solver's own steps."""
    strikes = walk.heel_strike_time
    count = min(SETTLED_STEPS, len(strikes) - 1)
    if count < 1:
        return Cycle(*[float("nan")] * 8)
    last = strikes[-1 - count :]
    periods = np.diff(last)
    period = float(periods.mean())
    hip = walked.trajectory.at(last)[0][:, 0]
    length = float((hip[-1] - hip[0]) / count)
    inside = (walked.trajectory.time >= last[0]) & (walked.trajectory.time <= last[-1])
    held = walked.trajectory.in_play(walked.trajectory.time)
    rows = walked.trajectory.position, walked.trajectory.velocity
    depth = np.column_stack([foot_kinematics(*rows, leg, radius)[0] for leg in (0, 1)])
    force = walked.trajectory.ground_reaction[inside, :, 1]
    return Cycle(
        period_s=period,
        step_frequency_hz=1.0 / period,
        step_length_m=length,
        speed_m_s=length / period,
        double_stance_s=walk.double_stance(last),
        peak_normal_force=float(force.max()) if force.size else float("nan"),
        largest_penetration=float(np.where(held, depth, 0.0)[inside].max()),
        period_change=float(np.ptp(periods)),
    )
