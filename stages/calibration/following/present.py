"""What is known of a walk at one time: its state, with the spread of what a line does not show.

The unknowns are Gaussian, and a state is a function of them. At a fixed time since its stretch of the walk began it is
nearly linear. When that began is not known either, and where a leg has just landed its springs ring, or a foot leaves
the ground and the state has a bend: so the mean and covariance over that one time are those of Gauss and Hermite's
points, given the leg that stands; all that goes not along with it is taken as a line at each of them.

Whether the robot will fall follows from states drawn from what is known of its next heel strike, which walk on step by
step. Of the robot and its ground only the mean is walked. A fall is what the step map says: a step that has no end.
"""

import contextlib
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from stages.analytic.errors import StepFailed
from stages.analytic.gait.gait_report import energy
from stages.analytic.gait.poincare import poincare_map
from stages.analytic.model.kinds import natural_lengths, radii
from stages.analytic.model.walker import Vector, Walker
from stages.analytic.phases.section import section_coordinates
from stages.analytic.phases.succession import single_stance, succeed
from stages.calibration.observation.prediction import Walked

#: What is wrong in a state comes with so many times as much in its time, in units of the walker: contacts take theirs.
LATE = 10.0
#: So many standard errors of its time from an event a state may be before or after it.
NEAR = 6.0
#: Derivatives by time that describe a state so near to another that no event lies between, and their factorials.
ORDERS = np.arange(6)
FACTORIALS = np.array([math.factorial(order) for order in ORDERS], dtype=float)
#: A sample near a heel strike may be so many standard errors of its time nearer than it is thought to be.
WIDE = 2.0
#: Step of the differences of energy and step length by the state: stiff legs bend them.
SMALL = 1e-8
#: Points in standard deviations, and weights: far from all events, and near one.
FEW, MANY = ((np.sqrt(2.0) * points, weights / weights.sum())
             for points, weights in map(np.polynomial.hermite.hermgauss, (3, 15)))  # fmt: skip
#: Steps that are looked ahead; states that are drawn, and how many of them first: where these do alike, so do all.
STEPS, DRAWN, FIRST = 3, 60, 8
#: Falls are found with steps that are solved to this.
LOOSE = 1e-5


@dataclass(frozen=True)
class Instant:
    """What is known right after a sample of the hip, at `time` [s] on the run's clock, from samples up to that time.

    The state (size,) in SI units with its `covariance`, the leg that stands, whether both bear, and when the next heel
    strike comes with its standard error [s]. `innovation` is the mean square of the readings' innovations, in their own
    standard deviations; NaN without a reading. `energy` [J] counts from the standing foot; `step` [m] is how long the
    step is that the strike ends: each with its standard error by the state alone. Shortly before a heel strike `falls`
    are the probabilities to fall in the first, the first two and so on of the steps after it.
    """

    time: float
    state: Vector
    covariance: np.ndarray
    leg: int
    double: bool
    strike: float
    strike_sd: float
    innovation: float
    energy: tuple[float, float]
    step: tuple[float, float]
    falls: Sequence[float] = ()


