"""Design search: the least (or largest) value of a goal over chosen design parameters within bounds.

A goal is the largest of several smooth parts (`goals`), and the optimum often lies where two of them meet or in
a corner of the bounds. So each step solves the linear programme min t, part_i + g_i d <= t, in a box, with exact
gradients and with targets (speed, step length) as linear equations. Where the optimum is neither, curvature decides:
SciPy's SLSQP goes on from there with the same gradients. Where the search ends, one more linear programme says what is
left to gain.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import linprog, minimize
from scipy.stats import qmc

from stages.analytic.derivatives.gait import GaitTangents, gait_derivatives
from stages.analytic.design.goals import GOALS, Goal
from stages.analytic.errors import StepFailed
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.gait_search import describe
from stages.analytic.gait.poincare import FixedPoint, fixed_point
from stages.analytic.model.walker import Vector, Walker
from stages.biped.walk import Gait

#: Measures that can be held, by the words that goals and `ask` have for them: the goal's own, or a field of the gait.
TARGETS = {"multiplier": "multiplier", "friction": "friction", "scuff": "scuff", "speed": "speed_m_s",
           "step_length": "step_length_m", "step_frequency": "step_frequency_hz"}  # fmt: skip
#: Price of missing a target, per unit of relative error: above any slope of the goals seen.
PENALTY = 10.0
#: Longest way in one go, so that the gait stays the same one; half widths of the first and of the widest box, and of
#: the one in which what is left to gain is estimated, all in shares of the parameters.
STRIDE, FIRST, LONGEST, NEAR = 0.05, 0.05, 0.3, 1e-3
#: SLSQP ends where it expects no more than this share of the start's value.
ACCURACY = 1e-12
#: An optimum gains less than this share of the start's value for a share of the parameters; parts and bounds this near
#: count as met.
STATIONARY, MET = 1e-6, 1e-6
#: Smallest box of a step. Where it ends for want of a gait, a fold has a multiplier so near to one.
BESIDE, FOLD = 1e-7, 0.05
#: Multipliers this near to each other, as a share of their size, all but meet.
TOGETHER = 0.05
#: A target is held that is missed by no more than this share; steps that lead to it at most.
HELD, RESTORED = 1e-6, 4
#: Searches end at the same value if they differ by no more than this share.
SAME = 1e-4
#: Where a search ends, in words.
ENDINGS = {
    "minimum": "in a minimum inside the bounds",
    "maximum": "in a maximum inside the bounds",
    "bound": "in an optimum on bounds",
    "kink": "in a kink: two parts of the goal are equal there, and one cannot get better but for the other",
    "coalescence": "where two multipliers meet and the goal changes ever steeper with the parameters",
    "fold": "on a fold: beyond it this gait does not exist",
    "edge": "at the edge of what can be walked: beyond it this gait is not found",
    "walked": "where no design beside it walks longer on the same blocks",
    "unfinished": "without an optimum",
}
#: Least and largest value of measures that are held, by field.
Targets = Mapping[str, tuple[float, float]]


@dataclass(frozen=True)
class Candidate:
    """A design with its gait, its parts of the goal (m,) with the goal's sign, its measures that are held (k,), SI, and
    the shares of the middles of their targets by which it is outside of these (k,).
    """

    design: DesignPoint
    walker: Walker
    point: FixedPoint
    gait: Gait
    parts: Vector
    held: Vector
    misses: Vector

    @property
    def largest_multiplier(self) -> float:
        """Magnitude of the largest multiplier, of one step."""
        return self.gait.largest_multiplier

    @property
    def value(self) -> float:
        """The goal, SI."""
        return float(np.abs(self.parts.max()))


@dataclass(frozen=True)
class DesignSearch:
    """The best design from one start, how it was reached, and where the search ended.

    `history` (k + 1,) and `path` (k + 1, n) are the goal and the parameters' values by step. `ending` is one of
    `ENDINGS`; `bounds` names the parameters that are at their "lower" or "upper" bound; `gain` is what is left to gain,
    in shares of the start's value for a share of the parameters. `gaits` and `gradients` count how often a gait was
    found and differentiated. `own` says whether it began with the design given.
    """

    start: Candidate
    best: Candidate
    history: tuple[float, ...]
    path: np.ndarray
    ending: str
    bounds: Mapping[str, str]
    gain: float
    gaits: int
    gradients: int
    own: bool = True

    @property
    def met(self) -> bool:
        """Whether the best design holds the targets."""
        return bool((np.abs(self.best.misses) <= HELD).all())

    @property
    def converged(self) -> bool:
        """Whether the search holds the targets, and ended for another reason than want of steps."""
        return self.met and self.ending != "unfinished"


class Problem:
    """Parameters `names` in relative units x (sizes of start values), with bounds, targets and a goal to be least."""

    def __init__(
        self,
        design: DesignPoint,
        bounds: Mapping[str, tuple[float, float]],
        targets: Targets,
        tolerance: float,
        goal: Goal = GOALS["multiplier"],
        maximise: bool = False,
    ) -> None:
        self.names: Sequence[str] = list(bounds)
        self.design, self.targets, self.tolerance = design, list(targets), tolerance
        low, high = np.array(list(targets.values())).reshape(-1, 2).T
        self.middles, self.room = (low + high) / 2, (high - low) / (high + low)
        self.goal, self.sign = goal, -1.0 if maximise else 1.0
        self.scale = np.array([abs(design.value(name)) or max(map(abs, bounds[name])) for name in self.names])
        self.lower, self.upper = np.array([bounds[name] for name in self.names]).T / self.scale
        self.unit, self.gaits, self.derivatives = 1.0, 0, 0
        self.latest: tuple[Candidate, tuple[np.ndarray, np.ndarray] | None] | None = None

    def start(self) -> Vector:
        """The design's own values in relative units."""
        return np.asarray(self.values(self) / self.scale)

    def values(self, of: Candidate | Problem) -> Vector:
        """Values (n,) of the parameters in the design of a candidate, or in that of the problem."""
        return np.array([of.design.value(name) for name in self.names])

    def candidate(self, x: Vector, z: Vector) -> Candidate | None:
        """The gait near `z` of the design at `x`; None if the design is illegal or has no gait there."""
        design = self.design.with_values(dict(zip(self.names, x * self.scale, strict=True)))
        if not design.is_legal():
            return None
        walker = design.walker()
        self.gaits += 1
        point = fixed_point(walker, z, self.tolerance)
        if point is None:
            return None
        try:
            parts = self.sign * self.goal.parts(walker, point, self.tolerance)
            gait = describe(walker, point)
            held = np.array([GOALS[name].parts(walker, point, self.tolerance).max() if name in GOALS
                             else getattr(gait, name) for name in self.targets])  # fmt: skip
        except StepFailed:
            return None
        offsets = held / self.middles - 1
        return Candidate(design, walker, point, gait, parts[[parts.argmin()]] if self.sign < 0 else parts, held,
                         offsets - np.clip(offsets, -self.room, self.room))  # fmt: skip

    def merit(self, here: Candidate) -> float:
        """The goal in units of the start's value, with the price of missed targets."""
        return float(here.parts.max() / self.unit + PENALTY * np.abs(here.misses).sum())

    def position(self, here: Candidate) -> Vector:
        """Where a candidate is, in relative units."""
        return np.asarray(self.values(here) / self.scale)

    def met_bounds(self, here: Candidate) -> dict[str, str]:
        """The parameters that are at their "lower" or "upper" bound."""
        x = self.position(here)
        room = zip(self.names, x - self.lower, self.upper - x, strict=True)
        return {name: "lower" if below < MET else "upper" for name, below, above in room if min(below, above) < MET}

    def follow(self, here: Candidate, x: Vector) -> Candidate | None:
        """The gait of `here` followed to the design at `x`."""
        origin = self.position(here)
        parts = max(1, int(np.ceil(np.abs(x - origin).max() / STRIDE)))
        for part in range(1, parts + 1):
            there = self.candidate(origin + (x - origin) * part / parts, here.point.z)
            if there is None:
                return None
            here = there
        return here

    def gradients(self, here: Candidate) -> tuple[np.ndarray, np.ndarray] | None:
        """Gradients by x of the parts (m, n) and of what is held, in middles of targets (k, n); None on a fold."""
        if self.latest is None or self.latest[0] is not here:
            self.latest = here, self._gradients(here)
        return self.latest[1]

    def _gradients(self, here: Candidate) -> tuple[np.ndarray, np.ndarray] | None:
        self.derivatives += 1
        try:
            gait = gait_derivatives(here.design, here.point, tuple(self.names), self.tolerance)
            parts = self._largest(here, gait, self.goal) if self.sign < 0 else self.goal.slopes(gait, self.tolerance)
            shares, units = gait.elasticities(), self.scale / gait.changes.scales
            held = [self._largest(here, gait, GOALS[name])[0] if name in GOALS else value * shares[name]
                    for name, value in zip(self.targets, here.held, strict=True)]  # fmt: skip
        except (StepFailed, np.linalg.LinAlgError):
            return None
        return self.sign * parts * units, np.array(held).reshape(-1, len(units)) / self.middles[:, None] * units

    def _largest(self, here: Candidate, gait: GaitTangents, goal: Goal) -> np.ndarray:
        """Derivatives (1, n) of the largest part of a goal for whole shares of the parameters."""
        parts = goal.parts(here.walker, here.point, self.tolerance)
        return np.asarray(goal.slopes(gait, self.tolerance)[[parts.argmax()]])


