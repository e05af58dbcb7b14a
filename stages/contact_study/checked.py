"""Some of the study's steps, and one of its cycles, walked by Exudyn too."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress

from stages.contact_study.one_step import Scene
from stages.contact_study.result import VARIED
from stages.engines.result import EngineAgreement, drawn
from stages.engines.walks import Machine, between_cycles, over_a_walk
from stages.ground.contact_law import ContactLaw
from stages.planar.section import NoLimitCycle, section_numbers
from stages.planar.state import PlanarState, rolling_state

#: Seed of the draws.
SEED = 17


def checked(
    scene: Scene, laws: Sequence[tuple[ContactLaw, int]], cycles: Sequence[ContactLaw], count: int, tolerance: float
) -> EngineAgreement:
    """So many steps with sets, each given with its cost, and one cycle unless there is one step only.

    The dearest set is the first, the others and the cycle are drawn. `tolerance` is Exudyn's. Raises EnginesDisagree.
    """
    hardest = max(range(len(laws)), key=lambda number: laws[number][1])

    def placed(law: ContactLaw) -> tuple[Machine, PlanarState]:
        start = rolling_state(scene.biped, law, scene.mid_stance, scene.walk.standing_force)
        return Machine(scene.biped, scene.slope, law, tolerance), start

    def named(law: ContactLaw) -> str:
        return ", ".join(f"{key} {getattr(law, key):.3g}" for key in VARIED)

    distances = [
        over_a_walk(f"a step with {named(laws[number][0])}", *placed(laws[number][0]), duration=scene.period)
        for number in drawn(count, len(laws), SEED, (hardest,))
    ]
    for number in drawn(min(1, count - 1), len(cycles), SEED):
        machine, start = placed(cycles[number])
        with suppress(NoLimitCycle):  # a set without a gait has none to compare
            what = f"the cycle with {named(cycles[number])}"
            distances.append(between_cycles(what, machine, start, section_numbers(start)))
    return EngineAgreement(SEED, tuple(distances))
