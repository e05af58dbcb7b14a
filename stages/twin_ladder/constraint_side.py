"""The constraint model of a rung's own machine: its gait, to lay the machine's beside it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stages.analytic.errors import NoGait, StepFailed
from stages.analytic.gait.gait_search import find_gait, step_lengths
from stages.analytic.gait.poincare import FixedPoint, poincare_derivative
from stages.analytic.model.walker import Walker
from stages.analytic.walk.recording import crossing, is_last, up_to_mid_stance, vaulting, walk_on
from stages.analytic.walk.sampling import signals_at
from stages.biped.design import Biped
from stages.biped.gait import StanceState
from stages.ground.friction_coefficients import Friction
from stages.ground.slope import Slope
from stages.twin_ladder.cycle import IN_PLANE, step_multipliers
from stages.twin_ladder.result import COMPLETED, SameMachine

#: Shares of a stride at which hips are compared.
PHASES = np.linspace(0.0, 1.0, 801)


@dataclass(frozen=True)
class ConstraintGait:
    """A gait of the constraint model in the terms of `RungGait`; `hip` (801, 2) [m] at `PHASES` of a stride.

    The stride begins at `mid_stance`, the first leg upright at x = 0 with a normal force of `standing_force` [N].
    `outcome` says why where there is none.
    """

    outcome: str
    period: float
    step_length: float
    limp: float
    multipliers: np.ndarray
    hip: np.ndarray
    mid_stance: StanceState
    standing_force: float

    @property
    def found(self) -> bool:
        """Whether there is one."""
        return self.outcome == COMPLETED


def constraint_gait(biped: Biped, slope: Slope, tolerance: float, friction: Friction | None = None) -> ConstraintGait:
    """The gait of the constraint model of a biped; with `friction` its trailing foot may slip and rise."""
    try:
        walker, point = find_gait(biped, slope, tolerance, friction)
        return _described(walker, point, tolerance)
    except (NoGait, StepFailed) as error:
        nothing = float("nan")
        hip, state = np.full((len(PHASES), 2), nothing), StanceState(*[nothing] * 8)
        return ConstraintGait(str(error), nothing, nothing, nothing, np.zeros(0), hip, state, nothing)


def section_numbers(state: StanceState) -> np.ndarray:
    """A mid-stance of the constraint model as `stages.planar.section` has it, (10,): it rolls without slip."""
    length, forward = state.stance_length, state.stance_length * state.stance_rate
    rates = -state.stance_rate, state.swing_rate, state.stance_length_rate, state.swing_length_rate
    return np.array([length, state.swing_angle, length, state.swing_length, forward, state.stance_length_rate, *rates])


def _described(walker: Walker, point: FixedPoint, tolerance: float) -> ConstraintGait:
    upright, elapsed = crossing(walker, point.z, tolerance)
    segments = walk_on(walker, upright, 2, tolerance, elapsed)
    found = signals_at(walker, segments, 2 * point.period * PHASES)
    strikes = np.cumsum([is_last(segment) for segment in segments])
    second = [segment for segment, before in zip(segments[1:], strikes, strict=False) if before == 1]
    other = up_to_mid_stance(walker.exchanged, second[vaulting(second)])
    period = point.period * walker.time
    first = poincare_derivative(walker, point.z, tolerance)[1]
    stride = point.monodromy_matrix if len(point.steps) == 2 else point.monodromy_matrix @ point.monodromy_matrix
    return ConstraintGait(
        outcome=COMPLETED,
        period=period,
        step_length=float(np.mean(step_lengths(walker, point))) * walker.length,
        limp=2 * (other.start + other.duration) / point.period - 2,
        multipliers=step_multipliers(np.eye(len(first)), first, stride)[:IN_PLANE],
        hip=found["hip_position"] - found["hip_position"][0] * [1.0, 0.0],
        mid_stance=walker.stance_state(upright),
        standing_force=float(found["ground_reaction"][0, 0, 1]),
    )


def beside(name: str, own: ConstraintGait, simple: ConstraintGait, hip: np.ndarray) -> SameMachine:
    """The row of a rung: its own constraint model, and how far its `hip` (801, 2) is from that and the simple one's."""
    return SameMachine(
        name=name,
        outcome=own.outcome,
        period_s=own.period,
        step_length_m=own.step_length,
        inner_outer_difference=own.limp,
        multipliers=np.column_stack([own.multipliers.real, own.multipliers.imag]),
        hip_apart_m=np.abs(hip - own.hip).max(axis=0),
        hip_from_simple_m=np.abs(hip - simple.hip).max(axis=0),
    )
