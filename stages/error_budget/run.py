"""Error budget: the difference of hip motion between constraint and penalty model, split into what causes it.

Inputs: none; both models are walked here, on a path from one to the other on which one effect is switched on at a time.
Settings: params/error_budget.yaml, the contact set of ground.yaml. Output: `Result`.
"""

from stages.analytic.errors import NoGait, StepFailed
from stages.biped.design import require_own_strikes
from stages.biped.processes import Progress, ignore
from stages.error_budget.parameters import Parameters
from stages.error_budget.path import LIMITS, OneStep, cycle_budget, step_budget, switched
from stages.error_budget.result import CONTACT, Result
from stages.planar.section import NoLimitCycle
from stages.studies.result import COMPLETED, EngineAgreement, drawn

#: Seed of the draw.
SEED = 17


def checked(scene: OneStep) -> EngineAgreement:
    """Steps with laws drawn from those of the budget's nodes, and the cycle of the law itself.

    Raises EnginesDisagree, NoLimitCycle, NoGait, StepFailed.
    """
    parameters, settings, upright = scene.parameters, scene.parameters.settings, scene.upright
    tolerance = parameters.checked_tolerance
    nodes = [(frozenset(CONTACT), 1.0)]
    nodes += [(on, part * settings.step_share) for on in LIMITS for part in (4.0, 2.0, 1.0)]
    distances = []
    for on, share in (nodes[number] for number in drawn(settings.checked, len(nodes), SEED)):
        off = [effect for effect in CONTACT if effect not in on]
        what = f"a step with the part {share:.3g} of {' and of '.join(off)}" if off else "a step with the law itself"
        law = switched(parameters.contact, on, share)
        distances.append(upright.step_apart(what, law, tolerance, float(scene.time[-1])))
    try:
        distances.append(upright.cycle_apart("the cycle", parameters.contact, tolerance))
    except NoLimitCycle as reason:
        raise NoLimitCycle(f"on a cycle: {reason}") from None
    return EngineAgreement(SEED, tuple(distances))


def run(parameters: Parameters, inputs: None = None, progress: Progress = ignore) -> Result:
    """Split the difference over one step, then between cycles. A model that does not walk is a result that says so.

    Raises EnginesDisagree if the compiled penalty walker is not Exudyn's, BeyondModel for a hip that rubs, or a strike
    at a given time.
    """
    require_own_strikes(parameters.biped, "the error budget")
    step, cycle, engines, outcome = None, None, None, COMPLETED
    try:
        progress(0.0, "one step with one effect at a time")
        scene = OneStep(parameters)
        step = step_budget(scene)
        progress(0.2, "cycles with one effect at a time")
        cycle = cycle_budget(parameters, scene.constraint)
        progress(0.4, "comparing with Exudyn")
        engines = checked(scene)
    except (NoLimitCycle, NoGait, StepFailed) as reason:
        outcome = str(reason)
    return Result(outcome, step, cycle, engines)
