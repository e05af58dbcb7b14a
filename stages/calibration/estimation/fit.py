"""The robot that one run was made with: its design, its start and its sensors, by least squares on a growing horizon.

Heel strikes are spikes, and where the model's do not yet meet the measured ones least squares are lost. So the first
step is fitted first, and each longer stretch starts from what the shorter one gave; and the noise is taken for larger
than it is at first, so that a wrong event does not outweigh what is believed of design and sensors.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Generic, TypeVar

import numpy as np

from stages.analytic.derivatives.numbers import changes_of
from stages.analytic.errors import StepFailed
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.model.walker import Vector
from stages.biped.accuracy.scales import quickness
from stages.calibration.estimation.equations import Equations, Model, run_equations
from stages.calibration.estimation.first_guess import first_guess, other_guesses
from stages.calibration.estimation.known import Known, information_of
from stages.calibration.observation.measured_run import MeasuredRun

State = TypeVar("State")
#: Damping at first, its factors, and from which on a step is given up as hopeless.
FIRST, EASED, HARDENED, HOPELESS = 1e-3, 0.1, 10.0, 1e8
#: A fit has come to its end where half the sum of squares would fall by less than this, times the mean square residual
#: where that is larger than noise would have it: intervals are wider by as much, so it is the same part of them.
ENOUGH = 1e-3
MOST_ITERATIONS = 60


@dataclass(frozen=True)
class Point(Generic[State]):
    """Where the method stands: unknowns `x` (n,), half the sum of squares, its equations (matrix (n, n), right side
    (n,)), and what the problem keeps of it; `spread` is the mean square residual, one where noise is all that is left.
    """

    x: Vector
    cost: float
    matrix: np.ndarray
    right: Vector
    state: State
    spread: float = 1.0


@dataclass(frozen=True)
class Ended(Generic[State]):
    """Where the method ended, after how many evaluations, and whether it came to rest; if not, why."""

    point: Point[State]
    evaluations: int
    converged: bool
    why: str


def least_squares(
    evaluate: Callable[[Vector], Point[State] | None], begin: Vector, sizes: Vector, low: Vector,
    most: int = MOST_ITERATIONS, enough: float = ENOUGH,
) -> Ended[State]:
    """Bring the cost down from `begin` (n,) until it rests.

    `evaluate` gives the point at some unknowns, None where there is none. `sizes` (n,) are changes that are neither
    large nor small; no unknown goes below `low` (n,).
    """
    at = evaluate(begin)
    if at is None:
        raise ValueError("no value at the start")
    damping, evaluations = FIRST, 1
    while evaluations < most:
        if _step(at, sizes, low, 0.0)[1] < enough * max(at.spread, 1.0):
            return Ended(at, evaluations, True, "")
        step, foreseen = _step(at, sizes, low, damping)
        tried = evaluate(np.maximum(at.x + step, low))
        evaluations += 1
        if tried is not None and tried.cost < at.cost + 1e-9 * abs(at.cost):
            gain = (at.cost - tried.cost) / max(foreseen, 1e-300)
            at = tried
            if gain > 0.25:
                damping = max(damping * EASED, 1e-9)
            continue
        damping *= HARDENED
        if damping > HOPELESS:
            return Ended(at, evaluations, False, "no step brings the residuals down")
    return Ended(at, evaluations, False, f"{most} evaluations were not enough")


def _step(at: Point[State], sizes: Vector, low: Vector, damping: float) -> tuple[Vector, float]:
    """The damped step of all unknowns that are free to move, and by how much the cost should fall with it."""
    free = ~((at.x <= low) & (at.right <= 0.0))
    unit = sizes[free]
    matrix = at.matrix[np.ix_(free, free)] * unit * unit[:, None]
    right = at.right[free] * unit
    diagonal = np.diag(matrix)
    damped = matrix + np.diag(damping * diagonal + 1e-9)
    equal = 1.0 / np.sqrt(np.diag(damped))
    move = np.linalg.lstsq(damped * equal * equal[:, None], right * equal, rcond=1e-15)[0] * equal
    step = np.zeros(len(at.x))
    step[free] = move * unit
    return step, float(move @ right - 0.5 * move @ matrix @ move)


#: Times are those for Table 1's robot, and each other's by its own quickness. Horizons end so long [s] before the heel
#: strikes of these numbers; on each, noise is taken so many times too large.
BEFORE, STRIKES, LOUDER = 0.01, (1, 2, 3, 5, 8, 13, 21), (100.0, 50.0, 30.0, 20.0, 10.0, 10.0, 10.0)
#: Before those, so long before the second heel strike, where no walker near the right one lands yet.
SWING = (0.12, 0.06)
#: The same for the whole run, at last as it is.
WHOLE = (10.0, 3.0, 1.0)
#: A change of a parameter of the design that is neither large nor small, as a share of it; an inertia is known worse.
SHARE, SHARE_OF_INERTIA = 0.03, 0.3
#: On all horizons but the last the design is held by the first guess, with so many of these for a standard deviation.
HELD = 1.0
#: Standard deviation of measured heel strikes [s], which count until the last.
STRIKE_SD = 0.003
#: A fit is taken if its mean square residual is below this, in sigmas; else these factors of the noise are tried, and
#: then horizons with samples for so long at least [s], at last from the gait's own start. Two fits that end with costs
#: that are alike to this share are the same: what is left then is the model's error, and not the way's.
GOOD, ATTEMPTS, LEAST, ALIKE = 4.0, (1.0, 6.0, 0.3), 0.08, 1e-3
#: Other guesses that are followed at most.
OTHERS = 6
#: Where the walker falls on the way to the next horizon, the last one is fitted again and then one half way, noise so
#: many times smaller; at most so often.
QUIETER, MOST_AGAIN = 3.0, 5
#: Evaluations of a horizon that is not the last.
SOME = 12


#: Friction at the hip that is none, as a share of the weight times a leg's length.
LEAST_FRICTION = 1e-9


@dataclass(frozen=True)
class RunFit:
    """A run's fit: `design` (d,) values of the shared parameters, `own` (o,), `unknowns` (k,), and its equations there.

    `converged`, or `why` not; `evaluations` of how many walks; `approach` the cost where the last horizon began.
    """

    design: Vector
    own: Vector
    unknowns: Vector
    equations: Equations
    evaluations: int
    converged: bool
    why: str
    approach: float = np.nan


def design_sizes(design: DesignPoint, names: Sequence[str]) -> Vector:
    """Changes of parameters that are neither large nor small, (n,)."""
    shares = [SHARE_OF_INERTIA if design.unit(name) == "kg m^2" else SHARE for name in names]
    return np.asarray(shares * changes_of(design, names).scales)


def lowest(design: DesignPoint, names: Sequence[str]) -> Vector:
    """The least value of each parameter that means something, (n,)."""
    low = []
    for name in names:
        bound = design.bound(name)
        least = bound.minimum if bound.minimum is not None else bound.above
        if name == "biped.hip_friction":  # a walker without it is of another kind, which knows no derivative by it
            least = LEAST_FRICTION * design.biped.total_mass * design.slope.gravity * design.biped.leg_length
        low.append(-np.inf if least is None else least + (1e-6 if bound.above is not None else 0.0))
    return np.array(low)


def horizons(
    run: MeasuredRun, louder_still: float = 1.0, least: float = 0.0, quick: float = 1.0
) -> list[tuple[float, float]]:
    """Rising horizons up to the whole run [s], and how many times too large noise is taken on each.

    On those that are shorter than the run it is larger by `louder_still` times. The first has samples for `least` [s].
    All that for a robot that is so many times as `quick` as Table 1's.
    """
    found = [(float(run.strikes[number]) - BEFORE / quick, louder_still * louder)
             for number, louder in zip(STRIKES, LOUDER, strict=True) if number < len(run.strikes)]
    swing = [(float(run.strikes[1]) - short / quick, LOUDER[0]) for short in SWING]
    shorter = [(end, louder) for end, louder in found if end < run.duration]
    first = float(run.sampling.hip[0]) + least / quick if least else 0.0
    return [*(one for one in (*swing, *shorter) if one[0] > first), *((run.duration, one) for one in WHOLE)]


def known_equations(
    known: Sequence[Known], design: DesignPoint, names: Sequence[str]
) -> tuple[np.ndarray, Vector, float]:
    """What known values add to matrix, right side and cost."""
    right, cost = np.zeros(len(names)), 0.0
    for one in known:
        off = one.of(design) - one.value
        right -= one.row(names) * off / one.sd**2
        cost += 0.5 * (off / one.sd) ** 2
    return information_of(known, names), right, cost


def fit_near(
    design: DesignPoint, begin: Vector, run: MeasuredRun, model: Model, known: Sequence[Known]
) -> RunFit:
    """Fit a run whose design and unknowns (k,) are known but for what a model puts wrong; `fit_run` if that fails.

    Raises StepFailed as that does.
    """
    with contextlib.suppress(StepFailed):
        fit = _fit(design, begin, [(run.duration, one) for one in WHOLE], run, model, known)
        if fit.converged:
            return fit
    return fit_run(design, run, model, known)


def fit_run(
    design: DesignPoint, run: MeasuredRun, model: Model, known: Sequence[Known], begin: Vector | None = None
) -> RunFit:
    """Fit a run from a first guess of the design, its start from its heel strikes, the rest from what is believed.

    `begin` (k,) is that start, where `first_guess` has told it. Where that leads nowhere it is tried again with other
    noises and horizons on the way, and where the guess does not walk through the first horizon with one parameter
    changed so that steps last as long as measured. Raises StepFailed where none of that does.
    """
    try:
        return _from_guess(design, run, model, known, begin)
    except StepFailed as reason:
        failure = reason
    spent = 0
    for there in other_guesses(design, model.shared, run.strikes)[:OTHERS]:
        with contextlib.suppress(StepFailed):
            fit = _from_guess(there, run, model, known, None)
            spent += fit.evaluations
            if fit.converged and fit.equations.chi2 < GOOD * fit.equations.count:
                return replace(fit, evaluations=spent)
    raise failure


def _from_guess(
    design: DesignPoint, run: MeasuredRun, model: Model, known: Sequence[Known], begin: Vector | None
) -> RunFit:
    """The best of the attempts of `fit_run` from one design."""
    found: RunFit | None = None
    quick = quickness(design.biped, design.slope.gravity)
    spent, failure = 0, StepFailed("no fit was tried")
    begin = first_guess(design, run.strikes, run.sampling.first_leg, model.layout) if begin is None else begin
    for start, louder, least in (*((begin, one, 0.0) for one in ATTEMPTS), (begin, 1.0, LEAST),
                                 (model.layout.middle, 1.0, LEAST)):
        try:
            fit = _fit(design, start, horizons(run, louder, least, quick), run, model, known, found)
        except StepFailed as reason:
            failure = reason
            continue
        spent += fit.evaluations
        same = found is not None and abs(fit.equations.cost - found.equations.cost) < ALIKE * found.equations.cost
        if found is None or fit.equations.cost < found.equations.cost:
            found = fit
        good = found.equations.chi2 < GOOD * found.equations.count
        if (same and not good) or (found.converged and (same or good)):
            break
    if found is None:
        raise failure
    return replace(found, evaluations=spent)


def _fit(
    design: DesignPoint, begin: Vector, ends: Sequence[tuple[float, float]], run: MeasuredRun, model: Model,
    known: Sequence[Known], other: RunFit | None = None,
) -> RunFit:
    """One attempt of `fit_run`, the run's unknowns from `begin` (k,), on the horizons `ends`.

    One that comes to where the last horizon of an `other` began, which came to rest, is that.
    """
    d, k = len(model.shared), len(model.layout.names)
    names = (*model.shared, *model.own)
    own = [run.own[name][0] if name in run.own else design.value(name) for name in model.own]
    x = np.concatenate([[design.value(name) for name in model.shared], begin, own])
    all_sizes = design_sizes(design, names)
    sizes = np.concatenate([all_sizes[:d], model.layout.sizes, all_sizes[d:]])
    all_low = lowest(design, names)
    low = np.concatenate([all_low[:d], np.full(k, -np.inf), all_low[d:]])
    first, evaluations, approach = x[:d].copy(), 0, np.nan
    waiting, reached, again = list(ends), 0.0, 0
    strike_sd = STRIKE_SD / quickness(design.biped, design.slope.gravity)
    while waiting:
        horizon, louder = waiting.pop(0)
        part, is_last = run.upto(horizon), louder == 1.0
        noise = (louder * model.noise[0], louder * model.noise[1], louder * model.noise[2])
        heard = model if is_last else replace(model, noise=noise, strike=strike_sd)

        def evaluate(
            at: Vector, part: MeasuredRun = part, heard: Model = heard, held: bool = not is_last
        ) -> Point[Equations] | None:
            there = design.with_values(dict(zip(model.shared, at[:d], strict=True)))
            if not there.is_legal():
                return None
            try:
                found = run_equations(there, at[d + k :], at[d : d + k], part, heard)
            except StepFailed:
                return None
            matrix, right, cost = known_equations(known, there, model.shared)
            more, other = found.matrix.copy(), found.right.copy()
            more[:d, :d] += matrix
            other[:d] += right
            if held:
                off = (at[:d] - first) / (HELD * sizes[:d])
                more[range(d), range(d)] += 1.0 / (HELD * sizes[:d]) ** 2
                other[:d] -= off / (HELD * sizes[:d])
                cost += 0.5 * float(off @ off)
            return Point(at, found.cost + cost, more, other, found, found.chi2 / max(found.count, 1))

        try:
            ended = least_squares(evaluate, x, sizes, low) if is_last else least_squares(
                evaluate, x, sizes, low, SOME, 1.0)
        except ValueError:
            again += 1
            if again > MOST_AGAIN or reached == 0.0:
                raise StepFailed(
                    f"the first guess does not walk for {horizon:.1f} s; it is the design in params/biped.yaml (or, "
                    "with design: parts, the parts in params/twin.yaml): give a nearer one there, by --set "
                    "biped.KEY=VALUE, or in another folder by --params") from None  # fmt: skip
            nearer = max(louder / QUIETER**again, 1.5)
            waiting = [(reached, nearer), (0.5 * (reached + horizon), nearer), (horizon, louder), *waiting]
            continue
        x, evaluations, reached = ended.point.x, evaluations + ended.evaluations, horizon
        if waiting == [(run.duration, 1.0)]:
            approach = ended.point.cost
            if other is not None and other.converged and abs(approach - other.approach) < ALIKE * other.approach:
                return replace(other, evaluations=evaluations)
    return RunFit(x[:d], x[d + k :], x[d : d + k], ended.point.state, evaluations, ended.converged, ended.why, approach)
