"""The robot that one run was made with: its design, its start and its sensors, by least squares on a growing horizon.

Heel strikes are spikes, and where the model's do not yet meet the measured ones least squares are lost. So the first
step is fitted first, and each longer stretch starts from what the shorter one gave; and the noise is taken for larger
than it is at first, so that a wrong event does not outweigh the priors of design and sensors.

Unknowns stand in the order of `Model.names`: shared parameters, the run's own ones, its start and sensors.
"""

import contextlib
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from stages.analytic.derivatives.numbers import changes_of
from stages.analytic.errors import StepFailed
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.model.walker import Vector
from stages.biped.accuracy.scales import quickness
from stages.calibration.estimation.first_guess import first_guess, other_guesses
from stages.calibration.estimation.least_squares import (
    WHOLE_RUN,
    Known,
    Point,
    Rule,
    known_equations,
    least_squares,
)
from stages.calibration.observation.measured_run import SIDES, Layout, MeasuredRun, Sampling
from stages.calibration.observation.prediction import Predicted, predict


@dataclass(frozen=True)
class Model:
    """What is fitted: parameters `shared` by all runs and those that are each run's `own`, by their files' names.

    `noise` (3,) standard deviation of a sample forward, up, rate, behind a low pass that cuts off at `noise_hz` [Hz];
    `robust` sigmas from which on a residual pulls less; `strike` [s] standard deviation of the measured heel strikes,
    infinite where they are not used.
    """

    shared: tuple[str, ...]
    own: tuple[str, ...]
    layout: Layout
    noise: tuple[float, float, float]
    noise_hz: float
    tolerance: float
    robust: float = np.inf
    strike: float = np.inf

    @property
    def of_design(self) -> tuple[str, ...]:
        """The design's parameters, shared and own."""
        return (*self.shared, *self.own)

    @property
    def names(self) -> tuple[str, ...]:
        """All unknowns of one run, (n,)."""
        return (*self.of_design, *self.layout.names)

    def noise_at(self, sampling: Sampling, side: str) -> Vector:
        """Standard deviation (3,) of a side's samples: white noise grows with the root of the bandwidth."""
        return np.array(self.noise) * math.sqrt(sampling.bandwidth_hz[side] / self.noise_hz)

    def robot(self, design: DesignPoint, shared: Iterable[float], own: Iterable[float] = ()) -> DesignPoint:
        """The design with values of the shared parameters, and of a run's own where they are given."""
        return design.with_values({name: float(value) for name, value in zip(self.of_design, (*shared, *own))})


@dataclass(frozen=True)
class Equations:
    """Gauss-Newton's matrix (n, n) and right side (n,) of a run, in SI units, priors of the run included.

    `cost` of Huber's, priors included; `chi2` the sum of squares of `count` readings, none of which counts for more
    than `robust` sigmas. `residuals` by side (m, 3), in sigmas of its `noise` (3,), NaN where nothing is used.
    """

    matrix: np.ndarray
    right: Vector
    cost: float
    chi2: float
    count: int
    residuals: dict[str, np.ndarray]
    predicted: Predicted
    robust: float = np.inf
    noise: Mapping[str, Vector] = field(default_factory=dict)

    def pulls(self, side: str) -> np.ndarray:
        """Residuals (m, 3) as they pull: one beyond `robust` sigmas, a spike, no more than that."""
        return np.asarray(np.clip(self.residuals[side], -self.robust, self.robust))

    def others(self, right: np.ndarray) -> np.ndarray:
        """The unknowns (o, c) after the first of them that the last rows of the matrix give for right sides (o, c)."""
        own = self.matrix[-len(right) :, -len(right) :]
        scale = 1.0 / np.sqrt(np.diag(own))
        scaled = own * scale * scale[:, None]
        return np.asarray(np.linalg.lstsq(scaled, right * scale[:, None], rcond=1e-14)[0] * scale[:, None])

    def eliminated(self, shared: int) -> tuple[np.ndarray, Vector]:
        """What is left for the first `shared` unknowns when the others are solved for: matrix and right side."""
        cross = self.matrix[:shared, shared:]
        solved = self.others(np.column_stack([cross.T, self.right[shared:]]))
        left = self.matrix[:shared, :shared] - cross @ solved[:, :-1]
        return 0.5 * (left + left.T), self.right[:shared] - cross @ solved[:, -1]

    def own_step(self, step: Vector) -> Vector:
        """The other unknowns' step (o,) that goes with that of the shared ones (d,)."""
        d = len(step)
        return self.others((self.right[d:] - self.matrix[d:, :d] @ step)[:, None])[:, 0]


