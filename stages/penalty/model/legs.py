"""The legs of either kind of walker: whose numbers they are, and the derived functions of these."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from stages.analytic.compiled import ByKind, Numbers
from stages.analytic.model.made import EQUATIONS, Made, OfSets, derived
from stages.biped.machine_code import Kept, sympy_version
from stages.penalty.compiled import FOLDER, compiled
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
LEGS = Kept(f"legs-{sympy_version()}", FOLDER / "model", by=EQUATIONS.stamp)


def by_sympy(name: str) -> Callable[[], str]:
    """What makes the text of the functions of a kind of leg."""
    from stages.penalty.model.generate import KINDS, module_source

    return partial(module_source, KINDS[name])


SETS = {kinds: Made(f"{__name__}.{name}", partial(derived, LEGS, name, by_sympy))
        for kinds, name in ((Penalty, "plain"), (LegNumbers, "detailed"))}  # fmt: skip
leg_terms: Callable[..., Numbers] = OfSets("leg_terms", SETS)
leg_jacobian: Callable[..., Numbers] = OfSets("leg_jacobian", SETS)
leg_by: Callable[..., Numbers] = OfSets("leg_by", SETS)
leg_change: Callable[..., Numbers] = OfSets("leg_change", SETS)
