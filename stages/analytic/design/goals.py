"""What a design can be searched for: measures of a gait with exact gradients by the design's parameters.

A goal is the largest of its parts, each of which is smooth by itself: of the multipliers' magnitudes, of the values at
the start, inside and at the end of each phase of single stance.

The largest value of F(y(t), p) inside of single stance is an event, dF/dt = 0. Its time moves with the parameters, but
to first order its value does not move with its time (envelope theorem): what is left is the change of F at that time,
F_y dy + F_p, with dy from variational equations. At the phase's start and end, which are events of their own, the
variation at the event is taken. A hip with Coulomb friction ends phases inside of single stance as well, where forces
jump. Times count from the start of the phase.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from stages.analytic.derivatives import on_blocks
from stages.analytic.derivatives.gait import GaitTangents, exchanged_rows
from stages.analytic.derivatives.multipliers import APART, LEADING, eigensystem, matrix_slope
from stages.analytic.derivatives.numbers import moved
from stages.analytic.errors import StepFailed
from stages.analytic.gait.gait_report import record_steps
from stages.analytic.gait.gait_search import step_length
from stages.analytic.gait.poincare import STEP_LIMIT_OF_A_PHASE, TIME_LIMIT_OF_A_PHASE, FixedPoint, step_failure
from stages.analytic.integration.integrator import STAGES, take_step
from stages.analytic.integration.phase import EVENT, NO_NODES, integrate
from stages.analytic.model.kinds import Directions, Kind, directions
from stages.analytic.model.stiffness import attainable_tolerance
from stages.analytic.model.walker import Vector, Walker
from stages.analytic.phases.guards import guard
from stages.analytic.phases.motion import flow
from stages.analytic.phases.section import section_state
from stages.analytic.phases.succession import first_phase, succeed
from stages.analytic.walk.recording import Segment, in_single_stance, states_at
from stages.analytic.walk.sampling import accelerations_and_forces
from stages.analytic.walk.validity import SAMPLES_PER_STEP

#: A value at each of some states (n, size) of a phase.
Quantity = Callable[[int, np.ndarray, Kind], Vector]
#: Largest share by which states and numbers move in the differences of a closed form, extrapolated once.
SHARE = 2e-3


def friction_ratio(phase: int, states: np.ndarray, p: Kind) -> Vector:
    """|tangential| / normal force on the stance foot. Raises StepFailed where the ground would have to pull."""
    forces = accelerations_and_forces(phase, states, p)[:, 4:6]
    if not (forces[:, 1] > 0.0).all():
        raise StepFailed("the ground would pull the stance foot")
    return np.asarray(np.abs(forces[:, 0]) / forces[:, 1])


def scuff_depth(phase: int, states: np.ndarray, p: Kind) -> Vector:
    """Depth of the swing foot below the ground, leg lengths."""
    return np.array([-guard(phase, y, p, y, 0)[0] for y in states])


@dataclass(frozen=True)
class Piece:
    """A phase of a gait, the walker in whose step it is, and the phase's three times, (3,): its start, that of the
    largest value inside, its end; and the values there. Both are empty where the swing foot is not in play.

    Where there is no maximum inside, the end with the larger value stands for it.
    """

    segment: Segment
    walker: Walker
    times: Vector
    values: Vector


def pieces(walker: Walker, point: FixedPoint, quantity: Quantity, tolerance: float) -> list[Piece]:
    """The phases of all steps of a gait, with where a quantity is largest in single stance. Raises StepFailed."""
    return [
        largest(walker.on(segment.stance_leg), segment, quantity) if in_single_stance(segment)
        else Piece(segment, walker.on(segment.stance_leg), np.zeros(0), np.zeros(0))
        for segment in record_steps(walker, point, tolerance)]


def extremes(walker: Walker, point: FixedPoint, quantity: Quantity, tolerance: float) -> Vector:
    """Values (3 m,) of a quantity where it may be largest in the m phases of single stance of a gait's steps.

    Raises StepFailed.
    """
    return np.concatenate([piece.values for piece in pieces(walker, point, quantity, tolerance)])


def largest(walker: Walker, segment: Segment, quantity: Quantity) -> Piece:
    """Where a quantity is largest in a phase; `walker` is the one in its step."""
    p = walker.p
    edges = np.append(segment.times, segment.duration)
    times = np.append(np.linspace(edges[:-1], edges[1:], SAMPLES_PER_STEP, endpoint=False, axis=1), segment.duration)

    def at(*when: float) -> np.ndarray:
        return states_at(segment.phase, segment.times, segment.states, np.array(when), p)

    def rate(time: float) -> float:
        y, rates = at(time)[0], np.empty(walker.size)
        flow(segment.phase, y, p, rates)
        return change(quantity, segment.phase, y, p, rates, np.zeros(len(p)))

    top = 1 + int(np.argmax(quantity(segment.phase, at(*times[1:-1]), p)))
    before, after = times[top - 1], times[top + 1]
    states = np.vstack([at(0.0), segment.end])
    first, last = quantity(segment.phase, states, p)
    if rate(before) > 0.0 > rate(after):
        inside = brentq(rate, before, after, xtol=1e-13)
        most = quantity(segment.phase, at(inside), p)[0]
    else:
        inside, most = (0.0, first) if first > last else (segment.duration, last)
    return Piece(segment, walker, np.array([0.0, inside, segment.duration]), np.array([first, most, last]))


def extreme_derivatives(gait: GaitTangents, quantity: Quantity, tolerance: float) -> np.ndarray:
    """Derivatives (3 m, n) of `extremes` for whole shares of the gait's parameters. Raises StepFailed."""
    walker, along = gait.walker, gait.changes.along
    found, tolerance = pieces(walker, gait.point, quantity, tolerance), attainable_tolerance(walker.p, tolerance)
    numbers = directions(along, len(along))
    y = np.concatenate([section_state(gait.point.z, walker.p), gait.state.T.ravel()])
    phase, _ = first_phase(y, walker.p)
    rows: list[np.ndarray] = []
    for piece in found:
        if phase != piece.segment.phase:
            raise StepFailed("an event of the hip comes and goes with the integration's steps")
        start, p = y.copy(), piece.walker.p
        finish(phase, y, p, numbers, tolerance)
        if piece.times.size:
            inside = y if piece.times[1] == piece.segment.duration else carried(
                phase, start, p, numbers, piece.segment, piece.times[1])
            rows += [changes(quantity, phase, state, piece.walker, along) for state in (start, inside, y)]
        phase, _ = succeed(phase, y, p, numbers)
        if piece.segment.last:
            along = exchanged_rows(piece.walker, along)
            numbers = directions(along, len(along))
    return np.array(rows)


