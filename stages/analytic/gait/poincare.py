"""The Poincare map just after heel strike, its exact derivative, its fixed points and their multipliers.

Newton's method on it finds gaits from many starts, and cycles of two, four or eight steps, or so many strides if the
legs differ.
"""

from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from itertools import islice
from typing import TypeGuard

import numpy as np

from stages.analytic.errors import StepFailed
from stages.analytic.integration.phase import BOTTOMED, CHATTER, EVENT, FALL, STEP_FLOOR, TIME_LIMIT, WEDGED, walk_step
from stages.analytic.model.kinds import Directions, Rigid
from stages.analytic.model.walker import Vector, Walker
from stages.analytic.phases.motion import HOVERING, SINGLE_STANCE, in_contact
from stages.analytic.phases.section import section_coordinates, section_derivative, section_state, section_tangent

#: Longest phase, in pendulum times sqrt(L/g); a step takes about 2.6.
TIME_LIMIT_OF_A_PHASE = 30.0
STEP_LIMIT_OF_A_PHASE = 400_000
#: Damping of Newton's method: longest change of a coordinate at once, and how often it is halved.
LONGEST_CHANGE = 0.2
HALVINGS = 6
#: Near a longer correction the matrix is nearly singular: a place where the walker almost has a gait, and none.
HOPELESS = 2.0
#: Corrections that a fixed point is given.
CORRECTIONS = 25
#: A change this small is not damped: the test walks without variations, in other integration steps, which differ more.
SURE_CHANGE = 1e-6


@dataclass(frozen=True)
class Step:
    """One step of the map: section coordinates after it, its period and double stance time (dimensionless)."""

    z: Vector
    state: Vector
    period: float
    double_stance: float
    evaluations: int


def step_failure(status: int, phase: int) -> str:
    """Why a step has no end, in words."""
    where = "double stance" if in_contact(phase) or phase == HOVERING else "single stance"
    wedged = "at heel strike" if phase == SINGLE_STANCE else "in double stance"
    reasons = {
        FALL: f"the walker falls in {where}",
        TIME_LIMIT: f"{where} does not end: the walker stands still or rocks",
        BOTTOMED: f"a leg is pressed down to its foot in {where}",
        WEDGED: f"friction can wedge the trailing foot {wedged}: the laws of contact have several solutions or none",
        CHATTER: "the trailing foot changes between sliding, rolling and hovering without end",
        STEP_FLOOR: f"the step size falls to the round-off floor in {where}",
    }
    return reasons.get(status, f"{where} needs more than {STEP_LIMIT_OF_A_PHASE} integration steps")


def require_landing(walker: Walker, y: Vector, status: int, phase: int) -> None:
    """A step ends at heel strike with the hip between the feet, as the section has it.

    Raises StepFailed otherwise. A walker that rocks back lands with the hip behind both feet; the section coordinates
    of that state are those of another one, so that it could look periodic.
    """
    if status != EVENT:
        raise StepFailed(step_failure(status, phase))
    if y[1 if walker.rigid else 2] >= 0.0:
        raise StepFailed("the walker rocks back: at heel strike the hip is behind both feet")
    if walker.timed and y[0] + y[1] >= 0.0:
        raise StepFailed("when its time has come the swing foot is behind the stance foot")


def start_state(walker: Walker, z: Vector) -> Vector:
    """State just after heel strike at section coordinates `z`. Raises StepFailed if there is none."""
    y = section_state(np.asarray(z, dtype=float), walker.p)
    if not np.isfinite(y).all():
        raise StepFailed("the trailing foot cannot reach the ground")
    return y


def poincare_map(walker: Walker, z: Vector, tolerance: float) -> Step:
    """Image of section coordinates `z` (j,) after one step.

    Raises StepFailed if the walker falls or stands still.
    """
    return step_from(walker, start_state(walker, z), tolerance)


def step_from(walker: Walker, y: Vector, tolerance: float, directions: Directions | None = None) -> Step:
    """The step from a state with or without variations, which are advanced in place.

    The last variations go with `directions` of the walker's numbers, if given. Raises StepFailed as `require_landing`
    does.
    """
    status, phase, double, period, evaluations = walk_step(
        y, walker.p, tolerance, TIME_LIMIT_OF_A_PHASE, STEP_LIMIT_OF_A_PHASE, directions)
    require_landing(walker, y, status, phase)
    end = y[: walker.size].copy()
    return Step(section_coordinates(end, walker.exchanged.p), end, period, double, evaluations)


