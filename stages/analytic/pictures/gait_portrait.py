"""Gaits of one design: phase portrait of a leg, and the ground reaction, over one stride each."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from stages.analytic.gait.poincare import FixedPoint
from stages.analytic.model.walker import Walker
from stages.analytic.phases.section import section_state
from stages.analytic.walk.recording import record
from stages.analytic.walk.sampling import sample_walk
from stages.drawing import style

COLOURS = (style.ANALYTIC, style.MULTIBODY, style.SECOND, style.THIRD)


def draw(walker: Walker, points: Sequence[FixedPoint], tolerance: float, rate_hz: float = 2000.0) -> Figure:
    """Full lines are stable gaits, dashed ones unstable; the ground carries one foot at a time but in double stance."""
    figure, (portrait, force) = plt.subplots(1, 2, figsize=(style.TWO_COLUMNS, 3.2))
    for number, (point, colour) in enumerate(zip(points, COLOURS * len(points), strict=False), 1):
        largest = float(np.abs(point.floquet_multipliers).max())
        line = "-" if largest < 1 else (0, (3, 2))
        start = section_state(point.z, walker.p)
        walk = sample_walk(walker, record(walker, start, 2, tolerance), rate_hz)
        label = f"gait {number}: |multiplier| {largest:.3g}"
        portrait.plot(np.degrees(walk.leg_angle[:, 0]), walk.leg_rate[:, 0], color=colour, linestyle=line, label=label)
        force.plot(walk.time, walk.ground_reaction[:, 0, 1], color=colour, linestyle=line)
    portrait.set_xlabel("leg angle, foot ahead positive [°]")
    portrait.set_ylabel("leg rate [rad/s]")
    force.set_xlabel("time since heel strike [s]")
    force.set_ylabel("normal force on that leg's foot [N]")
    figure.legend(*portrait.get_legend_handles_labels(), loc="outside upper center", ncols=3)
    return figure
