"""Error budget: the difference of hip motion between constraint and penalty model, split into what causes it.

Inputs: none; both models are walked here, on a path from one to the other on which one effect is switched on at a time.
Settings: params/error_budget.yaml, the contact set of ground.yaml. Output: `Result`.
"""

from __future__ import annotations

from stages.analytic.errors import NoGait, StepFailed
from stages.biped.design import require_alike, require_own_strikes
from stages.biped.progress import Progress, ignore
from stages.engines.result import EngineAgreement, drawn
from stages.engines.walks import between_cycles, over_a_walk
from stages.error_budget.cycles import OneStep, cycle_budget, step_budget
from stages.error_budget.effects import CONTACT, switched
from stages.error_budget.errors import NotWalked
from stages.error_budget.parameters import Parameters
from stages.error_budget.path import LIMITS
from stages.error_budget.result import COMPLETED, CycleBudget, Result, StepBudget
from stages.planar.section import NoLimitCycle, section_numbers
from stages.planar.state import rolling_state

#: Seed of the draw.
SEED = 17


def checked(scene: OneStep) -> EngineAgreement:
    """Steps with laws drawn from those of the budget's nodes, and the cycle of the law itself.

    Raises EnginesDisagree, NotWalked, NoGait, StepFailed.
    """
    parameters, settings = scene.parameters, scene.parameters.settings
    nodes = [(frozenset(CONTACT), 1.0)]
    nodes += [(on, part * settings.step_share) for on in LIMITS for part in (4.0, 2.0, 1.0)]
    distances = []
    for number in drawn(settings.checked, len(nodes), SEED):
        on, share = nodes[number]
        law = switched(parameters.contact, on, share)
        start = rolling_state(parameters.biped, law, scene.constraint.mid_stance, scene.constraint.standing_force)
        off = [effect for effect in CONTACT if effect not in on]
        what = f"a step with the part {share:.3g} of {' and of '.join(off)}" if off else "a step with the law itself"
        distances.append(over_a_walk(what, scene.machine(law), start, duration=float(scene.time[-1])))
    law = parameters.contact
    start = rolling_state(parameters.biped, law, scene.constraint.mid_stance, scene.constraint.standing_force)
    try:
        distances.append(between_cycles("the cycle", scene.machine(law), start, section_numbers(start)))
    except NoLimitCycle as reason:
        raise NotWalked(f"on a cycle: {reason}") from None
    return EngineAgreement(SEED, tuple(distances))


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
