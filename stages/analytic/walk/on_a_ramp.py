"""Whether a gait walks so on a plain ramp, by what it needs of the ground; read without what computes."""

import math
from dataclasses import dataclass

from stages.analytic.result import ROUND_OFF, Validity
from stages.biped.quantity import quantity, written_out

WALKS, WALKS_IF, DOES_NOT = "walks", "walks if", "does not walk"


@dataclass(frozen=True)
class OnARamp:
    """The verdict; `because` are the conditions of "walks if", or what speaks against it."""

    verdict: str = quantity("-", "walks, walks if, or does not walk")
    because: tuple[str, ...] = quantity("-", "conditions, or reasons why not")

    @property
    def sentence(self) -> str:
        """The verdict with its conditions or reasons."""
        if self.verdict == WALKS:
            return f"{WALKS} on a plain ramp"
        if self.verdict == WALKS_IF:
            return f"{WALKS} on a plain ramp if {'; and '.join(self.because)}"
        return f"{DOES_NOT} so on a plain ramp: {'; '.join(self.because)}"


def on_a_ramp(validity: Validity, stable: bool, cycle: int = 0) -> OnARamp:
    """Judge a gait by what it needs of the ground; beside an unstable one there may be a stable cycle of so many steps.

    The model holds the foot that bears the robot whatever that takes: ground that cannot ends the gait. What it needs
    under the trailing foot, which is about to leave, and below ground in mid-swing can be had in other ways.
    """
    there_is, pull = validity.friction_there_is * (1.0 + ROUND_OFF), min(0.0, validity.least_normal_force_stance)
    alone, landing, trailing = (
        validity.friction_single_stance, validity.impulse_friction_landing, validity.impulse_friction_trailing)
    ground = f"the ground has {validity.friction_there_is:.3g}"
    pulled = validity.impulse_normal_trailing < 0.0 or trailing == math.inf
    outside = validity.time_outside_cone
    why = f"the impulse there needs friction {written_out(trailing)} and {ground}" if trailing > there_is else (
        f"it needs more friction than there is in {100.0 * outside:.2g} % of double stance")
    against = (
        (not stable, "a step enlarges what disturbs it"
         + f"; there is a stable cycle of {cycle} steps" * bool(cycle)),
        (pull < 0.0 or alone == math.inf, f"the ground would have to pull the stance foot with {-pull:.3g} N"),
        (there_is < alone < math.inf, f"the stance foot needs friction {written_out(alone)}, {ground}"),
        (there_is < landing < math.inf,
         f"the impulse on the landing foot needs friction {written_out(landing)}, {ground}"),
        (landing == math.inf, "the ground would have to pull the landing foot at heel strike"))
    conditions = (
        (validity.deepest_scuff > 0.0, "it has stepping blocks or feet that retract, as the swing foot passes "
         f"{written_out(1e3 * validity.deepest_scuff, 2)} mm below ground"),
        (pulled, "the trailing foot may lift at heel strike, as the ground would have to pull it"),
        ((trailing > there_is or outside > 0.0) and not pulled, f"the trailing foot may slip, as {why}"))
    for verdict, rows in ((DOES_NOT, against), (WALKS_IF, conditions)):
        if because := tuple(sentence for holds, sentence in rows if holds):
            return OnARamp(verdict, because)
    return OnARamp(WALKS, ())
