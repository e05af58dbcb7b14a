"""What derivatives by all parameters cost: one step alone, with derivatives by its state, and with all others.

    python -m benchmarks.sensitivity_cost

Table 1 with rolling, with limited friction and with rigid legs, each from its gait. Processor time of one step, the
best of many rounds. Then the differences that the derivatives replace, and the derivatives of the multipliers.
"""

import dataclasses

from benchmarks.analytic_step import TABLE_1, best_time
from stages.analytic.derivatives.gait import gait_derivatives, step_tangents
from stages.analytic.derivatives.multipliers import multiplier_derivatives
from stages.analytic.derivatives.numbers import changes_of, sensitive_names
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.gait_search import find_gait
from stages.analytic.gait.poincare import poincare_derivative, poincare_map
from stages.ground.slope import Friction, Slope

SLOPE, FRICTION = Slope(slope_deg=2.0, gravity=9.81), Friction(static_friction=1.1, dynamic_friction=1.0)
#: Calls of a round, and rounds.
ROUNDS = 30, 30
WALKERS = (("rolling", "compliant", None), ("limited friction", "compliant", FRICTION), ("rigid", "rigid", None))


def main() -> None:
    print(f"{'walker':18}{'tolerance':>10}{'map us':>9}{'state us':>10}{'parameters':>12}{'all us':>9}{'ratio':>7}"
          f"{'differences us':>16}{'multipliers ms':>16}")
    for name, legs, friction in WALKERS:
        design = DesignPoint(dataclasses.replace(TABLE_1, legs=legs), SLOPE, friction)
        names = sensitive_names(design)
        changes = changes_of(design, names)
        for tolerance in (1e-8, 1e-10, 1e-12):
            walker, point = find_gait(design.biped, SLOPE, tolerance, friction)
            alone = best_time(lambda w=walker, z=point.z, t=tolerance: poincare_map(w, z, t), *ROUNDS)
            state = best_time(lambda w=walker, z=point.z, t=tolerance: poincare_derivative(w, z, t), *ROUNDS)
            every = best_time(
                lambda w=walker, z=point.z, a=changes.along, t=tolerance: step_tangents(w, z, a, t), *ROUNDS)
            gait = gait_derivatives(design, point, names, tolerance)
            multipliers = best_time(lambda g=gait: multiplier_derivatives(g), 1, 5)
            print(f"{name:18}{tolerance:10.0e}{1e6 * alone:9.0f}{1e6 * state:10.0f}{len(names):12d}{1e6 * every:9.0f}"
                  f"{every / state:7.2f}{2e6 * alone * (len(names) + point.z.size):16.0f}{1e3 * multipliers:16.0f}")


if __name__ == "__main__":
    main()