def changes(quantity: Quantity, phase: int, y: Vector, walker: Walker, along: np.ndarray) -> Vector:
    """Change (n,) of a quantity with each variation of the state in y ((1 + n) * size,), which goes with a row (n,)."""
    state, *moves = y.reshape(-1, walker.size)
    pairs = zip(moves, along, strict=True)
    return np.array([change(quantity, phase, state, walker.p, move, numbers) for move, numbers in pairs])


def finish(phase: int, y: Vector, p: Kind, numbers: Directions, tolerance: float) -> None:
    """Take state and variations to the event that ends the phase, in place."""
    status, *_ = integrate(
        phase, y, p, tolerance, TIME_LIMIT_OF_A_PHASE, STEP_LIMIT_OF_A_PHASE, 0.02, NO_NODES, numbers)
    if status != EVENT:
        raise StepFailed(step_failure(status, phase))


def carried(phase: int, y: Vector, p: Kind, numbers: Directions, segment: Segment, time: float) -> Vector:
    """State and variations at a time inside the segment, from those at its start, by the integrator's own steps."""
    stages = np.empty((STAGES, y.size))
    for length in np.diff(np.append(segment.times[segment.times < time], time)):
        new = np.empty(y.size)
        flow(phase, y, p, stages[0], numbers)
        take_step(phase, y, length, p, stages, new, numbers)
        y = new
    return y


def change(quantity: Quantity, phase: int, y: Vector, p: Kind, dy: Vector, dp: Vector) -> float:
    """Change of a quantity, a closed form of state and numbers, for changes of both.

    Central differences of that form alone, extrapolated: no integration is in them, so they are good to 1e-10 or so.
    """
    numbers = np.array(p)
    size = max(float(np.abs(dy / (1 + np.abs(y))).max()), float(np.abs(dp / (1 + np.abs(numbers))).max()))
    if not size > 0.0:
        return 0.0

    def slope(step: float) -> float:
        above, below = (
            quantity(phase, (y + side * dy)[None, :], type(p)(*(numbers + side * dp).tolist()))[0]
            for side in (step, -step))
        return float((above - below) / (2 * step))

    step = SHARE / size
    return (4 * slope(step / 2) - slope(step)) / 3


#: Share of a parameter over which the exact monodromy matrix is differenced along the gaits' exact tangent.
MATRIX_SHARE = 2e-5
#: The same of the gait sensitivity norm, and the tolerance of the steps that it is differenced from.
NORM_SHARE, NORM_TOLERANCE = 4e-4, 1e-12


