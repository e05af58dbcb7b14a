"""The error of a stage's walk, estimated by a second run.

The second run takes the most accurate setting measured at no more than half the cost; where none is measured, the next
more accurate one, which costs somewhat more. Both runs differ by the difference of their errors. The kept table shows
with which power of the tolerance (or step) the errors of the way go; so the difference gives the error, as Richardson
has it.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from typing import Any

from stages.tradeoff.accuracy.choice import TABLE, Choice

#: Places to which times count as equal [s].
PLACES = 9


def verified(choice: Choice, result: Any, rerun: Callable[[Mapping[str, float]], Any]) -> dict[str, Any]:
    """The estimate as plain values; `rerun` computes the stage's result with other solver settings.

    Whatever a stage raises at another setting becomes the reason why there is no estimate.
    """
    about = {
        "asked": dict(choice.asked),
        "settings": dict(choice.settings),
        "hip_error_expected_m": _rounded(choice.expected),
        "table": {kind: entry["made"] for kind, entry in json.loads(TABLE.read_text())["about"].items()},
    }
    second = choice.second
    if second is None:
        return {**about, "hip_error_estimate_m": None, "reason": "no other setting of this way is measured"}
    about["second_run"] = {"settings": dict(second.settings), "budget": round(second.budget, 2),
                           "order": round(second.order, 2)}  # fmt: skip
    try:
        difference = walk_difference(result.walk, rerun(second.settings).walk)
    except Exception as error:
        return {**about, "hip_error_estimate_m": None, "reason": f"the second run failed: {error}"}
    about["hip_difference_m"] = _rounded(difference)
    return {**about, "hip_error_estimate_m": _rounded(second.estimate(difference))}


def line(found: Mapping[str, Any]) -> str:
    """A verification in one line."""
    asked, used = _listed(found["asked"]), _listed(found["settings"])
    said = f"{found['stage']}: asked {asked}; used {used}; hip error expected {found['hip_error_expected_m']:.1e} m"
    estimate = found["hip_error_estimate_m"]
    if estimate is None:
        return f"{said}; not estimated: {found['reason']}"
    second = found["second_run"]
    other = f"a run with {_listed(second['settings'])}, at {second['budget']:g} of the cost"
    return f"{said}, estimated {estimate:.1e} m ({other}, differs by {found['hip_difference_m']:.1e} m)"


def walk_difference(one: Any, other: Any) -> float:
    """Largest distance [m] of two walks' hips at the times both have sampled; NaN without any."""
    import numpy as np

    times = (np.round(walk.time, PLACES) for walk in (one, other))
    _, first, second = np.intersect1d(*times, return_indices=True)
    if not len(first):
        return math.nan
    return float(np.abs(one.hip_position[first] - other.hip_position[second]).max())


def _listed(values: Mapping[str, float]) -> str:
    return ", ".join(f"{key} {value:g}" for key, value in values.items())


def _rounded(value: float) -> float:
    """Two digits: an estimate has no more."""
    return float(f"{value:.1e}")