class Present:
    """The states of a walk at any time, which are `wrong` by so much beside what is known of it, dimensionless.

    Times are those of a `clock`: the place of its rate among the unknowns, the rate the walk has, and since when [s] it
    runs apart. In a state its error counts as one of its own.
    """

    def __init__(self, walked: Walked, wrong: float, clock: tuple[int, float, float]) -> None:
        self._walked, self._unit = walked, walked.walker.time
        self._begins, self._begins_by = walked.begins()
        self._strikes = walked.strikes()
        self._legs = np.array([one.stance_leg for one in walked.stretches])
        self._floor, self._scales = wrong**2 * np.eye(walked.walker.size), walked.walker.scales()
        self._late, self._clock = LATE * wrong, clock
        place, rate, since = clock
        apart = self._strikes[:, 0] - since
        self._strikes[:, 0] -= rate * apart
        self._strikes[:, 1 + place] -= apart
        self.ends = float(self._begins[-1] + walked.stretches[-1].duration[0]) * self._unit

    def at(self, time: float, moved: Vector, covariance: np.ndarray, innovation: float) -> Instant:
        """What is known at a time [s] of a walk whose unknowns are `moved` (n,) from its own, with a covariance."""
        place, rate, since = self._clock
        now = (time + (rate + moved[place]) * (time - since)) / self._unit
        late = math.hypot(self._late, math.sqrt(covariance[place, place]) * (time - since) / self._unit)
        change = self._walked.columns @ moved
        spread = self._walked.columns @ covariance @ self._walked.columns.T
        events = self._begins + self._begins_by @ change
        number = self._number(events, now)
        nearest = int(np.argmin(np.abs(events - now)))
        along = spread @ self._begins_by[nearest]
        sd = math.sqrt(self._begins_by[nearest] @ along)
        along /= sd or 1.0  # a step that was begun at a given time
        rest, later = spread - np.outer(along, along), self._begins_by @ along
        if abs(events[nearest] - now) < NEAR * sd:
            points, weights = MANY
            on = np.array([self._number(events + point * later, now) for point in points])
            kept = self._legs[on] == self._legs[number]
            points, weights, on = points[kept], weights[kept], on[kept]
            found = np.empty((len(points), 2, *self._floor.shape[:1], len(change)))
            for one in set(on.tolist()):
                here = on == one
                found[here] = self._walked.stretches[one].at(now - events[one] - points[here] * later[one], 2)
        else:
            (points, weights), on = FEW, np.full(len(FEW[0]), number)
            series = self._walked.stretches[number].at(now - events[number], len(ORDERS))
            by_point = (-points[:, None] * later[number]) ** ORDERS / FACTORIALS
            found = np.stack([np.tensordot(by_point, series, 1), np.tensordot(by_point[:, :-1], series[1:], 1)], 1)
        there = np.column_stack([np.ones(len(points)), change + points[:, None] * along])[:, :-1]
        state, rates = (found @ there[:, None, :, None])[..., 0].swapaxes(0, 1)
        by = -rates[:, :, None] * self._begins_by[on][:, None]
        by[:, :, :-1] += found[:, 0, :, 1:]
        weights = weights / weights.sum()
        mean = weights @ state
        off = state - mean
        covered = (np.tensordot(weights, by @ rest @ by.swapaxes(1, 2), 1) + off.T @ (weights[:, None] * off)
                   + self._floor + late**2 * np.outer(weights @ rates, weights @ rates))  # fmt: skip
        stretch = self._walked.stretches[number]
        strike, strike_sd = self.strike(time, moved, covariance)
        return Instant(time, mean * self._scales, covered * self._scales * self._scales[:, None], stretch.stance_leg,
                       stretch.double, strike, strike_sd, innovation,
                       _with_error(partial(_energy, self._walked.walker.on(stretch.stance_leg)), mean, covered),
                       self._step(strike, moved, covariance))  # fmt: skip

    def _step(self, strike: float, moved: Vector, covariance: np.ndarray) -> tuple[float, float]:
        """Length of the step that ends with a strike [s] and its standard error [m]; NaN beyond the walk."""
        if math.isnan(strike):
            return math.nan, math.nan
        number = int(np.argmin(np.abs(self._strikes[:, 0] + self._strikes[:, 1:] @ moved - strike)))
        leg, state, spread = landing(self._walked, number, moved, covariance)
        return _with_error(partial(_length, self._walked.walker.on(leg)), state, spread + self._floor)

    def _number(self, begins: Vector, now: float) -> int:
        """The stretch at a time, where they begin at rising times (e,)."""
        return max(int(np.searchsorted(begins, now, "right")) - 1, 0)

    def strike(self, time: float, moved: Vector, covariance: np.ndarray) -> tuple[float, float]:
        """When the next heel strike after a time comes [s] and its standard error; NaN beyond the walk."""
        coming = self._strikes[:, 0] + self._strikes[:, 1:] @ moved
        if not (coming > time).any():
            return math.nan, math.nan
        following = int(np.argmax(coming > time))
        row = self._strikes[following, 1:]
        return float(coming[following]), math.sqrt(row @ covariance @ row)

    def is_near_a_strike(
        self, time: float, moved: Vector, covariance: np.ndarray, before: float, after: float
    ) -> bool:
        """Whether a time is from `before` to `after` a heel strike [s], or `WIDE` of its standard errors beside.

        These are `before` at most: who knows nothing of a strike needs samples.
        """
        for row in self._strikes:
            late = time - row[0] - row[1:] @ moved
            if -2.0 * before < late < before + after:
                wide = min(WIDE * math.sqrt(row[1:] @ covariance @ row[1:]), before)
                if -wide - before < late < wide + after:
                    return True
        return False


