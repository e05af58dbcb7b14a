"""What the error budget hands on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stages.biped.quantity import quantity
from stages.engines.result import EngineAgreement
from stages.error_budget.convergence import Convergence
from stages.error_budget.effects import CONTACT, EFFECTS
from stages.error_budget.split import EACH, POSITION, VELOCITY, Split, orders

COMPLETED = "completed"
#: Columns of the hip's motion in words.
HIP = ("x", "y", "x'", "y'")


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
            f"{name}: {100 * budget.split.explained(POSITION):.1f} % of the hip's displacement and "
            f"{100 * budget.split.explained(VELOCITY):.1f} % of its velocity explained"
            for name, budget in self.known()
        ]
        if self.engines is not None:
            parts.append(f"all contributions from one engine, {self.engines.sentence()}")
        return "; ".join(parts if self.outcome == COMPLETED else [*parts, self.outcome])

    def tables(self) -> tuple[tuple[str, tuple[str, ...], list[tuple[object, ...]]], ...]:
        """Contributions to the hip's motion and to the cycle's scalars, and what they rest on."""
        tables: list[tuple[str, tuple[str, ...], list[tuple[object, ...]]]] = []
        sizes = ("", "rms mm", "peak mm", "rms mm/s", "peak mm/s")
        heads: tuple[str, ...]
        for name, budget in self.known():
            if isinstance(budget, StepBudget):
                heads, ends, both = ("end x mm",), budget.split.parts[:, -1, :1], budget.split.orders[:, :, -1, :1]
            else:
                heads, ends, both = ("T ms", "s mm"), budget.scalars, budget.scalar_orders
            columns = [column for head in heads for column in (head, f"{head}, either order")]
            rows = [
                (effect, *_sizes(budget.split, part), *_either(end, way))
                for effect, part, end, way in zip(EFFECTS, budget.split.parts, ends, both.swapaxes(0, 1))
            ]
            sums = [_short(1e3 * value) for value in ends.sum(axis=0)]
            total = [word for value in sums for word in (value, "")]
            rows.append(("total", *_sizes(budget.split, budget.split.total), *total))
            tables.append((f"Penalty minus constraint model, {name}", (*sizes, *columns), rows))
        if tables:
            tables.append(self._trust())
        if self.engines is not None:
            tables.append(self.engines.table())
        return tuple(tables)

    def _trust(self) -> tuple[str, tuple[str, ...], list[tuple[object, ...]]]:
        rows: list[tuple[object, ...]] = []
        for name, budget in self.known():
            split, found = budget.split, budget.convergence
            whole = np.array([split.rms(split.total, column) for column in EACH])
            rows.append((f"{name}: total, rms in mm and mm/s", *(_short(1e3 * size) for size in whole)))
            rows.append((f"{name}: explained, %", *(_short(100 * split.explained(column)) for column in EACH)))
            for limit, order, missed in zip(("both", *reversed(CONTACT)), found.order, found.missed):
                rows.append((f"{name}: order in the share, {limit} off", *(_short(value) for value in order)))
                percent = 100 * missed / whole
                rows.append((f"{name}: share {found.share:g} not foretold, %, {limit} off", *map(_short, percent)))
        return "What is explained, and how effects vanish with their share", ("", *HIP), rows


def _either(mean: np.ndarray, ways: np.ndarray) -> list[object]:
    """Means, each followed by its values in both orders where they differ; in thousandths."""
    cells: list[object] = []
    for value, both in zip(1e3 * mean, 1e3 * ways.T):
        cells += [_short(value), "" if both[0] == both[1] else f"{_short(both.min()):g} to {_short(both.max()):g}"]
    return cells


def _sizes(split: Split, part: np.ndarray) -> tuple[float, ...]:
    return tuple(
        _short(1e3 * size(part, columns)) for columns in (POSITION, VELOCITY) for size in (split.rms, split.peak)
    )


def _short(value: float) -> float:
    return float(f"{value:.3g}")