@dataclass
class Path:
    """The designs taken, the most steps, and who listens to the progress."""

    taken: list[Candidate]
    most: int
    progress: Callable[[int, float], None]

    def add(self, there: Candidate) -> None:
        """Take a design."""
        self.taken.append(there)
        self.progress(len(self.taken) - 2, there.value)


def linear_step(problem: Problem, here: Candidate, radius: float) -> tuple[float, Vector]:
    """What the goal, in units of the start's, and its price of missed targets gain to first order; the step (n,) to it.

    The linear programme min t + price, part + slope d <= t, with |d| at most `radius` and in the bounds. Nothing is
    gained on a fold, where there are no slopes.
    """
    x, slopes = problem.position(here), problem.gradients(here)
    if slopes is None:
        return 0.0, np.zeros(len(x))
    rows, held = slopes[0] / problem.unit, slopes[1]
    count, targets, parts = len(x), len(here.held), here.parts / problem.unit
    cost = np.concatenate([np.zeros(count), [1.0], PENALTY * np.ones(2 * targets), np.zeros(targets)])
    upper = np.hstack([rows, -np.ones((len(parts), 1)), np.zeros((len(parts), 3 * targets))])
    eye = np.eye(targets)  # missed above, missed below, and where within the target
    equal = np.hstack([held, np.zeros((targets, 1)), -eye, eye, -eye]) if targets else None
    box = np.column_stack([np.maximum(problem.lower - x, -radius), np.minimum(problem.upper - x, radius)])
    solution = linprog(cost, upper, -parts, equal, 1 - here.held / problem.middles if targets else None,
                       [*map(tuple, box), (None, None), *[(0, None)] * (2 * targets),
                        *zip(-problem.room, problem.room, strict=True)])
    if solution.x is None:
        return 0.0, np.zeros(count)
    return max(0.0, problem.merit(here) - float(solution.fun)), solution.x[:count]


