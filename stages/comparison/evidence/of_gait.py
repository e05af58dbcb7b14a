"""Numbers of the claims on the gait."""

from __future__ import annotations

import math

import numpy as np

from stages.comparison.claims import gait
from stages.comparison.evidence.evidence import NAN, Evidence, largest


def step_frequency(e: Evidence) -> gait.StepFrequency:
    analytic = e.results.analytic
    digits = next((one for one in analytic.uncertainties if one.name == "step_frequency_hz"), None)
    frequency = analytic.gait.step_frequency_hz
    if digits is None:  # all values are exact
        return gait.StepFrequency(frequency, 0.0, "", 0.0, (frequency, frequency))
    slopes = digits.slope_least, digits.slope_most
    return gait.StepFrequency(frequency, digits.worst, digits.decisive, digits.decisive_part, slopes)


def stable_gait(e: Evidence) -> gait.StableGait:
    planar = e.results.multibody.cycle.largest_multiplier
    return gait.StableGait(largest(e.results.analytic.gait.floquet_multipliers), planar)


def multipliers_minimised(e: Evidence) -> gait.MultipliersMinimised:
    analytic = e.results.analytic
    options = [
        (value, f"{variation.name} {sign}{100 * variation.change:.0f} %")
        for variation in analytic.variations
        for value, sign in ((variation.multiplier_below, "-"), (variation.multiplier_above, "+"))
        if math.isfinite(value)
    ]
    return gait.MultipliersMinimised(largest(analytic.gait.floquet_multipliers), *min(options, default=(NAN, "")))


def chaos_amplifies(e: Evidence) -> gait.ChaosAmplifies:
    analytic = e.results.analytic
    steps, matrix = len(analytic.walk.heel_strike_time), analytic.monodromy_matrix
    sizes = [float(np.linalg.norm(np.linalg.matrix_power(matrix, n), 2)) for n in range(1, max(steps, 1) + 1)]
    return gait.ChaosAmplifies(largest(analytic.gait.floquet_multipliers), max(sizes), sizes[-1], len(sizes))
