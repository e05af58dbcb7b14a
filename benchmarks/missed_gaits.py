"""How many gaits the search misses, on designs drawn from a wide box whose gaits forward walking shows.

`python -m benchmarks.missed_gaits [seed] [designs]` draws designs (M/m .1 to 1000, foot and mass anywhere on the leg,
k and b within a factor of 4 of Table 1, .3 to 6 degrees, legs rigid or compliant in turn) until so many walk. Walks
from random starts need no guess and no Newton's method to settle; what they settle on is known. It prints, a line
each, the designs where the search finds no gait, or no stable one, or where `gait --all` omits a gait that is known;
then the counts. Two processes; some minutes.
"""

import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from multiprocessing import get_context

import numpy as np

from stages.analytic.errors import NoGait, StepFailed
from stages.analytic.gait.gait_search import find_gait, find_gaits
from stages.analytic.gait.poincare import FixedPoint, by_stability, fixed_point, is_new, is_walking, poincare_map
from stages.analytic.gait.search_starts import start_coordinates
from stages.analytic.model.walker import Vector, Walker, build_walker
from stages.biped.design import Biped
from stages.ground.slope import Slope

#: Table 1: total mass [kg], leg [m], stiffness [N/m], damping [N s/m].
MASS, LENGTH, STIFFNESS, DAMPING = 0.986, 0.333, 2800.0, 58.35
STARTS, STEPS = 300, 60
#: Tolerance of the walks; a walk has settled when a step changes the coordinates by less than `SETTLED`.
TOLERANCE, SETTLED = 1e-7, 1e-5
#: A walk this near to a gait that is known need not be walked on.
NEAR = 1e-3


@dataclass(frozen=True)
class Missed:
    """What the search made of a design that walks: the known gaits, how many of them each search found, its time."""

    index: int
    legs: str
    known: int
    found_stable: bool
    omitted: int
    quick: float
    whole: float


def drawn(seed: int, index: int) -> tuple[Biped, Slope]:
    """Design `index` of a seed."""
    rng = np.random.default_rng([seed, index])
    ratio = 10 ** rng.uniform(-1, 3)
    foot_com, foot_radius = rng.uniform(0, 1, 2) * LENGTH
    stiffness, damping = 4 ** rng.uniform(-1, 1, 2) * (STIFFNESS, DAMPING)
    foot = MASS / (ratio + 2)
    legs = ("compliant", "rigid")[index % 2]
    slope = Slope(slope_deg=float(rng.uniform(0.3, 6.0)), gravity=9.81)
    return Biped(legs, ratio * foot, foot, LENGTH, foot_radius, foot_com, stiffness, damping, 0.0), slope


def random_start(walker: Walker, rng: np.random.Generator) -> Vector:
    """Section coordinates of a landing, the swing and axial rates scattered."""
    z = start_coordinates(walker, float(rng.uniform(0.01, 1.0)), float(rng.uniform(0.02, 2.0)))
    z[2 if walker.rigid else 4] += rng.normal(0, 0.1)
    return z


def settled(walker: Walker, z: Vector, known: list[FixedPoint]) -> Vector | None:
    """What a walk from `z` settles on; None if it falls, wanders, or comes to a gait that is known."""
    try:
        for _ in range(STEPS):
            image = poincare_map(walker, z, TOLERANCE).z
            if any(np.abs(image - point.z).max() < NEAR for point in known):
                return None
            if np.abs(image - z).max() < SETTLED:
                return image
            z = image
    except StepFailed:
        pass
    return None


def walked_gaits(walker: Walker, rng: np.random.Generator) -> list[FixedPoint]:
    """The stable gaits that walks from random starts settle on."""
    known: list[FixedPoint] = []
    for _ in range(STARTS):
        z = settled(walker, random_start(walker, rng), known)
        point = None if z is None else fixed_point(walker, z, 1e-10)
        if point is not None and is_walking(point) and by_stability(point) < 1 and is_new(known, point):
            known.append(point)
    return known


def found_first(biped: Biped, slope: Slope) -> FixedPoint | None:
    """The gait that `gait` shows, if any."""
    try:
        return find_gait(biped, slope, 1e-10)[1]
    except NoGait:
        return None


def judged(task: tuple[int, int]) -> Missed | None:
    """What the search makes of a design; None if no walk settles on it."""
    seed, index = task
    biped, slope = drawn(seed, index)
    walker = build_walker(biped, slope)
    known = walked_gaits(walker, np.random.default_rng([seed, index, 1]))
    if not known:
        return None
    began = time.process_time()
    quick = found_first(biped, slope)
    between = time.process_time()
    every = find_gaits(walker, 1e-10, unstable=True)
    end = time.process_time()
    omitted = sum(all(np.abs(point.z - other.z).max() > 1e-5 for other in every) for point in known)
    stable = quick is not None and by_stability(quick) < 1
    return Missed(index, biped.legs, len(known), stable, omitted, between - began, end - between)


def judgements(seed: int, designs: int) -> Iterator[Missed]:
    """The judgement of so many designs that walk."""
    with get_context("spawn").Pool(2) as pool:
        walking = 0
        for found in pool.imap(judged, ((seed, index) for index in range(50 * designs)), 4):
            if found is not None:
                yield found
                walking += 1
                if walking == designs:
                    return


def main() -> None:
    """Print what is missed, and counts."""
    seed, designs = (int(text) for text in (sys.argv[1:] + ["1", "300"][len(sys.argv) - 1 :]))
    found: list[Missed] = []
    for one in judgements(seed, designs):
        found.append(one)
        if not one.found_stable or one.omitted:
            print(f"  design {one.index} ({one.legs}): stable gaits known {one.known}, "
                  f"{'a' if one.found_stable else 'no'} stable one found, --all omits {one.omitted}", flush=True)
    for legs in ("compliant", "rigid"):
        mine = [one for one in found if one.legs == legs]
        quick, whole = np.array([(one.quick, one.whole) for one in mine]).T
        print(f"{legs}: {len(mine)} walk; no stable gait found on {sum(not one.found_stable for one in mine)}, "
              f"--all omits {sum(one.omitted for one in mine)} of {sum(one.known for one in mine)}; "
              f"search {np.median(quick):.3f} s (at most {quick.max():.2f}), --all {np.median(whole):.3f} s")
    print(f"of {found[-1].index + 1} designs drawn with seed {seed}")


if __name__ == "__main__":
    main()
