"""The robot that several runs were made with: one design, and for each run its own start, ramp and sensors.

Each run's own unknowns meet the others' only through the design, so the normal equations have the shape of an arrow:
they are solved for run by run, and what is left are equations for the design alone.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from itertools import repeat

import numpy as np

from stages.analytic.errors import StepFailed
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.model.walker import Vector
from stages.biped.processes import each_in_a_process
from stages.calibration.estimation.equations import Equations, Model, eliminated, run_equations
from stages.calibration.estimation.fit import RunFit, design_sizes, fit_run, known_equations, lowest
from stages.calibration.estimation.known import Known
from stages.calibration.observation.measured_run import MeasuredRun

#: Joint steps, when half the sum of squares is at rest, and how often a step is halved.
MOST_STEPS, ENOUGH, HALVINGS = 25, 1e-3, 12
#: A run is left out of the joint fit if its own fit leaves so many times the square residual of the usual run.
ODD = 3.0

FitEach = Callable[[Sequence[MeasuredRun]], Iterable[tuple[int, RunFit | str]]]


@dataclass(frozen=True)
class CampaignFit:
    """The design's shared parameters (d,) with their covariance (d, d), and of each run in `runs` its own parameters
    and unknowns, with its equations there. `left_out` runs have a reason each.

    `chi2` over `count` readings; `evaluations` of how many walks.
    """

    names: tuple[str, ...]
    design: Vector
    covariance: np.ndarray
    information: np.ndarray
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


def fit_campaign(
    design: DesignPoint, runs: Sequence[MeasuredRun], model: Model, known: Sequence[Known],
    fit_each: FitEach | None = None,
) -> CampaignFit:
    """Fit runs, each alone and then all together. `fit_each` may spread the former over processes.

    Raises StepFailed where no run can be fitted.
    """
    fits: dict[int, RunFit] = {}
    left_out: dict[str, str] = {}
    for number, fit in (fit_each or (lambda all_runs: alone(design, all_runs, model, known)))(runs):
        if isinstance(fit, str):
            left_out[runs[number].name] = fit
        else:
            fits[number] = fit
    if not fits:
        raise StepFailed(next(iter(left_out.values()), "there is no run"))
    usual = float(np.median([fit.equations.chi2 / fit.equations.count for fit in fits.values()]))
    for number in sorted(fits):
        size = fits[number].equations.chi2 / fits[number].equations.count
        if size > ODD * usual:
            left_out[runs[number].name] = f"its own fit leaves {np.sqrt(size / usual):.1f} times the usual residuals"
            del fits[number]
    chosen = sorted(fits)
    walks = sum(fit.evaluations for fit in fits.values())
    joint = Joint(design, [runs[number] for number in chosen], model, known)
    return joint.fitted([fits[number] for number in chosen], left_out, walks)


def alone(
    design: DesignPoint, runs: Sequence[MeasuredRun], model: Model, known: Sequence[Known]
) -> Iterable[tuple[int, RunFit | str]]:
    """Each run's own fit, or why there is none."""
    for number, run in enumerate(runs):
        yield number, _own_fit(run, design, model, known)


def side_by_side(
    design: DesignPoint, runs: Sequence[MeasuredRun], model: Model, known: Sequence[Known]
) -> Iterable[tuple[int, RunFit | str]]:
    """The same on all cores, as they get ready."""
    return each_in_a_process(partial(_own_fit, design=design, model=model, known=known), runs)


def _own_fit(run: MeasuredRun, design: DesignPoint, model: Model, known: Sequence[Known]) -> RunFit | str:
    try:
        return fit_run(design, run, model, known)
    except StepFailed as reason:
        return str(reason)


