"""An accuracy that was requested, checked by the run itself on the design at hand.

The loosest settings are where it begins. A second walk with finer ones shows the error: how far both differ. That is
too much as soon as refining halves the error, and solvers of any order do better. If it exceeds the request, the next
pair is at the settings that should have half of what is requested, by what was found.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, TypeVar

from stages.biped.accuracy.tolerances import Accuracy, scaled
from stages.biped.quantity import quantity

if TYPE_CHECKING:
    from stages.biped.walk import Walk

#: Places to which times count as equal [s].
PLACES = 9
#: Finest tolerance of Exudyn's explicit solver that the parameter files allow, and the loosest at which feet stand.
FINEST_EXPLICIT, LOOSEST_EXPLICIT = 1e-11, 1e-4
#: Of a pair, the finer settings have this share of the coarser ones' tolerance; the largest step goes with its root.
REFINED, ROOT = 0.3, 0.3
#: What the coarser ones of the next pair aim at, as a share of the request, and how far they go at most. An error is
#: taken to follow the tolerance.
AIM, FARTHEST = 0.5, 1e-3
#: So many times settings are refined at most.
MOST_REFINEMENTS = 12

S = TypeVar("S")
W = TypeVar("W")


class NotMet(ValueError):
    """An accuracy requested cannot be shown to be met on this design; the message says what was reached."""


@dataclass(frozen=True)
class ErrorEstimate:
    """One error that was requested, as estimated by a walk with coarser settings than the one kept."""

    name: str = quantity("-", "what was requested, as in accuracy")
    asked: float = quantity("1", "largest error requested, in the unit of its name")
    estimated: float = quantity("1", "difference from the coarser walk, in the unit of its name")
    settings: str = quantity("-", "solver settings of the walk kept")


def to_accuracy(
    accuracy: str | Accuracy,
    settings: S,
    walked: Callable[[S], W],
    finer: Callable[[S, float], S | None],
    differences: Callable[[W, W], Mapping[str, float]],
) -> tuple[S, W, tuple[ErrorEstimate, ...]]:
    """The walk that meets the accuracy, its settings and estimated errors; as `settings` are without a request.

    `finer` gives settings at so many times the tolerance, within what there is; None at its end. Raises NotMet.
    """
    if isinstance(accuracy, str):
        return settings, walked(settings), ()
    wanted, given, settings = accuracy.errors, settings, finer(settings, math.inf) or settings
    last = walked(settings)
    found: Mapping[str, float] = {}
    for _ in range(MOST_REFINEMENTS):
        refined = finer(settings, REFINED)
        if refined is None:
            break
        walk = walked(refined)
        found, used = differences(last, walk), changed(given, refined)
        if not found.keys() >= wanted.keys():
            break
        over = max(found[key] / error for key, error in wanted.items())
        if over <= 1.0:
            return refined, walk, tuple(ErrorEstimate(key, error, found[key], used) for key, error in wanted.items())
        further = finer(settings, max(AIM / over, FARTHEST)) if AIM / REFINED < over < math.inf else None
        if further is None or finer(further, REFINED) is None:
            settings, last = refined, walk
        else:
            settings, last = further, walked(further)
    raise NotMet(f"the requested accuracy is not met on this design: {sentence(wanted, found)}")


def finer_explicit(settings: S, by: float) -> S | None:
    """So many times the tolerance of an explicit solver, and a smaller largest step; None at its finest tolerance."""
    given: Any = settings
    tolerance = min(max(scaled(given.tolerance, by), FINEST_EXPLICIT), LOOSEST_EXPLICIT)
    if tolerance == given.tolerance:
        return None
    step = given.largest_step * min(tolerance / given.tolerance, 1.0) ** ROOT
    refined: S = replace(given, tolerance=tolerance, largest_step=step)
    return refined


def sentence(wanted: Mapping[str, float], found: Mapping[str, float]) -> str:
    """What was wanted and what was reached."""
    return "; ".join(
        f"{key} <= {error:g} requested, " + (f"{found[key]:.1e} reached with the finest settings" if key in found
                                          else "of which this stage has no estimate")
        for key, error in wanted.items())  # fmt: skip


def changed(one: Any, other: Any) -> str:
    """The settings of `other` that differ from those of `one`, or that there is none."""
    found = [f"{key} {value:.3g}" for key, value in vars(other).items() if value != getattr(one, key)]
    return ", ".join(found) or "the level's own settings"


def walk_difference(one: Any, other: Any) -> float:
    """Largest distance [m] of two walks' hips at the times both have sampled; NaN without any."""
    import numpy as np  # parameters are read without it

    times = (np.round(walk.time, PLACES) for walk in (one, other))
    _, first, second = np.intersect1d(*times, return_indices=True)
    if not len(first):
        return math.nan
    return float(np.abs(one.hip_position[first] - other.hip_position[second]).max())


def walk_differences(one: Walk, other: Walk) -> dict[str, float]:
    """How far two walks differ, by the names of `Accuracy`; infinite if they do not make the same steps."""
    if len(one.heel_strike_time) != len(other.heel_strike_time):
        return dict.fromkeys(("hip_position_m", "period_s", "peak_force_n"), math.inf)
    import numpy as np

    durations = [np.diff(walk.heel_strike_time) for walk in (one, other)]
    found = {"hip_position_m": walk_difference(one, other)}
    if durations[0].size:
        found["period_s"] = float(np.abs(durations[0] - durations[1]).max())
    if len(one.ground_reaction):
        peaks = [float(walk.ground_reaction[:, :, 1].max()) for walk in (one, other)]
        found["peak_force_n"] = abs(peaks[0] - peaks[1])
    return found