def run_equations(
    design: DesignPoint, own_values: Vector, unknowns: Vector, run: MeasuredRun, model: Model
) -> Equations:
    """The equations at a design, with the run's own parameters of it and its other unknowns.

    Raises StepFailed where the walker does not get to the run's end.
    """
    design = design.with_values(dict(zip(model.own, own_values, strict=True)))
    found = predict(design, model.of_design, unknowns, model.layout, run.sampling, model.tolerance)
    n, layout = len(model.names), model.layout
    noise = {side: model.noise_at(run.sampling, side) for side in SIDES}
    matrix, right, cost, chi2, count = np.zeros((n, n)), np.zeros(n), 0.0, 0.0, 0
    residuals = {}
    for side in SIDES:
        used = run.used[side]
        left = (run.samples[side] - found.samples[side][:, :, 0]) / noise[side]
        residuals[side] = np.where(used, left, np.nan)
        r, jacobian = left[used], (found.samples[side][:, :, 1:] / noise[side][:, None])[used]
        size = np.abs(r)
        beyond = size > model.robust
        weight = np.where(beyond, model.robust / np.maximum(size, 1e-300), 1.0)
        matrix += jacobian.T @ (weight[:, None] * jacobian)
        right += jacobian.T @ (weight * r)
        cost += 0.5 * float((r[~beyond] ** 2).sum())
        cost += float((model.robust * (size[beyond] - 0.5 * model.robust)).sum()) if beyond.any() else 0.0
        chi2 += float((np.minimum(size, model.robust) ** 2).sum())
        count += r.size
    if np.isfinite(model.strike):
        both = min(len(found.strikes), len(run.strikes) - 1)
        late = (run.strikes[1 : both + 1] - found.strikes[:both, 0]) / model.strike
        rows = found.strikes[:both, 1:] / model.strike
        matrix += rows.T @ rows
        right += rows.T @ late
        cost += 0.5 * float(late @ late)
    readings: list[tuple[int, float, float, float]] = [
        (len(model.shared) + k, float(own_values[k]), *run.own[name])
        for k, name in enumerate(model.own) if name in run.own]
    priors = [(n - len(layout.names) + k, float(unknowns[k]), float(layout.middle[k]), float(sd))
              for k, sd in enumerate(layout.prior_at(run.sampling)) if np.isfinite(sd)]  # fmt: skip
    for place, value, middle, sd in [*readings, *priors]:
        matrix[place, place] += 1.0 / sd**2
        right[place] -= (value - middle) / sd**2
        cost += 0.5 * ((value - middle) / sd) ** 2
    return Equations(matrix, right, cost, chi2, count, residuals, found, model.robust, noise)


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
#: Where a fit's first guess stands, and how another is given.
GUESS = ("of a robot that was never fitted it is the design in params/biped.yaml (or, with design: parts, the parts in "
         "params/twin.yaml): give a nearer one there, by --set biped.KEY=VALUE, or in another folder by --params")
