"""What a map says of each design, and how a block of designs is answered: neighbours first, the full search at last.

A block is answered from its numbers alone, whatever other blocks say, so the map does not depend on who computes it.
As in `gait`, the answer is the most stable gait: the anchors are that by the full search, and families lead from there,
along the tangent and corrected by Newton's method, in parts where that is too far.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from stages.analytic.derivatives.gait import walk_derivatives
from stages.analytic.derivatives.on_blocks import on_blocks
from stages.analytic.errors import NoGait, StepFailed
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.gait_report import record_steps
from stages.analytic.gait.gait_search import find_gait, find_gaits, search as search_gait, step_length
from stages.analytic.gait.poincare import FixedPoint, by_stability, is_new, is_walking, iterate, repeated, round_off
from stages.analytic.maps.box import Box
from stages.analytic.model.kinds import Plain, present
from stages.analytic.model.stiffness import attainable_tolerance, judged
from stages.analytic.model.walker import Vector, Walker
from stages.analytic.walk.recording import Segment, in_single_stance, states_at
from stages.analytic.walk.sampling import accelerations_and_forces
from stages.analytic.walk.validity import friction_used
from stages.biped.question import Column

#: Tolerance of derivatives that only lead Newton's method.
ROUGH = 1e-5
#: Newton's method keeps its matrix while a correction is at most this part of the one before, and takes a new one at
#: most so often. Longest correction of a coordinate.
KEEPS, RENEWALS, CORRECTIONS, LONGEST = 0.1, 6, 16, 0.3
#: Longest and shortest part of the way from an anchor.
PARTS = (1 / 2, 1 / 6)


def closes(walker: Walker, tolerance: float) -> float:
    """The residual that an answer may have: the tolerance, or the round-off of a length times the stiffness."""
    return max(tolerance, round_off(walker))


def corrected(walker: Walker, z: Vector, tolerance: float) -> FixedPoint | None:
    """The gait near section coordinates `z`, by Newton's method with few derivatives; None if it does not converge.

    The answer's derivative and residual are those at the answer, taken at the tolerance.
    """
    fine = attainable_tolerance(walker.p, tolerance)
    good_enough, unit = closes(walker, tolerance), np.eye(z.size)
    size, renewals = np.inf, 0
    inverse: np.ndarray | None = None
    with suppress(StepFailed, np.linalg.LinAlgError):
        for _ in range(CORRECTIONS):
            if inverse is None:
                renewals += 1
                steps, by_state = iterate(walker, z, walker.gait_steps, max(ROUGH, fine))
                image, inverse = steps[-1].z, np.linalg.inv(unit - by_state)
            else:
                image = repeated(walker, z, walker.gait_steps, fine)
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
    return None


def exact(walker: Walker, z: Vector, tolerance: float) -> FixedPoint:
    """The point `z` with its steps and derivative. Raises StepFailed like `poincare_map`."""
    steps, by_state = iterate(walker, z, walker.gait_steps, tolerance)
    return FixedPoint(z, tuple(steps), by_state, float(np.abs(steps[-1].z - z).max()))


def along_tangent(walker: Walker, known: Anchor, tolerance: float) -> FixedPoint | None:
    """The design's gait from an anchor in one part."""
    return corrected(walker, known.towards(numbers_of(walker)), tolerance)


def in_parts(walker: Walker, known: Anchor, tolerance: float) -> FixedPoint | None:
    """The design's gait from an anchor, followed along the straight line between them in parts."""
    start, end = known.numbers, numbers_of(walker)
    done, part, at = 0.0, PARTS[0], known
    while True:
        there = min(1.0, done + part)
        beside = walker if there > 1 - 1e-9 else with_numbers(walker, start + there * (end - start))
        found = corrected(beside, at.towards(numbers_of(beside)), tolerance if beside is walker else 1e-6)
        if found is not None and beside is walker:
            return found
        further = None if found is None else anchor(beside, found, 1e-6)
        if further is not None:
            done, at = there, further
        elif part > PARTS[1]:
            part = PARTS[1]
        else:
            return None


def friction_needed(walker: Walker, point: FixedPoint, tolerance: float) -> float:
    """Largest |tangential| / normal in single stance, at the integrator's steps, amid them, and at heel strike.

    Infinite where the ground would pull. `validity.assess` samples three times as densely. NaN where the step cannot be
    taken again.
    """
    try:
        segments = record_steps(walker, point, tolerance)
    except StepFailed:
        return float("nan")
    return max(needed_in(walker.on(each.stance_leg), each) for each in segments if in_single_stance(each))


