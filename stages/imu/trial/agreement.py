"""How well a measured ensemble and a simulated curve agree: no number says it all, so here are the usual ones."""

import math
from dataclasses import dataclass

import numpy as np

from stages.biped.quantity import quantity


@dataclass(frozen=True)
class Agreement:
    """Agreement of one simulated curve with the measured ensemble of the same signal over the stride."""

    rmse: float = quantity("SI", "root mean square of simulated minus measured mean", symbol="RMSE")
    nrmse: float = quantity("1", "RMSE over the range of the measured mean", symbol="NRMSE")
    correlation: float = quantity("1", "coefficient of multiple correlation; NaN where undefined", symbol="CMC")
    correlation_defined: bool = quantity("1", "whether the coefficient of multiple correlation is a real number")
    icc: float = quantity("1", "intraclass correlation, two-way, single, absolute agreement", symbol="ICC(A,1)")
    bias: float = quantity("SI", "mean difference, simulated minus measured (Bland-Altman)")
    lower_limit: float = quantity("SI", "lower limit of agreement, bias - 1.96 standard deviations")
    upper_limit: float = quantity("SI", "upper limit of agreement, bias + 1.96 standard deviations")
    envelope_share: float = quantity("1", "share of the stride where the simulated curve lies inside the envelope",
                                     without_error="it counts points of the stride")


def agreement(simulated: np.ndarray, mean: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> Agreement:
    """Compare a simulated curve (p,) with mean, lower and upper edge (p,) of a measured ensemble; NaN left out."""
    known = np.isfinite(simulated) & np.isfinite(mean)
    model, measured = simulated[known], mean[known]
    bias, lower_limit, upper_limit = bland_altman(model, measured)
    correlation = multiple_correlation(np.stack([model, measured]))
    return Agreement(
        rmse=rmse(model, measured),
        nrmse=nrmse(model, measured),
        correlation=correlation,
        correlation_defined=math.isfinite(correlation),
        icc=intraclass_correlation(np.column_stack((model, measured))),
        bias=bias,
        lower_limit=lower_limit,
        upper_limit=upper_limit,
        envelope_share=envelope_share(simulated, lower, upper),
    )


def rmse(simulated: np.ndarray, measured: np.ndarray) -> float:
    """Root mean square of the difference of two curves (p,); NaN if they are empty."""
    return float(np.sqrt(np.mean((simulated - measured) ** 2))) if len(measured) else math.nan


def nrmse(simulated: np.ndarray, measured: np.ndarray) -> float:
    """RMSE over the range of the measured curve; NaN where that is flat."""
    span = float(np.ptp(measured)) if len(measured) else 0.0
    return rmse(simulated, measured) / span if span > 0 else math.nan


def multiple_correlation(waveforms: np.ndarray) -> float:
    """Coefficient of multiple correlation of waveforms (g, p) of one stride (Kadaba et al. 1989, within-day form).

    sqrt(1 - W / T), W the mean square about the phase's mean over the waveforms with p (g - 1) degrees of freedom,
    T that about the grand mean with p g - 1. NaN where W > T: then the root is not real and nothing correlates.
    """
    count, points = waveforms.shape
    if count < 2 or points < 2:
        return math.nan
    within = np.sum((waveforms - waveforms.mean(axis=0)) ** 2) / (points * (count - 1))
    total = np.sum((waveforms - waveforms.mean()) ** 2) / (points * count - 1)
    return math.sqrt(1 - within / total) if total > 0 and within <= total else math.nan


def intraclass_correlation(ratings: np.ndarray) -> float:
    """ICC(A,1) of ratings (targets, raters): two-way, single measurement, absolute agreement.

    (MS_R - MS_E) / (MS_R + (k - 1) MS_E + k (MS_C - MS_E) / n), McGraw and Wong 1996. NaN where nothing varies.
    """
    n, k = ratings.shape
    if n < 2 or k < 2:
        return math.nan
    grand, of_target, of_rater = ratings.mean(), ratings.mean(axis=1), ratings.mean(axis=0)
    rows = k * np.sum((of_target - grand) ** 2) / (n - 1)
    columns = n * np.sum((of_rater - grand) ** 2) / (k - 1)
    error = np.sum((ratings - of_target[:, None] - of_rater + grand) ** 2) / ((n - 1) * (k - 1))
    below = rows + (k - 1) * error + k * (columns - error) / n
    return float((rows - error) / below) if below != 0 else math.nan


def bland_altman(simulated: np.ndarray, measured: np.ndarray) -> tuple[float, float, float]:
    """Mean difference and the limits that hold 95 % of the differences if they are normal (Bland and Altman 1986)."""
    if len(measured) < 2:
        return math.nan, math.nan, math.nan
    difference = simulated - measured
    bias, reach = float(np.mean(difference)), 1.96 * float(np.std(difference, ddof=1))
    return bias, bias - reach, bias + reach


def envelope_share(simulated: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> float:
    """Share of the phases (p,) with an envelope at which it holds the simulated curve; NaN without an envelope."""
    known = np.isfinite(simulated) & np.isfinite(lower) & np.isfinite(upper)
    return float(np.mean((simulated >= lower)[known] & (simulated <= upper)[known])) if known.any() else math.nan


#: Level of the interval of a difference of frequencies.
CONFIDENCE = 0.95


@dataclass(frozen=True)
class FrequencyDifference:
    """Mean measured step frequency minus the simulated one, with its confidence interval (Student's t)."""

    difference: float = quantity("Hz", "measured minus simulated step frequency")
    lower: float = quantity("Hz", "lower end of the confidence interval")
    upper: float = quantity("Hz", "upper end of the confidence interval")
    confidence: float = quantity("1", "confidence level")


def frequency_difference(measured: np.ndarray, simulated: float) -> FrequencyDifference:
    """Difference of the runs' step frequencies (r,) [Hz] from a simulated one; the interval needs two runs."""
    runs = measured[np.isfinite(measured)]
    difference = float(np.mean(runs) - simulated) if len(runs) else math.nan
    if len(runs) < 2:
        return FrequencyDifference(difference, math.nan, math.nan, CONFIDENCE)
    from scipy.special import stdtrit  # here: who reads an agreement computes none

    reach = float(stdtrit(len(runs) - 1, 0.5 + CONFIDENCE / 2) * np.std(runs, ddof=1) / math.sqrt(len(runs)))
    return FrequencyDifference(difference, difference - reach, difference + reach, CONFIDENCE)