#: A fit is taken if its mean square residual is below this, in sigmas; else these factors of the noise are tried, and
#: then horizons with samples for so long at least [s], at last from the gait's own start. Two fits that end with costs
#: that are alike to this share are the same: what is left then is the model's error, and not the way's.
GOOD, ATTEMPTS, LEAST, ALIKE = 4.0, (1.0, 6.0, 0.3), 0.08, 1e-3
#: Other guesses that are followed at most.
OTHERS = 6
#: Where the walker falls on the way to the next horizon, the last one is fitted again and then one half way, noise so
#: many times smaller; at most so often.
QUIETER, MOST_AGAIN = 3.0, 5
#: Of a horizon that is not the last.
SHORTER = Rule(12, enough=1.0)
#: One step, whole and undamped, wherever it leads.
STEP = Rule(2, larger=np.inf, caution=(0.0, 0.0, np.inf))
#: What is said beside why a fit did not come to rest where nothing is known beside the samples.
UNWEIGHED = ("; the scale of masses, springs and dampers is not in such samples: weigh the robot and say its mass "
             "(known: total_mass; in a study calibration.weighed_mass)")
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
    return np.asarray(shares * np.abs(changes_of(design, names).scales))


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


def sizes_and_lowest(design: DesignPoint, names: Sequence[str], layout: Layout) -> tuple[Vector, Vector]:
    """Usual changes and least values (n,) of parameters, and after them of a run's unknowns, which have no least."""
    return (np.concatenate([design_sizes(design, names), layout.sizes]),
            np.concatenate([lowest(design, names), np.full(len(layout.names), -np.inf)]))


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


def fit_near(
    design: DesignPoint, begin: Vector, run: MeasuredRun, model: Model, known: Sequence[Known]
) -> RunFit:
    """Fit a run whose design and unknowns (k,) are known but for what a model puts wrong; `fit_run` if that fails.

    Raises StepFailed as that does.
    """
    with contextlib.suppress(StepFailed):
        fit = fit_from(design, begin, run, model, known, WHOLE)
        if fit.converged:
            return fit
    return fit_run(design, run, model, known)


def fit_from(
    design: DesignPoint, begin: Vector, run: MeasuredRun, model: Model, known: Sequence[Known],
    louder: Sequence[float] = (1.0,),
) -> RunFit:
    """Fit a whole run from a design and unknowns (k,), with noise so many times `louder` one after another.

    Raises StepFailed where the robot does not walk it.
    """
    ends = [(run.duration, one) for one in louder]
    return _fit(design, _as_drawn(design, begin, run, model), ends, run, model, known)


def one_step(
    design: DesignPoint, found: tuple[Vector, Vector, Vector], run: MeasuredRun, model: Model, known: Sequence[Known]
) -> RunFit:
    """One whole step of Gauss and Newton from what a fit of the run found: its shared parameters (d,), own (o,) and
    unknowns (k,). For a fit at rest, how far that leads with a closer model is its error.

    Raises StepFailed where the robot does not walk it.
    """
    fit = _fit(design, np.concatenate(found), [(run.duration, 1.0)], run, model, known, rule=STEP)
    return replace(fit, converged=True, why="")


def begun(design: DesignPoint, run: MeasuredRun, model: Model) -> RunFit:
    """The fit of a run's first two steps, of a robot that is known but for its ramp. Raises StepFailed."""
    first = replace(run.upto(float(run.strikes[2])), strikes=run.strikes[:3])
    return fit_run(design, first, replace(model, shared=(), own=("ground.slope_deg",)), ())


def fit_run(design: DesignPoint, run: MeasuredRun, model: Model, known: Sequence[Known]) -> RunFit:
    """Fit a run from a first guess of the design, its start from its heel strikes, the rest from what is believed.

    Where that leads nowhere it is tried again with other noises and horizons on the way, and where the guess does not
    walk through the first horizon with one parameter changed so that steps last as long as measured. Raises StepFailed
    where none of that does.
    """
    try:
        return _from_guess(design, run, model, known)
    except StepFailed as reason:
        failure = reason
    spent = 0
    for there in other_guesses(design, model.shared, run.strikes)[:OTHERS]:
        with contextlib.suppress(StepFailed):
            fit = _from_guess(there, run, model, known)
            spent += fit.evaluations
            if fit.converged and fit.equations.chi2 < GOOD * fit.equations.count:
                return replace(fit, evaluations=spent)
    raise failure


