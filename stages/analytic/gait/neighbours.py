"""A design's gait from its neighbours: gaits of the same design on other slopes, or with other springs, followed to it.

A family that does not get there shows why the design has no gait: it turns back before, at a fold, or ends where the
step map does.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from stages.analytic.errors import StepFailed
from stages.analytic.gait.continuation import TURNING_POINT, Branch, continue_gait
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.newton import SEARCH_TOLERANCE, first_gait, is_walking
from stages.analytic.gait.poincare import FixedPoint, fixed_point
from stages.analytic.gait.search_starts import is_searched, ranked_starts

#: Where a gait is looked for: parameters, and factors on the design's value of each.
ELSEWHERE = {"ground.slope_deg": (0.5, 2.0, 0.25, 4.0), "biped.stiffness": (2.0, 4.0, 16.0),
             "biped.damping": (0.5, 0.25, 2.0, 4.0)}  # fmt: skip
#: A family is followed by so many gaits at most, this far apart.
MOST_GAITS, APART = 80, 0.15


@dataclass(frozen=True)
class Followed:
    """A neighbour's family followed towards the design in `name`: from `start` to `end`, the nearest it comes."""

    name: str
    unit: str
    start: float
    end: float
    folds: bool

    def __str__(self) -> str:
        where = f"{self.end:.6g} {self.unit}"
        what = f"turns back at {where}, a fold" if self.folds else f"is lost at {where}"
        return f"the gait at {self.name} = {self.start:.4g} {self.unit}, followed towards the design, {what}"


def from_neighbours(design: DesignPoint, tolerance: float) -> FixedPoint | list[Followed]:
    """The design's gait that a neighbour's leads to, or else how far each family followed gets, up to a first fold."""
    followed = []
    for name, neighbour, point in neighbours(design):
        try:
            branch = approach(neighbour, name, design.value(name), point)
        except StepFailed:
            continue
        last = branch.points[-1]
        if last.value == design.value(name):
            found = fixed_point(design.walker(), last.z, tolerance)
            if found is not None and is_walking(found):
                return found
        followed.append(nearest(branch, design))
        if followed[-1].folds:
            break
    return followed


def neighbours(design: DesignPoint) -> Iterator[tuple[str, DesignPoint, FixedPoint]]:
    """For each parameter, the nearest value tried at which the design has a gait, with that gait."""
    for name, factors in ELSEWHERE.items():
        if name != "ground.slope_deg" and design.biped.legs == "rigid":
            continue
        for factor in factors:
            neighbour = design.with_value(name, factor * design.value(name))
            if not neighbour.is_legal() or not is_searched((walker := neighbour.walker()).p):
                continue
            point = first_gait(walker, ranked_starts(walker, thinned=2)[0])
            if point is not None:
                yield name, neighbour, point
                break


def approach(neighbour: DesignPoint, name: str, wanted: float, point: FixedPoint) -> Branch:
    """The neighbour's family on the way to the wanted value."""
    start = neighbour.value(name)
    return continue_gait(
        neighbour, name, (min(start, wanted), max(start, wanted)), point.z, SEARCH_TOLERANCE,
        upward=wanted > start, largest_step=APART, most_points=MOST_GAITS, until_fold=True)


def nearest(branch: Branch, design: DesignPoint) -> Followed:
    """How near to the design the family comes, and whether it turns back there."""
    wanted = design.value(branch.name)
    folds = [special.point.value for special in branch.special if special.kind == TURNING_POINT]
    values = [*folds, *(point.value for point in branch.points)]
    end = min(values, key=lambda value: abs(value - wanted))
    return Followed(branch.name, design.unit(branch.name), branch.points[0].value, end, end in folds)
