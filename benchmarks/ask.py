"""Whether `ask` keeps the errors it states, what it costs beside the twin, and which rung answers which error.

Run: python -m benchmarks.ask [COUNT]. Random questions (measure, error, design; every third design with details) are
answered from `results/model_error.h5`, and held against the twin at tolerance 1e-8. Prices are processor time.

Run: python -m benchmarks.ask stable [COUNT]. Of designs near a doubling, whether the share that is stable is what
`ask stable` says, in five bins of equal count. One design in two has the digits of the study's own, and its truth is
the twin of a robot drawn within them; the others are exact.
"""

import dataclasses
import sys
import time
from collections import Counter

import numpy as np
from scipy.optimize import brentq
from scipy.stats import binom

import bipedstudy as bs
from stages.model_error.choice import DERIVED, MULTIPLIER, Ladder
from stages.model_error.measures import NAMES
from stages.model_error.miss import Learnt
from stages.model_error.result import PENALTY, SHARED, TWIN
from stages.model_error.run import design_of
from stages.model_error.rungs import RUNGS, NoRung

SEED = 7
REFERENCE = 1e-8
BOX = ("hip_mass", "foot_mass", "leg_length", "foot_radius", "foot_com", "stiffness", "damping")


def question(parameters, rng):
    """A design, a measure and an error: the design within 20 % and 1.5 to 3 degrees, one in three with details."""
    biped = parameters.biped
    changed = {key: getattr(biped, key) * rng.uniform(0.8, 1.2) for key in BOX}
    if rng.random() < 1 / 3:
        changed |= {"foot_offset": rng.uniform(-3e-4, 3e-4), "hip_damping": rng.uniform(0, 1e-3),
                    "other_foot_mass": changed["foot_mass"] * rng.uniform(0.99, 1.01)}  # fmt: skip
    slope = dataclasses.replace(parameters.slope, slope_deg=rng.uniform(1.5, 3.0))
    measure = NAMES[rng.integers(len(NAMES))]
    design = dataclasses.replace(parameters, biped=dataclasses.replace(biped, **changed), slope=slope)
    return design, measure, float(10 ** rng.uniform(-4, -1))


def at_slope(parameters, slope_deg):
    """The same design on another slope."""
    return dataclasses.replace(parameters, slope=dataclasses.replace(parameters.slope, slope_deg=slope_deg))


def penalty_multiplier(parameters, slope_deg):
    """The penalty walker's largest multiplier there."""
    return float(RUNGS[PENALTY].find(design_of(at_slope(parameters, slope_deg)), 1e-7).values[MULTIPLIER])


def doubling(parameters, rng, learnt):
    """A drawn design near where its gait's period doubles, by about as much as `ask` leaves open. Raises NoRung.

    With the digits of the study's own parameters, or exact ones; and a robot drawn within them.
    """
    design, _, _ = question(parameters, rng)
    slopes = np.arange(2.0, 7.0, 0.5)
    below = slopes[0]
    for above in slopes:
        if penalty_multiplier(design, above) > 1.0:
            break
        below = above
    if not below < above:
        raise NoRung("no doubling among these slopes")
    there = brentq(lambda slope: penalty_multiplier(design, slope) - 1.0, below, above, xtol=1e-6)
    steep = (penalty_multiplier(design, there + 1e-3) - 1.0) / 1e-3
    exact = design.with_exact(design.biped, design.slope)
    given = design if rng.random() < 0.5 else exact
    open_ = Ladder(at_slope(given, there - 1e-3), learnt).stable()
    sigma = 0.5 * np.hypot(np.hypot(open_.solver, open_.model), open_.inputs)
    asked = at_slope(given, there + rng.normal() * sigma / steep)
    off = {name: rng.uniform(-width, width) for name, width in asked.half_widths.items()}
    biped = {key.partition(".")[2]: value for key, value in off.items() if key.startswith("biped.")}
    true = dataclasses.replace(asked, biped=dataclasses.replace(asked.biped, **{
        key: getattr(asked.biped, key) + value for key, value in biped.items()}))  # fmt: skip
    return asked, at_slope(true, asked.slope.slope_deg + off.get("ground.slope_deg", 0.0))


