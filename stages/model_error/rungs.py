"""The rungs: models of one design, the cheapest first, and the measures of the gait that each finds.

The constraint model takes the design as it stands in biped.yaml. The three others take the machine that the bill of
parts makes of it: the constraint model and the compiled penalty walker as it projects into the plane, the twin in
space.
"""

import math
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from stages.analytic.errors import NoGait, StepFailed
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.gait_search import describe, find_gait
from stages.analytic.gait.poincare import FixedPoint, by_stability, fixed_point, repeated
from stages.analytic.maps.answers import corrected as corrected_gait, exact
from stages.analytic.model.walker import Vector, Walker
from stages.analytic.walk.recording import crossing_state
from stages.biped.design import Biped
from stages.biped.walk import largest_of_a_step
from stages.ground.contact_law import ContactLaw
from stages.ground.slope import Friction, Slope
from stages.model_error.measures import NAMES
from stages.model_error.parameters import Parameters
from stages.model_error.result import MODELS, PRICES, SHARED
from stages.penalty.step_map import PenaltyStepper
from stages.penalty.walk import Settings as PenaltySettings, simulate
from stages.planar.limit_cycle import (
    ENOUGH,
    S,
    Steps,
    corrected,
    fixed_point as limit_cycle,
    floquet_multipliers,
    gait_near,
)
from stages.planar.run import LimitCycle
from stages.planar.sampling import peaks
from stages.planar.section import UNITS, NoLimitCycle, section_scales, section_state
from stages.planar.signals import GROUND_REACTION
from stages.twin.machine.machine import Machine
from stages.twin.machine.projection import machine_of, project
from stages.twin.parameters import Settings as TwinSettings
from stages.twin.walking.record import peak_force
from stages.twin_ladder.cycle import ALONG, SIDE_UNITS, Search, step_map
from stages.twin_ladder.run import STANDING, section_numbers

#: A second search at so many times the tolerance shows the error of the first.
LOOSER = 10.0
#: An error is so many times what the two differ by, as those of stages.
TIMES = 3.0
#: Tolerance of the constraint models.
CONSTRAINT = 1e-8
#: No tolerance leaves less of a multiplier by these differences.
DIFFERENCES_LEAVE = 1e-4


class NoRung(ValueError):
    """A rung finds no gait of a design, or does not know it; the message says which and why."""


class TooLoose(NoRung):
    """A gait that closes at a tolerance by chance; a tighter one may find it."""


@dataclass(frozen=True)
class Found:
    """The measures of a rung's gait (k,), in the order of `MEASURES`, and their solver's errors (k,)."""

    values: np.ndarray
    errors: np.ndarray


def measures(period: float, length: float, multiplier: float, peak: float = math.nan) -> np.ndarray:
    """A gait's measures (k,), from duration [s] and length [m] of a step, its largest multiplier's magnitude, and the
    largest normal force [N]."""
    return np.array([period, 1.0 / period, length, length / period, peak, multiplier])


def left_open(values: np.ndarray, looser: np.ndarray) -> np.ndarray:
    """Errors (k,) of a gait's measures, by what a looser search differs by.

    Two searches may agree in one measure by chance, as where errors of period and length cancel in the speed. They are
    of one gait, so that none is known to a smaller share than the least known of these three.
    """
    apart = np.abs(looser - values)
    least = (apart / values)[:NAMES.index("peak_force")].max()
    return np.asarray(TIMES * np.maximum(apart, least * np.where(SHARED, values, 1.0)))


def gait_of(design: DesignPoint, near: Vector | None) -> tuple[Walker, FixedPoint]:
    """The stable gait that Newton's method, damped if need be, reaches from a similar design's; else `find_gait`.

    Coordinates of a foot that rolls serve one with limited friction, whose further ones are zero where it rolls.
    Raises NoGait.
    """
    walker = design.walker()
    if near is not None and walker.section_size - near.size in (0, 2):
        start = np.pad(near, (0, walker.section_size - near.size))
        found = corrected_gait(walker, start, CONSTRAINT) or fixed_point(walker, start, CONSTRAINT)
        if found is not None and by_stability(found) < 1.0:
            return walker, found
    return find_gait(design.biped, design.slope, CONSTRAINT, design.friction)


