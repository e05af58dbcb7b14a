"""How long one gait takes, multipliers included, with compiled code present: from no guess, and from a neighbour.

    python benchmarks/one_gait.py [designs]

Designs of the box of `design_map.py`, tolerance 1e-8, processor time. A neighbour has its foot mass 1 % lower on
the leg; its coordinates are the guess as they are, and along the tangent.
"""

import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from benchmarks.design_map import BASE, TOLERANCE, box_of
from stages.analytic.errors import NoGait
from stages.analytic.gait.gait_search import find_gait
from stages.analytic.gait.poincare import by_stability
from stages.analytic.maps.answers import along_tangent, anchor, corrected


def spent(call: Callable[[], Any]) -> tuple[float, Any]:
    """Processor time [ms] and the answer."""
    began = time.process_time()
    answer = call()
    return 1e3 * (time.process_time() - began), answer


def line(what: str, times: list[float]) -> str:
    """Median, 95 % and largest of times [ms]."""
    median, most = np.quantile(times, (0.5, 0.95))
    return f"{what}: median {median:.2f} ms, 95 % below {most:.2f}, at most {max(times):.2f} ({len(times)} designs)"


def searched(design: Any) -> Any:
    """Walker and gait, or None."""
    try:
        return find_gait(design.biped, design.slope, TOLERANCE)
    except NoGait:
        return None


def main() -> None:
    """Print a line for each way to a gait."""
    count = int((sys.argv[1:] or ["100"])[0])
    box = box_of(4 * count)
    designs = [box.design(BASE, values) for values in box.values(3 * count, 4 * count)]
    searched(BASE)
    times: dict[str, list[float]] = {}
    failed = 0
    for number, design in enumerate(designs):
        taken, found = spent(lambda d=design: searched(d))
        times.setdefault("search, all", []).append(taken)
        kind = "none" if found is None else "stable" if by_stability(found[1]) < 1 else "unstable"
        times.setdefault(f"search, {kind}", []).append(taken)
        if found is None:
            continue
        known = anchor(*found, TOLERANCE)
        beside = design.with_value("biped.foot_com", 0.99 * design.biped.foot_com).walker()
        for what, call in (
            ("neighbour's coordinates", lambda w=beside, z=found[1].z: corrected(w, z, TOLERANCE)),
            ("neighbour's tangent", lambda w=beside, k=known: along_tangent(w, k, TOLERANCE)),
        ):
            taken, point = spent(call)
            failed += point is None
            if number:  # the first loads machine code
                times.setdefault(what, []).append(taken)
    for what, each in times.items():
        print(line(what, each))
    print(f"neighbours that led nowhere: {failed}")


if __name__ == "__main__":
    main()
