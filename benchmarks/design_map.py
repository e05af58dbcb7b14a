"""How many designs of a box a map answers in a second, how many it leaves that have a gait, and whether it is right.

    python benchmarks/design_map.py [designs] [processes]

The box has seven dimensions around Table 1: masses, foot radius and foot mass's height within 20 %, stiffness and
damping within 50 %, slope 1.5 to 3 degrees. Tolerance 1e-8, multipliers and friction included. Rates are by processor
time, anchors apart. Then up to 300 designs that no neighbour answers are searched as `gait` does, for the share that is
answered, and 60 that are answered, for differences.
"""

import dataclasses
import sys
import time
from collections.abc import Callable
from multiprocessing import get_context
from typing import Any

import numpy as np
from scipy.stats import binomtest

from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.poincare import by_stability
from stages.analytic.maps.answers import COLUMNS, UNANSWERED, WAYS, Task, anchors_of, block, searched as search
from stages.analytic.maps.box import Box, read
from stages.biped.design import Biped
from stages.ground.slope import Slope

TABLE_1 = Biped(legs="compliant", hip_mass=0.316, foot_mass=0.335, leg_length=0.333, foot_radius=0.083, foot_com=0.100,
                stiffness=2800.0, damping=58.35, leg_inertia=0.0)
BASE = DesignPoint(TABLE_1, Slope(slope_deg=2.0, gravity=9.81))
NARROW, WIDE = ("hip_mass", "foot_mass", "foot_radius", "foot_com"), ("stiffness", "damping")
TOLERANCE, ANCHORS, BLOCK, SEARCHED, COMPARED = 1e-8, 300, 500, 300, 60
#: A gait differs if its largest multiplier does by more than this, far above the tolerance.
DIFFERS = 1e-4
AT = {column.name: place for place, column in enumerate(COLUMNS)}


def box_of(count: int) -> Box:
    """The box of calibration around Table 1."""
    vary: dict[str, dict[str, float]] = {}
    for share, names in ((0.2, NARROW), (0.5, WIDE)):
        for name in names:
            value = getattr(TABLE_1, name)
            vary[f"biped.{name}"] = {"low": (1 - share) * value, "high": (1 + share) * value}
    vary["ground.slope_deg"] = {"low": 1.5, "high": 3.0}
    return read({"kind": "sobol", "count": count, "seed": 1, "vary": vary}, BASE)


def timed(part: Callable[[Task, int, int], Any], task: Task, first: int, end: int) -> tuple[float, Any]:
    """Processor time of a part of the map, and its rows."""
    began = time.process_time()
    rows = part(task, first, end)
    return time.process_time() - began, rows


def searched(task: tuple[Box, int, str]) -> tuple[float, float]:
    """Processor time of the search of a design, and the largest multiplier of what it finds; NaN for none."""
    box, number, how = task
    design = box.design(BASE, box.values(number, number + 1)[0])
    walker, began = design.walker(), time.process_time()
    found = search(design, walker, Task(box, BASE, TOLERANCE, how))
    return time.process_time() - began, by_stability(found[1]) if found else np.nan


def main() -> None:
    """Print the rates, the share answered and the differences."""
    words = sys.argv[1:]
    count, processes = (int(word) for word in (words + ["5000", "2"][len(words) :])[:2])
    box, rng = box_of(count), np.random.default_rng(0)
    with get_context("spawn").Pool(processes) as pool:
        task = Task(box, BASE, TOLERANCE, "none")
        parts = pool.starmap(timed, [(anchors_of, task, at, at + 10) for at in range(0, ANCHORS, 10)])
        anchors = [one for _, found in parts for one in found if one]
        print(f"{len(anchors)} anchors of {ANCHORS} designs in {sum(spent for spent, _ in parts):.1f} s")
        task = dataclasses.replace(task, anchors=anchors)
        pool.starmap(timed, [(block, task, at, at + 1) for at in range(processes)], 1)  # loads code
        began = time.monotonic()
        answered = pool.starmap(timed, [(block, task, at, min(at + BLOCK, count)) for at in range(0, count, BLOCK)], 1)
        wall, spent = time.monotonic() - began, sum(each for each, _ in answered)
        rows = np.array([row for _, rows in answered for row in rows])
        left = np.flatnonzero(rows[:, AT["outcome"]] == UNANSWERED)
        known = np.flatnonzero(rows[:, AT["outcome"]] != UNANSWERED)
        ways = {way: int((rows[:, AT["answered_by"]] == code).sum()) for code, way in enumerate(WAYS)}
        print(f"{count} designs: {count / spent:.0f} a second and core ({count / wall:.0f} a second by the clock on "
              f"{processes}) before the search of what is left; {ways}; largest residual "
              f"{np.nanmax(rows[:, AT['residual']]):.1e}", flush=True)  # fmt: skip
        tried = rng.permutation(left)[:SEARCHED].tolist()
        for how in ("limited", "complete") if tried else ():
            full = np.array(pool.map(searched, [(box, number, how) for number in tried], 1))
            hits, each = int(np.isfinite(full[:, 1]).sum()), full[:, 0].mean()
            shares = [len(known) / (len(known) + share * len(left)) for share in (
                hits / len(tried), *binomtest(hits, len(tried)).proportion_ci(method="wilson"))]  # fmt: skip
            print(f"of {len(left)} left {len(tried)} have a {how} search, {each:.3f} s each: {hits} have a gait, "
                  f"{int((full[:, 1] < 1).sum())} a stable one; share answered {100 * shares[0]:.2f} % "
                  f"({100 * shares[2]:.2f} to {100 * shares[1]:.2f}); with their search "
                  f"{count / (spent + each * len(left)):.0f} a second and core", flush=True)  # fmt: skip
        sample = rng.permutation(known)[:COMPARED].tolist()
        again = np.array(pool.map(searched, [(box, number, "complete") for number in sample], 1))
        mine = rows[sample][:, AT["largest_multiplier"]]
        differ = np.flatnonzero(~(np.abs(again[:, 1] - mine) < DIFFERS))
        print(f"of {len(sample)} answered {len(differ)} differ from the full search "
              f"({again[:, 0].mean():.3f} s each, median {np.median(again[:, 0]):.3f})")  # fmt: skip
        for place in differ:
            print(f"  design {sample[place]}: largest multiplier {mine[place]:.6f}, full search {again[place, 1]:.6f}")


if __name__ == "__main__":
    main()