def repeated(walker: Walker, z: Vector, steps: int, tolerance: float) -> Vector:
    """Section coordinates after so many steps from `z`. Raises StepFailed like `poincare_map`."""
    for _ in range(steps):
        z, walker = poincare_map(walker, z, tolerance).z, walker.exchanged
    return z


def poincare_derivative(walker: Walker, z: Vector, tolerance: float) -> tuple[Step, np.ndarray]:
    """The map and its exact derivative, shape (j, j), by variational equations and event shifts (saltation).

    Raises StepFailed like `poincare_map`.
    """
    start = start_state(walker, z)
    y = np.concatenate([start, section_tangent(np.asarray(z, dtype=float), start, walker.p)])
    step = step_from(walker, y, tolerance)
    return step, section_derivative(y, walker.exchanged.p)


def iterate(walker: Walker, z: Vector, steps: int, tolerance: float) -> tuple[list[Step], np.ndarray]:
    """`steps` steps in a row from `z` and the derivative of the whole, shape (j, j)."""
    taken, derivative = [], np.eye(walker.section_size)
    for _ in range(steps):
        step, one = poincare_derivative(walker, z, tolerance)
        taken.append(step)
        derivative = one @ derivative
        z, walker = step.z, walker.exchanged
    return taken, derivative


@dataclass(frozen=True)
class FixedPoint:
    """A fixed point of the map over its steps: where it is, these steps, its derivative and how well it closes."""

    z: Vector
    steps: tuple[Step, ...]
    monodromy_matrix: np.ndarray
    residual: float

    @property
    def period(self) -> float:
        """Duration of a step, the mean of its steps, dimensionless."""
        return sum(step.period for step in self.steps) / len(self.steps)

    @property
    def floquet_multipliers(self) -> np.ndarray:
        """Eigenvalues of the monodromy matrix, largest first, shape (j,); conjugates stay together."""
        return multipliers_of(self.monodromy_matrix)

    @property
    def half_cycle_move(self) -> float:
        """Largest change of a coordinate over the first half of the steps: none if the gait repeats after these."""
        return float(np.abs(self.steps[len(self.steps) // 2 - 1].z - self.z).max())


def multipliers_of(monodromy_matrix: np.ndarray) -> np.ndarray:
    """Eigenvalues of a monodromy matrix (j, j), largest first, shape (j,); conjugates stay together."""
    values: np.ndarray = np.linalg.eigvals(monodromy_matrix).astype(complex)
    return np.asarray(values[largest_first(values)])


def largest_first(multipliers: np.ndarray) -> np.ndarray:
    """Places (j,) of multipliers (j,) by falling magnitude; conjugates stay together."""
    return np.asarray(np.lexsort((-multipliers.imag, -np.round(np.abs(multipliers), 12))))


def round_off(walker: Walker) -> float:
    """Residual that round-off leaves: of a length times the stiffness."""
    return 0.0 if isinstance(walker.p, Rigid) else float(8 * np.finfo(float).eps * walker.p.k)


def damped_change(
    walker: Walker, z: Vector, change: Vector, matrix: np.ndarray, cycle: int, tolerance: float
) -> Vector | None:
    """The longest of `change`, half of it, a quarter ... after which the next correction is smaller; None if none is.

    Deuflhard's natural monotonicity test: corrections are compared, with the same matrix, not residuals.
    """
    size = float(np.abs(change).max())
    if size > HOPELESS:
        return None
    factor = min(1.0, LONGEST_CHANGE / max(size, 1e-300))
    for _ in range(HALVINGS):
        with suppress(StepFailed):
            image = repeated(walker, z + factor * change, cycle * walker.gait_steps, tolerance)
            following = np.linalg.solve(matrix, image - z - factor * change)
            if np.abs(following).max() <= (1 - factor / 4) * size:
                return factor * change
        factor /= 2
    return None


def fixed_point(
    walker: Walker, z: Vector, tolerance: float, cycle: int = 1,
    known: Callable[[Vector, float], bool] | None = None,
) -> FixedPoint | None:
    """Damped Newton's method on P^cycle(z) = z with the exact derivative; None if it does not converge from `z`.

    P is the step map, or the stride map, two steps, of a walker whose legs differ.

    Converged means that the residual no longer falls and is within the accuracy of the map itself, or within round-off.
    With `known`, a residual within that accuracy will do, and there is no answer where known(z, size), at each point z
    that a correction of this size leads to, says that the point ahead is known.
    """
    best: FixedPoint | None = None
    z = np.asarray(z, dtype=float)
    good_enough = max(1e-10, 10 * tolerance, round_off(walker))
    with suppress(StepFailed, np.linalg.LinAlgError):
        for _ in range(CORRECTIONS):
            steps, derivative = iterate(walker, z, cycle * walker.gait_steps, tolerance)
            gap = steps[-1].z - z
            residual = float(np.abs(gap).max())
            if best is None or residual < best.residual:
                best = FixedPoint(z, tuple(steps), derivative, residual)
            elif best.residual <= good_enough:
                break
            matrix = np.eye(z.size) - derivative
            change: Vector = np.linalg.solve(matrix, gap)
            size = float(np.abs(change).max())
            if known is not None and (residual <= good_enough or known(z + change, size)):
                break
            sure = residual <= good_enough or size <= SURE_CHANGE
            taken = change if sure else damped_change(walker, z, change, matrix, cycle, tolerance)
            if taken is None:
                break
            z = z + taken
    return best if best is not None and best.residual <= good_enough else None


#: Two fixed points closer than this are one.
DISTINCT = 1e-6
SEARCH_TOLERANCE = 1e-8
#: A correction smaller than this, which ends this much nearer to a fixed point than it is long, goes there.
NEAR, LEFT = 0.02, 0.03
#: Newton's method is tried from so many starts; when a stable gait is enough, from so few if they show one.
MOST_STARTS, FEW_STARTS = 80, 12
#: When a stable gait is enough, so many starts in a row that lead to nothing new are the last: the best came first.
#: Fewer are once a gait is known.
PATIENCE, LESS_PATIENCE = 16, 8
#: Cycles that are looked for, after so many steps: transients of stable cycles have died out by then.
CYCLES, TRANSIENT_STEPS = (2, 4, 8), 400


def is_new(found: list[FixedPoint], candidate: FixedPoint) -> bool:
    """Whether `candidate` is none of the fixed points found."""
    return all(np.abs(known.z - candidate.z).max() > DISTINCT for known in found)


def is_walking(point: FixedPoint) -> bool:
    """Whether a fixed point moves forward: the stance leg starts behind upright and every step takes time."""
    return bool(point.z[0] < -1e-4) and all(step.period > 1e-3 for step in point.steps)


def is_gait(point: FixedPoint | None, found: list[FixedPoint]) -> TypeGuard[FixedPoint]:
    """Whether Newton's method came to a point that walks and is none of those found."""
    return point is not None and is_walking(point) and is_new(found, point)


def by_stability(point: FixedPoint) -> float:
    """Magnitude of the largest multiplier, of one step."""
    return float(np.abs(point.floquet_multipliers).max() ** (1.0 / len(point.steps)))


def is_ahead(met: list[Vector], z: Vector, size: float) -> bool:
    """Whether Newton's method, which a correction of this size led to `z`, converges to one of the points met before.

    Near a fixed point the error that a correction leaves is a small part of it.
    """
    return size < NEAR and any(np.abs(known - z).max() <= LEFT * size for known in met)


def converge(
    walker: Walker, starts: Iterable[Vector], tolerance: float, *, unstable: bool, met: list[Vector] | None = None
) -> list[FixedPoint]:
    """Distinct gaits that Newton's method reaches from `starts`; only the first few if they show a stable one.

    Points in `met` are not gone to again; those that are reached are added to it.
    """
    found: list[FixedPoint] = []
    met, newest = [] if met is None else met, 0
    for count, start in enumerate(islice(starts, MOST_STARTS)):
        shown = count >= FEW_STARTS and any(by_stability(point) < 1 for point in found)
        if not unstable and (shown or count > newest + (LESS_PATIENCE if met else PATIENCE)):
            break
        point = fixed_point(walker, start, max(tolerance, SEARCH_TOLERANCE), known=partial(is_ahead, met))
        if point is not None:
            met.append(point.z)
            newest = count
        if is_gait(point, found):
            point = fixed_point(walker, point.z, tolerance)
            found += [point] if is_gait(point, found) else []
    return found


def find_cycle(walker: Walker, start: Vector, tolerance: float) -> FixedPoint | None:
    """The stable cycle of two, four or eight steps that a walk displaced from an unstable gait `start` settles on.

    None if the walk falls, or settles on no such cycle. Beside a longer cycle lies the shorter one that it comes from.
    """
    with suppress(StepFailed):
        z = repeated(walker, np.asarray(start, dtype=float) * (1.0 + 1e-4), TRANSIENT_STEPS, tolerance)
        for cycle in CYCLES:
            point = fixed_point(walker, z, tolerance, cycle)
            if point is None or np.abs(point.z - z).max() >= 1e-2 or by_stability(point) >= 1.0:
                continue
            if point.half_cycle_move >= DISTINCT:
                return point
    return None
