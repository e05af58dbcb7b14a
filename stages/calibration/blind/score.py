"""Blind campaigns fitted and held against their truth: which intervals hold it, and how wide they are."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from stages.analytic.errors import StepFailed
from stages.biped.processes import each_in_a_process
from stages.biped.progress import Progress, ignore
from stages.calibration.blind.draw import draw, model_of
from stages.calibration.estimation.campaign import fit_campaign
from stages.calibration.estimation.equations import eliminated, run_equations
from stages.calibration.estimation.known import information_of
from stages.calibration.parameters import Parameters
from stages.calibration.result import HALF_WIDTH


@dataclass(frozen=True)
class Scored:
    """One campaign: its seed, whether it converged, or `why` not; for each of `names` the truth, the estimate, its
    standard deviation and the smallest one there can be (n,), by the information at the truth; chi2 per reading; walks.
    """

    seed: int
    converged: bool
    why: str
    names: tuple[str, ...]
    truth: np.ndarray
    estimate: np.ndarray
    sd: np.ndarray
    bound: np.ndarray
    chi2: float
    evaluations: int

    @property
    def holds(self) -> np.ndarray:
        """Whether each interval holds the truth, (n,)."""
        return np.asarray(np.abs(self.estimate - self.truth) <= HALF_WIDTH * self.sd)


def scored(seed: int, runs: int, parameters: Parameters) -> Scored:
    """Draw a campaign, fit it without a look at the truth, and compare."""
    campaign = draw(seed, runs, parameters)
    drawing, model = model_of(parameters)
    names = model.shared
    truth = np.array([campaign.design.value(name) for name in names])
    bound = np.full(len(names), np.nan)
    try:
        fit = fit_campaign(drawing, campaign.runs, model, campaign.known)
    except StepFailed as reason:
        return Scored(seed, False, str(reason), names, truth, bound, bound, bound, np.nan, 0)
    information = information_of(campaign.known, names)
    for run, slope, unknowns in zip(campaign.runs, campaign.slopes, campaign.unknowns, strict=True):
        at_truth = run_equations(campaign.design, np.array([slope]), unknowns, run, model)
        information = information + eliminated(at_truth, len(names))[0]
    bound = np.sqrt(np.diag(np.linalg.inv(information)))
    return Scored(seed, fit.converged, fit.why, names, truth, fit.design, np.sqrt(np.diag(fit.covariance)), bound,
                  fit.chi2 / fit.count, fit.evaluations)


def as_plain(one: Scored) -> dict[str, Any]:
    """A campaign as JSON knows it."""
    return {key: value.tolist() if isinstance(value, np.ndarray) else value for key, value in
            dataclasses.asdict(one).items()}


def from_plain(plain: Mapping[str, Any]) -> Scored:
    """The campaign of `as_plain`."""
    return Scored(**{key: np.array(value, dtype=float) if isinstance(value, list) and key != "names" else value
                     for key, value in plain.items()} | {"names": tuple(plain["names"])})


def score(
    seeds: Sequence[int], runs: int, parameters: Parameters, progress: Progress = ignore
) -> Iterator[Scored]:
    """Many campaigns, on all cores, as they get ready."""
    for done, (_, one) in enumerate(
            each_in_a_process(partial(scored, runs=runs, parameters=parameters), list(seeds)), 1):
        progress(done / len(seeds), f"blind campaign {done} of {len(seeds)}")
        yield one


def summary(all_scored: Sequence[Scored]) -> dict[str, Any]:
    """Coverage of each parameter and together, median width over the bound, and what did not converge."""
    done = [one for one in all_scored if one.converged]
    holds = np.array([one.holds for one in done])
    widths = np.median([one.sd / one.bound for one in done], axis=0)
    errors = np.array([(one.estimate - one.truth) / one.sd for one in done])
    names = all_scored[0].names
    return {
        "campaigns": len(all_scored),
        "not_converged": {one.seed: one.why for one in all_scored if not one.converged},
        "coverage": dict(zip(names, holds.mean(axis=0).tolist(), strict=True)),
        "coverage_together": float(holds.mean()),
        "median_width_over_bound": dict(zip(names, widths.tolist(), strict=True)),
        "mean_error_in_sd": dict(zip(names, errors.mean(axis=0).tolist(), strict=True)),
        "median_sd_share": dict(zip(names, np.median([one.sd / np.abs(one.truth) for one in done], axis=0).tolist(),
                                    strict=True)),
        "chi2": [float(min(one.chi2 for one in done)), float(max(one.chi2 for one in done))],
        "median_walks": float(np.median([one.evaluations for one in done])),
    }
