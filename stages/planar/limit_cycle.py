"""A walker's own gait on penalty ground: fixed point, period and multipliers of its step map."""

import contextlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

import numpy as np
from scipy.linalg import eig

from stages.planar.run import LimitCycle, PlanarState
from stages.planar.section import NoLimitCycle, SectionStep, section_numbers, section_state

#: Steps of a walk that leads to where there is a gait.
SETTLING_STEPS = 8
#: Distance from an unstable gait, in `scales`, at which a step shows how the map bends, and within which that serves.
ASIDE, FARTHEST_ASIDE = 0.1, 2.0
NEWTON_STEPS = 16
#: The derivative is made anew when so many iterations have left more than this of the residual, so often at most; at
#: once where nothing is won since it was made. Making it costs ten steps, and a slow iteration has corrected it.
#: A change that makes the residual so much larger is a poor derivative's doing, and not taken: it is made anew first.
SLOW, PATIENCE, MOST_RENEWALS, AWAY = 0.8, 2, 4, 2.0
#: The residual, in tolerances of the walker and in `scales`, that will do at once, and after one or two iterations that
#: won nothing: it may then be the steps' own error, of which up to 60 were seen where legs give way, 800 where not.
ENOUGH = 1.0, 1e2, 1e3
#: Times a change of the state is halved if the model does not take a step from it.
HALVINGS = 4
#: A change of the state beyond this, in `scales`, leads where nothing walks: thirty leg lengths.
FARTHEST = 1e3
#: So near to a gait, in `scales`, the derivative is the gait's, but for what forward differences leave uncertain.
CLOSE = 5e-3


class After(Protocol):
    """What a step, or a stride, is known by: the section numbers (10,) at its end."""

    @property
    def numbers(self) -> np.ndarray:
        """Section numbers (10,)."""


S = TypeVar("S", bound=After)


@dataclass(frozen=True)
class FixedPointOf(Generic[S]):
    """Section numbers (10,) that a step changes by `residual` in `scales`, that step, and its derivative (10, 10)."""

    numbers: np.ndarray
    step: S
    residual: float
    derivative: np.ndarray


FixedPoint = FixedPointOf[SectionStep]


class Steps(Protocol[S]):
    """A map of the section to itself, of a step or of a stride."""

    @property
    def scales(self) -> np.ndarray:
        """Scales of the section's numbers, (10,)."""

    @property
    def tolerance(self) -> float:
        """Tolerance to which its steps are integrated."""

    def step(self, numbers: np.ndarray) -> S:
        """One step from section numbers (10,). Raises NoLimitCycle."""

    def derivative(self, numbers: np.ndarray, after: S | None = None) -> np.ndarray:
        """Derivative (10, 10) of the step from section numbers (10,), which leads to `after` if that is known.

        Raises NoLimitCycle.
        """


class StepTaker(Steps[SectionStep], Protocol):
    """A model that takes steps from mid-stance to mid-stance, and counts them.

    `step` and `derivative` are those of a cycle, which has one step where both legs are alike, or two.
    """

    steps_walked: int
    steps_a_cycle: int

    def walk(self, start: PlanarState, steps: int) -> SectionStep:
        """Walk from a mid-stance to the one after `steps` steps. Raises NoLimitCycle."""


def gait_near(walker: StepTaker, state: PlanarState, *, central: bool = True) -> LimitCycle:
    """The gait near `state`, a mid-stance, or near the end of a walk of some steps from it where there is no other.
    Where that is unstable, the stable one that it gives way to on the side of `state`, as beside a fold or in a limp.

    The derivative there is by `central` differences, or by forward ones, which cost half as much and leave one more
    digit of multipliers uncertain: then that of the search's own start serves if it is within `CLOSE`.
    Raises NoLimitCycle.
    """
    begin, derivative, close = section_numbers(state), None, False
    try:
        first = walker.step(begin)
        if not central:
            derivative = walker.derivative(begin, first)
        found = fixed_point(walker, begin, derivative, first)
        close = _size(walker, found.numbers - begin) <= CLOSE
    except NoLimitCycle:
        found = fixed_point(walker, walker.walk(state, SETTLING_STEPS).numbers)
    gait = cycle_at(walker, found, derivative if close else None, central)
    if not gait.stable:
        for numbers in beside(walker, gait, begin):
            with contextlib.suppress(NoLimitCycle):
                settled = walker.walk(section_state(numbers, state), SETTLING_STEPS).numbers
                other = cycle_at(walker, fixed_point(walker, settled), None, central)
                if other.stable:
                    return other
    return gait


