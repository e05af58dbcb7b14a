"""Intervals of a fit whose model is not quite the robot's.

Three answers, from the weakest to the strongest. *Noise*: the inverse of the information, right where the model is.
*Sandwich*: the scatter of what each half step asks of the parameters, right where model errors of the steps are
independent. Neither knows an error that is the same in every step, like a contact that is softer than the model's. That
is the *discrepancy*: what the same fit misses on runs of a better model of the same drawing, whose truth is known. Its
mean is taken off, its scatter over builds, starts and ramps widens the interval.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import stdtrit

from stages.analytic.model.walker import Vector
from stages.calibration.estimation.equations import Equations, Model
from stages.calibration.estimation.known import Known, information_of
from stages.calibration.observation.measured_run import MeasuredRun
from stages.calibration.observation.unknowns import SIDES

#: What an interval of 95 % leaves out on one side.
BEYOND = 0.025


def inverse(matrix: np.ndarray) -> np.ndarray:
    """Inverse of an information matrix (n, n) of unknowns of all sizes."""
    scale = 1.0 / np.sqrt(np.diag(matrix))
    return np.asarray(np.linalg.pinv(matrix * scale * scale[:, None], rcond=1e-14, hermitian=True)
                      * scale * scale[:, None])


def noise_covariance(equations: Equations, model: Model, known: tuple[Known, ...]) -> np.ndarray:
    """Covariance (n, n) of all unknowns of a run, were its residuals noise."""
    return inverse(_information(equations, model, known))


def sandwich_covariance(
    run: MeasuredRun, equations: Equations, model: Model, known: tuple[Known, ...]
) -> np.ndarray:
    """Covariance (n, n) of all unknowns of a run from the scatter of its half steps (Huber; White)."""
    d, n = len(model.shared), len(model.names)
    edges = np.sort(np.concatenate([run.strikes, 0.5 * (run.strikes[1:] + run.strikes[:-1])]))
    scores, told = np.zeros((len(edges) + 1, n)), np.zeros((n, n))
    for side in SIDES:
        by_design, by_run = equations.predicted.by_design[side], equations.predicted.by_run[side]
        rows = np.concatenate([by_design[:, :, :d], by_run, by_design[:, :, d:]], axis=2)
        rows = rows / np.asarray(model.noise)[:, None]
        left = equations.residuals[side]
        seen = np.isfinite(left)
        size = np.abs(left)
        pull = np.where(seen, left * np.minimum(1.0, model.robust / np.maximum(size, 1e-300)), 0.0)
        asked = np.einsum("mi,min->mn", pull, rows)
        np.add.at(scores, np.searchsorted(edges, getattr(run.sampling, side)), asked)
        told += np.einsum("min,mik->nk", np.where(seen[:, :, None], rows, 0.0), rows)
    groups = scores[np.abs(scores).any(axis=1)]
    spread = groups.T @ groups * (len(groups) / max(len(groups) - 1, 1))
    information = _information(equations, model, known)
    bread = inverse(information)
    believed = information - told  # what is not told by samples scatters as it is believed to
    return np.asarray(bread @ (spread + believed) @ bread)


def _information(equations: Equations, model: Model, known: tuple[Known, ...]) -> np.ndarray:
    d = len(model.shared)
    matrix = equations.matrix.copy()
    matrix[:d, :d] += information_of(known, model.shared)
    return matrix


@dataclass(frozen=True)
class Discrepancy:
    """What fits of a model miss on `count` runs of a better one: mean (n,) and covariance (n, n) of estimate less
    truth, in shares of the drawing's values."""

    names: tuple[str, ...]
    mean: Vector
    covariance: np.ndarray
    count: int

    @classmethod
    def of(cls, names: tuple[str, ...], misses: np.ndarray) -> Discrepancy:
        """From misses (count, n). Raises ValueError where there are fewer than three."""
        if len(misses) < 3:
            raise ValueError("a scatter needs three runs at least")
        return cls(names, misses.mean(axis=0), np.cov(misses, rowvar=False), len(misses))

    def corrected(self, estimate: Vector, scales: Vector) -> Vector:
        """An estimate (n,) without what the model puts wrong on average."""
        return np.asarray(estimate - self.mean * scales)

    def half_widths(self, scales: Vector) -> Vector:
        """Half of 95 % intervals (n,) of one more run's corrected estimate: Student's, as mean and scatter are from
        so few runs."""
        sd = np.sqrt(np.diag(self.covariance) * (1.0 + 1.0 / self.count)) * np.abs(scales)
        return np.asarray(float(stdtrit(self.count - 1, 1.0 - BEYOND)) * sd)
