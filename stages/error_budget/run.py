"""Error budget: the difference of hip motion between constraint and penalty model, split into what causes it.

Inputs: none; both models are walked here, on a path from one to the other on which one effect is switched on at a time.
Settings: params/error_budget.yaml, the contact set of ground.yaml. Output: `Result`.
"""

from __future__ import annotations

from stages.analytic.errors import NoGait, StepFailed
from stages.biped.design import require_alike, require_own_strikes
from stages.biped.progress import Progress, ignore
from stages.error_budget.checked import checked
from stages.error_budget.cycles import cycle_budget
from stages.error_budget.errors import NotWalked
from stages.error_budget.one_step import OneStep, step_budget
from stages.error_budget.parameters import Parameters
from stages.error_budget.result import COMPLETED, CycleBudget, Result, StepBudget


def run(parameters: Parameters, inputs: None = None, progress: Progress = ignore) -> Result:
    """Split the difference over one step, then between cycles. A model that does not walk is a result that says so.

    Raises EnginesDisagree if the compiled penalty walker is not Exudyn's, BeyondModel for legs that differ, a hip that
    rubs, or a strike at a given time.
    """
    require_alike(parameters.biped, "the error budget")
    require_own_strikes(parameters.biped, "the error budget")
    step, cycle, engines, outcome = None, None, None, COMPLETED
    try:
        progress(0.0, "one step with one effect at a time")
        scene = OneStep(parameters)
        step = StepBudget(*step_budget(scene))
        progress(0.2, "cycles with one effect at a time")
        cycle = CycleBudget(*cycle_budget(parameters, scene.constraint))
        progress(0.4, "comparing with Exudyn")
        engines = checked(scene)
    except (NotWalked, NoGait, StepFailed) as reason:
        outcome = str(reason)
    return Result(outcome, step, cycle, engines)
