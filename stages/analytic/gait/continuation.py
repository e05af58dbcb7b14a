"""Follows a gait through a design parameter by pseudo-arclength continuation, round turning points.

Keller's method: predict along the tangent of the branch in (section coordinates, parameter), correct by Newton's
method at fixed distance along the tangent. Special points between two points of the branch are located on it.
"""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from stages.analytic.errors import StepFailed
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.poincare import FixedPoint, fixed_point, iterate, multipliers_of, poincare_map, repeated
from stages.analytic.model.walker import Vector, Walker
from stages.analytic.result import RecordedFamily, Turn
from stages.biped.processes import Progress, ignore

KINDS = TURNING_POINT, PERIOD_DOUBLING, TORUS = "turning point", "period doubling", "torus"
CLOSED = "closes on itself"
LARGEST_CORRECTIONS = 12
SMALLEST_STEP = 1e-7
#: A value of the parameter beside the design's, as a share of the limits' span.
BESIDE = 1e-3
#: A bend sharper than this is stepped over.
SHARPEST_BEND = 1e-5
#: So many points that together get no further than this part of the largest step are the end: where multipliers go to
#: infinity, Newton's method takes ever shorter steps, without one too short.
CRAWLING, NOWHERE = 60, 0.05


@dataclass(frozen=True)
class BranchPoint:
    """A gait on the branch: parameter value, section coordinates, multipliers largest first, branch tangent."""

    value: float
    z: Vector
    floquet_multipliers: np.ndarray
    period: float
    tangent: Vector

    @property
    def stable(self) -> bool:
        """Whether every multiplier lies inside the unit circle."""
        return bool(np.abs(self.floquet_multipliers).max() < 1)


#: A turning point, period doubling or torus bifurcation on the branch: which, and the gait.
SpecialPoint = tuple[str, BranchPoint]


@dataclass(frozen=True)
class Branch:
    """A family of gaits over the parameter `name`, in order along the curve, and why it ends.

    They repeat after `cycle` steps, or so many strides of legs that differ: after `steps` steps, also where these are
    alike at one value alone.
    """

    name: str
    cycle: int
    steps: int
    points: tuple[BranchPoint, ...]
    special: tuple[SpecialPoint, ...]
    ended: str