def _from_guess(design: DesignPoint, run: MeasuredRun, model: Model, known: Sequence[Known]) -> RunFit:
    """The best of the attempts of `fit_run` from one design."""
    found: RunFit | None = None
    quick = quickness(design.biped, design.slope.gravity)
    spent, failure = 0, StepFailed("no fit was tried")
    begin = first_guess(design, run.strikes, run.sampling.first_leg, model.layout)
    for start, louder, least in (*((begin, one, 0.0) for one in ATTEMPTS), (begin, 1.0, LEAST),
                                 (model.layout.middle, 1.0, LEAST)):
        try:
            fit = _fit(design, _as_drawn(design, start, run, model), horizons(run, louder, least, quick), run, model,
                       known, found)  # fmt: skip
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


def _as_drawn(design: DesignPoint, unknowns: Vector, run: MeasuredRun, model: Model) -> Vector:
    """All unknowns (n,) where a fit begins: those of the design, of its own what the run was read to have."""
    own = [run.own[name][0] if name in run.own else design.value(name) for name in model.own]
    return np.concatenate([[design.value(name) for name in model.shared], own, unknowns])


def _fit(
    design: DesignPoint, x: Vector, ends: Sequence[tuple[float, float]], run: MeasuredRun, model: Model,
    known: Sequence[Known], other: RunFit | None = None, rule: Rule = WHOLE_RUN,
) -> RunFit:
    """One attempt of `fit_run`, the unknowns from `x` (n,), on the horizons `ends`, the last one by a `rule`.

    One that comes to where the last horizon of an `other` began, which came to rest, is that.
    """
    d, o = len(model.shared), len(model.of_design)
    sizes, low = sizes_and_lowest(design, model.of_design, model.layout)
    first, evaluations, approach = x[:d].copy(), 0, np.nan
    waiting, reached, again = list(ends), 0.0, 0
    strike_sd = STRIKE_SD / quickness(design.biped, design.slope.gravity)
    while waiting:
        horizon, louder = waiting.pop(0)
        part, is_last = run.upto(horizon), louder == 1.0
        forward, up, rate = (louder * one for one in model.noise)
        weighed = model if is_last else replace(model, noise=(forward, up, rate), strike=strike_sd)

        def evaluate(
            at: Vector, _: Point[Equations] | None = None, __: float = 1.0, part: MeasuredRun = part,
            weighed: Model = weighed, held: bool = not is_last,
        ) -> Point[Equations] | None:
            there = model.robot(design, at[:d])
            if not there.is_legal():
                return None
            try:
                found = run_equations(there, at[d:o], at[o:], part, weighed)
            except StepFailed:
                return None
            matrix, right, cost = known_equations(known, [one.of(there) for one in known], model.shared, there)
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
            point, walks, why = least_squares(evaluate, x, sizes, low, rule if is_last else SHORTER)
        except ValueError:
            again += 1
            if again > MOST_AGAIN or reached == 0.0:
                raise StepFailed(f"the first guess does not walk for {horizon:.1f} s; {GUESS}") from None
            nearer = max(louder / QUIETER**again, 1.5)
            waiting = [(reached, nearer), (0.5 * (reached + horizon), nearer), (horizon, louder), *waiting]
            continue
        x, evaluations, reached = point.x, evaluations + walks, horizon
        if waiting == [(run.duration, 1.0)]:
            approach = point.cost
            if other is not None and other.converged and abs(approach - other.approach) < ALIKE * other.approach:
                return replace(other, evaluations=evaluations)
    why += UNWEIGHED if why and model.shared and not known else ""
    return RunFit(x[:d], x[d:o], x[o:], point.state, evaluations, not why, why, approach)
