"""Cost of one step of the walk with explicit and with implicit integration steps, as the legs become stiffer.

    python -m benchmarks.stiff_legs

Prints a table: for each design the fastest axial rate and its decay, the time of one step with either integrator,
their difference in the period, and which one the study takes by itself. Each integrator is compiled in a process of
its own, with the choice overruled, in a cache that is thrown away.
"""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
import tempfile
import time

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


def measure(threshold: float) -> list[dict[str, float]]:
    """Time and period of one step of each design, with implicit steps above a rate of `threshold`."""
    import numba

    import stages.analytic.compiled  # noqa: F401 (sets the cache folder, which is overruled here)

    numba.config.CACHE_DIR = os.environ["STIFF_LEGS_CACHE"]
    from stages.analytic.phases import stiffness

    stiffness.STIFF_RATE, stiffness.STIFF_DECAY = threshold, 0.0
    from stages.analytic.gait.poincare import poincare_map
    from stages.analytic.gait.search_starts import lengths_after_heel_strike
    from stages.analytic.model.walker import build_walker
    from stages.biped.design import Biped
    from stages.ground.slope import Slope

    rows = []
    for k, b in designs():
        biped = Biped("compliant", 0.316, 0.335, 0.333, 0.083, 0.1, k, b, 0.0)
        walker = build_walker(biped, Slope(slope_deg=2.0, gravity=9.81))
        stance, swing = lengths_after_heel_strike(walker)
        z = [-0.277, stance, swing, 0.475, -0.205]
        best = math.inf
        for _ in range(4):
            start = time.perf_counter()
            step = poincare_map(walker, z, TOLERANCE)
            best = min(best, time.perf_counter() - start)
        rate, decay = stiffness.axial_rates(walker.p)
        rows.append({"k": k, "b": b, "rate": rate, "decay": decay, "time": best, "period": step.period})
    return rows


def in_own_process(threshold: str) -> list[dict[str, float]]:
    """`measure` with a compiler cache of its own."""
    with tempfile.TemporaryDirectory() as cache:
        command = [sys.executable, "-m", "benchmarks.stiff_legs", threshold]
        run = subprocess.run(command, env={**os.environ, "STIFF_LEGS_CACHE": cache}, stdout=subprocess.PIPE, check=True)
    rows: list[dict[str, float]] = json.loads(run.stdout)
    return rows


def main() -> None:
    """Print the table."""
    from stages.analytic.phases.stiffness import STIFF_DECAY, STIFF_RATE

    print("   k [N/m]  b [N s/m]      rate     decay  explicit ms  implicit ms   ratio  period differs  taken")
    for explicit, implicit in zip(in_own_process("inf"), in_own_process("0"), strict=True):
        rate, decay = explicit["rate"], explicit["decay"]
        taken = "implicit" if rate > STIFF_RATE and decay > STIFF_DECAY else "explicit"
        print(
            f"{explicit['k']:10.3g} {explicit['b']:10.4g} {rate:9.3g} {decay:9.3g} {1e3 * explicit['time']:12.3f} "
            f"{1e3 * implicit['time']:12.3f} {explicit['time'] / implicit['time']:7.2f} "
            f"{abs(explicit['period'] - implicit['period']):15.1e}  {taken}"
        )


if __name__ == "__main__":
    if len(sys.argv) > 1:
        print(json.dumps(measure(float(sys.argv[1]))))
    else:
        main()