def stable(count: int) -> None:
    """Ask near doublings, and print the bins."""
    parameters, rng = bs.parameters("model_error"), np.random.default_rng(SEED)
    learnt, rows = Learnt(bs.load("model_error")), []
    while len(rows) < count:
        try:
            asked, robot = doubling(parameters, rng, learnt)
            found = Ladder(asked, learnt).stable()
        except (NoRung, ValueError) as reason:
            print(f"none: {reason}", flush=True)
            continue
        try:
            largest = float(RUNGS[TWIN].find(design_of(robot), REFERENCE).values[MULTIPLIER])
        except NoRung:  # left out, only robots that walk would count
            largest = np.inf
        rows.append((found.probability, largest < 1.0, bool(asked.half_widths)))
        print(f"{found.probability:.4f} {found.multiplier:.6f} +- {found.solver:.1e} {found.model:.1e} "
              f"{found.inputs:.1e} {found.rung}; true {largest:.6f}", flush=True)  # fmt: skip
    for name, some in (("all", rows), ("with digits", [row for row in rows if row[2]]),
                       ("exact", [row for row in rows if not row[2]])):  # fmt: skip
        for part in np.array_split(np.array(sorted(some), float), 5):
            mean, share = part[:, 0].mean(), part[:, 1].mean()
            low, high = np.array(binom.interval(0.95, len(part), mean)) / len(part)
            print(f"{name}: {len(part)} of {part[0, 0]:.3f} to {part[-1, 0]:.3f}, mean {mean:.3f}: stable {share:.3f}, "
                  f"limits {low:.2f} to {high:.2f}", "" if low <= share <= high else "OUTSIDE")  # fmt: skip


def main(count: int) -> None:
    """Ask, and print the tables."""
    parameters, rng = bs.parameters("model_error"), np.random.default_rng(SEED)
    learnt = Learnt(bs.load("model_error"))
    ladder = Ladder(parameters, learnt)
    for rung in (0, 1, 2, 3):  # compiled and loaded before it is timed
        ladder.find(rung, RUNGS[rung].tolerances[0])
    rows, cost, twin_cost, easy = [], 0.0, 0.0, [0.0, 0.0]
    while len(rows) < count:
        design, measure, error = question(parameters, rng)
        began = time.process_time()
        asked = Ladder(design, learnt)
        found = asked.within(measure, error, True)
        took = time.process_time() - began
        fresh = Ladder(design, learnt)
        began = time.process_time()
        try:
            true = fresh.find(3, REFERENCE)
        except NoRung:
            continue  # the twin does not walk
        reference = time.process_time() - began
        place = NAMES.index(measure)
        miss = abs(found.value - true.values[place]) / (true.values[place] if SHARED[place] else 1.0)
        noise = true.errors[place] / (true.values[place] if SHARED[place] else 1.0)
        cheapest = next((one.name for number, one in enumerate(RUNGS)
                         if asked.learnt.at(number, place, asked.numbers).error < error), "")  # fmt: skip
        rows.append((measure, error, found, miss, miss <= error + noise, cheapest == found.rung,
                     true.values[-1] < 1))  # fmt: skip
        cost, twin_cost = cost + took, twin_cost + reference
        if measure in DERIVED and error > 5e-3:
            easy = [easy[0] + took, easy[1] + reference]
    answered = [row for row in rows if row[2].met]
    print(f"{len(rows)} questions, {len(answered)} answered, {sum(row[4] for row in answered)} of these within")
    print(f"the cheapest rung in {np.mean([row[5] for row in rows]):.2f}; processor time {cost:.1f} s against the "
          f"twin's {twin_cost:.1f} s ({cost / twin_cost:.3f}); times and lengths above .5 %: {easy[0] / easy[1]:.3f}")
    print(Counter((row[2].rung or "refused", f"1e{np.floor(np.log10(row[1])):.0f}") for row in rows))
    for row in rows:
        if not row[4]:
            print("outside" if row[2].met else "refused", row[0], f"{row[1]:.2g} asked, {row[3]:.2g} off", row[2].rung,
                  "stable" if row[6] else "unstable", row[2].passed_over[-1:])  # fmt: skip


if __name__ == "__main__":
    if "stable" in sys.argv[1:2]:
        stable(int(sys.argv[2]) if len(sys.argv) > 2 else 100)
    else:
        main(int(sys.argv[1]) if len(sys.argv) > 1 else 200)
