"""An accuracy that was asked for, checked by the run itself on the design at hand.

A table of what was measured on one design may propose settings; a second walk with finer ones decides. The finer walk
is kept. How far both differ is taken as its error: that is too much as soon as refining halves the error, and solvers
of any order do better. If it is more than asked, the next finer walk follows, up to the finest settings there are.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeVar

from stages.biped.accuracy.tolerances import Accuracy, errors_asked, scaled
from stages.biped.quantity import quantity

if TYPE_CHECKING:
    from stages.biped.walk import Walk

#: Places to which times count as equal [s].
PLACES = 9
#: Finest tolerance of Exudyn's explicit solver that the parameter files allow.
FINEST_EXPLICIT = 1e-11
#: So many times settings are refined at most.
MOST_REFINEMENTS = 5

S = TypeVar("S")
W = TypeVar("W")


class NotMet(ValueError):
    """An accuracy asked for cannot be shown to be met on this design; the message says what was reached."""


@dataclass(frozen=True)
class ErrorEstimate:
    """One error that was asked for, as estimated by a walk with coarser settings than the one kept."""

    name: str = quantity("-", "what was asked for, as in accuracy")
    asked: float = quantity("1", "largest error asked for, in the unit of its name")
    estimated: float = quantity("1", "difference from the coarser walk, in the unit of its name")
    settings: str = quantity("-", "solver settings of the walk kept")


def to_accuracy(
    accuracy: str | Accuracy,
    settings: S,
    walked: Callable[[S], W],
    finer: Callable[[S], S | None],
    differences: Callable[[W, W], Mapping[str, float]],
) -> tuple[S, W, tuple[ErrorEstimate, ...]]:
    """The walk that meets the accuracy, its settings and estimated errors; as `settings` are where nothing is asked.

    Raises NotMet.
    """
    asked = errors_asked(accuracy)
    last = walked(settings)
    if not asked:
        return settings, last, ()
    found: Mapping[str, float] = {}
    for _ in range(MOST_REFINEMENTS):
        refined = finer(settings)
        if refined is None:
            break
        walk = walked(refined)
        found, used = differences(last, walk), changed(settings, refined)
        settings, last = refined, walk
        if all(found.get(key, math.inf) <= error for key, error in asked.items()):
            return settings, last, tuple(ErrorEstimate(key, error, found[key], used) for key, error in asked.items())
    raise NotMet(f"the requested accuracy is not met on this design: {sentence(asked, found)}")


def finer_explicit(settings: S) -> S | None:
    """A tenth of the tolerance and half the largest step of an explicit solver; None below the finest tolerance."""
    given: Any = settings
    tolerance = scaled(given.tolerance, 0.1)
    if tolerance < FINEST_EXPLICIT:
        return None
    refined: S = dataclasses.replace(given, tolerance=tolerance, largest_step=given.largest_step / 2)
    return refined


def sentence(asked: Mapping[str, float], found: Mapping[str, float]) -> str:
    """What was asked and what was reached."""
    return "; ".join(
        f"{key} <= {error:g} requested, " + (f"{found[key]:.1e} reached with the finest settings" if key in found
                                          else "of which this stage has no estimate")
        for key, error in asked.items())  # fmt: skip


def changed(one: Any, other: Any) -> str:
    """The settings of `other` that differ from those of `one`."""
    return ", ".join(f"{key} {value:g}" for key, value in vars(other).items() if value != getattr(one, key))


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
