"""Whether a gait of the constraint model walks on a plain ramp: its ground pulls nothing, slips, and has no holes."""

from __future__ import annotations

from dataclasses import dataclass

from stages.analytic.result import ROUND_OFF, Validity
from stages.biped.quantity import quantity

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
        return f"{DOES_NOT} on a plain ramp: {'; '.join(self.because)}"


def on_a_ramp(validity: Validity, stable: bool) -> OnARamp:
    """Judge a gait by what it asks of the ground.

    The model holds the foot that bears the robot whatever that takes: ground that cannot ends the gait. What it asks
    under the trailing foot, which is about to leave, and below ground in mid-swing can be had in other ways.
    """
    there_is, pull = validity.friction_there_is * (1.0 + ROUND_OFF), min(0.0, validity.least_normal_force_stance)
    against = [] if stable else ["a step enlarges what disturbs it"]
    if pull < 0.0:
        against.append(f"the ground would have to pull the stance foot with {-pull:.3g} N")
    for needed, where in ((validity.friction_single_stance, "the stance foot"),
                          (validity.impulse_friction_landing, "the impulse on the landing foot")):  # fmt: skip
        if needed > there_is:
            against.append(f"{where} needs friction {needed:.3g}, the ground has {validity.friction_there_is:.3g}")
    trailing, pulled = validity.impulse_friction_trailing, validity.impulse_normal_trailing < 0.0
    conditions = []
    if validity.deepest_scuff > 0.0:
        conditions.append(f"it has stepping blocks or feet that retract, as the swing foot passes "
                          f"{1e3 * validity.deepest_scuff:.2g} mm below ground")  # fmt: skip
    if pulled:
        conditions.append("the trailing foot may lift at heel strike, as the ground would have to pull it")
    elif trailing > there_is or validity.time_outside_cone > 0.0:
        conditions.append(f"the trailing foot may slip, as the impulse there needs friction {trailing:.3g} and the "
                          f"ground has {validity.friction_there_is:.3g}")  # fmt: skip
    return OnARamp(DOES_NOT, tuple(against)) if against else (
        OnARamp(WALKS_IF, tuple(conditions)) if conditions else OnARamp(WALKS, ()))