def linear_steps(problem: Problem, path: Path, radius: float, least: float) -> bool:
    """Go on by linear programmes in a box that grows with success and shrinks, down to `least`, without.

    Returns whether the gait was lost at the last.
    """
    lost = False
    while len(path.taken) <= path.most and radius > least:
        here = path.taken[-1]
        gain, step = linear_step(problem, here, radius)
        if gain <= STATIONARY * radius:
            return False
        there = problem.follow(here, problem.position(here) + step)
        if there is None or problem.merit(there) >= problem.merit(here) - 1e-12:
            lost, radius = there is None, radius / 3
        else:
            path.add(there)
            lost, radius = False, min(2 * radius, LONGEST)
    return lost


def curved_steps(problem: Problem, path: Path) -> None:
    """Go on by SLSQP, which learns the curvature, near by; it evaluates v = (x, t), t in units of the start's value."""
    here, count, unit = path.taken[-1], len(problem.names), problem.unit
    x = problem.position(here)
    requested: dict[bytes, Candidate] = {}

    def at(v: Vector) -> Candidate:
        inside = np.clip(v[:-1], problem.lower, problem.upper)
        if inside.tobytes() not in requested:
            there = problem.candidate(inside, path.taken[-1].point.z)
            if there is None:
                raise StepFailed("the gait is lost")
            if len(there.parts) != len(here.parts):
                raise StepFailed("the hip has another number of events")
            requested[inside.tobytes()] = there
        return requested[inside.tobytes()]

    def slopes(v: Vector, kind: int) -> np.ndarray:
        found = problem.gradients(at(v))
        if found is None:
            raise StepFailed("the family of gaits folds")
        return found[kind]

    def accept(v: Vector) -> None:
        if problem.merit(at(v)) < problem.merit(path.taken[-1]):
            path.add(at(v))

    room = {"type": "ineq", "fun": lambda v: v[-1] - at(v).parts / unit,
            "jac": lambda v: np.column_stack([-slopes(v, 0) / unit, np.ones(len(here.parts))])}
    exact = problem.room == 0.0

    def offsets(v: Vector) -> Vector:
        return np.asarray(at(v).held / problem.middles - 1)

    def moves(v: Vector) -> np.ndarray:
        return np.column_stack([slopes(v, 1), np.zeros(len(exact))])

    held = {"type": "eq", "fun": lambda v: offsets(v)[exact], "jac": lambda v: moves(v)[exact]}
    kept = [{"type": "ineq", "fun": lambda v, side=side: (problem.room - side * offsets(v))[~exact],
             "jac": lambda v, side=side: -side * moves(v)[~exact]} for side in (1, -1)]
    near = np.clip(np.array([x - NEAR, x + NEAR]), problem.lower, problem.upper)
    bounds, most = [*near.T.tolist(), (None, None)], max(1, path.most + 1 - len(path.taken))
    with suppress(StepFailed):
        minimize(
            lambda v: v[-1], np.append(x, here.parts.max() / unit), jac=lambda v: np.eye(count + 1)[-1], bounds=bounds,
            method="SLSQP", constraints=[room, *([held] if exact.any() else []), *(kept if not exact.all() else [])],
            callback=accept,
            options={"maxiter": most, "ftol": ACCURACY})


