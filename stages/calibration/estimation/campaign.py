"""The robot that several runs were made with: one design, and for each run its own start, ramp and sensors.

Each run's own unknowns meet the others' only through the design, so the normal equations have the shape of an arrow:
they are solved for run by run, and what is left are equations for the design alone.
"""

import contextlib
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from itertools import repeat

import numpy as np
from scipy.special import stdtr

from stages.analytic.errors import StepFailed
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.model.walker import Vector
from stages.calibration.estimation.least_squares import (
    Known,
    Point,
    Rule,
    covariance_of,
    information_of,
    known_equations,
    least_squares,
)
from stages.calibration.estimation.run_fit import (
    SHORTER,
    Equations,
    Model,
    RunFit,
    design_sizes,
    fit_run,
    lowest,
    run_equations,
    sizes_and_lowest,
)
from stages.calibration.observation.measured_run import MeasuredRun

#: Joint steps: whole ones or halves of them; they rest by what the cost of a run falls.
JOINT = Rule(25, rests=1e-2, at_rest=1.0, halved=True, caution=(1.0, 1.0, 2.0**11), blind=1e-2,
             step="joint step", counted="joint steps")  # fmt: skip
#: A run is left out if its own fit, or the joint one, leaves so many times the square residual of the usual run.
ODD = 3.0
#: In so few campaigns of one robot runs are said to be of two.
CHANCE = 0.01


@dataclass(frozen=True)
class CampaignFit:
    """The design's shared parameters (d,) with their covariance (d, d), and of each run in `runs` its own parameters
    and unknowns, with its equations there. `left_out` runs have a reason each.

    `chi2` over `count` readings, which each run `alone` usually makes so large a reading; `evaluations` of how many
    walks.
    """

    names: tuple[str, ...]
    design: Vector
    covariance: np.ndarray
    runs: tuple[MeasuredRun, ...]
    own: np.ndarray
    unknowns: np.ndarray
    equations: tuple[Equations, ...]
    left_out: dict[str, str]
    chi2: float
    count: int
    evaluations: int
    converged: bool
    why: str
    alone: float = np.nan


def fit_campaign(
    design: DesignPoint, runs: Sequence[MeasuredRun], model: Model, known: Sequence[Known],
    own_fits: Iterable[tuple[int, RunFit | str]] | None = None,
) -> CampaignFit:
    """Fit runs, each alone and then all together. `own_fits` are the former by the runs' places, where they are made.

    Raises StepFailed where no run can be fitted.
    """
    found = [(runs[number], fit) for number, fit in sorted(dict(
        own_fits or side_by_side(design, runs, model, known)).items())]  # fmt: skip
    left_out = {run.name: fit for run, fit in found if isinstance(fit, str)}
    fits = [(run, fit) for run, fit in found if isinstance(fit, RunFit)]
    if not fits:
        raise StepFailed(next(iter(left_out.values()), "there is no run"))
    walks, sizes = sum(fit.evaluations for _, fit in fits), [_size(fit.equations) for _, fit in fits]
    alone, how, together = float(np.median(sizes)), "its own fit", None
    while together is None or max(sizes) > ODD * np.median(sizes):
        usual = float(np.median(sizes))
        left_out |= {run.name: f"{how} leaves {np.sqrt(size / usual):.1f} times the usual residuals"
                     for (run, _), size in zip(fits, sizes, strict=True) if size > ODD * usual}  # fmt: skip
        kept, chosen = zip(*(one for one, size in zip(fits, sizes, strict=True) if not size > ODD * usual), strict=True)
        together = Joint(design, kept, model, known).fitted(chosen, left_out, walks)
        fits, walks = [*zip(kept, chosen, strict=True)], together.evaluations
        sizes, how = [_size(one) for one in together.equations], "the fit of all together, as of another robot,"
    return replace(together, alone=alone)


