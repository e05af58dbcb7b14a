"""What the error budget hands on: contributions that add up to the difference of the models, and what they rest on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from stages.biped.quantity import GIVEN, quantity
from stages.studies.result import COMPLETED, EngineAgreement, Table, shown

CREEP, IMPACT = "creep below v_s", "impact of finite stiffness"
#: Effects of penalty contact in the order in which the path switches them on; then the same path backwards.
CONTACT = (CREEP, IMPACT)

SLIP, UNEXPLAINED = "trailing foot slips", "unexplained"
INTEGRATION_CONSTRAINT, INTEGRATION_PENALTY = "integration, constraint model", "integration, penalty model"
#: All contributions, in the order in which results hold them.
EFFECTS = (INTEGRATION_CONSTRAINT, SLIP, UNEXPLAINED, *CONTACT, INTEGRATION_PENALTY)
#: Columns of a curve.
POSITION, VELOCITY = slice(0, 2), slice(2, 4)
#: Each for itself: hip x, y and their rates.
EACH = tuple(slice(column, column + 1) for column in range(4))
#: Columns of the hip's motion in words.
HIP = ("x", "y", "x'", "y'")
#: The order in the share in which an effect vanishes.
ORDER = 1


def orders(parts: np.ndarray, interaction: np.ndarray) -> np.ndarray:
    """Contributions (6, ...) with creep switched on first, and with the impact first: (2, 6, ...)."""
    both = np.stack([parts, parts])
    both[:, EFFECTS.index(CREEP)] += np.stack([interaction, -interaction])
    both[:, EFFECTS.index(IMPACT)] -= np.stack([interaction, -interaction])
    return both


@dataclass(frozen=True)
class Split:
    """Contributions of `EFFECTS`, in their order, to the difference penalty model minus constraint model.

    What an effect of contact does depends on whether the other is on. `parts` has the mean over both orders (for two
    effects Shapley's value); creep switched on first has `interaction` more, switched on last as much less, and the
    impact the opposite.
    """

    parts: np.ndarray = quantity("m, m/s", "contributions to hip x, y and their rates, shape (6, n, 4)")
    interaction: np.ndarray = quantity("m, m/s", "what creep has more where it is switched on first, shape (n, 4)")
    compared: np.ndarray = quantity("1", "where velocities are compared: outside of impacts, shape (n,)")

    @property
    def total(self) -> np.ndarray:
        """The whole difference, (n, 4)."""
        return np.asarray(self.parts.sum(axis=0))

    @property
    def orders(self) -> np.ndarray:
        """Contributions with creep switched on first, and with the impact first: (2, 6, n, 4)."""
        return orders(self.parts, self.interaction)

    def part(self, effect: str) -> np.ndarray:
        """The contribution of one effect, (n, 4)."""
        return np.asarray(self.parts[EFFECTS.index(effect)])

    def interval(self, effect: str) -> tuple[np.ndarray, np.ndarray]:
        """Least and largest contribution of an effect over both orders, (n, 4) each."""
        first, last = self.orders[:, EFFECTS.index(effect)]
        return np.minimum(first, last), np.maximum(first, last)

    def _rows(self, curve: np.ndarray, columns: slice) -> np.ndarray:
        return curve[self.compared if columns.start >= VELOCITY.start else slice(None), columns]

    def rms(self, curve: np.ndarray, columns: slice) -> float:
        """Rms of a curve (n, 4) over the columns together."""
        return float(np.sqrt((self._rows(curve, columns) ** 2).sum(axis=1).mean()))

    def along(self, curve: np.ndarray, columns: slice) -> float:
        """What a curve (n, 4) has of the rms of the whole: its mean product with it over that. Adds up as curves do."""
        product = (self._rows(curve, columns) * self._rows(self.total, columns)).sum(axis=1).mean()
        return float(product) / self.rms(self.total, columns)

    def peak(self, curve: np.ndarray, columns: slice) -> float:
        """Largest magnitude of a curve (n, 4) in the columns."""
        return float(np.abs(self._rows(curve, columns)).max())

    def explained(self, columns: slice) -> float:
        """Share of the rms difference that is explained: 1 - rms(unexplained) / rms(total)."""
        whole = self.rms(self.total, columns)
        return 1.0 - self.rms(self.part(UNEXPLAINED), columns) / whole if whole > 0.0 else float("nan")


def split_of(parts: np.ndarray, interaction: np.ndarray, compared: np.ndarray) -> Split:
    """Contributions (6, n, 4) and the part of the order in them (n, 4), with velocities where they are `compared`: at a
    strike, which a solver finds on either side of a sample, they are before it or after it."""
    shown = compared[:, None] | (np.arange(VELOCITY.stop) < VELOCITY.start)
    return Split(np.where(shown, parts, np.nan), np.where(shown, interaction, np.nan), compared)


def rms_of_columns(curve: np.ndarray, compared: np.ndarray) -> np.ndarray:
    """Rms of each column of a curve (n, 4), of rates where `compared` (n,): (4,)."""
    return np.sqrt([(curve[compared if column >= 2 else slice(None), column] ** 2).mean() for column in range(4)])


def telescoped(values: Sequence[np.ndarray]) -> np.ndarray:
    """Differences of successive values along a path: they add up to the last less the first."""
    return np.array([after - before for before, after in pairwise(values)])


class Shares(NamedTuple):
    """An outcome with four times, twice and once the share, of one shape each: its limit, and how that is checked.

    Every length and every speed of contact that is switched off is the part s of its size, so f(s) = f(0) + a s + b s^2
    and f(0) = (8 f(s) - 6 f(2 s) + f(4 s)) / 3 (Richardson and Gaunt, 1927). Two numbers check that: the order that
    three shares show, and how far the last share is from what the other two predict.
    """

    far: np.ndarray
    middle: np.ndarray
    near: np.ndarray

    @property
    def limit(self) -> np.ndarray:
        """The outcome for a share of zero; what is left in the first two orders cancels."""
        return np.asarray((8.0 * self.near - 6.0 * self.middle + self.far) / 3.0)

    @property
    def predicted(self) -> np.ndarray:
        """The last share from the other two, by the first order."""
        return np.asarray(self.middle + (self.middle - self.far) / 2.0**ORDER)


@dataclass(frozen=True)
class Convergence:
    """How limits are approached: rows with both effects off, impact off, creep off, columns as in a curve."""

    share: float = quantity("1", "the last share", symbol="s", without_error=GIVEN)
    order: np.ndarray = quantity("1", "order in the share that three shares show in the rms, shape (3, 4)")
    missed: np.ndarray = quantity("m, m/s", "rms of the last share less what the other two predict, shape (3, 4)")

    @classmethod
    def of(cls, share: float, curves: Sequence[Shares], compared: np.ndarray) -> Convergence:
        """From curves (n, 4) of the hip, of which rates are compared where `compared` (n,) says so."""
        rms = partial(rms_of_columns, compared=compared)
        order = np.log2([rms(far - middle) / rms(middle - near) for far, middle, near in curves])
        return cls(share, order, np.array([rms(shares.near - shares.predicted) for shares in curves]))


@dataclass(frozen=True)
class StepBudget:
    """The difference of the hip's motion over one step from the same mid-stance state."""

    time: np.ndarray = quantity("s", "time from mid-stance, shape (n,)", symbol="t")
    split: Split = quantity("-", "contributions to the hip's motion")
    convergence: Convergence = quantity("-", "how the limits of the effects of contact are approached")
    paper_integration: np.ndarray = quantity(
        "m, m/s", "largest integration errors of constraint model and Exudyn's at the paper's tolerances, (2, 4)"
    )


@dataclass(frozen=True)
class CycleBudget:
    """The difference between converged cycles at equal phase over one stride from heel strike."""

    phase: np.ndarray = quantity("1", "phase of the stride, shape (n,)")
    split: Split = quantity("-", "contributions to the hip's motion")
    scalars: np.ndarray = quantity("s, m", "contributions to step period and step length, shape (6, 2)")
    scalar_interaction: np.ndarray = quantity("s, m", "what creep has more where it is switched on first, shape (2,)")
    convergence: Convergence = quantity("-", "how the limits of the effects of contact are approached")
    constraint_scalars: np.ndarray = quantity("s, m", "period and length of the constraint model's step, shape (2,)")

    @property
    def scalar_orders(self) -> np.ndarray:
        """Contributions with creep switched on first, and with the impact first: (2, 6, 2)."""
        return orders(self.scalars, self.scalar_interaction)


@dataclass(frozen=True)
class Result:
    """What the difference between the constraint model and the penalty model is made of."""

    outcome: str = quantity("-", "completed, or why a model on the path did not walk")
    step: StepBudget | None = quantity("-", "over one step; empty if a model did not walk")
    cycle: CycleBudget | None = quantity("-", "between cycles; empty if a model did not walk")
    engines: EngineAgreement | None = quantity(
        "-", "what the engine changes: the compiled penalty walker less Exudyn's model; empty if a model did not walk"
    )

    def known(self) -> list[tuple[str, StepBudget | CycleBudget]]:
        """The budgets there are, with their names."""
        both = (("one step", self.step), ("cycles", self.cycle))
        return [(name, budget) for name, budget in both if budget is not None]

    def summary(self) -> str:
        """Shares explained, in one line."""
        parts = [
            f"{100 * budget.split.explained(POSITION):.1f} % of the hip's displacement and "
            f"{100 * budget.split.explained(VELOCITY):.1f} % of its velocity explained over {name}"
            for name, budget in self.known()
        ]
        said = "; ".join(parts if self.outcome == COMPLETED else [*parts, self.outcome])
        return said if self.engines is None else f"{said}. All are from one engine, {self.engines.sentence()}"

    def tables(self) -> tuple[Table, ...]:
        """Contributions to the hip's motion and to the cycle's scalars, and what they rest on."""
        tables = [_contributions(name, budget) for name, budget in self.known()]
        tables += [_trust(self.known())] if tables else []
        return tuple(tables if self.engines is None else [*tables, self.engines.table()])


def _contributions(name: str, budget: StepBudget | CycleBudget) -> Table:
    """What each effect does to the hip's motion, and to the step's end or the cycle's scalars in either order."""
    split = budget.split
    if isinstance(budget, StepBudget):
        heads, ends, both = ["end x mm"], split.parts[:, -1, :1], split.orders[:, :, -1, :1]
    else:
        heads, ends, both = ["T ms", "s mm"], budget.scalars, budget.scalar_orders
    rows = [
        (effect, *_sizes(split, part), *_either(end, way))
        for effect, part, end, way in zip(EFFECTS, split.parts, ends, both.swapaxes(0, 1))
    ]
    total = [word for value in shown(*(1e3 * ends.sum(axis=0))) for word in (value, "")]
    columns = [column for head in heads for column in (head, f"{head}, either order")]
    return (
        f"Penalty minus constraint model, {name}",
        ("", "rms mm", "peak mm", "rms mm/s", "peak mm/s", *columns),
        [*rows, ("total", *_sizes(split, split.total), *total)],
    )


def _trust(known: Sequence[tuple[str, StepBudget | CycleBudget]]) -> Table:
    """What of the budgets is explained, and how effects vanish with their share."""
    rows: list[tuple[object, ...]] = []
    for name, budget in known:
        split, found = budget.split, budget.convergence
        whole = np.array([split.rms(split.total, column) for column in EACH])
        rows.append((f"{name}: total, rms in mm and mm/s", *shown(*(1e3 * whole))))
        rows.append((f"{name}: explained, %", *shown(*(100 * split.explained(column) for column in EACH))))
        for limit, order, missed in zip(("both", *reversed(CONTACT)), found.order, found.missed):
            rows.append((f"{name}: order in the share, {limit} off", *shown(*order)))
            percent = shown(*(100 * missed / whole))
            rows.append((f"{name}: share {found.share:g} not predicted, %, {limit} off", *percent))
    return "What is explained, and how effects vanish with their share", ("", *HIP), rows


def _either(mean: np.ndarray, ways: np.ndarray) -> list[object]:
    """Means, each followed by its values in both orders where they differ; in thousandths."""
    cells: list[object] = []
    for value, both in zip(1e3 * mean, 1e3 * ways.T):
        least, most = shown(both.min(), both.max())
        cells += [*shown(value), "" if both[0] == both[1] else f"{least:g} to {most:g}"]
    return cells


def _sizes(split: Split, part: np.ndarray) -> tuple[float, ...]:
    """Rms and peak of a contribution in mm, then in mm/s."""
    return shown(*(1e3 * size(part, columns) for columns in (POSITION, VELOCITY) for size in (split.rms, split.peak)))
