"""Follows a gait through a design parameter by pseudo-arclength continuation, round turning points.

Keller's method: predict along the tangent of the branch in (section coordinates, parameter), correct by Newton's
method at fixed distance along the tangent. Special points between two points of the branch are located on it.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from stages.analytic.errors import StepFailed
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.poincare import FixedPoint, fixed_point, iterate, multipliers_of, poincare_map
from stages.analytic.model.walker import Vector, Walker
from stages.analytic.result import RecordedFamily, Turn
from stages.biped.progress import Progress, ignore

KINDS = TURNING_POINT, PERIOD_DOUBLING, TORUS = "turning point", "period doubling", "torus"
LARGEST_CORRECTIONS = 12
SMALLEST_STEP = 1e-7
#: A value of the parameter beside the design's, as a share of the limits' span.
BESIDE = 1e-3
#: A bend sharper than this is stepped over.
SHARPEST_BEND = 1e-5


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


@dataclass(frozen=True)
class SpecialPoint:
    """A turning point, period doubling or torus bifurcation on the branch."""

    kind: str
    point: BranchPoint


@dataclass(frozen=True)
class Branch:
    """A family of `cycle`-step gaits over the parameter `name`, in order along the curve, and why it ends."""

    name: str
    cycle: int
    points: tuple[BranchPoint, ...]
    special: tuple[SpecialPoint, ...]
    ended: str


def closes(points: Sequence[BranchPoint], span: float, step: float) -> bool:
    """Whether the last point of a branch is back at its first one, or has just passed it, in the same direction."""
    away = coordinates(points[-1], span) - coordinates(points[0], span)
    return bool(len(points) > 4 and np.linalg.norm(away) <= step and points[-1].tangent @ points[0].tangent > 0.9)


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

    def residual(self, u: Vector) -> tuple[Vector, np.ndarray, float]:
        """P^cycle(z) - z at u = (z, value / span), the derivative of P^cycle and the duration of the cycle."""
        walker = self.design.with_value(self.name, u[-1] * self.span).walker()
        steps, derivative = iterate(walker, u[:-1], self.steps, self.tolerance)
        return steps[-1].z - u[:-1], derivative, sum(step.period for step in steps) * walker.time

    def image(self, u: Vector) -> Vector:
        """P^cycle(z) at u = (z, value / span)."""
        walker, z = self.design.with_value(self.name, u[-1] * self.span).walker(), u[:-1]
        for _ in range(self.steps):
            z, walker = poincare_map(walker, z, self.tolerance).z, walker.exchanged
        return z

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

    def correct(self, guess: Vector, along: Vector) -> tuple[Vector, np.ndarray, float] | None:
        """The point of the curve in the plane through `guess` normal to `along`; None if Newton's method fails."""
        u, best = guess.copy(), np.inf
        try:
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
        except (StepFailed, np.linalg.LinAlgError):
            return None
        return None

    def neighbour(self, points: Sequence[BranchPoint], step: float) -> BranchPoint | None:
        """The next point of the branch at distance `step`; None if there is none, or if it lies round a sharp bend."""
        last = points[-1]
        here = coordinates(last, self.span)
        guess = here + step * last.tangent
        if len(points) > 1:  # the branch bends on as it did
            before = points[-2]
            turned = (last.tangent - before.tangent) / np.linalg.norm(here - coordinates(before, self.span))
            guess += 0.5 * step**2 * (turned - turned @ last.tangent * last.tangent)
        corrected = self.correct(guess, last.tangent)
        if corrected is None or np.linalg.norm(corrected[0] - here) > 2 * step:
            return None
        point = self.point(*corrected, last.tangent)
        return None if point.tangent @ last.tangent < 0.9 and step > SHARPEST_BEND else point

    def half_cycle_move(self, u: Vector) -> Vector:
        """Change of the gait after half its cycle: zero for one of half the cycle; infinite for one step."""
        if self.cycle == 1:
            return np.full(len(u) - 1, np.inf)
        walker = self.design.with_value(self.name, u[-1] * self.span).walker()
        steps, _ = iterate(walker, u[:-1], self.steps // 2, self.tolerance)
        move: Vector = steps[-1].z - u[:-1]
        return move

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
        corrected = curve.correct(start + way * along + way * (1 - s) * bend, along)
        if corrected is None:
            raise StepFailed("no gait there")
        point = curve.point(*corrected, along)
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
                found.append(SpecialPoint(kind, point))
    return found


def on_limit(curve: Curve, last: BranchPoint, beyond: BranchPoint, limit: float) -> list[BranchPoint]:
    """The gait at a limit of the parameter, between the last point inside and the first beyond; empty if not found."""
    inside, outside = coordinates(last, curve.span), coordinates(beyond, curve.span)
    along = np.zeros_like(inside)
    along[-1] = 1.0
    share = (limit - last.value) / (beyond.value - last.value)
    guess = inside + share * (outside - inside)
    guess[-1] = limit / curve.span
    corrected = curve.correct(guess, along)
    return [] if corrected is None else [curve.point(*corrected, outside - inside)]


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
    span = limits[1] - limits[0]
    curve = Curve(design, name, span, cycle, tolerance)
    along = np.zeros(len(z) + 1)
    along[-1] = 1.0 if upward else -1.0
    u = np.append(start.z, design.value(name) / span)
    _, derivative, period = curve.residual(u)
    points = [curve.point(u, derivative, period, along)]
    way = abs(limits[upward] - points[0].value) or span
    special: list[SpecialPoint] = []
    ended = ""
    move = curve.half_cycle_move(u)
    step = min(largest_step, np.abs(move).max()) / 4
    since_refused = 2
    while len(points) < most_points:
        if step < SMALLEST_STEP:
            return Branch(name, cycle, tuple(points), tuple(special), ended)
        last = points[-1]
        try:
            point = curve.neighbour(points, step)
            new = curve.half_cycle_move(coordinates(point, span)) if point is not None else move
        except StepFailed:
            point, new = None, move
        if point is None:
            step, ended, since_refused = step / 2, "the gait ends: no step map beyond", 0
            continue
        if np.abs(new).max() < 0.3 * np.abs(move).max():  # about to fall onto, or on, the family of half the cycle
            step, ended, since_refused = step / 2, "joins the family of half the cycle", 0
            continue
        kinds = (TURNING_POINT,) if until_fold else KINDS
        crossed = special_between(curve, last, point, kinds, passes=cycle > 1 and float(new @ move) < 0.0)
        special += [one for one in crossed if limits[0] <= one.point.value <= limits[1]]
        if not limits[0] <= point.value <= limits[1]:
            points += on_limit(curve, last, point, limits[0] if point.value < limits[0] else limits[1])
            return Branch(name, cycle, tuple(points), tuple(special), "the limit of the parameter")
        points.append(point)
        if closes(points, span, step):
            return Branch(name, cycle, tuple(points), tuple(special), "closes on itself")
        if until_fold and crossed:
            return Branch(name, cycle, tuple(points), tuple(special), TURNING_POINT)
        move = new
        progress(abs(point.value - points[0].value) / way, f"cycle of {cycle}, {name} = {point.value:.4g}")
        since_refused += 1
        if since_refused > 1:  # towards an end of the family steps are halved: a longer one would be refused again
            step = min(1.5 * step, largest_step)
    return Branch(name, cycle, tuple(points), tuple(special), f"{most_points} points")


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


def recorded(design: DesignPoint, branch: Branch, tolerance: float) -> RecordedFamily:
    """A family with every step of its gaits, which are walked once more; its turns are among the gaits."""
    points = _with_turns(branch)
    durations, angles, double = _steps(design, branch, points, tolerance)
    multipliers = np.array([point.floquet_multipliers for point in points])
    turns = tuple(
        Turn(special.kind, special.point.value, _nearest(special.kind, special.point),
             *(steps[0] for steps in _steps(design, branch, [special.point], tolerance)[:2]))
        for special in branch.special
    )  # fmt: skip
    return RecordedFamily(
        branch.cycle, branch.ended, np.array([point.value for point in points]), durations, angles, double,
        np.stack([multipliers.real, multipliers.imag], axis=-1), turns,
    )  # fmt: skip


def _with_turns(branch: Branch) -> list[BranchPoint]:
    """The gaits of a branch with its special points, each between the neighbours that it is nearest to."""
    points = list(branch.points)
    for special in branch.special:
        away = [float(np.abs(special.point.z - point.z).max()) for point in points]
        if len(points) > 1:
            before = min(range(len(points) - 1), key=lambda i: away[i] + away[i + 1])
            points.insert(before + 1, special.point)
    return points


def _nearest(kind: str, point: BranchPoint) -> float:
    wanted = -1.0 if kind == "period doubling" else 1.0
    return float(point.floquet_multipliers[np.abs(point.floquet_multipliers - wanted).argmin()].real)


def _steps(
    design: DesignPoint, branch: Branch, points: Iterable[BranchPoint], tolerance: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Duration of every step [s], stance angle at its begin [rad] and double stance [s] of gaits, each (n, steps)."""
    rows = []
    for point in points:
        walker, z, row = design.with_value(branch.name, point.value).walker(), point.z, []
        for _ in range(branch.cycle * walker.gait_steps):
            step = poincare_map(walker, z, tolerance)
            row.append((step.period * walker.time, -z[0], step.double_stance * walker.time))
            z, walker = step.z, walker.exchanged
        rows.append(row)
    found = np.array(rows)
    return found[..., 0], found[..., 1], found[..., 2]
