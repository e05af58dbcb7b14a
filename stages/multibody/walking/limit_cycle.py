"""The multibody model's own gait: fixed point, period and multipliers of its step map, by finite differences.

The section is mid-stance, where the stance leg is normal to the ground. There the state has ten free numbers: the hip's
x does not matter, the stance angle is zero, and legs are named by role so that one step maps the section onto itself.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from stages.biped.design import Biped
from stages.biped.quantity import quantity
from stages.ground.contact_law import ContactLaw
from stages.ground.slope import Slope
from stages.multibody.assembly.solver import Run
from stages.multibody.assembly.state import PlanarState
from stages.multibody.parameters import Settings
from stages.multibody.walking.walk import build, simulate

SETTLING_STEPS = 8
NEWTON_STEPS = 12
# Scales in which the residual and the steps of the central differences are measured: m, rad, m/s, rad/s as below.
SCALES = np.array([1e-2, 1e-1, 1e-2, 1e-2, 1e-1, 1e-1, 1.0, 1.0, 1e-1, 1e-1])
DIFFERENCE = 1e-4


class NoLimitCycle(Exception):
    """The model does not walk, or the iteration finds no fixed point; the message says which."""


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
class SectionStep:
    """One step on the section: where it ends, as `section_numbers` (10,) and as a state, how long and wide it was."""

    numbers: np.ndarray
    state: PlanarState
    duration: float
    length: float
    solver_steps: int


def section_numbers(state: PlanarState) -> np.ndarray:
    """Hip y; swing angle; lengths of stance and swing leg; hip velocity x, y; rates of angles and lengths: (10,).

    Leg 0 is the stance leg.
    """
    _, swing = state.leg_angle
    numbers = (state.hip_position[1], swing, *state.leg_length, *state.hip_velocity)
    return np.array([*numbers, *state.leg_rate, *state.leg_length_rate])


def section_state(numbers: np.ndarray, like: PlanarState) -> PlanarState:
    """The state at x = 0 with these numbers; which feet are in play is taken from `like`."""
    y, swing, stance_length, swing_length, across, upward, *rates = numbers.tolist()
    return PlanarState(
        hip_position=(0.0, y),
        hip_velocity=(across, upward),
        leg_angle=(0.0, swing),
        leg_rate=(rates[0], rates[1]),
        leg_length=(stance_length, swing_length),
        leg_length_rate=(rates[2], rates[3]),
        in_play=like.in_play,
    )


def limit_cycle(
    biped: Biped,
    slope: Slope,
    contact: ContactLaw,
    state: PlanarState,
    settings: Settings,
    tolerance: float = 1e-8,
    difference: float = DIFFERENCE,
) -> LimitCycle:
    """Let the model settle from `state`, then find the fixed point by Newton's method with a kept derivative.

    `tolerance` is the residual wanted, `difference` the step of the finite differences, both in `SCALES`. For the
    defaults the integration's own tolerance should be 1e-10 or less. Raises NoLimitCycle.
    """
    machine = build(biped, slope, contact, settings, signals=())

    walked = 0

    def walk(start: PlanarState, steps: int) -> SectionStep:
        nonlocal walked
        walked += steps
        return mid_stance_after(simulate(biped, slope, contact, start, settings, steps=steps, assembly=machine))

    settled = walk(state, SETTLING_STEPS)
    numbers, like = settled.numbers, settled.state

    def step(at: np.ndarray) -> SectionStep:
        return walk(section_state(at, like), 1)

    derivative = _derivative(step, numbers, difference)
    after = step(numbers)
    for _ in range(NEWTON_STEPS):
        residual = float(np.abs((after.numbers - numbers) / SCALES).max())
        if residual < tolerance:
            break
        numbers = numbers + np.linalg.solve(np.eye(10) - derivative, after.numbers - numbers)
        after = step(numbers)
    else:
        raise NoLimitCycle(f"no fixed point within {NEWTON_STEPS} iterations, residual {residual:.1e}")
    derivative = _derivative(step, numbers, difference)
    values = np.linalg.eigvals(derivative)
    values = values[np.lexsort((-values.imag, -np.abs(values)))]
    multipliers = np.column_stack([values.real, values.imag])
    return LimitCycle(
        numbers, after.duration, after.length, derivative, multipliers, residual, after.solver_steps, walked
    )


def _derivative(step: Callable[[np.ndarray], SectionStep], at: np.ndarray, difference: float) -> np.ndarray:
    columns = []
    for index, scale in enumerate(SCALES):
        change = np.zeros(10)
        change[index] = difference * scale
        columns.append((step(at + change).numbers - step(at - change).numbers) / (2.0 * difference * scale))
    return np.column_stack(columns)


def mid_stance_after(run: Run) -> SectionStep:
    """The end of a run, brought to the moment in which the new stance leg is upright, with the legs named by role.

    Raises NoLimitCycle if the run failed or does not end there.
    """
    if not run.completed:
        raise NoLimitCycle(run.message or run.outcome)
    trajectory = run.trajectory
    stance = int(np.argmin(np.abs(trajectory.position[-1, 2:4])))

    def lean(time: float) -> float:
        return float(trajectory.at(np.array([time]))[0][0, 2 + stance])

    behind = np.flatnonzero(trajectory.position[:, 2 + stance] > 0.0)
    if not len(behind) or behind[-1] + 1 == len(trajectory.time):
        raise NoLimitCycle("the step does not end in mid-stance")
    before = behind[-1]  # the solver may take a step more than asked
    moment = float(brentq(lean, trajectory.time[before], trajectory.time[before + 1], xtol=1e-15, rtol=8.9e-16))
    state = trajectory.state_at(moment)
    length = state.hip_position[0] - float(trajectory.position[0, 0])
    if stance == 1:
        pairs = ("leg_angle", "leg_rate", "leg_length", "leg_length_rate", "in_play")
        state = dataclasses.replace(state, **{name: getattr(state, name)[::-1] for name in pairs})
    return SectionStep(section_numbers(state), state, moment, length, run.solver_steps)
