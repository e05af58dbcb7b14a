"""What is known of a design beside the run's samples: a weighed mass, a measured length."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.model.walker import Vector

TOTAL_MASS = "total_mass"
#: How much of each parameter a known sum has.
SUMS = {TOTAL_MASS: {"biped.hip_mass": 1.0, "biped.foot_mass": 2.0, "biped.frame_mass": 2.0}}


@dataclass(frozen=True)
class Known:
    """A value with its standard deviation: of the parameter `name` ("biped.leg_length"), or of a sum ("total_mass")."""

    name: str
    value: float
    sd: float
    source: str = ""

    def parts(self) -> dict[str, float]:
        """How much of each parameter is in it, of a design whose legs are alike."""
        return SUMS.get(self.name, {self.name: 1.0})

    def row(self, names: Sequence[str]) -> Vector:
        """Its derivative by the parameters `names`, (n,)."""
        parts = dict(self.parts())
        for name in (name for name in names if self.name in SUMS and name.startswith("biped.other_")):
            first = name.replace("other_", "")
            if first in parts:
                parts[first], parts[name] = 1.0, 1.0
        return np.array([parts.get(name, 0.0) for name in names])

    def of(self, design: DesignPoint) -> float:
        """What a design has of it."""
        if self.name == TOTAL_MASS:
            return design.biped.total_mass
        return design.value(self.name)


def information_of(known: Iterable[Known], names: Sequence[str]) -> np.ndarray:
    """What known values add to the information (n, n) about the parameters `names`."""
    total = np.zeros((len(names), len(names)))
    for one in known:
        row = one.row(names)
        total += np.outer(row, row) / one.sd**2
    return total