class Joint:
    """All runs together."""

    def __init__(
        self, design: DesignPoint, runs: Sequence[MeasuredRun], model: Model, known: Sequence[Known]
    ) -> None:
        self.design, self.runs, self.model, self.known = design, tuple(runs), model, known
        self.d, self.k = len(model.shared), len(model.layout.names)
        names = (*model.shared, *model.own)
        self.sizes, self.low = design_sizes(design, names), lowest(design, names)

    def fitted(self, fits: Sequence[RunFit], left_out: dict[str, str], walks: int) -> CampaignFit:
        """`from_point` of the design that the runs' own fits agree on, or of the first of them that walks all runs."""
        for design in (self._together(fits), *(fit.design for fit in fits)):
            moves = np.array([_along(fit, design - fit.design) for fit in fits])
            own, unknowns = np.array([fit.own for fit in fits]), np.array([fit.unknowns for fit in fits])
            with contextlib.suppress(StepFailed):
                return self.from_point(
                    design, own + moves[:, self.k :], unknowns + moves[:, : self.k], left_out, walks)
        raise StepFailed("their own fits have no design in common that walks; runs must be of one robot")

    def from_point(
        self, design: Vector, own: np.ndarray, unknowns: np.ndarray, left_out: dict[str, str], walks: int,
        most: int = MOST_STEPS,
    ) -> CampaignFit:
        """Gauss-Newton from a design (d,), own parameters (r, o) and unknowns (r, k); a step that does not help is
        halved. Raises StepFailed where the robot does not walk the runs there."""
        d = self.d
        at = self._at(design, own, unknowns)
        if at is None:
            raise StepFailed("the robot does not walk the runs")
        converged, why = False, f"{most} joint steps were not enough"
        walks += len(self.runs)
        for _ in range(most):
            matrix, right = self._reduced(at, design)
            step = _solved(matrix, right, self.sizes[:d])
            moves = [own_step(one, step) for one in at]
            foreseen = 0.5 * float(step @ right) + sum(0.5 * float(m @ one.right[d:]) for m, one in zip(
                moves, at, strict=True)) + 0.5 * float(step @ sum(one.right[:d] for one in at) - step @ right)
            share, now = 1.0, self._cost(at, design)
            for _ in range(HALVINGS):
                tried_design = np.maximum(design + share * step, self.low[:d])
                tried_unknowns = unknowns + share * np.array([move[: self.k] for move in moves])
                tried_own = own + share * np.array([move[self.k :] for move in moves])
                tried = self._at(tried_design, tried_own, tried_unknowns)
                walks += len(self.runs)
                if tried is not None and self._cost(tried, tried_design) <= now + 1e-9 * abs(now):
                    break
                share *= 0.5
            else:
                converged, why = abs(foreseen) < 1.0, "no joint step brings the residuals down"
                break
            gain = now - self._cost(tried, tried_design)
            design, own, unknowns, at = tried_design, tried_own, tried_unknowns, tried
            if max(gain, 0.0 if share == 1.0 else abs(foreseen)) < ENOUGH * len(self.runs):
                converged, why = True, ""
                break
        matrix, _ = self._reduced(at, design)
        return CampaignFit(
            names=self.model.shared, design=design, covariance=covariance_of(matrix, self.sizes[:d]),
            information=matrix, runs=self.runs, own=own, unknowns=unknowns, equations=tuple(at), left_out=left_out,
            chi2=sum(one.chi2 for one in at), count=sum(one.count for one in at), evaluations=walks,
            converged=converged, why="" if converged else why)  # fmt: skip

    def _together(self, fits: Sequence[RunFit]) -> Vector:
        """The design that the runs' own fits agree on, each weighed by what it tells."""
        total, right = np.zeros((self.d, self.d)), np.zeros(self.d)
        for fit in fits:
            matrix, _ = eliminated(fit.equations, self.d)
            total += matrix
            right += matrix @ fit.design
        middle = np.mean([fit.design for fit in fits], axis=0)
        return np.asarray(np.maximum(middle + _solved(total, right - total @ middle, self.sizes[: self.d]),
                                     self.low[: self.d]))

    def _at(self, design: Vector, own: np.ndarray, unknowns: np.ndarray) -> list[Equations] | None:
        """The runs' equations, side by side; None where the robot does not walk one of them."""
        there = self.design.with_values(dict(zip(self.model.shared, design, strict=True)))
        if not there.is_legal():
            return None
        try:
            with ThreadPoolExecutor() as pool:
                return list(pool.map(run_equations, repeat(there), own, unknowns, self.runs, repeat(self.model)))
        except StepFailed:
            return None

    def _cost(self, at: Sequence[Equations], design: Vector) -> float:
        return sum(one.cost for one in at) + self._known(design)[2]

    def _known(self, design: Vector) -> tuple[np.ndarray, Vector, float]:
        there = self.design.with_values(dict(zip(self.model.shared, design, strict=True)))
        return known_equations(self.known, there, self.model.shared)

    def _reduced(self, at: Sequence[Equations], design: Vector) -> tuple[np.ndarray, Vector]:
        """The equations for the design alone."""
        matrix, right, _ = self._known(design)
        for one in at:
            more, other = eliminated(one, self.d)
            matrix, right = matrix + more, right + other
        return matrix, right


def own_step(one: Equations, step: Vector) -> Vector:
    """A run's own unknowns' step that goes with the design's (d,)."""
    d = len(step)
    own = one.matrix[d:, d:]
    scale = 1.0 / np.sqrt(np.diag(own))
    right = (one.right[d:] - one.matrix[d:, :d] @ step) * scale
    return np.asarray(np.linalg.lstsq(own * scale * scale[:, None], right, rcond=1e-14)[0] * scale)


def _along(fit: RunFit, step: Vector) -> Vector:
    """How a run's own unknowns go with a step of the design (d,); no farther where they are not at rest yet, as their
    whole step may lead off."""
    whole = own_step(fit.equations, step)
    return whole if fit.converged else whole - own_step(fit.equations, np.zeros_like(step))


def _solved(matrix: np.ndarray, right: Vector, sizes: Vector) -> Vector:
    """The step of a system whose unknowns have these sizes; combinations that nothing is told of stay."""
    return np.asarray(np.linalg.lstsq(matrix * sizes * sizes[:, None], right * sizes, rcond=1e-13)[0] * sizes)


def covariance_of(matrix: np.ndarray, sizes: Vector) -> np.ndarray:
    """Inverse of an information matrix, in equal units for numerics; infinite along what nothing is told of."""
    values, vectors = np.linalg.eigh(matrix * sizes * sizes[:, None])
    seen = values > 1e-6
    inverse = (vectors[:, seen] / values[seen]) @ vectors[:, seen].T
    blind = (np.abs(vectors[:, ~seen]) > 1e-3).any(axis=1)
    inverse[blind, blind] = np.inf
    return np.asarray(inverse * sizes * sizes[:, None])
