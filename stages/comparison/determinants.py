"""Determinants of gait (section 3.5): what gait analysis reads off a walk, for every model alike.

Everything follows from the sampled walk and its events, over its last whole steps; so the models, and whatever else
gives a walk, are measured by one rule.

What rounding in the paper's digits leaves open in each model's gait, in the design's and in the slope's.

The constraint model has exact derivatives. The models of Exudyn have none; their gaits are within some percent of the
constraint model's, so they are given its elasticities: the same share of their own numbers.
"""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from stages.analytic.result import Uncertainty
from stages.biped.between_steps import largest_sampled, sampled_at
from stages.biped.quantity import quantity
from stages.biped.walk import Walk

#: Whole strides at the end of a walk over which determinants are taken.
STRIDES = 2
#: Columns of hip advance, height, forward speed, leg angles, leg lengths and clearances among the signals.
COLUMNS = (slice(0, 1), slice(1, 2), slice(2, 3), slice(3, 5), slice(5, 7), slice(7, 9))
NAN = float("nan")


@dataclass(frozen=True)
class Determinants:
    """Determinants of one gait, means over its last two strides; NaN where they are not known."""

    step_frequency: float = quantity("Hz", "step frequency", default=NAN)
    step_length: float = quantity("m", "step length", default=NAN)
    speed: float = quantity("m/s", "speed", default=NAN)
    froude_number: float = quantity("1", "Froude number, speed squared over g times leg length", default=NAN)
    double_stance: float = quantity("s", "double stance in a step", default=NAN)
    duty_factor: float = quantity("1", "duty factor, a leg's stance over its stride", default=NAN)
    hip_excursion: float = quantity("m", "rise and fall of the hip", default=NAN)
    speed_variation: float = quantity("1", "largest less smallest forward speed of the hip, over the mean", default=NAN)
    strike_angle: float = quantity("deg", "leg angle at heel strike", default=NAN)
    swing_range: float = quantity("deg", "range of a leg's angle", default=NAN)
    foot_clearance: float = quantity("m", "largest clearance of the swing foot", default=NAN)
    scuff_depth: float = quantity("m", "depth of the swing foot below ground at mid-swing", default=NAN)
    leg_compression: float = quantity("m", "largest compression of a leg", default=NAN)


def of_walk(walk: Walk, radii: np.ndarray, lengths: np.ndarray, gravity: float) -> Determinants:
    """Determinants of a walk with feet of `radii` (2,) [m] on legs of `lengths` (2,) [m]; empty without a whole stride.

    A foot is in stance from its heel strike to its toe-off. Clearance is eq. (3): hip height less the leg's.
    """
    strikes, count = walk.heel_strike_time, min(2 * STRIDES, (len(walk.heel_strike_time) - 1) // 2 * 2)
    if count < 2:
        return Determinants()
    start, end = strikes[-1 - count], strikes[-1]
    inside = (walk.time > start) & (walk.time < end)
    clearance = walk.hip_position[:, 1, None] - (walk.leg_length - radii) * np.cos(walk.leg_angle) - radii
    signals = walk.hip_position, walk.hip_velocity[:, :1], walk.leg_angle, walk.leg_length, clearance
    times, found = sampled_at(
        walk.time, np.concatenate(signals, axis=1), np.concatenate([strikes, walk.toe_off_time]),
        np.concatenate([[start], walk.time[inside], [end]]))  # fmt: skip
    most, least = largest_sampled(times, found), -largest_sampled(times, -found)
    _, height, forward, angle, legs, lift = ((least[columns], most[columns]) for columns in COLUMNS)
    ahead = [
        abs(float(np.interp(time, times, found[:, COLUMNS[3]][:, int(leg)])))
        for time, leg in zip(strikes[-1 - count : -1], walk.heel_strike_leg[-1 - count : -1])
    ]
    double = walk.double_stance(strikes[-1 - count : -1])
    period, length = (end - start) / count, float(found[-1, 0] - found[0, 0]) / count
    speed = length / period
    return Determinants(
        step_frequency=1 / period,
        step_length=length,
        speed=speed,
        froude_number=speed**2 / (gravity * float(np.mean(lengths))),
        double_stance=double,
        duty_factor=(period + double) / (2 * period),
        hip_excursion=float(np.ptp(height)),
        speed_variation=float(np.ptp(forward)) / speed,
        strike_angle=math.degrees(float(np.mean(ahead))),
        swing_range=math.degrees(float(np.mean(angle[1] - angle[0]))),
        foot_clearance=float(lift[1].max()),
        scuff_depth=max(0.0, -float(lift[0].min())),
        leg_compression=float((lengths - legs[0]).max()),
    )


TITLE = ("Uncertainty from rounded or fitted parameters, at the worst (multibody model and twin: by the constraint "
         "model's elasticities)")
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
