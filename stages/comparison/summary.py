"""What the study says of its biped, the paper's or another: agreement, stability, friction, step, cost."""

from __future__ import annotations

from dataclasses import dataclass

from stages.biped.quantity import quantity


@dataclass(frozen=True)
class BipedSummary:
    """The biped's gait in few numbers; NaN where a model has none."""

    step_frequency: float = quantity("Hz", "step frequency of the constraint model")
    step_length: float = quantity("m", "step length of the constraint model")
    period_error: float = quantity("s", "estimated numerical error of its step period")
    hip_error: float = quantity("m", "estimated numerical error of its hip over the walk")
    period_difference: float = quantity("s", "step period of the penalty model less the constraint model's")
    length_difference: float = quantity("m", "step length of the penalty model less the constraint model's")
    limit_difference: float = quantity(
        "m", "largest hip difference over one step of the constraint model with Coulomb friction from the rolling one"
    )
    hip_difference: float = quantity("m", "largest hip difference of these models over one step from a common state")
    twin_frequency: float = quantity("Hz", "step frequency of the twin's last four steps")
    multiplier: float = quantity("1", "largest multiplier of the constraint model")
    twin_multiplier: float = quantity("1", "largest multiplier of the twin in the plane")
    friction_single_stance: float = quantity("1", "friction it needs in single stance")
    friction_heel_strike: float = quantity("1", "friction it needs in the impulses of heel strike, to roll on")
    friction: float = quantity("1", "friction there is")
    specific_cost: float = quantity("1", "cost of transport: what gravity gives over weight and way")
    constraint_work: float = quantity("1", "evaluations a step of the constraint model for the error below")
    penalty_work: float = quantity("1", "evaluations a step of the penalty model for the error below")
    error: float = quantity("m", "hip error at which work is counted")
