"""A machine's gait: fixed point of its stride in the plane, and multipliers of its two steps by finite differences."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stages.planar.section import NoLimitCycle
from stages.twin_ladder.section import PLANE_SCALES, SIDE_SCALES, SectionState, Step, StepMap

MOST_ITERATIONS = 16
#: The derivative is made anew when an iteration leaves more than this of the residual, so often at most.
SLOW, MOST_RENEWALS = 0.3, 4
UPRIGHT = np.zeros(9)


@dataclass(frozen=True)
class Gait:
    """A gait at the inner pair's mid-stance.

    plane (10,): its numbers; derivatives of both steps in the plane (2, 10, 10), in the section's scales; multipliers
    of a step, largest first, complex; strides walked and solver steps of one stride.
    """

    plane: np.ndarray
    derivatives: np.ndarray
    plane_multipliers: np.ndarray
    side_multipliers: np.ndarray
    period: float
    step_length: float
    limp: float
    residual: float
    strides: int
    solver_steps: int


class Search:
    """Newton's method on the stride of one machine; counts the strides it walks."""

    def __init__(self, take: StepMap, difference: float, residual: float, sideways: bool = True) -> None:
        self.take = take
        self.difference = difference
        self.wanted = residual
        self.sideways = sideways
        self.steps = 0

    def step(self, plane: np.ndarray, stance: int, side: np.ndarray = UPRIGHT) -> Step:
        """One step from a mid-stance."""
        self.steps += 1
        return self.take(SectionState(plane, side), stance)

    def stride(self, plane: np.ndarray) -> tuple[Step, Step]:
        """Two steps from the inner pair's mid-stance in the plane."""
        first = self.step(plane, 0)
        return first, self.step(first.end.plane, 1)

    def find(self, plane: np.ndarray, derivatives: np.ndarray) -> Gait:
        """The gait near `plane`; `derivatives` (2, 10, 10) of a machine like this one serve until its own are known.

        Raises NoLimitCycle if the machine falls or the iteration does not converge.
        """
        previous, renewals = np.inf, 0
        for _ in range(MOST_ITERATIONS):
            first, second = self.stride(plane)
            moved = (second.end.plane - plane) / PLANE_SCALES
            residual = float(np.abs(moved).max())
            if residual < self.wanted:
                break
            if residual > SLOW * previous and renewals < MOST_RENEWALS:
                derivatives, renewals = self.plane_derivatives(plane, first, second), renewals + 1
            previous = residual
            newton = np.linalg.solve(np.eye(10) - derivatives[1] @ derivatives[0], moved)
            plane = plane + PLANE_SCALES * newton
        else:
            raise NoLimitCycle(f"no fixed point within {MOST_ITERATIONS} iterations, residual {residual:.1e}")
        return self._measured(plane, first, second, residual)

    def _measured(self, plane: np.ndarray, first: Step, second: Step, residual: float) -> Gait:
        derivatives = self.plane_derivatives(plane, first, second)
        side = self.side_derivatives(plane, first.end.plane) if self.sideways else np.zeros((2, 0, 0))
        period = 0.5 * (first.duration + second.duration)
        return Gait(
            plane=plane,
            derivatives=derivatives,
            plane_multipliers=step_multipliers(derivatives),
            side_multipliers=step_multipliers(side),
            period=period,
            step_length=0.5 * (first.length + second.length),
            limp=(first.duration - second.duration) / period,
            residual=residual,
            strides=self.steps // 2,
            solver_steps=first.solver_steps + second.solver_steps,
        )

    def plane_derivatives(self, inner: np.ndarray, first: Step, second: Step) -> np.ndarray:
        """Derivatives (2, 10, 10) of the steps from the inner and from the outer pair's mid-stance, in scales."""
        both = []
        for stance, (at, base) in enumerate(((inner, first.end.plane), (first.end.plane, second.end.plane))):
            columns = []
            for index, scale in enumerate(PLANE_SCALES):
                change = np.zeros(10)
                change[index] = self.difference * scale
                columns.append((self.step(at + change, stance).end.plane - base) / (self.difference * PLANE_SCALES))
            both.append(np.column_stack(columns))
        return np.stack(both)

    def side_derivatives(self, inner: np.ndarray, outer: np.ndarray) -> np.ndarray:
        """The same out of the plane (2, 9, 9). The mirrored run is not walked: it would give the mirrored motion."""
        both = []
        for stance, at in enumerate((inner, outer)):
            columns = []
            for index, scale in enumerate(SIDE_SCALES):
                change = np.zeros(9)
                change[index] = self.difference * scale
                columns.append(self.step(at, stance, change).end.side / (self.difference * SIDE_SCALES))
            both.append(np.column_stack(columns))
        return np.stack(both)


def step_multipliers(derivatives: np.ndarray) -> np.ndarray:
    """Multipliers of a step from the derivatives (2, n, n) of two steps in turn, largest first, complex (n,).

    The factor of a stride is an eigenvalue of their product; that of a step is its root, with the sign that tells
    whether a disturbance has changed its sign after the first step. For alike pairs these are the step map's own.
    """
    values, vectors = np.linalg.eig(derivatives[1] @ derivatives[0])
    roots = np.sqrt(values.astype(complex))
    after = derivatives[0] @ vectors
    along = (vectors.conj() * after).sum(axis=0)
    roots = np.where((along * roots.conj()).real < 0.0, -roots, roots)
    ordered: np.ndarray = roots[np.lexsort((-roots.imag, -np.abs(roots).round(12)))]
    return ordered