def needed_in(walker: Walker, single: Segment) -> float:
    """The same in one phase of single stance; `walker` is the one in its step."""
    edges = np.append(single.times, single.duration)
    amid = states_at(single.phase, single.times, single.states, (edges[1:] + edges[:-1]) / 2, walker.p)
    states = np.concatenate([single.states, amid, single.end[None]])
    return friction_used(accelerations_and_forces(single.phase, states, walker.p)[:, 4:6])


#: What became of a design.
OUTCOMES = ("stable", "unstable", "none", "unanswered", "not allowed")
STABLE, UNSTABLE, NONE, UNANSWERED, NOT_ALLOWED = range(len(OUTCOMES))
#: How a design was answered: along the tangent of the nearest anchor, of another anchor or design of its block, in
#: parts, or by a search.
WAYS = ("tangent", "neighbour", "homotopy", "search", "not")
TANGENT, NEIGHBOUR, HOMOTOPY, SEARCH, NOT = range(len(WAYS))
#: Multipliers that are stated, largest first.
MULTIPLIERS = 3
#: Columns of a map, after those of the varied parameters.
COLUMNS = (
    Column("outcome", "-", "what became of the design", OUTCOMES),
    Column("answered_by", "-", "how it was answered", WAYS),
    Column("period_s", "s", "duration of one step"),
    Column("step_length_m", "m", "advance of the hip over one step"),
    Column("speed_m_s", "m/s", "step length over duration"),
    *(Column(f"multiplier_{index}_{part}", "1",
             f"multiplier {index}, largest first, of two steps where legs differ: its {part} part")
      for index in range(1, MULTIPLIERS + 1) for part in ("real", "imag")),
    Column("largest_multiplier", "1", "magnitude of the largest multiplier, of one step"),
    Column("friction_single_stance", "1", "largest friction used in single stance"),
    Column("residual", "1", "by how much the gait fails to repeat, in leg lengths and pendulum times"),
)  # fmt: skip
#: What a map has besides where it is requested.
NORM = Column(
    "sensitivity_norm", "s/m", "gait sensitivity norm: spread of a step's duration over the rms height of blocks")
#: Anchors that a design is tried from, and solved designs of its own block.
TRIED = 3


def columns_of(norm: bool) -> tuple[Column, ...]:
    """Columns of a map, with the gait sensitivity norm or without."""
    return (*COLUMNS, NORM) if norm else COLUMNS


@dataclass(frozen=True)
class Task:
    """The box, and what its designs are answered from."""

    box: Box
    base: DesignPoint
    tolerance: float
    search: str
    anchors: Sequence[Sequence[Any]] = ()
    norm: bool = False


def anchors_of(task: Task, first: int, end: int) -> list[list[Any] | None]:
    """The anchors `first` to before `end` among so many spread over the box (`Anchor.plain`); None without a gait."""
    found: list[list[Any] | None] = []
    for values in task.box.spread(end)[first:]:
        design = task.box.design(task.base, values)
        here: Anchor | None = None
        if design.is_legal():
            with suppress(NoGait, StepFailed):
                here = anchor(*find_gait(design.biped, design.slope, task.tolerance, design.friction), task.tolerance)
        found.append(None if here is None else here.plain)
    return found


def block(task: Task, first: int, end: int) -> list[list[float]]:
    """The rows of `columns_of` of the designs `first` to before `end` of the box."""
    designs = [task.box.design(task.base, values) for values in task.box.values(first, end)]
    walkers = [design.walker() if design.is_legal() else None for design in designs]
    far = Anchors([Anchor.of(plain) for plain in task.anchors])
    answers: dict[int, tuple[int, FixedPoint]] = {}
    doubts: defaultdict[int, list[tuple[int, FixedPoint]]] = defaultdict(list)
    legal = [(index, walker) for index, walker in enumerate(walkers) if walker is not None]
    for index, walker in legal:
        if walker.p.g_x > 0 and (answer := followed(walker, far, task.tolerance, doubts[index])):
            answers[index] = answer
    for index, walker in legal:
        if index not in answers:
            near = beside(walker, walkers, answers, far, task.tolerance) if walker.p.g_x > 0 else Anchors([])
            answer = (followed(walker, near, task.tolerance, doubts[index], NEIGHBOUR)
                      or searched(designs[index], walker, task, doubts[index]))
            if answer is not None:
                answers[index] = answer
    return [row(walker, answers.get(index), task) for index, walker in enumerate(walkers)]