def beside(walker: StepTaker, gait: LimitCycle, begin: np.ndarray) -> list[np.ndarray]:
    """Section numbers (10,) near other gaits beside an unstable one, first on the side of `begin` (10,); none if far.

    Along the direction that grows by a multiplier above one, a cycle moves the state by a cubic, which is zero at fixed
    points: its slope at the gait is known, and cycles from either side give its bend and twist.
    """
    scales, numbers = walker.scales, gait.section_state
    values, left, right = eig(gait.monodromy_matrix / scales[:, None] * scales, left=True)
    index = int(np.abs(values).argmax())
    largest, direction, along = values[index], right[:, index].real, left[:, index].real
    if largest.imag or largest.real < 1.0:
        return []
    along = along / (along @ direction)
    try:
        ahead, behind = (
            along @ ((walker.step(numbers + aside * direction * scales).numbers - numbers) / scales) - aside
            for aside in (ASIDE, -ASIDE))  # fmt: skip
    except NoLimitCycle:
        return []
    slope, side = largest.real - 1.0, along @ ((begin - numbers) / scales)
    bend, twist = (ahead + behind) / (2.0 * ASIDE**2), ((ahead - behind) / (2.0 * ASIDE) - slope) / ASIDE**2
    near = [root.real for root in np.roots([twist, bend, slope]) if not root.imag and abs(root) < FARTHEST_ASIDE]
    return [numbers + root * direction * scales for root in sorted(near, key=np.sign, reverse=bool(side > 0.0))]


def cycle_at(walker: StepTaker, found: FixedPoint, derivative: np.ndarray | None, central: bool) -> LimitCycle:
    """The gait at a fixed point, with its `derivative` (10, 10) where that is known. Raises NoLimitCycle."""
    if derivative is None:
        derivative = walker.derivative(found.numbers, None if central else found.step)
    multipliers = floquet_multipliers(derivative)
    found = nearer(walker, found, derivative)
    after = found.step
    return LimitCycle(
        found.numbers,
        after.period,
        after.step_length,
        derivative,
        multipliers,
        found.residual,
        round(after.solver_steps / after.steps),
        walker.steps_walked,
    )


def fixed_point(
    walker: Steps[S], numbers: np.ndarray, derivative: np.ndarray | None = None, first: S | None = None
) -> FixedPointOf[S]:
    """The fixed point of a step map near `numbers` (10,), to the tolerance of its steps. Raises NoLimitCycle.

    The residual, in `scales`, is the tolerance, or the least met before the steps' own error let it fall no more, see
    `ENOUGH`. Newton's method; each step taken corrects the derivative (Broyden's rank one) until then, and it is made
    anew where the residual falls slowly. `derivative` (10, 10) of a similar model serves at first; `first` the step
    from `numbers`, if known.
    """
    after, previous, renewals, slow, began = first or walker.step(numbers), np.inf, 0, 0, 0.0
    least, since, close = np.inf, 0, walker.tolerance * ENOUGH[-1]
    for _ in range(NEWTON_STEPS):
        moved = after.numbers - numbers
        residual = _size(walker, moved)
        since = 0 if residual < SLOW * least else since + 1
        if not since:
            least, best = residual, (numbers, after)
        if least <= walker.tolerance * ENOUGH[min(since, len(ENOUGH) - 1)]:
            break
        if previous == np.inf:
            began = residual
        if residual > SLOW * previous:
            slow = PATIENCE if residual > SLOW * began else slow + 1
        fresh = derivative is None or (slow >= PATIENCE and renewals < MOST_RENEWALS and residual > close)
        if derivative is None or fresh:
            derivative, renewals, slow, began = walker.derivative(numbers, after), renewals + 1, 0, residual
        previous = residual
        change, then = _taken(walker, numbers, _newton_change(derivative, moved, walker.scales))
        leads = _size(walker, then.numbers - (numbers + change))
        if leads > AWAY * residual and residual > close and renewals < MOST_RENEWALS and not fresh:
            derivative, renewals, slow, began = walker.derivative(numbers, after), renewals + 1, 0, residual
            change, then = _taken(walker, numbers, _newton_change(derivative, moved, walker.scales))
            leads = _size(walker, then.numbers - (numbers + change))
        scaled = change / walker.scales
        missed = then.numbers - after.numbers - derivative @ change
        numbers, after = numbers + change, then
        if residual > close or leads < SLOW * least:
            derivative = derivative + np.outer(missed, scaled / walker.scales) / float(scaled @ scaled)
    if least > close:
        raise NoLimitCycle(f"no fixed point within {NEWTON_STEPS} iterations, residual {residual:.1e}")
    return FixedPointOf(*best, least, np.eye(10) if derivative is None else derivative)


