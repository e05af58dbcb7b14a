"""A machine's gait: fixed point of its stride in the plane, and the leading multipliers of its two steps."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from stages.planar.limit_cycle import by_differences, fixed_point
from stages.twin.machine.contact import X, Y
from stages.twin_ladder.section import SectionState, Step, StepMap

#: Multipliers that are wanted in the plane and out of it; the others are small.
IN_PLANE, SIDEWAYS = 2, 1
#: They are known when another stride changes them by no more than this, in errors of a difference; or by no more than
#: so many times that and no less than the stride before, which is noise.
SETTLED, NOISE, MOST_STRIDES = 5.0, 10.0, 6
#: Turns of a basis towards the changes that a matrix makes grow most: a power of their ratio to the others is left.
TURNS = 60
UPRIGHT = np.zeros(9)

#: Changes (n,) of a section's numbers after a step and after two, for one at the start; all in the section's scales.
Changes = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]


@dataclass(frozen=True)
class Stride:
    """Two steps from the inner pair's mid-stance; numbers (10,) in the plane at their end."""

    first: Step
    second: Step

    @property
    def numbers(self) -> np.ndarray:
        """As a step of the planar model has them."""
        return self.second.end.plane


@dataclass(frozen=True)
class Near:
    """What a machine's gait tells of one like it.

    plane (10,): its mid-stance; derivative of its stride (10, 10); changes of a mid-stance that grow most or fade last,
    a column each, in scales, in the plane (10, 2) and out of it (9, 1).
    """

    plane: np.ndarray
    derivative: np.ndarray
    in_plane: np.ndarray
    sideways: np.ndarray


@dataclass(frozen=True)
class Gait:
    """A gait: its leading multipliers of a step, largest first, complex; strides walked, solver steps of one stride."""

    near: Near
    stride: Stride
    plane_multipliers: np.ndarray
    side_multipliers: np.ndarray
    period: float
    step_length: float
    limp: float
    residual: float
    strides: int
    solver_steps: int

    def hip(self, phases: np.ndarray) -> np.ndarray:
        """Where the hip is at these shares of the stride, x and y from where it began, (n, 2) [m]."""
        first, second = self.stride.first, self.stride.second
        time = (first.duration + second.duration) * phases
        then = time - first.duration
        early, late = (step.record.at(np.clip(at, 0.0, step.duration))[0][:, [X, Y]]
                       for step, at in ((first, time), (second, then)))  # fmt: skip
        return np.where(then[:, None] < 0.0, early, late + [first.length, 0.0])


