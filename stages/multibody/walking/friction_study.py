"""How the gait answers to the transition velocities of the friction law (section 3.4 of the paper).

Each gait is solved for, not awaited, from the one before: its state extrapolated over the logarithm of the factor, its
derivative kept.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from stages.ground.contact_law import ContactLaw
from stages.multibody.result import FrictionVariation
from stages.multibody.walking.cycle import COARSE, Model
from stages.planar.limit_cycle import FixedPoint, LimitCycle, fixed_point
from stages.planar.section import NoLimitCycle, section_numbers
from stages.planar.state import PlanarState

#: Changes of each transition velocity on both sides, outwards: what the paper may mean by small to moderate.
FACTORS = (tuple(2.0 ** (-0.5 * step) for step in (1, 2, 4)), tuple(2.0 ** (0.5 * step) for step in (1, 2, 4)))
VELOCITIES = ("stiction_velocity", "friction_velocity")
#: Residual in the section's scales: period and length are then known to 1e-5 of themselves.
RESIDUAL = 5e-5


def vary_friction(
    model: Model, contact: ContactLaw, state: PlanarState, gait: LimitCycle | None
) -> tuple[FrictionVariation, ...]:
    """Gaits on ground with this contact law, and with each transition velocity changed alone by `FACTORS`.

    `state` is a mid-stance, `gait` one on similar ground, if there is one. Changes that break the order of the
    velocities are left out.
    """
    coarse = dataclasses.replace(model.at(COARSE), contact=contact)
    start, derivative = (section_numbers(state), None) if gait is None else (gait.section_state, gait.monodromy_matrix)
    base = solved(coarse, state, start, derivative)
    found = []
    for name in VELOCITIES:
        found.append(row(name, 1.0, base))
        for side in FACTORS:
            known = [] if base is None else [(0.0, base)]
            for factor in side:
                law = dataclasses.replace(contact, **{name: factor * getattr(contact, name)})
                if any(True for _ in law.broken_rules()):
                    continue
                guess, slope = extrapolated(known, math.log(factor)) if known else (start, derivative)
                point = solved(dataclasses.replace(coarse, contact=law), state, guess, slope)
                if point is not None:
                    known.append((math.log(factor), point))
                found.append(row(name, factor, point))
    return tuple(sorted(found, key=lambda one: (VELOCITIES.index(one.name), one.factor)))


def extrapolated(known: list[tuple[float, FixedPoint]], at: float) -> tuple[np.ndarray, np.ndarray]:
    """Section numbers on the line through the last two known gaits, or those of the only one; the last derivative."""
    (there, last), numbers = known[-1], known[-1][1].numbers
    if len(known) > 1:
        before, earlier = known[-2]
        numbers = numbers + (numbers - earlier.numbers) * (at - there) / (there - before)
    return numbers, last.derivative


def solved(
    model: Model, state: PlanarState, numbers: np.ndarray, derivative: np.ndarray | None
) -> FixedPoint | None:
    """The gait near these section numbers, or None."""
    try:
        return fixed_point(model.walker(state), numbers, RESIDUAL, derivative)
    except NoLimitCycle:
        return None


def row(name: str, factor: float, point: FixedPoint | None) -> FrictionVariation:
    """What is kept of a gait."""
    if point is None:
        return FrictionVariation(name, factor, float("nan"), float("nan"))
    return FrictionVariation(name, factor, point.step.duration, point.step.length)
