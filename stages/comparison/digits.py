"""What rounding in the paper's digits leaves open in each model's gait, in the design's and in the slope's.

The constraint model has exact derivatives. The models of Exudyn have none; their gaits are within some percent of the
constraint model's, so they are given its elasticities: the same share of their own numbers.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from stages.analytic.result import Uncertainty
from stages.biped.quantity import quantity
from stages.comparison.determinants import Determinants

NAN = float("nan")
TITLE = ("What rounded parameters leave open, at the worst (multibody model and twin: by the constraint model's "
         "elasticities)")
#: Fields of `Determinants` and the numbers of the constraint model's gait that they are.
NUMBERS = {"step_frequency": "step_frequency_hz", "step_length": "step_length_m", "speed": "speed_m_s"}


@dataclass(frozen=True)
class Digits:
    """By how much a gait's numbers may be off; NaN where nothing is known of it."""

    step_frequency: float = quantity("Hz", "step frequency, +- by the design's digits", default=NAN)
    step_length: float = quantity("m", "step length, +- by the design's digits", default=NAN)
    speed: float = quantity("m/s", "speed, +- by the design's digits", default=NAN)
    least_step_frequency: float = quantity("Hz", "least step frequency on slopes rounded alike", default=NAN)
    most_step_frequency: float = quantity("Hz", "greatest step frequency there", default=NAN)
    least_step_length: float = quantity("m", "least step length there", default=NAN)
    most_step_length: float = quantity("m", "greatest step length there", default=NAN)
    least_speed: float = quantity("m/s", "least speed there", default=NAN)
    most_speed: float = quantity("m/s", "greatest speed there", default=NAN)


def digits_of(uncertainties: Iterable[Uncertainty], determinants: Mapping[str, Determinants]) -> dict[str, Digits]:
    """What is left open of each model in `determinants`, by the shares of the constraint model's gait."""
    known = {one.name: one for one in uncertainties}
    found = {}
    for model, own in determinants.items():
        numbers = {}
        for field, name in NUMBERS.items():
            if name in known:
                share = getattr(own, field) / known[name].value
                numbers[field] = share * known[name].worst
                numbers[f"least_{field}"] = share * known[name].slope_least
                numbers[f"most_{field}"] = share * known[name].slope_most
        found[model] = Digits(**numbers)
    return found