def two_kinds(values: np.ndarray, variances: np.ndarray) -> tuple[int, np.ndarray] | None:
    """The parameter in which runs come apart as of two robots, by what each finds alone (r, d) with these `variances`
    (r, d), and which are of the one kind (r,); None where runs of one robot come so far apart in one campaign of a
    hundred (L. Engelman, J. A. Hartigan, J. Am. Stat. Assoc. 64, 1969, 1647: of all ways to part them the best).
    """
    (count, d), found, least = values.shape, None, CHANCE
    ways = 2.0 * d * (2.0 ** (count - 1) - count - 1.0)
    for column, (each, noise) in enumerate(zip(values.T, variances.mean(axis=0), strict=True)):
        order = np.argsort(each)
        for first in range(2, count - 1):
            one, other = np.split(each[order], [first])
            within = (one.var() * first + other.var() * (count - first)) / (count - 2)
            sd = np.sqrt(max(within, noise) * (1.0 / first + 1.0 / (count - first)))
            chance = ways * float(stdtr(count - 2, (one.mean() - other.mean()) / sd))
            if chance < least:
                least, found = chance, (column, np.isin(np.arange(count), order[:first]))
    return found


def _size(equations: Equations) -> float:
    """Mean square residual of a run's readings."""
    return equations.chi2 / equations.count


def side_by_side(
    design: DesignPoint, runs: Sequence[MeasuredRun], model: Model, known: Sequence[Known]
) -> Iterable[tuple[int, RunFit | str]]:
    """Each run's own fit, or why there is none, in threads: a process would run a user's whole script again, which asks
    this."""
    with ThreadPoolExecutor() as pool:
        return enumerate([*pool.map(partial(_own_fit, design=design, model=model, known=known), runs)])


def _own_fit(run: MeasuredRun, design: DesignPoint, model: Model, known: Sequence[Known]) -> RunFit | str:
    try:
        return fit_run(design, run, model, known)
    except StepFailed as reason:
        return str(reason)


#: The runs' equations, and the unknowns (r, o + k) that they alone have.
Runs = tuple[list[Equations], np.ndarray]