def landing(walked: Walked, number: int, moved: Vector, covariance: np.ndarray) -> tuple[int, Vector, np.ndarray]:
    """The leg that stands, state (size,) and its covariance just before a heel strike of a walk whose unknowns are
    `moved` (n,) from its own, dimensionless."""
    stretch = [one for one in walked.stretches if one.ends_step][number]
    by = stretch.end[:, 1:] @ walked.columns[:-1]
    return stretch.stance_leg, stretch.end[:, 0] + by @ moved, by @ covariance @ by.T


def _with_error(what: Callable[[Vector], float], state: Vector, covariance: np.ndarray) -> tuple[float, float]:
    """What follows from a dimensionless state, and its standard error."""
    value = what(state)
    by = np.array([what(state + step) - value for step in SMALL * np.eye(len(state))])
    return value, math.sqrt(by @ covariance @ by) / SMALL


def _energy(walker: Walker, state: Vector) -> float:
    """Energy of a dimensionless state [J]."""
    return float(walker.mass * (walker.length / walker.time) ** 2 * sum(energy(walker, state)))


def _length(walker: Walker, state: Vector) -> float:
    """Length [m] of the step that a dimensionless state just before its heel strike ends, as `gait_search.step_lengths`
    has it."""
    theta, psi = state[[0, 1 if walker.rigid else 2]]
    stance, swing = natural_lengths(walker.p) if walker.rigid else state[[1, 3]]
    radius, other = radii(walker.p)
    return float(walker.length * ((stance - radius) * math.sin(theta) + (swing - other) * math.sin(psi)
                                  + radius * theta + other * psi))  # fmt: skip


def falls(walked: Walked, moved: Vector, covariance: np.ndarray, wrong: float) -> Vector:
    """Probabilities (STEPS,) to fall in the first, the first two and so on of the steps after a walk's first strike.

    The walk's unknowns are `moved` (n,) from its own, with a covariance; the start of each step is `wrong` by so much,
    dimensionless. NaN where it does not come to a strike.
    """
    if not any(one.ends_step for one in walked.stretches):
        return np.full(STEPS, np.nan)
    leg, mean, spread = landing(walked, 0, moved, covariance)
    values, vectors = np.linalg.eigh(spread)
    spread = vectors * np.sqrt(np.maximum(values, 0.0))
    rng, walker, other = np.random.default_rng(0), walked.walker.on(leg), walked.walker.on(1 - leg)
    last = list[int]()
    while len(last) < (FIRST if len(set(last)) < 2 else DRAWN):
        off = wrong * rng.normal(size=(STEPS, 3))
        last.append(_last(mean + spread @ rng.normal(size=len(mean)), walker, other, off))
    return np.asarray((np.array(last)[:, None] <= np.arange(STEPS)).mean(axis=0))


def _last(before: Vector, walker: Walker, other: Walker, off: np.ndarray) -> int:
    """Whole steps, so many at most as there are errors `off` (steps, 3) of their starts, after a state (size,) just
    before a heel strike."""
    state, taken = before.copy(), 0
    _, decided = succeed(int(single_stance(state, walker.p)), state, walker.p, None)
    with contextlib.suppress(StepFailed):
        z = section_coordinates(state, other.p)
        while decided and taken < len(off):
            swings = [0, 3] if len(z) > 4 else [0, 1, 2]  # angles and their rates
            z[swings] += off[taken, : len(swings)]
            z, other, taken = poincare_map(other, z, LOOSE).z, other.exchanged, taken + 1
    return taken
