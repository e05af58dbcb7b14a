"""Cost of one step of the walk with explicit and with implicit integration steps, as the legs become stiffer.

    python -m benchmarks.stiff_legs

Prints a table: for each design the fastest axial rate and its decay, the time of one step with either integrator,
their difference in the period, and which one the study takes by itself.
"""

from __future__ import annotations

import dataclasses
import math
import time

import numpy as np

from stages.analytic.gait.poincare import poincare_map
from stages.analytic.gait.search_starts import lengths_after_heel_strike
from stages.analytic.model.kinds import PlainCompliant, StiffPlain
from stages.analytic.model.stiffness import axial_rates
from stages.analytic.model.walker import Walker, build_walker
from stages.biped.design import Biped
from stages.ground.slope import Slope

DAMPING = (58.35, 300.0, 600.0, 1e3, 2e3, 5e3, 1e4, 1e5)
STIFFNESS = (1e5, 3e5, 1e6, 1e7, 1e8, 1e9, 1e10)
#: Damping of the second series, as a share of the critical one of hip and foot against each other.
RATIOS = (0.9, 0.25, 0.1, 0.01)
TOLERANCE = 1e-9
REDUCED_MASS = 0.316 * 0.335 / (0.316 + 0.335)


def designs() -> list[tuple[float, float]]:
    """Stiffness [N/m] and damping [N s/m] of the legs that are timed."""
    damped = [(k, 2 * ratio * math.sqrt(k * REDUCED_MASS)) for ratio in RATIOS for k in STIFFNESS]
    return [(2800.0, b) for b in DAMPING] + damped


def measured(walker: Walker) -> tuple[float, float]:
    """Time [s] and period of one step, the best of several."""
    stance, swing = lengths_after_heel_strike(walker.p)
    best = math.inf
    for _ in range(4):
        start = time.perf_counter()
        step = poincare_map(walker, np.array([-0.277, stance, swing, 0.475, -0.205]), TOLERANCE)
        best = min(best, time.perf_counter() - start)
    return best, step.period


def main() -> None:
    """Print the table."""
    print("   k [N/m]  b [N s/m]      rate     decay  explicit ms  implicit ms   ratio  period differs  taken")
    for k, b in designs():
        walker = build_walker(Biped("compliant", 0.316, 0.335, 0.333, 0.083, 0.1, k, b, 0.0), Slope(2.0, 9.81))
        rate, decay = axial_rates(walker.p)
        explicit, period = measured(dataclasses.replace(walker, p=PlainCompliant(*walker.p)))
        implicit, other = measured(dataclasses.replace(walker, p=StiffPlain(*walker.p)))
        taken = "implicit" if walker.stiff else "explicit"
        print(f"{k:10.3g} {b:10.4g} {rate:9.3g} {decay:9.3g} {1e3 * explicit:12.3f} {1e3 * implicit:12.3f} "
              f"{explicit / implicit:7.2f} {abs(period - other):15.1e}  {taken}")


if __name__ == "__main__":
    main()
