"""Mean, spread and envelope of registered strides."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stages.biped.quantity import quantity


@dataclass(frozen=True)
class Ensemble:
    """Registered strides of all runs, phase by phase, for k signals at p phases; holes left out where they are."""

    phase: np.ndarray = quantity(
        "1", "phase of the stride, 0 and 1 at heel strikes of the inner leg, shape (p,)", dimensions=("phase",)
    )
    mean: np.ndarray = quantity("SI", "mean over strides, shape (p, k)", dimensions=("phase", "signal"))
    spread: np.ndarray = quantity("SI", "standard deviation over strides, shape (p, k)", dimensions=("phase", "signal"))
    lower: np.ndarray = quantity("SI", "lower edge of the envelope, shape (p, k)", dimensions=("phase", "signal"))
    upper: np.ndarray = quantity("SI", "upper edge of the envelope, shape (p, k)", dimensions=("phase", "signal"))
    count: np.ndarray = quantity("1", "strides seen at each phase, shape (p, k)", dimensions=("phase", "signal"))


def ensemble_of(strides: np.ndarray) -> Ensemble:
    """The ensemble of strides (s, p, k). A phase no stride covers is NaN; the spread needs two strides."""
    known = np.isfinite(strides)
    count = known.sum(axis=0)
    total = np.where(known, strides, 0.0).sum(axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = total / count
        square = np.where(known, (strides - mean) ** 2, 0.0).sum(axis=0)
        spread = np.sqrt(square / (count - 1))
    seen = count > 0
    return Ensemble(
        phase=np.linspace(0.0, 1.0, strides.shape[1]),
        mean=mean,
        spread=np.where(count > 1, spread, np.nan),
        lower=np.where(seen, np.where(known, strides, np.inf).min(axis=0, initial=np.inf), np.nan),
        upper=np.where(seen, np.where(known, strides, -np.inf).max(axis=0, initial=-np.inf), np.nan),
        count=count,
    )
