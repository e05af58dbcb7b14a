"""The rungs: models of one design, the cheapest first, and the measures of the gait that each finds.

The constraint model takes the design as it stands in biped.yaml. The three others take the machine that the bill of
parts makes of it: the constraint model and the compiled penalty walker as it projects into the plane, the twin in
space.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from stages.analytic.errors import NoGait, StepFailed
from stages.analytic.gait.gait_search import describe, find_gait
from stages.analytic.gait.poincare import FixedPoint
from stages.analytic.gait.poincare import fixed_point as looser_gait
from stages.analytic.model.walker import Walker
from stages.analytic.walk.recording import crossing_state
from stages.biped.design import Biped, require_own_strikes
from stages.ground.contact_law import ContactLaw
from stages.ground.friction_coefficients import Friction
from stages.ground.slope import Slope
from stages.model_error.measures import NAMES
from stages.model_error.result import MODELS
from stages.penalty.settings import Settings as PenaltySettings
from stages.penalty.step_map import PenaltyStepper
from stages.planar.limit_cycle import corrected, floquet_multipliers, gait_near
from stages.planar.run import LimitCycle
from stages.planar.section import UNITS, NoLimitCycle, section_scales, section_state
from stages.twin.machine.detailed import machine_of
from stages.twin.machine.machine import Machine
from stages.twin.machine.projection import project
from stages.twin.parameters import Settings as TwinSettings
from stages.twin_ladder.cycle import SIDE_UNITS, Search, step_map
from stages.twin_ladder.run import STANDING, like_planar, section_numbers

#: A second search at so many times the tolerance tells the error of the first.
LOOSER = 10.0
#: Tolerance of the constraint models.
CONSTRAINT = 1e-8
#: Step of the twin's finite differences in the section's scales, as in `params/twin_ladder.yaml`.
DIFFERENCE = 5e-4


class NoRung(ValueError):
    """A rung finds no gait of a design, or does not know it; the message says which and why."""


@dataclass(frozen=True)
class Found:
    """The measures of a rung's gait (k,), in the order of `MEASURES`, and their solver's errors (k,)."""

    values: np.ndarray
    errors: np.ndarray


def measures(period: float, length: float, multiplier: float) -> np.ndarray:
    """A gait's measures (k,), from duration [s] and length [m] of a step and its largest multiplier's magnitude."""
    return np.array([period, 1.0 / period, length, length / period, multiplier])


def steps_multiplier(multipliers: np.ndarray, steps: int) -> float:
    """Magnitude of the largest of multipliers (n, 2) of a cycle of so many steps, of one step."""
    largest: float = np.hypot(*multipliers[0]) ** (1.0 / steps)
    return largest


@dataclass(frozen=True)
class Design:
    """A biped on a ground, and how its machine is built.

    `friction` limits the constraint model's trailing foot, or is None where that rolls whatever it takes; `ground` is
    the ground's.
    """

    biped: Biped
    slope: Slope
    contact: ContactLaw
    friction: Friction | None
    ground: Friction
    twin: TwinSettings

    @cached_property
    def machine(self) -> Machine:
        """The twin's. Raises BeyondModel."""
        require_own_strikes(self.biped, "a machine that walks by itself")
        return machine_of(self.biped, self.twin)

    @cached_property
    def projected(self) -> Biped:
        """That machine from the side."""
        return project(self.machine)

    @cached_property
    def as_it_stands(self) -> tuple[Walker, FixedPoint]:
        """The gait of the constraint model. Raises NoGait."""
        return find_gait(self.biped, self.slope, CONSTRAINT, self.friction)

    @cached_property
    def in_detail(self) -> tuple[Walker, FixedPoint]:
        """The gait of the constraint model of that machine, its trailing foot with the ground's friction where the
        model knows it, as the penalty walker's feet have. Raises NoGait.
        """
        rubs = self.projected.hip_friction > 0.0 and self.projected.legs == "compliant"
        return find_gait(self.projected, self.slope, CONSTRAINT, None if rubs else self.ground)

    def penalty(self, tolerance: float) -> tuple[PenaltyStepper, LimitCycle]:
        """The penalty walker of the machine, and its gait near the constraint model's. Raises NoLimitCycle, NoGait."""
        walker, point = self.in_detail
        stance = walker.stance_state(crossing_state(walker, point.z, CONSTRAINT))
        start = section_state(section_numbers(stance), STANDING)
        stepper = PenaltyStepper(self.projected, self.slope, self.contact, start, PenaltySettings(tolerance))
        return stepper, gait_near(stepper, start)