@dataclass(frozen=True)
class Design:
    """A biped on a ground, and how its machine is built.

    `friction` limits the constraint model's trailing foot, or is None where that rolls whatever it takes; `ground` is
    the ground's. `near` are section coordinates of a similar design's gaits, its `searched`: searches begin there.
    """

    biped: Biped
    slope: Slope
    contact: ContactLaw
    friction: Friction | None
    ground: Friction
    twin: TwinSettings
    near: Mapping[str, Vector] = field(default_factory=dict, compare=False)

    @cached_property
    def machine(self) -> Machine:
        """The twin's. Raises BeyondModel."""
        return machine_of(self.biped, self.twin)

    @cached_property
    def projected(self) -> Biped:
        """That machine from the side."""
        return project(self.machine)

    @cached_property
    def as_it_stands(self) -> tuple[Walker, FixedPoint]:
        """The gait of the constraint model. Raises NoGait."""
        design = DesignPoint(self.biped, self.slope, self.friction)
        return gait_of(design, self.near.get("as_it_stands"))

    @cached_property
    def in_detail(self) -> tuple[Walker, FixedPoint]:
        """The gait of the constraint model of that machine, its trailing foot with the ground's friction where the
        model knows it, as the penalty walker's feet have. Raises NoGait.
        """
        rubs = self.projected.hip_friction > 0.0 and self.projected.legs == "compliant"
        design = DesignPoint(self.projected, self.slope, None if rubs else self.ground)
        near = self.near.get("in_detail")
        with suppress(NoGait):
            near = self.as_it_stands[1].z if near is None else near
        return gait_of(design, near)

    @property
    def searched(self) -> dict[str, Vector]:
        """Section coordinates of the constraint models' gaits that were searched, or those they began with."""
        own = {name: gait[1].z for name, gait in vars(self).items() if name in ("as_it_stands", "in_detail")}
        return {**self.near, **own}

    def penalty(self, tolerance: float) -> tuple[PenaltyStepper, LimitCycle]:
        """The penalty walker of the machine, and its gait near the constraint model's. Raises NoLimitCycle, NoGait."""
        walker, point = self.in_detail
        stance = walker.stance_state(crossing_state(walker, point.z, CONSTRAINT))
        start = section_state(section_numbers(stance), STANDING)
        stepper = PenaltyStepper(self.projected, self.slope, self.contact, start, PenaltySettings(tolerance))
        return stepper, gait_near(stepper, start)


def design_of(parameters: Parameters) -> Design:
    """The study's design."""
    friction = parameters.analytic.limited(parameters.friction)
    return Design(parameters.biped, parameters.slope, parameters.contact, friction, parameters.friction,
                  parameters.twin)  # fmt: skip


def by_constraint(design: Design, tolerance: float) -> Found:
    """The constraint model of the design as it stands."""
    return constrained(*design.as_it_stands, tolerance)


def by_detail(design: Design, tolerance: float) -> Found:
    """The constraint model of the twin's machine."""
    return constrained(*design.in_detail, tolerance)


def constrained(walker: Walker, point: FixedPoint, tolerance: float) -> Found:
    """A gait of the constraint model, and near it that of looser settings. Raises StepFailed."""
    moved = repeated(walker, point.z, walker.gait_steps, LOOSER * tolerance) - point.z
    near = point.z + np.linalg.solve(np.eye(point.z.size) - point.monodromy_matrix, moved)
    gaits = [describe(walker, each) for each in (point, exact(walker, near, LOOSER * tolerance))]
    values, found = (
        measures(gait.period_s, gait.step_length_m, gait.largest_multiplier)
        for gait in gaits)  # fmt: skip
    return Found(values, left_open(values, found))


def closing_step(walker: Steps[S], numbers: np.ndarray, derivative: np.ndarray) -> S:
    """The step from where a correction of a gait leads, at section numbers (10,). Raises TooLoose where that does not
    close, as loose steps may by chance beside the gait of a map that is not smooth."""
    found = corrected(walker, numbers, derivative)
    if found.residual > ENOUGH[-1] * walker.tolerance:
        raise TooLoose(f"steps to a tolerance of {walker.tolerance:.1g} close by chance beside it")
    return found.step