def followed(walker: Walker, anchors: Anchors, tolerance: float, doubtful: list[tuple[int, FixedPoint]],
             nearest: int = TANGENT) -> tuple[int, FixedPoint] | None:  # fmt: skip
    """The design's gait from a few anchors: at once, or else in parts.

    Newton's method may leave the family for another one. So an unstable gait, where the anchor is stable or the tangent
    led elsewhere, is taken once a second anchor leads to it too; until then it is among the `doubtful`.
    """
    numbers = numbers_of(walker)
    near = anchors.nearest(numbers, TRIED)
    for lead, way in ((along_tangent, None), (in_parts, HOMOTOPY)):
        for rank, known in enumerate(near):
            found = lead(walker, known, tolerance)
            if found is not None:
                answer, guess = (way or (NEIGHBOUR if rank else nearest), found), known.towards(numbers)
                led = np.abs(found.z - guess).max() <= np.abs(guess - known.z).max()
                again = not is_new([other for _, other in doubtful], found)
                if by_stability(found) < 1 or (led and not known.stable) or again:
                    return answer
                doubtful.append(answer)
    return None


def beside(
    walker: Walker, walkers: Sequence[Walker | None], answers: dict[int, tuple[int, FixedPoint]], far: Anchors,
    tolerance: float,
) -> Anchors:  # fmt: skip
    """The designs of the block that are answered and nearest, as anchors."""
    numbers = numbers_of(walker)
    known = [index for index in answers if (other := walkers[index]) is not None and alike(other, walker)]
    if not known:
        return Anchors([])
    distances = far.distances(np.array([numbers_of(each) for index in known if (each := walkers[index])]), numbers)
    found = []
    for place in np.argsort(distances, kind="stable")[:TRIED].tolist():
        other = walkers[known[place]]
        assert other is not None
        found.append(anchor(other, answers[known[place]][1], tolerance))
    return Anchors([each for each in found if each is not None])


def searched(
    design: DesignPoint, walker: Walker, task: Task, doubtful: Sequence[tuple[int, FixedPoint]]
) -> tuple[int, FixedPoint] | None:
    """The design's gait by a search from no guess, as far as that is the task's, or a `doubtful` more stable one."""
    found: FixedPoint | list[str] | None = None
    if task.search == "complete":
        found = search_gait(design, walker, task.tolerance)
    elif task.search == "limited":
        found = next(iter(find_gaits(walker, task.tolerance, unstable=False)), None)
    if isinstance(found, FixedPoint) and found.residual > closes(walker, task.tolerance):
        found = corrected(walker, found.z, task.tolerance)
    every = [*doubtful, *([(SEARCH, found)] if isinstance(found, FixedPoint) else [])]
    return min(every, key=lambda answer: by_stability(answer[1]), default=None)


def row(walker: Walker | None, answer: tuple[int, FixedPoint] | None, task: Task) -> list[float]:
    """A design's row: codes of `OUTCOMES` and `WAYS`, then numbers, NaN where there is no gait."""
    if walker is None or answer is None:
        outcome = NOT_ALLOWED if walker is None else (
            NONE if task.search == "complete" or walker.p.g_x <= 0 else UNANSWERED)
        return [float(outcome), float(NOT), *[float("nan")] * (len(columns_of(task.norm)) - 2)]
    way, point = answer
    period, length = point.period * walker.time, step_length(walker, point) * walker.length
    multipliers = [part for value in point.floquet_multipliers[:MULTIPLIERS].tolist()
                   for part in (value.real, value.imag)]  # fmt: skip
    largest = by_stability(point)
    outcome = STABLE if largest < 1 else UNSTABLE
    friction = friction_needed(walker, point, task.tolerance)
    rough = on_blocks(walker, point, task.tolerance) if task.norm else None
    return [float(outcome), float(way), period, length, length / period, *multipliers, largest, friction,
            point.residual, *([rough.sensitivity_norm if rough else float("nan")] if task.norm else [])]


@dataclass(frozen=True)
class Anchor:
    """A gait: numbers of its walker (f,), section coordinates (j,), and `slopes` (j, f): their derivatives by these."""

    numbers: Vector
    z: Vector
    slopes: np.ndarray
    stable: bool

    @classmethod
    def of(cls, plain: Sequence[Any]) -> Anchor:
        """The anchor that `plain` describes."""
        numbers, z, slopes, stable = plain
        return cls(np.array(numbers), np.array(z), np.array(slopes).reshape(len(z), -1), stable)

    @property
    def plain(self) -> list[Any]:
        """Numbers, coordinates, slopes by rows, and whether the gait is stable."""
        return [self.numbers.tolist(), self.z.tolist(), self.slopes.ravel().tolist(), self.stable]

    def towards(self, numbers: Vector) -> Vector:
        """Coordinates of the gait of a walker with other numbers, along the tangent."""
        return np.asarray(self.z + self.slopes @ (numbers - self.numbers))


