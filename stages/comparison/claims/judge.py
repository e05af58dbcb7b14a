"""From what was measured to the claims: each sentence of the paper with its four parts."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable

from stages.comparison.claims.accuracy.number import Number
from stages.comparison.claims.accuracy.numerical_error import numbers, other_verdicts
from stages.comparison.claims.applies import OF_THE_METHOD, another_biped, rests_on
from stages.comparison.claims.measured import Measured, Unmeasured
from stages.comparison.claims.paper import BIPED, SAYS
from stages.comparison.claims.verdict import DOES_NOT_APPLY, OPEN, UNDECIDED, UNKNOWN, Cause, Judgement
from stages.comparison.parameters import Parameters
from stages.comparison.result import Claim


def judge(parameters: Parameters, measured: Iterable[Measured | Unmeasured]) -> tuple[Claim, ...]:
    """A claim for all that was measured, in its order. Claims on the paper's biped are not judged for another one."""
    return tuple(judged(parameters, one) for one in measured)


def judged(parameters: Parameters, measured: Measured | Unmeasured) -> Claim:
    """One claim; what was not measured stays open. Numbers whose errors are unknown are judged as if they had none, and
    that is said.
    """
    known: tuple[Number, ...] = ()
    others: tuple[tuple[Number, str], ...] = ()
    if isinstance(measured, Unmeasured):
        about = measured.claim
        judgement = Judgement(f"nothing: {measured.why}", OPEN, (Cause(True, measured.why),))
    else:
        about, judgement = type(measured), measured.judge(parameters.settings)
        known = numbers(measured, parameters)
        others = tuple(other_verdicts(measured, parameters.settings, known))
    beside = UNKNOWN if any(math.isnan(one.error) for one in known if math.isfinite(one.value)) else ""
    says, verdict, condition, causes = SAYS[about.ID], judgement.verdict, judgement.condition, judgement.reasons
    for number, other in others:
        verdict, condition = UNDECIDED, ""
        causes = (*causes, f"{number.name.replace('_', ' ')} = {number.value:.4g} has a numerical error of "
                           f"{number.error:.1g}, within which the verdict could also be: {other}")  # fmt: skip
    differing = another_biped(parameters, OF_THE_METHOD if about.METHOD else BIPED)
    if differing:
        verdict, condition, beside = DOES_NOT_APPLY, "", ""
        causes = (f"this is another biped than the sentence is about: {'; '.join(differing)}",)
    return Claim(
        id=about.ID,
        section=says.section,
        words=says.words,
        implies=says.implies,
        measured=re.sub(r"[-+]?\bnan\b", "?", judgement.measured),  # a number that is not known
        verdict=verdict,
        condition=condition,
        beside=beside,
        causes=causes,
        rests_on=rests_on(parameters, about.RESTS_ON),
        numbers=known,
    )
