"""How the gait answers to the transition velocities of the friction law (section 3.4 of the paper).

Each gait is solved for, not awaited, from the one before: its state extrapolated over the logarithm of the factor, its
derivative kept.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence

import numpy as np

from stages.contact_study.friction_result import FrictionVariation
from stages.ground.contact_law import ContactLaw
from stages.penalty.step_map import PenaltyStepper
from stages.planar.limit_cycle import FixedPoint, fixed_point
from stages.planar.section import NoLimitCycle, section_numbers

#: Changes of each transition velocity on both sides, outwards: what the paper may mean by small to moderate.
FACTORS = (tuple(2.0 ** (-0.5 * step) for step in (1, 2, 4)), tuple(2.0 ** (0.5 * step) for step in (1, 2, 4)))
VELOCITIES = ("stiction_velocity", "friction_velocity")
#: Steps after which a walker is near its gait, if the mid-stance it starts from does not lead to it at once.
SETTLING_STEPS = 8


def vary_friction(
    contact: ContactLaw, stepper: Callable[[ContactLaw], PenaltyStepper]
) -> tuple[FrictionVariation, ...]:
    """Gaits on ground with this contact law, and with each transition velocity changed alone by `FACTORS`.

    `stepper` walks on ground with a law from a mid-stance near its gait. Changes that break the order of the velocities
    are left out.
    """
    base = first_gait(stepper(contact))
    found = []
    for name in VELOCITIES:
        found.append(row(name, 1.0, base))
        for side in FACTORS:
            known = [] if base is None else [(0.0, base)]
            for factor in side:
                law = dataclasses.replace(contact, **{name: factor * getattr(contact, name)})
                if any(True for _ in law.broken_rules()):
                    continue
                point = next_gait(stepper(law), known, math.log(factor))
                if point is not None:
                    known.append((math.log(factor), point))
                found.append(row(name, factor, point))
    return tuple(sorted(found, key=lambda one: (VELOCITIES.index(one.name), one.factor)))


def laws_of(contact: ContactLaw, variations: Sequence[FrictionVariation]) -> list[ContactLaw]:
    """The contact laws of variations of this one that have a gait."""
    known = [one for one in variations if math.isfinite(one.period_s)]
    return [dataclasses.replace(contact, **{one.name: one.factor * getattr(contact, one.name)}) for one in known]


def first_gait(walker: PenaltyStepper) -> FixedPoint | None:
    """The gait near the walker's start, or where some steps lead to; None if there is none."""
    try:
        return fixed_point(walker, section_numbers(walker.start))
    except NoLimitCycle:
        pass
    try:
        return fixed_point(walker, walker.walk(walker.start, SETTLING_STEPS).numbers)
    except NoLimitCycle:
        return None


def next_gait(walker: PenaltyStepper, known: list[tuple[float, FixedPoint]], at: float) -> FixedPoint | None:
    """The gait on the line through the last two known ones, each with the logarithm of its factor, `at` another."""
    if not known:
        return first_gait(walker)
    numbers, derivative = extrapolated(known, at)
    try:
        return fixed_point(walker, numbers, derivative)
    except NoLimitCycle:
        return None


def extrapolated(known: list[tuple[float, FixedPoint]], at: float) -> tuple[np.ndarray, np.ndarray]:
    """Section numbers on the line through the last two known gaits, or those of the only one; the last derivative."""
    (there, last), numbers = known[-1], known[-1][1].numbers
    if len(known) > 1:
        before, earlier = known[-2]
        numbers = numbers + (numbers - earlier.numbers) * (at - there) / (there - before)
    return numbers, last.derivative


def row(name: str, factor: float, point: FixedPoint | None) -> FrictionVariation:
    """What is kept of a gait."""
    if point is None:
        return FrictionVariation(name, factor, float("nan"), float("nan"))
    return FrictionVariation(name, factor, point.step.duration, point.step.length)
