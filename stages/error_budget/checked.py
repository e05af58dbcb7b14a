"""What the engine changes: some of the budget's steps, and the cycle on its ground, walked by Exudyn too.

Every contribution is a difference of walks of one engine, so what the contact law changes is not mixed with what the
engine changes; that is told here.
"""

from __future__ import annotations

from stages.engines.result import EngineAgreement, drawn
from stages.engines.walks import between_cycles, over_a_walk
from stages.error_budget.effects import CONTACT, switched
from stages.error_budget.errors import NotWalked
from stages.error_budget.one_step import OneStep
from stages.error_budget.path import LIMITS
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