class Search:
    """Looks for the gait of one machine; counts the steps it walks. `tolerance` is that of the steps, in the scales.

    `scales` are those of the section's numbers in the plane (10,) and out of it (9,).
    """

    def __init__(
        self, take: StepMap, scales: tuple[np.ndarray, np.ndarray], tolerance: float, difference: float,
        sideways: bool = True,
    ) -> None:
        self.take, (self.scales, self.side_scales), self.tolerance = take, scales, tolerance
        self.difference = difference
        self.sideways = sideways
        self.settled = SETTLED * tolerance / difference
        self.steps = 0

    def step(self, plane: np.ndarray, stance: int, side: np.ndarray = UPRIGHT) -> Step:
        """One step from a mid-stance."""
        self.steps += 1
        return self.take(SectionState(plane, side), stance)

    def stride(self, plane: np.ndarray, side: np.ndarray = UPRIGHT) -> Stride:
        """Two steps from the inner pair's mid-stance."""
        first = self.step(plane, 0, side)
        return Stride(first, self.step(first.end.plane, 1, first.end.side))

    def find(self, near: Near) -> Gait:
        """The gait near that of a machine like this one. Raises NoLimitCycle if it falls or the search fails."""
        found = fixed_point(_Strides(self), near.plane, near.derivative)
        first, second = found.step.first, found.step.second
        rough = found.derivative * self.scales / self.scales[:, None]
        walked = self._in_plane(found.numbers, found.step)
        plane, in_plane, known = leading(walked, near.in_plane, self.settled, rough)
        side, sideways = np.zeros(0), near.sideways
        if self.sideways:
            side, sideways, _ = leading(self._sideways(found.numbers), near.sideways, self.settled)
        period = 0.5 * (first.duration + second.duration)
        return Gait(
            stride=found.step,
            near=Near(found.numbers, known * self.scales[:, None] / self.scales, in_plane, sideways),
            plane_multipliers=plane,
            side_multipliers=side,
            period=period,
            step_length=0.5 * (first.length + second.length),
            limp=(first.duration - second.duration) / period,
            residual=found.residual,
            strides=self.steps // 2,
            solver_steps=first.solver_steps + second.solver_steps,
        )

    def _in_plane(self, plane: np.ndarray, base: Stride) -> Changes:
        def changes(change: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            after = self.stride(plane + self.difference * self.scales * change)
            ends = (after.first.end.plane - base.first.end.plane, after.numbers - base.numbers)
            first, second = (end / (self.difference * self.scales) for end in ends)
            return first, second

        return changes

    def _sideways(self, plane: np.ndarray) -> Changes:
        """The mirrored run is not walked: it would give the mirrored motion, and the motion in the plane stays."""

        def changes(change: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            sizes = self.difference * self.side_scales
            after = self.stride(plane, sizes * change)
            return after.first.end.side / sizes, after.second.end.side / sizes

        return changes


class _Strides:
    """A machine's strides in the plane, as the solver for fixed points wants them."""

    def __init__(self, search: Search) -> None:
        self.step: Callable[[np.ndarray], Stride] = search.stride
        self.scales, self.tolerance = search.scales, search.tolerance
        self.differences = search.difference * search.scales

    def derivative(self, numbers: np.ndarray, after: Stride | None = None) -> np.ndarray:
        return by_differences(self.step, numbers, self.differences, after)


def leading(
    changes: Changes, start: np.ndarray, settled: float, stride: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The k multipliers of a step that are largest, complex (k,), the changes (n, k) that go with them, and what is
    known of the derivative of a stride (n, n).

    Orthogonal iteration from `start` (n, k): every stride turns the changes towards those sought, by the ratio of the
    next multiplier to theirs, squared, until that changes the multipliers by less than `settled`. So it is, too, where
    `stride`, if anything is known of that derivative before, says that it would not. What does not settle is taken
    from all n changes.
    """
    size, count = start.shape
    basis, known, before = np.linalg.qr(start)[0], np.full(count, np.inf + 0j), np.inf
    whole = np.zeros((size, size)) if stride is None else stride
    for _ in range(MOST_STRIDES):
        first, second = (np.column_stack(rows) for rows in zip(*map(changes, basis.T), strict=True))
        whole = whole + (second - whole @ basis) @ basis.T
        turned = growing(whole, basis)
        found = step_multipliers(basis, first, second)
        foreseen = step_multipliers(turned, first @ (basis.T @ turned), whole @ turned)
        changed = float(np.abs(found - known).max())
        if stride is not None:
            changed = min(changed, float(np.abs(found - foreseen).max()))
        if changed < settled or before <= changed < NOISE * settled:
            return found, basis, whole
        basis, known, before = np.linalg.qr(second)[0], found, changed
    everything = np.eye(size)
    first, second = (np.column_stack(rows) for rows in zip(*map(changes, everything), strict=True))
    return step_multipliers(everything, first, second)[:count], growing(second, basis), second


def growing(matrix: np.ndarray, basis: np.ndarray) -> np.ndarray:
    """Orthonormal columns (n, k) that span what a matrix (n, n) makes grow most, or lets fade last, from a `basis`."""
    for _ in range(TURNS):
        basis = np.linalg.qr(matrix @ basis)[0]
    return basis


def step_multipliers(basis: np.ndarray, first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Multipliers of a step (k,), largest first, complex, from changes (n, k) and what two steps make of them.

    `basis` has orthonormal columns that a stride maps onto each other. The factor of a stride is an eigenvalue of that;
    the factor of a step is its root, with the sign that tells whether a disturbance has changed its sign after the
    first step. For alike pairs these are the step map's own.
    """
    values, vectors = np.linalg.eig(basis.T @ second)
    roots = np.sqrt(values.astype(complex))
    along = ((basis @ vectors).conj() * (first @ vectors)).sum(axis=0)
    roots = np.where((along * roots.conj()).real < 0.0, -roots, roots)
    turning = np.flatnonzero((values.imag == 0.0) & (values.real < 0.0))  # an imaginary pair, whose squares are alike
    roots[turning[1::2]] *= -1.0
    ordered: np.ndarray = roots[np.lexsort((-roots.imag, -np.abs(roots).round(12)))]
    return ordered