def by_penalty(design: Design, tolerance: float) -> Found:
    """The penalty walker of the twin's machine; its second search starts at the first's gait."""
    stepper, cycle = design.penalty(tolerance)
    looser = replace(stepper.settings, tolerance=LOOSER * tolerance)
    other = PenaltyStepper(design.projected, design.slope, design.contact, stepper.start, looser)

    def measured(walker: PenaltyStepper) -> np.ndarray:
        step = closing_step(walker, cycle.section_state, cycle.monodromy_matrix)
        multipliers = floquet_multipliers(walker.derivative(step.numbers, step))
        count, start = walker.steps_a_cycle, section_state(step.numbers, walker.start)
        run = simulate(design.projected, design.slope, design.contact, start, walker.settings, steps=count,
                       signals=(GROUND_REACTION,))  # fmt: skip
        peak = peaks(run.trajectory, design.contact, design.projected.foot_radii, 0.0, step.duration)[0].max()
        return measures(step.period, step.step_length, largest_of_a_step(multipliers, count), peak)

    values = measured(stepper)
    return Found(values, left_open(values, measured(other)))


def by_twin(design: Design, tolerance: float) -> Found:
    """The twin, searched from the penalty walker's gait, which is the twin's but for some millionths.

    The error of its multiplier is at least what it differs by from the penalty walker's exact one.
    """
    stepper, cycle = design.penalty(tolerance)
    steps_a_stride = 2 // stepper.steps_a_cycle
    exact = np.linalg.matrix_power(cycle.monodromy_matrix, steps_a_stride)
    scales, side = (section_scales(design.biped, design.slope, each) for each in (UNITS, SIDE_UNITS))

    def search(one: float) -> Search:
        settings = replace(design.twin, tolerance=one)
        take = step_map(design.machine, design.slope, design.contact, settings)
        return Search(take, (scales, side), one, ALONG)

    walker = search(tolerance)
    found = limit_cycle(walker, cycle.section_state, exact)
    strides = [closing_step(each, found.numbers, found.derivative) for each in (walker, search(LOOSER * tolerance))]
    largest = float(abs(walker.multipliers(found.numbers, exact, 1)[0]))
    penalty = float(np.abs(np.linalg.eigvals(exact)).max()) ** 0.5
    values, other = (
        measures(0.5 * (first.duration + second.duration), 0.5 * (first.length + second.length), largest,
                 max(peak_force(first.record), peak_force(second.record)))
        for first, second in ((one.first, one.second) for one in strides))  # fmt: skip
    errors = left_open(values, other)
    errors[NAMES.index("multiplier")] = (
        LOOSER * tolerance / ALONG + max(DIFFERENCES_LEAVE, abs(largest - penalty)))  # fmt: skip
    return Found(values, errors)


@dataclass(frozen=True)
class Rung:
    """A model: its name, the tolerances at which it is walked, the loosest first, and its price.

    No tolerance makes the error of its multiplier less than `differences`.
    """

    name: str
    walked: Callable[[Design, float], Found]
    tolerances: tuple[float, ...]
    price: float
    differences: float = 0.0

    def find(self, design: Design, tolerance: float) -> Found:
        """The measures of its gait. Raises NoRung."""
        try:
            return self.walked(design, tolerance)
        except TooLoose as error:
            raise TooLoose(f"no gait of the {self.name} was found: {error}") from None
        except (NoGait, StepFailed, NoLimitCycle, ValueError) as error:
            raise NoRung(f"no gait of the {self.name} was found: {error}") from None


RUNGS = (
    Rung(MODELS[0], by_constraint, (CONSTRAINT,), PRICES[0]),
    Rung(MODELS[1], by_detail, (CONSTRAINT,), PRICES[1]),
    Rung(MODELS[2], by_penalty, (1e-6, 1e-7, 1e-8), PRICES[2]),
    Rung(MODELS[3], by_twin, (1e-6, 1e-7, 1e-8), PRICES[3], DIFFERENCES_LEAVE),
)
