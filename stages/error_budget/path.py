"""The path from the constraint model to the penalty model, one effect at a time, and the limits on it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from stages.error_budget.convergence import Convergence, Shares
from stages.error_budget.effects import CONTACT, switched
from stages.error_budget.split import telescoped
from stages.ground.contact_law import ContactLaw

#: What a model gives, as an array of one shape: the hip's curves, or a cycle's scalars beside them.
Outcome = np.ndarray
#: Effects that are on where others are in their limit.
LIMITS: tuple[frozenset[str], ...] = (frozenset(), *(frozenset({effect}) for effect in CONTACT))


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
        self.shares: dict[frozenset[str], Shares] = {}
        self.whole: Outcome | None = None

    def at(self, on: frozenset[str]) -> Outcome:
        """Outcome with the effects `on`, the others in their limit."""
        if on == frozenset(CONTACT):
            if self.whole is None:
                self.whole = self.outcome(self.law, self.tolerance)
            return self.whole
        if on not in self.shares:
            self.shares[on] = Shares(
                *(self.outcome(switched(self.law, on, part * self.share), self.limit_tolerance) for part in (4, 2, 1))
            )
        return self.shares[on].limit

    def convergence(self, curves: Callable[[Outcome], Outcome], compared: np.ndarray) -> Convergence:
        """How the limits were approached; `curves` takes the hip (n, 4) out of an outcome."""
        shares = [Shares(*(curves(outcome) for outcome in self.shares[on])) for on in LIMITS]
        return Convergence.of(self.share, shares, compared)


def contributions(
    constraint: Outcome, fine: Outcome, coulomb: Outcome, limits: Limits, fine_penalty: Outcome
) -> tuple[np.ndarray, np.ndarray]:
    """Contributions in the order of `EFFECTS` (6, ...), and how they depend on which effect of contact is first (...).

    The path: constraint model; integrated finely; with Coulomb friction at the trailing foot; penalty model with both
    effects of contact in their limits; each switched on; integrated as it is. `fine_penalty` has both on. The effects
    of contact have the mean over both orders; what comes second is half the difference, see `Split`.
    """
    neither, creep, impact = (limits.at(on) for on in LIMITS)
    whole = limits.at(frozenset(CONTACT))
    first, last = (telescoped([neither, node, fine_penalty]) for node in (creep, impact))
    steps = telescoped([constraint, fine, coulomb, neither])
    mean = 0.5 * (first + last[::-1])
    return np.concatenate([steps, mean, [whole - fine_penalty]]), 0.5 * (first[0] - last[1])
