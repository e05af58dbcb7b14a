"""The normal equations of one run: what its samples say about the design, about the run, and about both together."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.model.walker import Vector
from stages.calibration.observation.measured_run import MeasuredRun
from stages.calibration.observation.prediction import Predicted, predict
from stages.calibration.observation.unknowns import SIDES, Layout


@dataclass(frozen=True)
class Model:
    """What is fitted: parameters `shared` by all runs and those that are each run's `own`, by their files' names.

    `noise` (3,) standard deviation of a sample forward, up, rate; `robust` sigmas from which on a residual pulls less;
    `strike` [s] standard deviation of the measured heel strikes, infinite where they are not used.
    """

    shared: tuple[str, ...]
    own: tuple[str, ...]
    layout: Layout
    noise: tuple[float, float, float]
    tolerance: float
    robust: float = np.inf
    strike: float = np.inf

    @property
    def names(self) -> tuple[str, ...]:
        """All unknowns of one run: shared, of the run, own parameters."""
        return (*self.shared, *self.layout.names, *self.own)


@dataclass(frozen=True)
class Equations:
    """Gauss-Newton's matrix (n, n) and right side (n,) of a run, in SI units, beliefs about the run included.

    Unknowns: `shared` of the model first, then the run's own. `cost` of Huber's, beliefs included; `chi2` the sum of
    squares of `count` readings, none of which counts for more than `robust` sigmas. `residuals` by side (m, 3), in
    sigmas, NaN where nothing is used.
    """

    matrix: np.ndarray
    right: Vector
    cost: float
    chi2: float
    count: int
    residuals: dict[str, np.ndarray]
    predicted: Predicted
    robust: float = np.inf

    def pulls(self, side: str) -> np.ndarray:
        """Residuals (m, 3) as they pull: one beyond `robust` sigmas, a spike, no more than that."""
        return np.asarray(np.clip(self.residuals[side], -self.robust, self.robust))


def run_equations(
    design: DesignPoint, own_values: Vector, unknowns: Vector, run: MeasuredRun, model: Model
) -> Equations:
    """The equations at a design, with the run's own parameters of it and its other unknowns.

    Raises StepFailed where the walker does not get to the run's end.
    """
    design = design.with_values(dict(zip(model.own, own_values, strict=True)))
    names = (*model.shared, *model.own)
    found = predict(design, names, unknowns, model.layout, run.sampling, model.tolerance)
    d, n = len(model.shared), len(model.names)
    matrix, right, cost, chi2, count = np.zeros((n, n)), np.zeros(n), 0.0, 0.0, 0
    residuals = {}
    noise = np.asarray(model.noise)
    for side in SIDES:
        used = run.used[side]
        by_design = found.by_design[side]
        whole = np.concatenate([by_design[:, :, :d], found.by_run[side], by_design[:, :, d:]], axis=2)
        left = (run.samples[side] - found.samples[side]) / noise
        residuals[side] = np.where(used, left, np.nan)
        r = left[used]
        jacobian = (whole / noise[:, None])[used]
        size = np.abs(r)
        weight = np.where(size > model.robust, model.robust / np.maximum(size, 1e-300), 1.0)
        matrix += jacobian.T @ (weight[:, None] * jacobian)
        right += jacobian.T @ (weight * r)
        beyond = size > model.robust
        cost += 0.5 * float((r[~beyond] ** 2).sum())
        cost += float((model.robust * (size[beyond] - 0.5 * model.robust)).sum()) if beyond.any() else 0.0
        chi2 += float((np.minimum(size, model.robust) ** 2).sum())
        count += r.size
    if np.isfinite(model.strike):
        strikes_by = np.concatenate(
            [found.strikes_by_design[:, :d], found.strikes_by_run, found.strikes_by_design[:, d:]], axis=1)
        both = min(len(found.strikes), len(run.strikes) - 1)
        late = (run.strikes[1 : both + 1] - found.strikes[:both]) / model.strike
        rows = strikes_by[:both] / model.strike
        matrix += rows.T @ rows
        right += rows.T @ late
        cost += 0.5 * float(late @ late)
    at = d + np.flatnonzero(np.isfinite(model.layout.believed))
    sure = 1.0 / model.layout.believed[at - d] ** 2
    off = unknowns[at - d] - model.layout.middle[at - d]
    matrix[at, at] += sure
    right[at] -= sure * off
    cost += 0.5 * float((sure * off**2).sum())
    for k, name in enumerate(model.own):
        if name in run.own:
            reading, sd = run.own[name]
            place = d + len(model.layout.names) + k
            matrix[place, place] += 1.0 / sd**2
            right[place] -= (own_values[k] - reading) / sd**2
            cost += 0.5 * ((own_values[k] - reading) / sd) ** 2
    return Equations(matrix, right, cost, chi2, count, residuals, found, model.robust)


def eliminated(equations: Equations, shared: int) -> tuple[np.ndarray, Vector]:
    """What is left for the first `shared` unknowns when the others are solved for: matrix and right side."""
    matrix, right = equations.matrix, equations.right
    cross, own = matrix[:shared, shared:], matrix[shared:, shared:]
    scale = 1.0 / np.sqrt(np.diag(own))
    asked = np.column_stack([cross.T, right[shared:]]) * scale[:, None]
    solved = np.linalg.lstsq(own * scale * scale[:, None], asked, rcond=1e-14)[0] * scale[:, None]
    left = matrix[:shared, :shared] - cross @ solved[:, :-1]
    return 0.5 * (left + left.T), right[:shared] - cross @ solved[:, -1]
