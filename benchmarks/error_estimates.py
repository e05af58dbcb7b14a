"""Error estimates of the constraint model against true errors, on designs that no table knows.

`python -m benchmarks.error_estimates [seed] [designs]` draws designs (every number of Table 1 within 30 %, 1 to 4
degrees), and compares, for tolerances of 1e-5 to 1e-10, what is estimated for gait and walk with the distance to the
same computed at 1e-13. It prints, for each tolerance, for how many numbers an estimate was given, and the smallest and
the largest ratio of estimate and truth; truths below `ROUND_OFF` are left out. A minute for 50 designs.
"""

import sys

import numpy as np

from stages.analytic.errors import NoGait, StepFailed
from stages.analytic.gait.gait_search import find_gait, step_length
from stages.analytic.gait.poincare import FixedPoint, fixed_point
from stages.analytic.model.walker import Walker
from stages.analytic.walk.error_estimate import estimate_errors
from stages.analytic.walk.sampling import walk_from_mid_stance
from stages.biped.accuracy.estimate import walk_differences
from stages.biped.design import Biped
from stages.ground.slope import Slope

TOLERANCES = tuple(10.0**-power for power in range(5, 11))
EXACT, STEPS, RATE = 1e-13, 10, 2000.0
#: Round-off in what is compared, in metres and seconds.
ROUND_OFF = 2e-14
VARIED = {"hip_mass": 0.316, "foot_mass": 0.335, "leg_length": 0.333, "foot_radius": 0.083, "foot_com": 0.1,
          "stiffness": 2800.0, "damping": 58.35}  # fmt: skip
MEASURES = ("period", "step_length", "hip_position", "step_duration")


def drawn(seed: int, index: int) -> tuple[Biped, Slope]:
    """Design `index` of a seed."""
    rng = np.random.default_rng([seed, index])
    values = {key: value * rng.uniform(0.7, 1.3) for key, value in VARIED.items()}
    return Biped(legs="compliant", leg_inertia=0.0, **values), Slope(float(rng.uniform(1.0, 4.0)), 9.81)


def results(walker: Walker, point: FixedPoint, tolerance: float) -> tuple[float, float, object]:
    """Period [s], step length [m] and walk."""
    walk, _ = walk_from_mid_stance(walker, point.z, STEPS, tolerance, RATE)
    return point.steps[0].period * walker.time, step_length(walker, point) * walker.length, walk


def main() -> None:
    """Print shares and ratios."""
    seed, designs = (int(text) for text in (sys.argv[1:] + ["1", "50"][len(sys.argv) - 1 :]))
    given: dict[float, list[bool]] = {tolerance: [] for tolerance in TOLERANCES}
    ratios: dict[float, list[tuple[str, float]]] = {tolerance: [] for tolerance in TOLERANCES}
    index = 0
    while len(given[TOLERANCES[0]]) < designs * len(MEASURES):
        biped, slope = drawn(seed, index)
        index += 1
        try:
            walker, exact_point = find_gait(biped, slope, EXACT)
            exact = results(walker, exact_point, EXACT)
        except (NoGait, StepFailed):
            continue
        for tolerance in TOLERANCES:
            point = fixed_point(walker, exact_point.z, tolerance)
            estimate = None if point is None else estimate_errors(walker, point, STEPS, tolerance)
            given[tolerance] += [estimate is not None and np.isfinite(getattr(estimate, name)) for name in MEASURES]
            if point is None or estimate is None or not estimate.given:
                continue
            found = results(walker, point, tolerance)
            walks = walk_differences(found[2], exact[2])
            true = (exact[0] - found[0], exact[1] - found[1], walks["hip_position_m"], walks["period_s"])
            for name, value in zip(MEASURES, true, strict=True):
                if abs(value) > ROUND_OFF and np.isfinite(getattr(estimate, name)):
                    ratios[tolerance].append((f"{name} of design {index - 1}", getattr(estimate, name) / value))
    for tolerance in TOLERANCES:
        values = np.array([ratio for _, ratio in ratios[tolerance]] or [np.nan])
        worst = ratios[tolerance][int(np.argmax(np.abs(np.log(np.abs(values)))))][0] if ratios[tolerance] else "-"
        share = f"given for {np.mean(given[tolerance]):.1%} of {len(given[tolerance])} numbers"
        within = np.mean((values > 0.5) & (values < 2.0))
        print(f"{tolerance:.0e}: {share}; estimate over truth {values.min():.3f} to {values.max():.3f} over "
              f"{values.size}, {within:.1%} from .5 to 2 (farthest: {worst})")


if __name__ == "__main__":
    main()
