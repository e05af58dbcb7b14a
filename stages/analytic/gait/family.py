"""A gait's whole family over a parameter: both sides of the design, and the families of doubled period."""

from __future__ import annotations

from contextlib import suppress

import numpy as np

from stages.analytic.gait.continuation import PERIOD_DOUBLING, Branch, SpecialPoint, continue_gait
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.poincare import FixedPoint, fixed_point, iterate
from stages.analytic.model.walker import Vector, Walker
from stages.biped.progress import Progress, ignore

#: Just beyond its doubling a family has a multiplier this near to 1; other cycles may lie close by.
NEWBORN = 0.3
#: Largest distance of two gaits of a family, see `continue_gait`; for a longer cycle it is shorter.
LARGEST_STEP = 0.02


def leaves(point: FixedPoint, cycle: int) -> bool:
    """Whether a gait of twice `cycle` steps is one of the family that leaves its doubling, with a multiplier near 1."""
    moves = np.abs(point.steps[len(point.steps) // 2 - 1].z - point.z).max() > 1e-6
    return bool(moves and np.abs(point.floquet_multipliers - 1).min() < NEWBORN)


def doubled_start(design: DesignPoint, branch: Branch, special: SpecialPoint, tolerance: float) -> tuple[float, Vector]:
    """Parameter value and section coordinates on the family of twice the cycle that leaves a period doubling.

    The start lies a little beyond, displaced along the eigenvector of the multiplier -1, where Newton's method on the
    doubled map finds a gait that is not the old one. Raises ValueError if it finds none on either side.
    """
    span = max(abs(point.value) for point in branch.points)

    def walker_at(value: float) -> Walker:
        return design.with_value(branch.name, value).walker()

    there = walker_at(special.point.value)
    _, derivative = iterate(there, special.point.z, branch.cycle * there.gait_steps, tolerance)
    values, vectors = np.linalg.eig(derivative)
    direction = np.real(vectors[:, int(np.argmin(np.abs(values + 1)))])
    direction /= np.linalg.norm(direction)
    for shift in (1e-4, 1e-3, 1e-5, 3e-6):
        for sign in (1, -1):
            value = special.point.value + sign * shift * span
            for size in (1e-2, 3e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5):
                point = fixed_point(walker_at(value), special.point.z + size * direction, tolerance, 2 * branch.cycle)
                if point is not None and leaves(point, branch.cycle):
                    return value, point.z
    raise ValueError("no gait of twice the cycle was found next to the period doubling")


def follow_family(
    design: DesignPoint, name: str, limits: tuple[float, float], z: Vector, tolerance: float, doublings: int,
    progress: Progress = ignore, largest_step: float = LARGEST_STEP,
) -> list[Branch]:  # fmt: skip
    """The gait's family on both sides of the design, and the first `doublings` families of twice the cycle from it.

    Raises ValueError if `z` leads to no gait.
    """
    down, up = (
        continue_gait(design, name, limits, z, tolerance, upward=upward, largest_step=largest_step, progress=progress)
        for upward in (False, True)
    )
    points = (*reversed(down.points), *up.points[1:])
    family = Branch(name, 1, points, (*reversed(down.special), *up.special), f"{down.ended}; {up.ended}")
    branches = [family]
    for _ in range(doublings):
        newest = [known for known in branches if known.cycle == branches[-1].cycle]
        for branch, special in [(known, special) for known in newest for special in known.special]:
            if special.kind == PERIOD_DOUBLING:
                # a doubling whose new gaits no longer walk has no family to follow
                with suppress(ValueError):
                    branches.append(
                        doubled_family(design, branch, special, limits, tolerance, progress, largest_step))
        if branches[-1].cycle == newest[-1].cycle:
            break
    return branches


def doubled_family(
    design: DesignPoint, branch: Branch, special: SpecialPoint, limits: tuple[float, float], tolerance: float,
    progress: Progress = ignore, largest_step: float = LARGEST_STEP,
) -> Branch:  # fmt: skip
    """The family of twice the cycle that leaves a period doubling, followed away from it.

    Raises ValueError if no gait of twice the cycle is found.
    """
    value, start = doubled_start(design, branch, special, tolerance)
    there, cycle = design.with_value(branch.name, value), 2 * branch.cycle
    return continue_gait(
        there, branch.name, limits, start, tolerance,
        cycle=cycle, upward=value > special.point.value, largest_step=largest_step / cycle, progress=progress,
    )  # fmt: skip
