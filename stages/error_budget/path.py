"""The path from the constraint model to the penalty model, one effect at a time, and the limits on it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from stages.error_budget.effects import CONTACT, EFFECTS, switched
from stages.error_budget.split import telescoped
from stages.ground.contact_law import ContactLaw

#: What a model gives, as an array of one shape: the hip's curves, or a cycle's scalars beside them.
Outcome = np.ndarray


class Limits:
    """The penalty model with some effects on and the others in their limit; every node is computed once.

    `outcome` walks with a contact law at a tolerance; `share` is the part left of an effect that is off.
    """

    def __init__(
        self,
        law: ContactLaw,
        share: float,
        outcome: Callable[[ContactLaw, float], Outcome],
        tolerance: float,
        limit_tolerance: float,
    ) -> None:
        self.law, self.share, self.outcome = law, share, outcome
        self.tolerance, self.limit_tolerance = tolerance, limit_tolerance
        self.known: dict[frozenset[str], Outcome] = {}

    def at(self, on: frozenset[str]) -> Outcome:
        """Outcome with the effects `on`: 2 f(s) - f(2 s), in which what is left in first order of s cancels."""
        if on not in self.known:
            if on == frozenset(CONTACT):
                self.known[on] = self.outcome(self.law, self.tolerance)
            else:
                far = self.outcome(switched(self.law, on, 2.0 * self.share), self.limit_tolerance)
                near = self.outcome(switched(self.law, on, self.share), self.limit_tolerance)
                self.known[on] = 2.0 * near - far
        return self.known[on]


def contributions(
    constraint: Outcome, fine: Outcome, coulomb: Outcome, limits: Limits, fine_penalty: Outcome, order: tuple[str, ...]
) -> np.ndarray:
    """Contributions in the order of `EFFECTS` when the effects of contact are switched on in `order`, (7, ...).

    The path: constraint model; integrated finely; with Coulomb friction at the trailing foot; penalty model with all
    effects of contact in their limits; each effect switched on; integrated as it is. `fine_penalty` has all on.
    """
    on: frozenset[str] = frozenset()
    nodes = [constraint, fine, coulomb, limits.at(on)]
    for effect in order[:-1]:
        on |= {effect}
        nodes.append(limits.at(on))
    steps = telescoped([*nodes, fine_penalty, limits.at(frozenset(CONTACT))])
    names = [*EFFECTS[:3], *order, EFFECTS[-1]]
    return steps[[names.index(effect) for effect in EFFECTS]]
