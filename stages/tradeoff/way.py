"""A way to compute a walk, and what is compared of it.

All ways of one model walk from the same mid-stance. Compared are the hip's path on one grid of times, the duration of
the last step, the leading multiplier and the peak of the ground's normal force: they converge at different rates.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from stages.analytic.errors import StepFailed

#: Rate of the grid on which hips are compared [Hz].
GRID_HZ = 2000.0


@dataclass(frozen=True)
class Walked:
    """One walk: hip on the grid (n, 2) [m], last heel strike [s], last period [s], peak force [N], cost of a step."""

    hip: np.ndarray
    end: float
    period: float
    peak_force: float
    cost: float


@dataclass(frozen=True)
class Way:
    """One setting of one way: `walk` raises StepFailed; `multiplier` is None where it is not measured.

    `integrate` is what the walk takes without looking at it, to be timed. `setting` has the keys of the stage's
    parameters. A way of the paper, or this study's default, is marked.
    """

    model: str
    name: str
    setting: Mapping[str, float | str]
    integrate: Callable[[], Any]
    walk: Callable[[], Walked]
    multiplier: Callable[[], float] | None = None
    mark: str = ""

    @property
    def text(self) -> str:
        """The setting in one line."""
        return ", ".join(f"{key} {value:g}" if isinstance(value, float) else f"{key} {value}"
                         for key, value in self.setting.items())


def grid(end: float) -> np.ndarray:
    """Times of comparison up to `end` [s], shape (n,)."""
    return np.arange(math.floor(end * GRID_HZ)) / GRID_HZ


def hip_error(walked: Walked, reference: Walked) -> float:
    """Largest distance of the hips over the reference's walk up to its last heel strike [m].

    A walk that has ended by then is compared as far as it goes, if no more than a tenth of a step is missing.
    """
    count = math.floor(reference.end * GRID_HZ)
    common = min(count, len(walked.hip), len(reference.hip))
    if common < count - 0.1 * reference.period * GRID_HZ:
        raise StepFailed("it does not walk as far as the reference")
    return float(np.abs(walked.hip[:common] - reference.hip[:common]).max())
