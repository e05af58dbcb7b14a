"""A design's gait from an anchor: along its tangent, corrected by Newton's method; in parts where that is too far."""

from __future__ import annotations

import numpy as np

from stages.analytic.errors import StepFailed
from stages.analytic.gait.newton import is_walking
from stages.analytic.gait.poincare import FixedPoint, iterate, poincare_map
from stages.analytic.maps.anchors import Anchor, anchor, with_numbers
from stages.analytic.model.kinds import Rigid
from stages.analytic.model.stiffness import attainable_tolerance
from stages.analytic.model.walker import Vector, Walker

#: Tolerance of derivatives that only lead Newton's method.
ROUGH = 1e-5
#: Newton's method keeps its matrix while a correction is at most this part of the one before, and takes a new one at
#: most so often. Longest correction of a coordinate.
KEEPS, RENEWALS, CORRECTIONS, LONGEST = 0.1, 6, 16, 0.3
#: Longest and shortest part of the way from an anchor.
PARTS = (1 / 2, 1 / 6)


def closes(walker: Walker, tolerance: float) -> float:
    """The residual that an answer may have: the tolerance, or the round-off of a length times the stiffness."""
    return tolerance if isinstance(walker.p, Rigid) else max(tolerance, 8 * np.finfo(float).eps * walker.p.k)


def corrected(walker: Walker, z: Vector, tolerance: float) -> FixedPoint | None:
    """The gait near section coordinates `z`, by Newton's method with few derivatives; None if it does not converge.

    The answer's derivative and residual are those at the answer, taken at the tolerance.
    """
    fine = attainable_tolerance(walker.p, tolerance)
    good_enough, unit = closes(walker, tolerance), np.eye(z.size)
    size, renewals = np.inf, 0
    inverse: np.ndarray | None = None
    try:
        for _ in range(CORRECTIONS):
            if inverse is None:
                renewals += 1
                steps, by_state = iterate(walker, z, walker.gait_steps, max(ROUGH, fine))
                image, inverse = steps[-1].z, np.linalg.inv(unit - by_state)
            else:
                image = repeated(walker, z, fine)
            change = inverse @ (image - z)
            before, size = size, float(np.abs(change).max())
            if size > LONGEST or not size <= max(2 * before, 1e-12):
                return None
            z = z + change
            if size <= 1e-3 and size <= KEEPS * before and size * size / before <= 0.1 * good_enough:
                found = exact(walker, z, fine)
                if found.residual <= good_enough:
                    return found if is_walking(found) else None
                inverse, size = np.linalg.inv(unit - found.monodromy_matrix), np.inf
                z = z + inverse @ (found.steps[-1].z - z)
            elif size > KEEPS * before and size > good_enough:
                if renewals == RENEWALS:
                    return None
                inverse = None
    except (StepFailed, np.linalg.LinAlgError):
        pass
    return None


def exact(walker: Walker, z: Vector, tolerance: float) -> FixedPoint:
    """The point `z` with its steps and derivative. Raises StepFailed like `poincare_map`."""
    steps, by_state = iterate(walker, z, walker.gait_steps, tolerance)
    return FixedPoint(z, tuple(steps), by_state, float(np.abs(steps[-1].z - z).max()))


def repeated(walker: Walker, z: Vector, tolerance: float) -> Vector:
    """Image of section coordinates `z` after the steps of a gait. Raises StepFailed like `poincare_map`."""
    for _ in range(walker.gait_steps):
        z, walker = poincare_map(walker, z, tolerance).z, walker.exchanged
    return z


def along_tangent(walker: Walker, known: Anchor, tolerance: float) -> FixedPoint | None:
    """The design's gait from an anchor in one part."""
    return corrected(walker, known.towards(np.array(walker.p)), tolerance)


def in_parts(walker: Walker, known: Anchor, tolerance: float) -> FixedPoint | None:
    """The design's gait from an anchor, followed along the straight line between them in parts."""
    start, end = known.numbers, np.array(walker.p)
    done, part, at = 0.0, PARTS[0], known
    while True:
        there = min(1.0, done + part)
        beside = walker if there > 1 - 1e-9 else with_numbers(walker, start + there * (end - start))
        found = corrected(beside, at.towards(np.array(beside.p)), tolerance if beside is walker else 1e-6)
        if found is not None and beside is walker:
            return found
        further = None if found is None else anchor(beside, found, 1e-6)
        if further is not None:
            done, at = there, further
        elif part > PARTS[1]:
            part = PARTS[1]
        else:
            return None
