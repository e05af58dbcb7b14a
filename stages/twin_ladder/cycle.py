"""A machine's gait: fixed point of its stride in the plane, and the leading multipliers of its cycle, which has two
steps where the legs differ.

Strides are counted from mid-stance, in which the standing pair is normal to the ground. Place along and across the
slope do not matter, and pairs are named by role, so that a step maps the section onto itself where both pairs are
alike. A slope with a plane of symmetry keeps the two kinds of motion apart to first order: ten numbers in the plane,
those of the planar model's section, and nine out of it.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import eig

from stages.ground.contact_law import ContactLaw
from stages.ground.slope import Slope
from stages.planar.limit_cycle import by_differences, fixed_point
from stages.planar.section import NoLimitCycle, upright_at
from stages.studies.result import COMPLETED
from stages.twin.machine.contact import COUNT, HINGE, PITCH, ROLL, SLIDE, YAW, X, Y, Z
from stages.twin.machine.machine import Machine
from stages.twin.machine.tree import SpatialTree
from stages.twin.parameters import Settings
from stages.twin.walking.record import Record
from stages.twin.walking.simulate import Start, simulate_twin
from stages.twin_ladder.result import RungGait

#: Units of the numbers out of the plane.
SIDE_UNITS = ("rad", "rad", "m", "m", "m/s", "rad/s", "rad/s", "m/s", "m/s")
#: Multipliers that are wanted in the plane and out of it; the others are small.
IN_PLANE, SIDEWAYS = 2, 1
#: They are known when another stride changes them by no more than this, in errors of a difference; or by no more than
#: so many times that and no less than the stride before, which is noise.
SETTLED, NOISE, MOST_STRIDES = 5.0, 10.0, 6
#: Turns of a basis towards the changes that a matrix makes grow most: a power of their ratio to the others is left.
TURNS = 60
#: Step of central differences along changes that lead back to the gait, in the section's scales: no foot is lifted by
#: these, and shorter steps show the solver's error.
ALONG = 5e-3
UPRIGHT = np.zeros(9)
#: Changes (n,) of a section's numbers after a step and after two, for one at the start; all in the section's scales.
Changes = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]


@dataclass(frozen=True)
class SectionState:
    """A mid-stance by role of the pairs.

    plane (10,): hip y; swing angle; lengths of stance and swing legs; hip velocity x, y; rates of both angles and of
    both lengths. side (9,): yaw; roll; half the length difference left less right of stance and swing legs; hip
    velocity z; rates of yaw, roll and the differences. Lengths are means of a pair, from hip to foot bottom.
    """

    plane: np.ndarray
    side: np.ndarray


@dataclass(frozen=True)
class Step:
    """One step: the mid-stance it ends with, its duration [s], the hip's advance [m], the solver's steps and record."""

    end: SectionState
    duration: float
    length: float
    solver_steps: int
    record: Record


def section_state(q: np.ndarray, v: np.ndarray, stance: int, length: np.ndarray) -> SectionState:
    """Numbers of a mid-stance on pair `stance` from coordinates and rates (11,) and unloaded leg lengths (4,)."""
    legs, rates = length - q[list(SLIDE)], -v[list(SLIDE)]
    angle, turning = (row[[PITCH, PITCH]] + [0.0, row[HINGE]] for row in (q, v))
    order = [stance, 1 - stance]
    mean, half = legs.reshape(2, 2).mean(axis=1)[order], (0.5 * (legs[::2] - legs[1::2]))[order]
    mean_rate, half_rate = rates.reshape(2, 2).mean(axis=1)[order], (0.5 * (rates[::2] - rates[1::2]))[order]
    plane = [q[Y], angle[1 - stance], *mean, v[X], v[Y], *turning[order], *mean_rate]
    side = [q[YAW], q[ROLL], *half, v[Z], v[YAW], v[ROLL], *half_rate]
    return SectionState(np.array(plane), np.array(side))


def start_from(state: SectionState, stance: int, length: np.ndarray) -> Start:
    """The inverse of `section_state`, at x = z = 0, the swinging pair out of play."""
    q, v = np.zeros(COUNT), np.zeros(COUNT)
    y, swing, *lengths = state.plane[:4]
    forward, upward, *rates = state.plane[4:]
    q[Y], q[YAW], q[ROLL] = y, state.side[0], state.side[1]
    v[X], v[Y], v[Z], v[YAW], v[ROLL] = forward, upward, *state.side[4:7]
    angles, turning = np.array([0.0, swing]), np.array(rates[:2])
    if stance == 1:
        angles, turning = angles[::-1], turning[::-1]
    q[PITCH], q[HINGE] = angles[0], angles[1] - angles[0]
    v[PITCH], v[HINGE] = turning[0], turning[1] - turning[0]
    for role, pair in enumerate((stance, 1 - stance)):
        for side, sign in enumerate((1.0, -1.0)):
            leg = 2 * pair + side
            q[SLIDE[leg]] = length[leg] - lengths[role] - sign * state.side[2 + role]
            v[SLIDE[leg]] = -rates[2 + role] - sign * state.side[7 + role]
    return Start(q, v, (stance == 0, stance == 1))


StepMap = Callable[[SectionState, int], Step]


def step_map(machine: Machine, slope: Slope, contact: ContactLaw, settings: Settings) -> StepMap:
    """A function that takes a step from a mid-stance on a pair to the next on the other; it raises NoLimitCycle."""
    tree = SpatialTree(machine, slope, contact)

    def take(state: SectionState, stance: int) -> Step:
        start = start_from(state, stance, machine.length)
        record = simulate_twin(machine, slope, contact, start, settings, steps=1, tree=tree)
        if not record.completed:
            raise NoLimitCycle(record.reason or record.outcome)
        return _mid_stance(record, 1 - stance, machine.length)

    return take


def _mid_stance(record: Record, stance: int, length: np.ndarray) -> Step:
    """The end of a record, brought to the moment in which the new standing pair is normal to the ground."""
    before, moment = upright_at(record, [PITCH, HINGE][: 1 + stance])
    q, v = (rows[0] for rows in record.at(np.array([moment])))
    return Step(section_state(q, v, stance, length), moment, float(q[X]), before + 1, record)


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
class Gait:
    """A gait: its row; its mid-stance in the plane (10,); the change of one out of it that grows most or fades last, in
    scales (9, 1); its stride."""

    row: RungGait
    plane: np.ndarray
    sideways: np.ndarray
    stride: Stride

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

    `scales` are those of the section's numbers in the plane (10,) and out of it (9,). A cycle has so many `steps`.
    """

    def __init__(
        self, take: StepMap, scales: tuple[np.ndarray, np.ndarray], tolerance: float, difference: float,
        sideways: bool = True, steps: int = 1,
    ) -> None:
        self.take, (self.scales, self.side_scales), self.tolerance = take, scales, tolerance
        self.difference = difference
        self.sideways, self.steps_a_cycle = sideways, steps
        self.settled = SETTLED * tolerance / difference
        self.steps = 0

    def step(self, plane: np.ndarray, side: np.ndarray = UPRIGHT) -> Stride:
        """A stride from the inner pair's mid-stance."""
        self.steps += 2
        first = self.take(SectionState(plane, side), 0)
        return Stride(first, self.take(first.end, 1))

    def derivative(self, numbers: np.ndarray, after: Stride | None = None) -> np.ndarray:
        """Of a stride in the plane, by differences, (10, 10)."""
        return by_differences(self.step, numbers, self.difference * self.scales, after)

    def find(self, near: np.ndarray, derivative: np.ndarray, sideways: np.ndarray, **named: Any) -> Gait:
        """The gait near the mid-stance (10,) of a machine like this one, from the derivative of that one's stride (10,
        10) and its `sideways`; `named` is what its row says of the machine. Raises NoLimitCycle if it falls or the
        search fails."""
        found = fixed_point(self, near, derivative)
        first, second = found.step.first, found.step.second
        plane = self.multipliers(found.numbers, derivative, IN_PLANE)[:IN_PLANE]
        side = np.zeros(0)
        if self.sideways:
            side, sideways = leading(self._changes(found.numbers), sideways, self.settled, self.steps_a_cycle)
        period = 0.5 * (first.duration + second.duration)
        row = RungGait(
            **named,
            outcome=COMPLETED,
            period_s=period,
            step_length_m=0.5 * (first.length + second.length),
            inner_outer_difference=(first.duration - second.duration) / period,
            plane_multipliers=columns(plane),
            side_multipliers=columns(side),
            residual=found.residual,
            solver_steps=0.5 * (first.solver_steps + second.solver_steps),
            strides_walked=self.steps // 2,
        )
        return Gait(row, found.numbers, sideways, found.step)

    def multipliers(self, numbers: np.ndarray, near: np.ndarray, count: int) -> np.ndarray:
        """The `count` largest multipliers of a cycle in the plane, complex, or one more where the last is of a pair.

        They are those of the gait at `numbers` (10,), to first order in what its stride's derivative differs by from
        `near` (10, 10), that of a gait near it: the stride is differenced along the changes that go with these alone.
        """
        values, left, right = eig(near * self.scales / self.scales[:, None], left=True)
        order = np.argsort(-np.abs(values), kind="stable")
        count += bool(values[order[count - 1]].imag and values[order[count]] == values[order[count - 1]].conj())
        basis, across = (np.linalg.svd(np.hstack([part.real, part.imag]))[0][:, :count]
                         for part in (right[:, order[:count]], left[:, order[:count]]))  # fmt: skip
        sizes = ALONG * self.scales
        pairs = [[self.step(numbers + sign * sizes * column) for sign in (1.0, -1.0)] for column in basis.T]
        first = np.column_stack([ahead.first.end.plane - back.first.end.plane for ahead, back in pairs])
        second = np.column_stack([ahead.numbers - back.numbers for ahead, back in pairs])
        first, second = (columns / (2.0 * sizes[:, None]) for columns in (first, second))
        second = basis @ np.linalg.solve(across.T @ basis, across.T @ second)
        return multipliers_of(basis, first, second, self.steps_a_cycle)

    def _changes(self, plane: np.ndarray) -> Changes:
        """Out of the plane. The mirrored run is not walked: it would give the mirrored motion, and the motion in the
        plane stays.
        """
        sizes = self.difference * self.side_scales

        def changes(change: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            after = self.step(plane, sizes * change)
            return after.first.end.side / sizes, after.second.end.side / sizes

        return changes


def columns(values: np.ndarray) -> np.ndarray:
    """Complex numbers (n,) as real and imaginary part (n, 2)."""
    return np.column_stack([values.real, values.imag])


def leading(changes: Changes, start: np.ndarray, settled: float, steps: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """The k multipliers of a cycle of so many `steps` that are largest, complex (k,), and their changes (n, k).

    Orthogonal iteration from `start` (n, k): every stride turns the changes towards those sought, by the ratio of the
    next multiplier to theirs, squared, until that changes the multipliers by less than `settled`. What does not settle
    is taken from all n changes.
    """
    size, count = start.shape
    basis, known, before = np.linalg.qr(start)[0], np.full(count, np.inf + 0j), np.inf
    for _ in range(MOST_STRIDES):
        first, second = (np.column_stack(rows) for rows in zip(*map(changes, basis.T), strict=True))
        found = multipliers_of(basis, first, second, steps)
        changed = float(np.abs(found - known).max())
        if changed < settled or before <= changed < NOISE * settled:
            return found, basis
        basis, known, before = np.linalg.qr(second)[0], found, changed
    everything = np.eye(size)
    first, second = (np.column_stack(rows) for rows in zip(*map(changes, everything), strict=True))
    return multipliers_of(everything, first, second, steps)[:count], growing(second, basis)


def growing(matrix: np.ndarray, basis: np.ndarray) -> np.ndarray:
    """Orthonormal columns (n, k) that span what a matrix (n, n) makes grow most, or lets fade last, from a `basis`."""
    for _ in range(TURNS):
        basis = np.linalg.qr(matrix @ basis)[0]
    return basis


def multipliers_of(basis: np.ndarray, first: np.ndarray, second: np.ndarray, steps: int = 1) -> np.ndarray:
    """Multipliers of a cycle (k,), largest first, complex, from changes (n, k) and what two steps make of them.

    `basis` has orthonormal columns that a stride maps onto each other. The factor of a stride, a cycle of two `steps`,
    is an eigenvalue of that; that of a step, where the legs are alike, is its root, with the sign that shows whether a
    disturbance has changed its sign after the first step.
    """
    values, vectors = np.linalg.eig(basis.T @ second)
    found = values.astype(complex)
    if steps == 1:
        found = np.sqrt(found)
        along = ((basis @ vectors).conj() * (first @ vectors)).sum(axis=0)
        found = np.where((along * found.conj()).real < 0.0, -found, found)
        turning = np.flatnonzero((values.imag == 0.0) & (values.real < 0.0))  # an imaginary pair, of alike squares
        found[turning[1::2]] *= -1.0
    ordered: np.ndarray = found[np.lexsort((-found.imag, -np.abs(found).round(12)))]
    return ordered
