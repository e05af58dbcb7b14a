"""What a varied walker does in place of the plain one: the register of its functions, filled where this is imported."""

from __future__ import annotations

from stages.analytic.compiled import compiled, extend
from stages.analytic.derivatives.guards import (
    limited_varied_guard,
    rigid_varied_guard,
    rolling_varied_guard,
    rubbing_rolling_varied_guard,
)
from stages.analytic.derivatives.impacts import (
    limited_varied_reset,
    limited_varied_succession,
    rigid_varied_reset,
    rolling_varied_reset,
)
from stages.analytic.derivatives.rates import (
    limited_varied_rates,
    rigid_varied_rates,
    rolling_varied_rates,
    rubbing_rolling_varied_rates,
    rubbing_varied_rates,
)
from stages.analytic.integration import dop853_step, radau
from stages.analytic.integration.integrator import error_norm, take_step
from stages.analytic.integration.phase import failure
from stages.analytic.model.kinds import Kind
from stages.analytic.model.terms import exchanged
from stages.analytic.model.varied import (
    StiffVaried,
    Varied,
    VariedLimited,
    VariedRigid,
    VariedRigidLegs,
    VariedRolling,
    VariedRubbing,
    VariedRubbingRolling,
)
from stages.analytic.model.walker import Vector
from stages.analytic.phases.flow import flow
from stages.analytic.phases.guards import guard
from stages.analytic.phases.succession import (
    Next,
    first_phase,
    rigid_succession,
    rolling_succession,
    rubbing_rolling_succession,
    rubbing_succession,
    succeed,
)
from stages.analytic.phases.transitions import heel_strike_reset


@compiled
def plain_failure(phase: int, y: Vector, p: Varied) -> int:
    """`failure`: that of the plain walker."""
    return failure(phase, y, p.plain)


@compiled
def plain_first_phase(y: Vector, p: Varied) -> Next:
    """`first_phase`: that of the plain walker."""
    return first_phase(y, p.plain)


@compiled
def plain_exchanged(p: Varied) -> Kind:
    """`exchanged`: the plain walker in its next step."""
    after: Kind = exchanged(p.plain)
    return after


extend(exchanged, {Varied: plain_exchanged})
extend(flow, {
    VariedRigid: rigid_varied_rates, VariedRubbing: rubbing_varied_rates, VariedRolling: rolling_varied_rates,
    VariedRubbingRolling: rubbing_rolling_varied_rates, VariedLimited: limited_varied_rates})
extend(guard, {
    VariedRigidLegs: rigid_varied_guard, VariedRolling: rolling_varied_guard,
    VariedRubbingRolling: rubbing_rolling_varied_guard, VariedLimited: limited_varied_guard})
extend(heel_strike_reset, {
    VariedRigidLegs: rigid_varied_reset, VariedRolling | VariedRubbingRolling: rolling_varied_reset,
    VariedLimited: limited_varied_reset})
extend(succeed, {
    VariedRigid: rigid_succession, VariedRubbing: rubbing_succession, VariedRolling: rolling_succession,
    VariedRubbingRolling: rubbing_rolling_succession, VariedLimited: limited_varied_succession})
extend(first_phase, {Varied: plain_first_phase})
extend(failure, {Varied: plain_failure})
extend(take_step, {StiffVaried: radau.take_step, Varied: dop853_step.take_step})
extend(error_norm, {StiffVaried: radau.error_norm, Varied: dop853_step.error_norm})
