"""The gait over all slopes that a rounded one may stand for. Half a degree in two is no small change: it is solved."""

from __future__ import annotations

import numpy as np

from stages.analytic.derivatives.gait import VariedGait
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.gait_search import describe
from stages.analytic.gait.newton import SEARCH_TOLERANCE
from stages.analytic.gait.poincare import FixedPoint, fixed_point
from stages.analytic.model.stiffness import attainable_tolerance
from stages.analytic.model.walker import Walker

SLOPE = "ground.slope_deg"
#: The numbers of a gait with an elasticity.
MEASURES = ("period_s", "step_frequency_hz", "step_length_m", "speed_m_s")
#: Gaits solved on the way to either edge.
PARTS = 8


def numbers_at(walker: Walker, point: FixedPoint, multipliers: int) -> dict[str, float]:
    """Measures, magnitudes of the first multipliers, and the state just after heel strike, in SI units."""
    described = describe(walker, point)
    numbers = {name: float(getattr(described, name)) for name in MEASURES}
    magnitudes = np.abs(point.floquet_multipliers[:multipliers])
    numbers |= {f"multiplier_{index}": float(value) for index, value in enumerate(magnitudes, 1)}
    return numbers | vars(described.fixed_point)


def over_slopes(
    design: DesignPoint, gait: VariedGait, half_width: float, multipliers: int
) -> dict[str, tuple[float, float]]:
    """Least and most of each number of the gait on slopes within `half_width` [deg]; NaN if the gait is lost there.

    Of `PARTS` gaits to either side, which the tangent and then the last two lead to. Multipliers by their rank.
    """
    row = gait.changes.names.index(SLOPE)
    tangent = gait.z[:, row] / gait.changes.scales[row]
    seen = [numbers_at(gait.walker, gait.point, multipliers)]
    for edge in (-half_width, half_width):
        before, z, change = gait.point.z, gait.point.z, tangent * edge / PARTS
        for part in range(1, PARTS + 1):
            there = design.with_value(SLOPE, design.value(SLOPE) + edge * part / PARTS)
            walker = there.walker()
            point = None
            if there.is_legal() and there.slope.angle > 0.0:
                point = fixed_point(walker, z + change, attainable_tolerance(walker.p, SEARCH_TOLERANCE))
            if point is None:
                return dict.fromkeys(seen[0], (np.nan, np.nan))
            before, z = z, point.z
            change = z - before
            seen.append(numbers_at(walker, point, multipliers))
    return {name: (min(one[name] for one in seen), max(one[name] for one in seen)) for name in seen[0]}
