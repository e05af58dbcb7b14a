"""The multibody model's own gait: fixed point, period and multipliers of its step map, by finite differences."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from stages.biped.design import Biped
from stages.biped.quantity import quantity
from stages.ground.contact_law import ContactLaw
from stages.ground.normal_force import static_penetration
from stages.ground.slope import Slope
from stages.multibody.assembly.state import PlanarState
from stages.multibody.parameters import Settings
from stages.multibody.walking.section import (
    SCALES,
    NoLimitCycle,
    SectionStep,
    mid_stance_after,
    section_numbers,
    section_state,
)
from stages.multibody.walking.walk import build, simulate

SETTLING_STEPS = 8
NEWTON_STEPS = 16
#: The derivative is made anew when an iteration leaves more than this of the residual, so often at most.
SLOW, MOST_RENEWALS = 0.8, 4
#: Times a change of the state is halved if the model does not take a step from it.
HALVINGS = 4
DIFFERENCE = 1e-4
#: Numbers that lift the standing foot, hip y and its leg's length, and the share of its depth that they may change by.
LIFTING, SHARE_OF_DEPTH = [0, 2], 0.4


@dataclass(frozen=True)
class LimitCycle:
    """A gait of the multibody model at mid-stance; rows and columns are the numbers of `section_numbers`."""

    section_state: np.ndarray = quantity("1", "hip y, swing angle, both lengths, then the rates, shape (10,)")
    period_s: float = quantity("s", "duration of one step", symbol="T")
    step_length_m: float = quantity("m", "advance of the hip in one step", symbol="s")
    monodromy_matrix: np.ndarray = quantity("1", "derivative of the step map, shape (10, 10)")
    floquet_multipliers: np.ndarray = quantity("1", "eigenvalues, largest first, real and imaginary part, (10, 2)")
    residual: float = quantity("1", "how far the fixed point moves in one step, in the scales of the section")
    solver_steps: int = quantity("1", "solver steps of one step")
    steps_walked: int = quantity("1", "steps walked to find the gait and its derivative")


@dataclass(frozen=True)
class FixedPoint:
    """Section numbers (10,) that a step changes by no more than `residual`, that step, and its derivative (10, 10)."""

    numbers: np.ndarray
    step: SectionStep
    residual: float
    derivative: np.ndarray


def limit_cycle(
    biped: Biped,
    slope: Slope,
    contact: ContactLaw,
    state: PlanarState,
    settings: Settings,
    tolerance: float = 1e-8,
    difference: float = DIFFERENCE,
) -> LimitCycle:
    """The gait near `state`, a mid-stance, or, if there is none, near the end of a walk of some steps from it.

    `tolerance` is the residual wanted, `difference` the step of the finite differences, both in `SCALES`. For the
    defaults the integration's own tolerance should be 1e-10 or less. Raises NoLimitCycle.
    """
    walker = SectionWalker(biped, slope, contact, state, settings)
    differences = walker.differences(difference)
    try:
        found = fixed_point(walker.step, section_numbers(state), tolerance, differences)
    except NoLimitCycle:
        settled = walker.walk(state, SETTLING_STEPS).numbers
        found = fixed_point(walker.step, settled, tolerance, differences)
    derivative = section_derivative(walker.step, found.numbers, differences)
    multipliers = floquet_multipliers(derivative)
    after = found.step
    return LimitCycle(
        found.numbers,
        after.duration,
        after.length,
        derivative,
        multipliers,
        found.residual,
        after.solver_steps,
        walker.steps_walked,
    )


class SectionWalker:
    """A built model that takes steps from mid-stance to mid-stance, and counts them."""

    def __init__(
        self, biped: Biped, slope: Slope, contact: ContactLaw, state: PlanarState, settings: Settings
    ) -> None:
        self.model = biped, slope, contact
        self.start, self.settings = state, settings
        self.machine = build(biped, slope, contact, settings, signals=())
        self.steps_walked = 0

    def walk(self, start: PlanarState, steps: int) -> SectionStep:
        """Walk from a mid-stance to the one after `steps` steps. Raises NoLimitCycle."""
        self.steps_walked += steps
        return mid_stance_after(
            simulate(*self.model, start, self.settings, steps=steps, assembly=self.machine)
        )

    def step(self, numbers: np.ndarray) -> SectionStep:
        """One step from section numbers (10,). Raises NoLimitCycle."""
        return self.walk(section_state(numbers, self.start), 1)

    def differences(self, size: float) -> np.ndarray:
        """Steps of finite differences (10,), `size` in `SCALES`, but none that lifts the standing foot."""
        biped, slope, contact = self.model
        sunk = static_penetration(contact, biped.total_mass * slope.gravity)
        steps = size * SCALES
        steps[LIFTING] = np.minimum(steps[LIFTING], SHARE_OF_DEPTH * sunk)
        return steps


def fixed_point(
    step: Callable[[np.ndarray], SectionStep],
    numbers: np.ndarray,
    wanted: float,
    differences: np.ndarray,
    derivative: np.ndarray | None = None,
) -> FixedPoint:
    """The fixed point of a step map near `numbers` (10,), to the residual `wanted`. Raises NoLimitCycle.

    Newton's method; each step taken corrects the derivative (Broyden's rank one), which is made anew by finite
    `differences` (10,) where the residual falls slowly. `derivative` (10, 10) of a similar model serves at first.
    """
    after, previous, renewals = step(numbers), np.inf, 0
    for _ in range(NEWTON_STEPS):
        moved = after.numbers - numbers
        residual = float(np.abs(moved / SCALES).max())
        if residual < wanted:
            break
        if derivative is None or (residual > SLOW * previous and renewals < MOST_RENEWALS):
            derivative, renewals = section_derivative(step, numbers, differences, after), renewals + 1
        previous = residual
        change = np.linalg.solve(np.eye(10) - derivative, moved)
        change, then = _taken(step, numbers, change)
        scaled = change / SCALES
        missed = then.numbers - after.numbers - derivative @ change
        derivative = derivative + np.outer(missed, scaled / SCALES) / float(scaled @ scaled)
        numbers, after = numbers + change, then
    else:
        raise NoLimitCycle(f"no fixed point within {NEWTON_STEPS} iterations, residual {residual:.1e}")
    return FixedPoint(numbers, after, residual, np.eye(10) if derivative is None else derivative)


def _taken(
    step: Callable[[np.ndarray], SectionStep], numbers: np.ndarray, change: np.ndarray
) -> tuple[np.ndarray, SectionStep]:
    """A change of the section numbers from which the model takes a step: the one asked for, or a part of it."""
    for _ in range(HALVINGS):
        try:
            return change, step(numbers + change)
        except NoLimitCycle:
            change = 0.5 * change
    return change, step(numbers + change)


def section_derivative(
    step: Callable[[np.ndarray], SectionStep],
    numbers: np.ndarray,
    differences: np.ndarray,
    after: SectionStep | None = None,
) -> np.ndarray:
    """Derivative (10, 10) of a step map by central differences, or by forward ones from the step `after` numbers."""
    columns = []
    for index, size in enumerate(differences):
        change = np.zeros(10)
        change[index] = size
        ahead = step(numbers + change).numbers
        if after is None:
            columns.append((ahead - step(numbers - change).numbers) / (2.0 * size))
        else:
            columns.append((ahead - after.numbers) / size)
    return np.column_stack(columns)


def floquet_multipliers(derivative: np.ndarray) -> np.ndarray:
    """Eigenvalues of a derivative of the step map, largest first, real and imaginary part, (10, 2)."""
    values = np.linalg.eigvals(derivative)
    values = values[np.lexsort((-values.imag, -np.abs(values)))]
    return np.column_stack([values.real, values.imag])
