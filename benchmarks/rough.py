"""Steps to a fall on blocks, as `rough` answers, against plain counts by another loop with other heights.

`python -m benchmarks.rough [steps | rare]` prints a table each of ten designs around Table 1, drawn by `SEED`, a third
of them of another size under another gravity: frequent falls against a million steps, or as many as leave 2 %; and rare
ones against 80 falls. Half an hour on one core.
"""

import sys
import time
from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import numpy as np

from stages.analytic.errors import NoGait
from stages.analytic.gait.gait_search import find_gait
from stages.analytic.gait.poincare import by_stability
from stages.analytic.result import REACHES
from stages.biped.design import Biped
from stages.ground.blocks import Blocks
from stages.ground.slope import Slope
from stages.model_error.questions.design import Here
from stages.stability.blocks.borne import Borne
from stages.stability.questions.rough import Options, passage, rough_of

SEED, DESIGNS = 39, 10
#: Steps to a fall that are aimed at, designs whose legs are rigid, and falls and steps that are enough.
TABLES = {"steps": (np.geomspace(12, 900, DESIGNS), lambda n: n % 2 == 1, 2500, 10**6),
          "rare": (np.geomspace(3.5e3, 1.5e5, DESIGNS), lambda n: n % 2 == 1 or n > 5, 80, 10**8)}


def drawn(number: int, rigid: bool, seed: int = SEED) -> tuple[Any, Any]:
    """Parameters with a design whose gait is stable, and that gait."""
    rng = np.random.default_rng([seed, number, rigid])
    while True:
        size, gravity = (rng.uniform(0.5, 3.0), rng.choice([1.62, 3.71, 24.8])) if number % 3 == 2 else (1.0, 9.81)
        hip, foot, radius, com, stiff, damp = np.exp(rng.uniform(-0.2, 0.2, 6))
        fall = gravity / 9.81
        biped = Biped("rigid" if rigid else "compliant", 0.316 * hip, 0.335 * foot, 0.333 * size, 0.083 * radius * size,
                      0.1 * com * size, 2800 * stiff * fall / size, 58.35 * damp * (fall / size) ** 0.5, 0.0)
        slope = Slope(slope_deg=rng.uniform(1.5, 2.5), gravity=gravity)
        try:
            walker, point = find_gait(biped, slope, 1e-10)
        except NoGait:
            continue
        if len(point.steps) == 1 and by_stability(point) < 1.0:
            blocks = Blocks(block_length=0.08 * size)
            return SimpleNamespace(biped=biped, slope=slope, blocks=blocks, walker=walker), point


def counted(rough: Any, rng: np.random.Generator, enough: int, most: int) -> tuple[int, int]:
    """Steps and falls."""
    steps = falls = 0
    while falls < enough and steps < most:
        at, ending = rough.start, REACHES
        while ending == REACHES:
            at, ending = rough.step(at, rng.standard_normal())
            steps += 1
        falls += 1
    return steps, falls


def height(borne: float, steps: float) -> float:
    """Height at about so many steps to a fall, whose logarithm is nearly linear in one over the height's square."""
    return float(borne * np.sqrt(2.1 / (np.log(steps) - 1.8)))


def rows(table: str) -> Iterator[list[str]]:
    """A row for each design: answer and count."""
    aims, is_rigid, enough, most = TABLES[table]
    for number, aim in enumerate(aims.tolist()):
        parameters, point = drawn(number, is_rigid(number))
        blocks = parameters.blocks
        parameters.blocks = Blocks(height(Borne(blocks).of(parameters.walker, point.z), aim), 0, blocks.block_length)
        began = time.process_time()
        found, _ = passage(parameters, Options(), Here(parameters), point.z.tolist())
        cost = time.process_time() - began
        steps, falls = counted(rough_of(parameters, point.z.tolist()), np.random.default_rng([SEED, 1, number]),
                               enough, most)  # fmt: skip
        mean, low, high = steps / falls, found.steps_low, found.steps_high
        biped, slope = parameters.biped, parameters.slope
        yield [f"{number + 1}", f"{biped.legs}, {biped.leg_length:.2f} m, {slope.gravity:g} m/s2",
               f"{1e3 * parameters.blocks.block_height_rms:.3f}", f"{found.steps_to_fall:.4g}",
               f"{low:.4g} to {high:.4g}", f"{mean:.4g}", f"{100 / falls**0.5:.1f} %",
               f"{100 * (found.steps_to_fall / mean - 1):+.1f} %", "yes" if low < mean < high else "no",
               found.method, f"{cost:.1f}"]  # fmt: skip


if __name__ == "__main__":
    for table in sys.argv[1:] or TABLES:
        for row in rows(table):
            print("|", " | ".join(row), "|", flush=True)
