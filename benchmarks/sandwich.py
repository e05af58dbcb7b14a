"""Covariances of a fit whose model is not quite the robot's, as far as its own residuals tell them.

*Noise*: the inverse of the information, right where the model is. *Sandwich*: the scatter of what each half step asks
of the parameters, right where model errors of the steps are independent. Neither knows an error that is the same in
every step, like a contact that is softer than the model's: that is for `discrepancy`.
"""

import numpy as np

from stages.calibration.estimation.least_squares import Known, information_of
from stages.calibration.estimation.run_fit import Equations, Model
from stages.calibration.observation.measured_run import SIDES, MeasuredRun


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
    n = len(model.names)
    edges = np.sort(np.concatenate([run.strikes, 0.5 * (run.strikes[1:] + run.strikes[:-1])]))
    scores, told = np.zeros((len(edges) + 1, n)), np.zeros((n, n))
    for side in SIDES:
        rows = equations.predicted.samples[side][:, :, 1:] / equations.noise[side][:, None]
        left = equations.residuals[side]
        seen = np.isfinite(left)
        size = np.abs(left)
        pull = np.where(seen, left * np.minimum(1.0, model.robust / np.maximum(size, 1e-300)), 0.0)
        asked = np.einsum("mi,min->mn", pull, rows)
        np.add.at(scores, np.searchsorted(edges, run.sampling.of(side)), asked)
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