class Joint:
    """All runs together."""

    def __init__(
        self, design: DesignPoint, runs: Sequence[MeasuredRun], model: Model, known: Sequence[Known]
    ) -> None:
        self.design, self.runs, self.model, self.known = design, tuple(runs), model, known
        self.sizes, self.low = design_sizes(design, model.shared), lowest(design, model.shared)
        self._walks = 0

    def fitted(self, fits: Sequence[RunFit], left_out: dict[str, str], walks: int) -> CampaignFit:
        """`from_point` of the design that the runs' own fits agree on, or of the first of them that walks all runs."""
        o = len(self.model.own)
        for design in (self._together(fits), *(fit.design for fit in fits)):
            moves = np.array([_along(fit, design - fit.design) for fit in fits])
            own, unknowns = np.array([fit.own for fit in fits]), np.array([fit.unknowns for fit in fits])
            with contextlib.suppress(StepFailed):
                return self.from_point(design, own + moves[:, :o], unknowns + moves[:, o:], left_out, walks)
        raise StepFailed("their own fits have no design in common that walks; runs must be of one robot")

    def from_point(
        self, design: Vector, own: np.ndarray, unknowns: np.ndarray, left_out: dict[str, str], walks: int,
        rule: Rule = JOINT,
    ) -> CampaignFit:
        """Gauss-Newton from a design (d,), own parameters (r, o) and unknowns (r, k); a step that does not help is
        halved. Raises StepFailed where the robot does not walk the runs there."""
        begin, self._walks = np.concatenate([own, unknowns], axis=1), walks

        def evaluate(x: Vector, before: Point[Runs] | None, share: float) -> Point[Runs] | None:
            others = begin if before is None else self._along(x - before.x, before.state, share)
            return self._at(x, others)

        try:
            at, _, why = least_squares(evaluate, design, self.sizes, self.low, rule)
        except ValueError:
            raise StepFailed("the robot does not walk the runs") from None
        (equations, others), o = at.state, len(self.model.own)
        return CampaignFit(
            names=self.model.shared, design=at.x, covariance=covariance_of(at.matrix, self.sizes),
            runs=self.runs, own=others[:, :o], unknowns=others[:, o:],
            equations=tuple(equations), left_out=left_out, chi2=sum(one.chi2 for one in equations),
            count=sum(one.count for one in equations), evaluations=self._walks,
            converged=not why, why=why)  # fmt: skip

    def _together(self, fits: Sequence[RunFit]) -> Vector:
        """The design that the runs' own fits agree on, each weighed by what it shows, about their mean, beside what is
        known: of a combination that no run shows, as the scale of mass, each shows something else by its curvature."""
        d, unit = len(self.sizes), self.sizes
        middle = np.mean([fit.design for fit in fits], axis=0)
        there = self.model.robot(self.design, middle)
        total, right = information_of(self.known, self.model.shared, there), np.zeros(d)
        for fit in fits:
            matrix, _ = fit.equations.eliminated(d)
            total += matrix + np.diag(unit**-2)
            right += matrix @ (fit.design - middle)
        move = np.linalg.solve(total * unit * unit[:, None], right * unit) * unit
        return np.asarray(np.maximum(middle + move, self.low))

    def _along(self, step: Vector, runs: Runs, share: float) -> np.ndarray:
        """The runs' own unknowns (r, o + k) after a step (d,) of the design, which is a `share` of a whole one."""
        equations, others = runs
        return np.asarray(others + share * np.array([one.own_step(step / share) for one in equations]))

    def _settled(self, there: DesignPoint, begin: Vector, run: MeasuredRun) -> tuple[Equations, Vector, int]:
        """A run's equations at a design, its own unknowns (o + k,) there, and after how many walks.

        Where their part of a step led past what fits, as a filter's bandwidth and a delay may, they are moved on by
        damped steps. Raises StepFailed where the robot does not walk it.
        """
        o, d = len(self.model.own), len(self.model.shared)

        def evaluate(x: Vector, _: Point[Equations] | None, __: float) -> Point[Equations] | None:
            try:
                found = run_equations(there, x[:o], x[o:], run, self.model)
            except StepFailed:
                return None
            return Point(x, found.cost, found.matrix[d:, d:], found.right[d:], found)

        try:
            at, walks, _ = least_squares(
                evaluate, begin, *sizes_and_lowest(there, self.model.own, self.model.layout), SHORTER)
        except ValueError:
            raise StepFailed("the robot does not walk the run") from None
        return at.state, at.x, walks

    def _at(self, x: Vector, others: np.ndarray) -> Point[Runs] | None:
        """The equations for the design alone, with the runs' side by side; None where the robot does not walk one."""
        there = self.model.robot(self.design, x)
        if not there.is_legal():
            return None
        try:
            with ThreadPoolExecutor() as pool:
                found, moved, walks = zip(*pool.map(self._settled, repeat(there), others, self.runs))
        except StepFailed:
            return None
        self._walks += sum(walks)
        matrix, right, cost = known_equations(
            self.known, [one.of(there) for one in self.known], self.model.shared, there)
        eliminated = 0.0
        for one in found:
            more, other = one.eliminated(len(x))
            matrix, right, cost = matrix + more, right + other, cost + one.cost
            eliminated += 0.5 * float(one.own_step(np.zeros(len(x))) @ one.right[len(x) :])
        return Point(x, cost, matrix, right, (list(found), np.array(moved)), len(self.runs), eliminated)


def _along(fit: RunFit, step: Vector) -> Vector:
    """How a run's own unknowns go with a step of the design (d,); no farther where they are not at rest yet, as their
    whole step may lead off."""
    whole = fit.equations.own_step(step)
    return whole if fit.converged else whole - fit.equations.own_step(np.zeros_like(step))