class Curve:
    """The zero set of P^cycle(z; value) - z in (z, value / span), one dimension more than equations.

    P is the step map, or the stride map where the legs differ.
    """

    def __init__(self, design: DesignPoint, name: str, span: float, cycle: int, tolerance: float) -> None:
        self.design, self.name, self.span = design, name, span
        self.cycle, self.tolerance = cycle, tolerance
        # legs that are alike at one value of the parameter alone are followed in strides there as well
        values = (design.value(name), design.value(name) + BESIDE * span)
        self.steps = cycle * max(design.with_value(name, value).walker().gait_steps for value in values)
        self.enough = max(1e-12, tolerance / 100)

    def walker(self, u: Vector) -> Walker:
        """The walker at u = (z, value / span). Raises StepFailed for a gravity or a length of zero, and less."""
        value, least = u[-1] * self.span, self.design.bound(self.name).above
        if least is not None and value <= least:
            raise StepFailed(f"{self.name} = {value:g} is no biped's")
        return self.design.with_value(self.name, value).walker()

    def residual(self, u: Vector) -> tuple[Vector, np.ndarray, float]:
        """P^cycle(z) - z at u = (z, value / span), the derivative of P^cycle and the duration of the cycle."""
        walker = self.walker(u)
        steps, derivative = iterate(walker, u[:-1], self.steps, self.tolerance)
        return steps[-1].z - u[:-1], derivative, sum(step.period for step in steps) * walker.time

    def image(self, u: Vector) -> Vector:
        """P^cycle(z) at u = (z, value / span)."""
        return repeated(self.walker(u), u[:-1], self.steps, self.tolerance)

    def jacobian(self, u: Vector, derivative: np.ndarray) -> np.ndarray:
        """Derivative of the residual, (j, j + 1); the last column by central differences in the parameter."""
        change = np.zeros_like(u)
        change[-1] = 1e-6
        slope = (self.image(u + change) - self.image(u - change)) / 2e-6
        return np.column_stack([derivative - np.eye(len(u) - 1), slope])

    def tangent(self, u: Vector, derivative: np.ndarray, along: Vector) -> Vector:
        """Unit tangent of the curve, on the side of `along`."""
        direction: Vector = np.linalg.svd(self.jacobian(u, derivative))[2][-1]
        return direction if direction @ along >= 0 else -direction

    def correct(self, guess: Vector, along: Vector) -> tuple[Vector, np.ndarray, float]:
        """The point of the curve in the plane through `guess` normal to `along`. Raises StepFailed."""
        u, best = guess.copy(), np.inf
        with suppress(np.linalg.LinAlgError):
            gap, derivative, period = self.residual(u)
            matrix = np.vstack([self.jacobian(u, derivative), along])
            for _ in range(LARGEST_CORRECTIONS):
                error = max(np.abs(gap).max(), abs(along @ (u - guess)))
                if error <= self.enough or (error <= 1e-9 and error >= 0.5 * best):
                    return u, derivative, period
                best = min(best, error)
                u = u - np.linalg.solve(matrix, np.append(gap, along @ (u - guess)))
                gap, derivative, period = self.residual(u)
                matrix[:-1, :-1] = derivative - np.eye(len(u) - 1)
        raise StepFailed("Newton's method finds none beyond")

    def neighbour(self, points: Sequence[BranchPoint], step: float) -> BranchPoint:
        """The next point of the branch at distance `step`. Raises StepFailed, also if it lies round a sharp bend."""
        last = points[-1]
        here = coordinates(last, self.span)
        guess = here + step * last.tangent
        if len(points) > 1:  # the branch bends on as it did
            before = points[-2]
            turned = (last.tangent - before.tangent) / np.linalg.norm(here - coordinates(before, self.span))
            guess += 0.5 * step**2 * (turned - turned @ last.tangent * last.tangent)
        point = self.point(*self.correct(guess, last.tangent), last.tangent)
        if np.linalg.norm(coordinates(point, self.span) - here) > 2 * step or (
                point.tangent @ last.tangent < 0.9 and step > SHARPEST_BEND):
            raise StepFailed("Newton's method leads away from it")
        return point

    def half_cycle_move(self, u: Vector) -> Vector:
        """Change of the gait after half its cycle: zero for one of half the cycle; infinite for one step."""
        if self.cycle == 1:
            return np.full(len(u) - 1, np.inf)
        steps, _ = iterate(self.walker(u), u[:-1], self.steps // 2, self.tolerance)
        return np.asarray(steps[-1].z - u[:-1])

    def point(self, u: Vector, derivative: np.ndarray, period: float, along: Vector) -> BranchPoint:
        """The gait at a corrected point of the curve."""
        multipliers = multipliers_of(derivative)
        return BranchPoint(float(u[-1] * self.span), u[:-1], multipliers, period, self.tangent(u, derivative, along))


def coordinates(point: BranchPoint, span: float) -> Vector:
    """A branch point as coordinates of the curve."""
    return np.append(point.z, point.value / span)


def test_functions(point: BranchPoint) -> dict[str, float]:
    """Functions that change sign at special points."""
    multipliers = point.floquet_multipliers
    pairs = [abs(value) ** 2 - 1 for value in multipliers if value.imag > 1e-9]
    return {
        TURNING_POINT: float(point.tangent[-1]),
        PERIOD_DOUBLING: float(np.prod(1 + multipliers).real),
        TORUS: float(max(pairs)) if pairs else float("nan"),
    }


test_functions.__test__ = False  # type: ignore[attr-defined]


def locate(curve: Curve, kind: str, left: BranchPoint, right: BranchPoint) -> BranchPoint | None:
    """The special point between two points of the branch, by Brent's method on its test function.

    It is looked for from the cubic through both points with the tangents there; None if that leads to no gait.
    """
    from scipy.optimize import brentq

    start, end = coordinates(left, curve.span), coordinates(right, curve.span)
    distance = float(np.linalg.norm(end - start))
    along = (end - start) / distance
    ends = {0.0: test_functions(left)[kind], distance: test_functions(right)[kind]}
    found: dict[float, BranchPoint] = {}

    def value(way: float) -> float:
        if way in ends:
            return ends[way]
        s = way / distance
        bend = (1 - s) * left.tangent - s * right.tangent - (1 - 2 * s) * along
        point = curve.point(*curve.correct(start + way * along + way * (1 - s) * bend, along), along)
        here = test_functions(point)[kind]
        found[abs(here)] = point
        return here

    with suppress(StepFailed):
        brentq(value, 0.0, distance, xtol=10 * curve.enough, maxiter=40, disp=False)
    return found[min(found)] if found else None


def special_between(
    curve: Curve, left: BranchPoint, right: BranchPoint, kinds: tuple[str, ...], *, passes: bool
) -> list[SpecialPoint]:
    """Special points of these kinds between two neighbours on the branch.

    Where the branch `passes` the family of half the cycle it comes back as itself half a cycle later: its tangent is
    upright there, and no gaits meet and vanish. That is the other family's period doubling and no turning point.
    """
    before, after = test_functions(left), test_functions(right)
    found = []
    for kind in kinds:
        if before[kind] * after[kind] < 0 and not (passes and kind == TURNING_POINT):
            point = locate(curve, kind, left, right)
            if point is not None:
                found.append((kind, point))
    return found


def on_limit(curve: Curve, last: BranchPoint, beyond: BranchPoint, limit: float) -> list[BranchPoint]:
    """The gait at a limit of the parameter, between the last point inside and the first beyond; empty if not found."""
    inside, outside = coordinates(last, curve.span), coordinates(beyond, curve.span)
    along = np.zeros_like(inside)
    along[-1] = 1.0
    share = (limit - last.value) / (beyond.value - last.value)
    guess = inside + share * (outside - inside)
    guess[-1] = limit / curve.span
    with suppress(StepFailed):
        return [replace(curve.point(*curve.correct(guess, along), outside - inside), value=limit)]
    return []


def continue_gait(
    design: DesignPoint,
    name: str,
    limits: tuple[float, float],
    z: Vector,
    tolerance: float,
    *,
    cycle: int = 1,
    upward: bool = True,
    largest_step: float = 0.02,
    most_points: int = 400,
    until_fold: bool = False,
    progress: Progress = ignore,
) -> Branch:
    """Follow the gait at `z` of `design` in the parameter `name` until it leaves `limits` or ends.

    `largest_step` is the largest distance of two points in section coordinates and shares of the limits' span; with
    `until_fold` the first turning point, the only special point looked for, ends the branch.
    Raises ValueError if `z` leads to no gait of the given cycle.
    """
    start = fixed_point(design.walker(), z, tolerance, cycle)
    if start is None:
        raise ValueError(f"no gait of {cycle} steps to start from")
    curve = Curve(design, name, limits[1] - limits[0], cycle, tolerance)
    return Follower(curve, start.z, limits, upward, largest_step, until_fold).branch(most_points, progress)


class Follower:
    """A branch as it grows: its points, the special ones, the step, and why it was refused last."""

    def __init__(
        self, curve: Curve, z: Vector, limits: tuple[float, float], upward: bool, largest_step: float, until_fold: bool
    ) -> None:
        self.curve, self.limits, self.largest_step, self.until_fold = curve, limits, largest_step, until_fold
        along = np.zeros(len(z) + 1)
        along[-1] = 1.0 if upward else -1.0
        u = np.append(z, curve.design.value(curve.name) / curve.span)
        _, derivative, period = curve.residual(u)
        self.points = [curve.point(u, derivative, period, along)]
        self.special: list[SpecialPoint] = []
        self.way = abs(limits[upward] - self.points[0].value) or curve.span
        self.move = curve.half_cycle_move(u)
        self.step = min(largest_step, np.abs(self.move).max()) / 4
        self.ended, self.since_refused = "", 2

    def branch(self, most_points: int, progress: Progress) -> Branch:
        """Follow the branch to its end."""
        ended, curve = "", self.curve
        while not ended and self.step >= SMALLEST_STEP and len(self.points) < most_points and not self.crawls():
            ended = self.next(progress)
        why = f"{most_points} points" if len(self.points) >= most_points else self.ended
        return Branch(curve.name, curve.cycle, curve.steps, tuple(self.points), tuple(self.special), ended or why)

    def next(self, progress: Progress) -> str:
        """Take the next point, or a shorter step after a refusal; why the branch ends there, if it does."""
        curve, last = self.curve, self.points[-1]
        try:
            point = curve.neighbour(self.points, self.step)
            new = curve.half_cycle_move(coordinates(point, curve.span))
        except StepFailed as reason:
            return self.refused(str(reason))
        if np.abs(new).max() < 0.3 * np.abs(self.move).max():  # about to fall onto, or on, that family
            return self.refused("joins the family of half the cycle")
        kinds = (TURNING_POINT,) if self.until_fold else KINDS
        passes = curve.cycle > 1 and float(new @ self.move) < 0.0
        crossed = special_between(curve, last, point, kinds, passes=passes)
        self.special += [(kind, point) for kind, point in crossed if self.limits[0] <= point.value <= self.limits[1]]
        limit = min(max(point.value, self.limits[0]), self.limits[1])
        if limit != point.value:
            self.points += on_limit(curve, last, point, limit) if limit != last.value else []
            return "the limit of the parameter"
        self.points.append(point)
        if self.closes():
            return CLOSED
        if self.until_fold and crossed:
            return TURNING_POINT
        self.move = new
        gone = abs(point.value - self.points[0].value) / self.way
        progress(gone, f"cycle of {curve.cycle}, {curve.name} = {point.value:.4g}")
        self.since_refused += 1
        if self.since_refused > 1:  # towards an end of the family steps are halved: a longer one would be refused again
            self.step = min(1.5 * self.step, self.largest_step)
        return ""

    def refused(self, why: str) -> str:
        """Halve the step; the branch does not end yet."""
        self.step, self.ended, self.since_refused = self.step / 2, why, 0
        return ""

    def crawls(self) -> bool:
        """Whether the last points lie so close together that more would lead nowhere."""
        ends = [coordinates(point, self.curve.span) for point in self.points[-CRAWLING::CRAWLING - 1]]
        return len(ends) > 1 and float(np.linalg.norm(ends[1] - ends[0])) < NOWHERE * self.largest_step

    def closes(self) -> bool:
        """Whether the last point is back at the first one, or has just passed it, in the same direction."""
        first, last, span = self.points[0], self.points[-1], self.curve.span
        near = np.linalg.norm(coordinates(last, span) - coordinates(first, span)) <= self.step
        return bool(len(self.points) > 4 and near and last.tangent @ first.tangent > 0.9)


#: Just beyond its doubling a family has a multiplier this near to 1; other cycles may lie close by.
NEWBORN = 0.3
#: Largest distance of two gaits of a family, see `continue_gait`; for a longer cycle it is shorter.
LARGEST_STEP = 0.02


def newborn(walker: Walker, z: Vector, direction: Vector, tolerance: float, cycle: int) -> Iterator[FixedPoint]:
    """Gaits of a doubled `cycle` with a multiplier near 1, found from `z` displaced along a direction (j,)."""
    for size in (1e-2, 3e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5):
        point = fixed_point(walker, z + size * direction, tolerance, cycle)
        if (point is not None and point.half_cycle_move > 1e-6
                and np.abs(point.floquet_multipliers - 1).min() < NEWBORN):  # fmt: skip
            yield point


def doubled_family(
    design: DesignPoint, branch: Branch, doubling: BranchPoint, limits: tuple[float, float], tolerance: float,
    progress: Progress, largest_step: float,
) -> Branch:  # fmt: skip
    """The family of twice the cycle that leaves a period doubling, followed away from it.

    It starts a little beyond, displaced along the eigenvector of the multiplier -1, where Newton's method on the
    doubled map finds a gait that is not the old one. Raises ValueError if it finds none on either side.
    """
    span, cycle, z = max(abs(point.value) for point in branch.points), 2 * branch.cycle, doubling.z
    there = design.with_value(branch.name, doubling.value).walker()
    _, derivative = iterate(there, z, branch.steps, tolerance)
    values, vectors = np.linalg.eig(derivative)
    direction = np.real(vectors[:, int(np.argmin(np.abs(values + 1)))])
    direction /= np.linalg.norm(direction) * np.sign(direction[np.abs(direction).argmax()])
    for shift in (1e-4, 1e-3, 1e-5, 3e-6):
        sides = {sign: design.with_value(branch.name, doubling.value + sign * shift * span) for sign in (1, -1)}
        found = [(point, sign) for sign, beyond in sides.items()
                 for point in newborn(beyond.walker(), z, direction, tolerance, cycle)]  # fmt: skip
        if found:  # the one that limps least: beyond a fold of the family there may be another
            point, sign = min(found, key=lambda one: one[0].half_cycle_move)
            start = point.z
            if (start - z) @ direction < 0.0:  # which half comes first is not left to where Newton's method led
                start = point.steps[branch.steps - 1].z
            return continue_gait(
                sides[sign], branch.name, limits, start, tolerance, cycle=cycle, upward=sign > 0,
                largest_step=largest_step / cycle, progress=progress)
    raise ValueError("no gait of twice the cycle was found next to the period doubling")


def follow_family(
    design: DesignPoint, name: str, limits: tuple[float, float], z: Vector, tolerance: float, doublings: int,
    progress: Progress = ignore, largest_step: float = LARGEST_STEP,
) -> list[Branch]:  # fmt: skip
    """The gait's family on both sides of the design, and the first `doublings` families of twice the cycle from it.

    A family that closes on itself is followed once round. Raises ValueError if `z` leads to no gait.
    """
    follow = partial(continue_gait, design, name, limits, z, tolerance, largest_step=largest_step, progress=progress)
    whole = follow(upward=False)
    if whole.ended != CLOSED:
        down, up = whole, follow(upward=True)
        points, special = (*reversed(down.points), *up.points[1:]), (*reversed(down.special), *up.special)
        whole = Branch(name, 1, down.steps, points, special, f"{down.ended}; {up.ended}")
    branches = [whole]
    for _ in range(doublings):
        newest = [known for known in branches if known.cycle == branches[-1].cycle]
        doublings_of = ((known, one) for known in newest for kind, one in known.special if kind == PERIOD_DOUBLING)
        for branch, doubling in doublings_of:
            with suppress(ValueError):  # a doubling whose new gaits no longer walk has no family to follow
                branches.append(doubled_family(design, branch, doubling, limits, tolerance, progress, largest_step))
        if branches[-1].cycle == newest[-1].cycle:
            break
    return branches


def recorded(design: DesignPoint, branch: Branch, tolerance: float) -> RecordedFamily:
    """A family with every step of its gaits, which are walked once more; its turns are among the gaits."""
    points = list(branch.points)
    for _, special in branch.special:  # each between the neighbours that it is nearest to
        away = [float(np.abs(special.z - point.z).max()) for point in points]
        if len(points) > 1:
            before = min(range(len(points) - 1), key=lambda i: away[i] + away[i + 1])
            points.insert(before + 1, special)
    durations, angles, double = _steps(design, branch, points, tolerance)
    multipliers = np.array([point.floquet_multipliers for point in points])
    turns = []
    for kind, special in branch.special:
        at_turn, wanted = special.floquet_multipliers, -1.0 if kind == PERIOD_DOUBLING else 1.0
        nearest = float(at_turn[np.abs(at_turn - wanted).argmin()].real)
        lengths, leans, _ = _steps(design, branch, [special], tolerance)
        turns.append(Turn(kind, special.value, nearest, lengths[0], leans[0]))
    return RecordedFamily(
        branch.cycle, branch.ended, np.array([point.value for point in points]), durations, angles, double,
        np.stack([multipliers.real, multipliers.imag], axis=-1), tuple(turns),
    )  # fmt: skip


def _steps(
    design: DesignPoint, branch: Branch, points: Iterable[BranchPoint], tolerance: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Duration of every step [s], stance angle at its begin [rad] and double stance [s] of gaits, each (n, steps)."""
    rows = []
    for point in points:
        walker, z, row = design.with_value(branch.name, point.value).walker(), point.z, []
        for _ in range(branch.steps):
            step = poincare_map(walker, z, tolerance)
            row.append((step.period * walker.time, -z[0], step.double_stance * walker.time))
            z, walker = step.z, walker.exchanged
        rows.append(row)
    found = np.array(rows)
    return found[..., 0], found[..., 1], found[..., 2]
