"""The legs of either kind of walker: whose numbers they are, and the generated functions of these."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from stages.analytic.compiled import ByKind, Numbers
from stages.penalty.compiled import compiled
from stages.penalty.model.equations import detailed, plain
from stages.penalty.model.walker import DetailedPenalty, LegNumbers, Penalty


@compiled
def numbers_of_both(p: Penalty, leg: int) -> Penalty:
    """`leg_of` of Table 1's walker, whose legs are alike."""
    return p


@compiled
def numbers_of_one(p: DetailedPenalty, leg: int) -> LegNumbers:
    """`leg_of` of a detailed walker."""
    return p.first if leg == 0 else p.other


#: The numbers of a leg: leg_of(p, leg).
leg_of: Callable[..., Any] = ByKind({Penalty: numbers_of_both, DetailedPenalty: numbers_of_one})
leg_terms: Callable[..., Numbers] = ByKind({Penalty: plain.leg_terms, LegNumbers: detailed.leg_terms})
leg_jacobian: Callable[..., Numbers] = ByKind({Penalty: plain.leg_jacobian, LegNumbers: detailed.leg_jacobian})
leg_by: Callable[..., Numbers] = ByKind({Penalty: plain.leg_by, LegNumbers: detailed.leg_by})
leg_change: Callable[..., Numbers] = ByKind({Penalty: plain.leg_change, LegNumbers: detailed.leg_change})