def search_design(
    design: DesignPoint,
    z: Vector,
    bounds: Mapping[str, tuple[float, float]],
    *,
    targets: Targets | None = None,
    tolerance: float = 1e-10,
    iterations: int = 60,
    goal: str | Goal = "multiplier",
    maximise: bool = False,
    starts: int = 1,
    progress: Callable[[int, float], None] = lambda iteration, merit: None,
) -> list[DesignSearch]:
    """Searches for the least (or largest) `goal`, a word of `GOALS` or one's own, from the design with its gait at
    section coordinates `z` and from more `starts` spread within the bounds, where the gait leads there; the best comes
    first, and where none holds the targets the nearest to them.

    `bounds` gives (lower, upper) of each parameter to vary, by its name in the parameter files; `targets` least and
    largest value of measures to hold, by their fields in `TARGETS` [SI]. Raises ValueError without a gait at `z`.
    """
    goal = GOALS[goal] if isinstance(goal, str) else goal
    problem = Problem(design, bounds, targets or {}, tolerance, goal, maximise)
    own = problem.candidate(np.clip(problem.start(), problem.lower, problem.upper), z)
    if own is None:
        raise ValueError("the design has no gait to start the search from")
    problem.unit = own.value or 1.0
    spread = qmc.Halton(len(bounds), scramble=False).random(starts)[1:]  # its first point is a corner
    others = (problem.follow(own, problem.lower + point * (problem.upper - problem.lower)) for point in spread)
    found = [replace(search_from(problem, start, iterations, progress), own=start is own)
             for start in (own, *others) if start is not None]
    found.sort(key=lambda search: (0.0 if search.met else np.abs(search.best.misses).sum(),
                                   problem.sign * search.best.value))
    met, best = found[0].met, found[0].best.value  # of two alike the design's own comes first
    return sorted(found, key=lambda search: not (
        search.own and search.met == met and abs(search.best.value - best) <= MET * best))