def corrected(
    walker: Steps[S], numbers: np.ndarray, derivative: np.ndarray, first: S | None = None
) -> FixedPointOf[S]:
    """Where one correction of a fixed point by Newton's method leads; `first` is the step from it, if known.

    A search stops at the tolerance of its steps, and what is left of it is larger than their errors; a gait of a model
    as close as round-off needs no search. Raises NoLimitCycle.
    """
    moved = (first or walker.step(numbers)).numbers - numbers
    there = numbers + _newton_change(derivative, moved, walker.scales)
    step = walker.step(there)
    return FixedPointOf(there, step, _size(walker, step.numbers - there), derivative)


def nearer(walker: Steps[S], found: FixedPointOf[S], derivative: np.ndarray) -> FixedPointOf[S]:
    """A fixed point that was found, or where one more correction leads if that is nearer.

    So its numbers are off by the steps' own errors, which looser steps tell, and not by where the search stopped.
    """
    with contextlib.suppress(NoLimitCycle):  # what was found stays, if nothing is near it
        if found.residual > 0.0:
            other = corrected(walker, found.numbers, derivative, found.step)
            return other if other.residual < found.residual else found
    return found


def _size(walker: Steps[S], moved: np.ndarray) -> float:
    """How far a step moves the section numbers (10,), in `scales`."""
    return float(np.abs(moved / walker.scales).max())


def _newton_change(derivative: np.ndarray, moved: np.ndarray, scales: np.ndarray) -> np.ndarray:
    """The change of the section numbers (10,) that makes up for what a step moved them. Raises NoLimitCycle."""
    try:
        change = np.linalg.solve(np.eye(10) - derivative, moved)
    except np.linalg.LinAlgError:
        change = np.full(10, np.inf)
    if not np.abs(change / scales).max() < FARTHEST:
        raise NoLimitCycle("no fixed point in reach: the step map has a multiplier of one, and moves every state")
    return change


def _taken(walker: Steps[S], numbers: np.ndarray, change: np.ndarray) -> tuple[np.ndarray, S]:
    """A change of the section numbers from which the model takes a step: the one requested, or a part of it."""
    for _ in range(HALVINGS):
        try:
            return change, walker.step(numbers + change)
        except NoLimitCycle:
            change = 0.5 * change
    return change, walker.step(numbers + change)


def by_differences(
    step: Callable[[np.ndarray], S],
    numbers: np.ndarray,
    differences: np.ndarray,
    after: S | None = None,
) -> np.ndarray:
    """Derivative (10, 10) of a step map by central differences, or by forward ones from the step `after` numbers."""
    columns = []
    for index, size in enumerate(differences):
        change = np.zeros(10)
        change[index] = size
        ahead = step(numbers + change).numbers
        if after is None:
            columns.append((ahead - step(numbers - change).numbers) / (2.0 * size))
        else:
            columns.append((ahead - after.numbers) / size)
    return np.column_stack(columns)


def floquet_multipliers(derivative: np.ndarray) -> np.ndarray:
    """Eigenvalues of a derivative of the step map, largest first, real and imaginary part, (10, 2)."""
    values = np.linalg.eigvals(derivative)
    values = values[np.lexsort((-values.imag, -np.abs(values)))]
    return np.column_stack([values.real, values.imag])