@dataclass(frozen=True)
class Goal:
    """Parts (m,) of a gait's value, SI, at a tolerance, and their derivatives (m, n) for whole shares of parameters.

    Where these are differences of what is drawn, `coarse` is the share of a parameter below which they show little.
    """

    title: str
    unit: str
    parts: Callable[[Walker, FixedPoint, float], Vector]
    slopes: Callable[[GaitTangents, float], np.ndarray]
    coarse: float = 0.0


def magnitudes(walker: Walker, point: FixedPoint, tolerance: float) -> Vector:
    """Magnitudes of the multipliers, of one step, in the order of their real parts, in which they stay as they pass
    each other's."""
    return np.asarray(np.abs(np.sort_complex(point.floquet_multipliers)) ** (1.0 / len(point.steps)))


def magnitude_slopes(gait: GaitTangents, tolerance: float) -> np.ndarray:
    """Derivatives of `magnitudes`; zero for the small ones.

    Two that have met have none of their own: they share that of their mean.
    """
    values, left, right = eigensystem(gait.by_state)
    slopes = np.zeros((len(values), len(gait.changes.names)))
    leading = np.abs(values) >= LEADING * np.abs(values).max()
    for row in range(slopes.shape[1]):
        moves = np.einsum("ij,jk,ki->i", left, matrix_slope(gait, row, MATRIX_SHARE), right)
        for index in np.flatnonzero(leading):
            met = leading & (np.abs(values - values[index]) < APART)
            slopes[index, row] = np.real(np.conj(values[index]) * moves[met].mean()) / np.abs(values[index])
    steps = len(gait.point.steps)
    slopes[leading] *= np.abs(values[leading, None]) ** (1.0 / steps - 1.0) / steps
    return slopes[np.lexsort((values.imag, values.real))]


def speed(walker: Walker, point: FixedPoint, tolerance: float) -> Vector:
    """Speed, (1,)."""
    return np.array([step_length(walker, point) / point.period * walker.length / walker.time])


def speed_slopes(gait: GaitTangents, tolerance: float) -> np.ndarray:
    """Derivatives of `speed`."""
    return np.asarray(speed(gait.walker, gait.point, tolerance)[:, None] * gait.elasticities()["speed_m_s"])


def norm(walker: Walker, point: FixedPoint, tolerance: float) -> Vector:
    """Gait sensitivity norm, (1,). Raises StepFailed where there is none."""
    found = on_blocks.on_blocks(walker, point, tolerance)
    if found is None:
        raise StepFailed("the gait is unstable, or its feet do not roll")
    return np.array([found.sensitivity_norm])


def norm_slopes(gait: GaitTangents, tolerance: float) -> np.ndarray:
    """Derivatives of `norm`: extrapolated differences of it, by exact derivatives, along the gait's exact tangent."""
    walker, point = gait.walker, gait.point

    def there(row: int, share: float) -> float:
        beside = moved(walker, share * gait.changes.along[row])
        found = on_blocks.spreads(beside, point.z + share * gait.z[:, row], len(point.steps), NORM_TOLERANCE)
        return float(found[on_blocks.DURATION]) * walker.time / walker.length

    def slope(row: int, share: float) -> float:
        return (there(row, share) - there(row, -share)) / (2 * share)

    return np.array([[(4 * slope(row, NORM_SHARE / 2) - slope(row, NORM_SHARE)) / 3
                      for row in range(len(gait.changes.names))]])  # fmt: skip


def _over_stance(title: str, unit: str, quantity: Quantity, length: Callable[[Walker], float]) -> Goal:
    """The largest value of a quantity in single stance."""
    def parts(walker: Walker, point: FixedPoint, tolerance: float) -> Vector:
        return length(walker) * extremes(walker, point, quantity, tolerance)

    def slopes(gait: GaitTangents, tolerance: float) -> np.ndarray:
        return length(gait.walker) * extreme_derivatives(gait, quantity, tolerance)

    return Goal(title, unit, parts, slopes)


GOALS = {
    "multiplier": Goal("largest multiplier", "1", magnitudes, magnitude_slopes),
    "speed": Goal("speed", "m/s", speed, speed_slopes),
    "friction": _over_stance("friction needed in single stance", "1", friction_ratio, lambda walker: 1.0),
    "sensitivity_norm": Goal("gait sensitivity norm", "s/m", norm, norm_slopes),
    "scuff": _over_stance("deepest scuff", "m", scuff_depth, lambda walker: walker.length),
}