def search_from(
    problem: Problem, start: Candidate, iterations: int, progress: Callable[[int, float], None]
) -> DesignSearch:
    """The search from one start, and where it ended."""
    before, path = (problem.gaits, problem.derivatives), Path([start], iterations, progress)
    coarse = problem.goal.coarse
    lost = linear_steps(problem, path, FIRST, coarse or NEAR)
    left = not coarse and left_to_gain(problem, path.taken[-1]) > STATIONARY
    if left and not lost and not meeting(problem, path.taken[-1]):
        curved_steps(problem, path)
    if left and left_to_gain(problem, path.taken[-1]) > STATIONARY:
        lost = linear_steps(problem, path, NEAR, BESIDE)
    gain = left_to_gain(problem, path.taken[-1])
    if coarse:
        meet_targets(problem, path)
    here = path.taken[-1]
    at = problem.met_bounds(here)
    if gain <= STATIONARY:
        optimum = "bound" if at else "maximum" if problem.sign < 0 else "minimum"
        ending = "kink" if is_kink(problem, here) else optimum
    elif lost:
        ending = "fold" if np.abs(here.point.floquet_multipliers - 1.0).min() < FOLD else "edge"
    elif len(path.taken) > iterations:
        ending = "unfinished"
    else:
        ending = "walked" if coarse else "coalescence" if meeting(problem, here) else "unfinished"
    return DesignSearch(
        start, here, tuple(each.value for each in path.taken), np.array([problem.values(each) for each in path.taken]),
        ending, at, gain, problem.gaits - before[0], problem.derivatives - before[1])


def meet_targets(problem: Problem, path: Path) -> None:
    """Go to the nearest designs within the targets by Newton's method, as coarse steps end beside these."""
    for _ in range(RESTORED):
        here = path.taken[-1]
        slopes = problem.gradients(here) if (np.abs(here.misses) > HELD).any() else None
        if slopes is None:
            return
        step = np.linalg.lstsq(slopes[1], -here.misses * (1 + HELD), rcond=None)[0]
        x = np.clip(problem.position(here) + step, problem.lower, problem.upper)
        there = problem.follow(here, x)
        if there is None:
            return
        path.add(there)


def left_to_gain(problem: Problem, here: Candidate) -> float:
    """What is left to gain for a share of the parameters, in units of the start's value."""
    return linear_step(problem, here, NEAR)[0] / NEAR


def is_kink(problem: Problem, here: Candidate) -> bool:
    """Whether parts of the goal are the largest together that change otherwise with the parameters."""
    together, slopes = here.parts > here.parts.max() - MET * problem.unit, problem.gradients(here)
    return slopes is not None and bool(np.ptp(slopes[0][together], axis=0).max() > MET * problem.unit)


def meeting(problem: Problem, here: Candidate) -> bool:
    """Whether two multipliers all but meet that decide the goal, so that their derivatives have no end."""
    values = here.point.floquet_multipliers
    largest = values[np.abs(values) > (1 - TOGETHER) * np.abs(values[0])]
    apart = np.abs(largest[:, None] - largest[None, :])[np.triu_indices(largest.size, 1)]
    of_multipliers = problem.goal is GOALS["multiplier"] and problem.sign > 0
    return of_multipliers and bool((apart < TOGETHER * np.abs(values[0])).any())
