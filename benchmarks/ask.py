"""Whether `ask` keeps the errors it states, what it costs beside the twin, and which rung answers which error.

Run: python -m benchmarks.ask [COUNT]. Random questions (measure, error, design; every third design with details) are
answered from `results/model_error.h5`, and held against the twin at tolerance 1e-8. Prices are processor time.
"""

from __future__ import annotations

import dataclasses
import sys
import time
from collections import Counter

import numpy as np

import bipedstudy as bs
from stages.model_error.choice import Ladder
from stages.model_error.measures import NAMES
from stages.model_error.miss import Learnt
from stages.model_error.result import SHARED
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
        if measure != "multiplier" and error > 5e-3:
            easy = [easy[0] + took, easy[1] + reference]
    answered = [row for row in rows if row[2].met]
    print(f"{len(rows)} questions, {len(answered)} answered, {sum(row[4] for row in answered)} of these within")
    print(f"the cheapest rung in {np.mean([row[5] for row in rows]):.2f}; processor time {cost:.1f} s against the "
          f"twin's {twin_cost:.1f} s ({cost / twin_cost:.3f}); measures above .5 %: {easy[0] / easy[1]:.3f}")
    print(Counter((row[2].rung or "refused", f"1e{np.floor(np.log10(row[1])):.0f}") for row in rows))
    for row in rows:
        if not row[4]:
            print("outside" if row[2].met else "refused", row[0], f"{row[1]:.2g} asked, {row[3]:.2g} off", row[2].rung,
                  "stable" if row[6] else "unstable", row[2].passed_over[-1:])  # fmt: skip


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 200)