def by_constraint(design: Design, tolerance: float) -> Found:
    """The constraint model of the design as it stands."""
    return constrained(*design.as_it_stands, tolerance)


def by_detail(design: Design, tolerance: float) -> Found:
    """The constraint model of the twin's machine."""
    return constrained(*design.in_detail, tolerance)


def constrained(walker: Walker, point: FixedPoint, tolerance: float) -> Found:
    """A gait of the constraint model; the second search starts there. Raises NoGait."""
    other = looser_gait(walker, point.z, LOOSER * tolerance)
    if other is None:
        raise NoGait("at looser settings none is found near it")
    gaits = [describe(walker, each) for each in (point, other)]
    values, found = (
        measures(gait.period_s, gait.step_length_m, steps_multiplier(gait.floquet_multipliers, len(point.steps)))
        for gait in gaits)  # fmt: skip
    return Found(values, np.abs(found - values))


def by_penalty(design: Design, tolerance: float) -> Found:
    """The penalty walker of the twin's machine; its second search starts at the first's gait."""
    stepper, cycle = design.penalty(tolerance)
    looser = dataclasses.replace(stepper.settings, tolerance=LOOSER * tolerance)
    other = PenaltyStepper(design.projected, design.slope, design.contact, stepper.start, looser)

    def measured(walker: PenaltyStepper) -> np.ndarray:
        step = corrected(walker, cycle.section_state, cycle.monodromy_matrix)
        multipliers = floquet_multipliers(walker.derivative(step.numbers, step))
        count = walker.steps_a_cycle
        return measures(step.duration / count, step.length / count, steps_multiplier(multipliers, count))

    values = measured(stepper)
    return Found(values, np.abs(measured(other) - values))


def by_twin(design: Design, tolerance: float) -> Found:
    """The twin, searched from the penalty walker's gait; its multiplier is by finite differences."""
    cycle = design.penalty(tolerance)[1]
    scales, side = (section_scales(design.biped, design.slope, each) for each in (UNITS, SIDE_UNITS))

    def search(one: float) -> Search:
        settings = dataclasses.replace(design.twin, tolerance=one)
        take = step_map(design.machine, design.slope, design.contact, settings)
        return Search(take, (scales, side), one, DIFFERENCE, sideways=False)

    gait = search(tolerance).find(like_planar(cycle, scales))
    largest = float(abs(gait.plane_multipliers[0]))
    strides = [corrected(search(one), gait.near.plane, gait.near.derivative) for one in (tolerance, LOOSER * tolerance)]
    values, found = (
        measures(0.5 * (first.duration + second.duration), 0.5 * (first.length + second.length), largest)
        for first, second in ((one.first, one.second) for one in strides))  # fmt: skip
    errors = np.abs(found - values)
    errors[NAMES.index("multiplier")] = LOOSER * tolerance / DIFFERENCE + DIFFERENCE
    return Found(values, errors)


@dataclass(frozen=True)
class Rung:
    """A model: its name, the tolerances at which it is walked, the loosest first, and its price.

    The price is the processor time [s] of a gait at the first tolerance, the median of drawn designs on one machine; it
    orders the rungs, and is told.
    """

    name: str
    walked: Callable[[Design, float], Found]
    tolerances: tuple[float, ...]
    price: float

    def find(self, design: Design, tolerance: float) -> Found:
        """The measures of its gait. Raises NoRung."""
        try:
            return self.walked(design, tolerance)
        except (NoGait, StepFailed, NoLimitCycle, ValueError) as error:
            raise NoRung(f"the {self.name} has no gait: {error}") from None


RUNGS = tuple(
    Rung(name, *row) for name, row in zip(MODELS, (
        (by_constraint, (CONSTRAINT,), 0.01),
        (by_detail, (CONSTRAINT,), 0.01),
        (by_penalty, (1e-6, 1e-7, 1e-8), 0.1),
        (by_twin, (1e-6, 1e-7, 1e-8), 1.5),
    ), strict=True))  # fmt: skip