def anchor(walker: Walker, point: FixedPoint, tolerance: float) -> Anchor | None:
    """The gait as an anchor; None on a fold, or where its steps cannot be taken with their derivatives.

    Of a detailed walker it is always that of a stride: the legs of its neighbours may differ where its own do not.
    """
    places = [walker.p._fields.index(name) for name in present(walker.p)]
    along, steps = np.eye(len(walker.p))[places], 1 if isinstance(walker.p, Plain) else 2
    try:
        end = walk_derivatives(walker, point.z, along, steps, attainable_tolerance(walker.p, tolerance))[-1]
        slopes = np.linalg.solve(np.eye(point.z.size) - end.by_start, end.along)
    except (StepFailed, np.linalg.LinAlgError):
        return None
    return Anchor(numbers_of(walker), point.z, slopes, by_stability(point) < 1)


def with_numbers(walker: Walker, numbers: Vector) -> Walker:
    """The walker with other numbers, in the same units."""
    p: Any = walker.p
    return replace(walker, p=judged(p._replace(**dict(zip(present(p), numbers.tolist(), strict=True)))))


def numbers_of(walker: Walker) -> Vector:
    """The numbers that a walker has."""
    return np.array([getattr(walker.p, name) for name in present(walker.p)])


def alike(one: Walker, other: Walker) -> bool:
    """Whether walkers have the same numbers, whatever their values, and steps of one kind."""
    return type(one.p) is type(other.p) and present(one.p) == present(other.p) and one.stiff == other.stiff


class Anchors:
    """Anchors, nearest first: a number counts by how much it moves the gaits."""

    def __init__(self, known: Sequence[Anchor]) -> None:
        fields = max((each.numbers.size for each in known), default=0)  # a hip without friction has a number less
        self.known = [each for each in known if each.numbers.size == fields]
        self._numbers = np.array([each.numbers for each in self.known])
        moves = [np.linalg.norm(each.slopes, axis=0) for each in self.known]
        self._weights = np.median(moves, axis=0) if known else np.ones(1)

    def distances(self, numbers: np.ndarray, other: Vector) -> Vector:
        """How far walkers with these numbers (n, f) are from another, `other` (f,)."""
        weights = self._weights if self._weights.size in (1, other.size) else np.ones(1)
        return np.asarray(np.linalg.norm((numbers - other) * weights, axis=1))

    def nearest(self, numbers: Vector, count: int) -> list[Anchor]:
        """Up to `count` anchors, the nearest first."""
        if not self.known or self._numbers.shape[1] != numbers.size:
            return []
        order = np.argsort(self.distances(self._numbers, numbers), kind="stable")
        return [self.known[row] for row in order[:count].tolist()]


NAMES = [column.name for column in COLUMNS]
#: Columns of which the range is stated.
SUMMARISED = ("period_s", "step_length_m", "speed_m_s", "largest_multiplier", "friction_single_stance", NORM.name)


class Counts:
    """Counts and ranges of the rows given so far, which have these columns."""

    def __init__(self, columns: Sequence[Column]) -> None:
        self._columns = {column.name: (place, column) for place, column in enumerate(columns)}
        self.designs, self.residual = 0, 0.0
        self._outcomes: Counter[int] = Counter()
        self._ways: Counter[int] = Counter()
        self._least, self._most = np.full(len(columns), np.inf), np.full(len(columns), -np.inf)

    def add(self, rows: Sequence[Sequence[float]]) -> np.ndarray:
        """Count the rows of a block; gives them back as an array."""
        table = np.array(rows, dtype=float)
        self.designs += len(table)
        self._outcomes.update(table[:, 0].astype(int).tolist())
        self._ways.update(table[:, 1].astype(int).tolist())
        self._least = np.fmin(self._least, np.fmin.reduce(table))
        self._most = np.fmax(self._most, np.fmax.reduce(table))
        self.residual = float(max(self._most[NAMES.index("residual")], 0.0))
        return table

    @property
    def answered(self) -> int:
        """Designs with a gait."""
        return self._outcomes[STABLE] + self._outcomes[UNSTABLE]

    def outcomes(self) -> dict[str, int]:
        """Designs by outcome."""
        return {word: self._outcomes[code] for code, word in enumerate(OUTCOMES) if self._outcomes[code]}

    def ways(self) -> dict[str, int]:
        """Designs by how they were answered."""
        return {word: self._ways[code] for code, word in enumerate(WAYS) if self._ways[code]}

    def ranges(self) -> dict[str, tuple[float, float]]:
        """Least and largest value of some columns."""
        places = {name: self._columns[name][0] for name in SUMMARISED if name in self._columns}
        return {name: (float(self._least[at]), float(self._most[at])) for name, at in places.items()}

    def as_plain(self) -> dict[str, Any]:
        """As JSON."""
        ranges = {name: {"low": low, "high": high, "unit": self._columns[name][1].unit}
                  for name, (low, high) in self.ranges().items()}  # fmt: skip
        return {
            "designs": self.designs,
            "outcomes": self.outcomes(),
            "answered_by": self.ways(),
            "largest_residual": self.residual,
            "ranges": ranges if self.answered else {},
        }
