"""What the error budget hands on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stages.biped.quantity import quantity
from stages.error_budget.effects import COMPLIANCE, EFFECTS, RAMP
from stages.error_budget.split import POSITION, VELOCITY, Split

COMPLETED = "completed"


@dataclass(frozen=True)
class StepBudget:
    """The difference of the hip's motion over one step from the same mid-stance state."""

    time: np.ndarray = quantity("s", "time from mid-stance, shape (n,)", symbol="t")
    split: Split = quantity("-", "effects of contact switched on in the order of EFFECTS")
    reverse: Split = quantity("-", "the same with the effects of contact switched on in reverse order")
    paper_integration: np.ndarray = quantity(
        "m, m/s", "largest integration errors of constraint and penalty model at the paper's tolerances, (2, 4)"
    )


@dataclass(frozen=True)
class CycleBudget:
    """The difference between converged cycles at equal phase over one stride from heel strike."""

    phase: np.ndarray = quantity("1", "phase of the stride, shape (n,)")
    split: Split = quantity("-", "effects of contact switched on in the order of EFFECTS")
    scalars: np.ndarray = quantity(
        "s, m, 1, 1",
        "contributions to step period, step length, leading and second multiplier (real parts), shape (7, 4)",
    )
    constraint_scalars: np.ndarray = quantity("s, m, 1, 1", "those of the constraint model's cycle, shape (4,)")


@dataclass(frozen=True)
class Result:
    """What the difference between the constraint model and the penalty model is made of."""

    outcome: str = quantity("-", "completed, or why a model on the path did not walk")
    step: StepBudget | None = quantity("-", "over one step; empty if a model did not walk")
    cycle: CycleBudget | None = quantity("-", "between cycles; empty if a model did not walk")

    def summary(self) -> str:
        """Shares explained, in one line."""
        parts = [
            f"{name}: {100 * budget.split.explained(POSITION):.1f} % of the hip's displacement and "
            f"{100 * budget.split.explained(VELOCITY):.1f} % of its velocity explained"
            for name, budget in (("one step", self.step), ("cycles", self.cycle))
            if budget is not None
        ]
        return "; ".join(parts if self.outcome == COMPLETED else [*parts, self.outcome])

    def tables(self) -> tuple[tuple[str, tuple[str, ...], list[tuple[object, ...]]], ...]:
        """Contributions to the hip's motion and to the cycle's scalars."""
        tables: list[tuple[str, tuple[str, ...], list[tuple[object, ...]]]] = []
        if self.step is not None:
            columns = ("", "rms mm", "peak mm", "rms mm/s", "peak mm/s", "end x mm", "end x mm, reverse order")
            ends = 1e3 * self.step.split.parts[:, -1, 0], 1e3 * self.step.reverse.parts[:, -1, 0]
            rows = [
                (name, *_sizes(self.step.split, part), _short(end), _short(back))
                for name, part, end, back in zip(EFFECTS, self.step.split.parts, *ends)
            ]
            both = [EFFECTS.index(effect) for effect in (COMPLIANCE, RAMP)]
            together = self.step.split.parts[both].sum(axis=0)
            last = [_short(values[both].sum()) for values in ends]
            rows.append((f"{COMPLIANCE} and {RAMP}", *_sizes(self.step.split, together), *last))
            rows.append(_last_row(self.step.split, *(_short(values.sum()) for values in ends)))
            tables.append(("Hip over one step, penalty minus constraint model", columns, rows))
        if self.cycle is not None:
            heads = ("", "rms mm", "peak mm", "rms mm/s", "peak mm/s", "T ms", "s mm", "multiplier", "second")
            units = np.array([1e3, 1e3, 1.0, 1.0])
            rows = [
                (name, *_sizes(self.cycle.split, part), *(_short(value) for value in units * scalars))
                for name, part, scalars in zip(EFFECTS, self.cycle.split.parts, self.cycle.scalars)
            ]
            sums = units * self.cycle.scalars.sum(axis=0)
            rows.append(_last_row(self.cycle.split, *(_short(value) for value in sums)))
            tables.append(("Cycles at equal phase over a stride, penalty minus constraint model", heads, rows))
        return tuple(tables)


def _last_row(split: Split, *more: object) -> tuple[object, ...]:
    return ("total", *_sizes(split, split.total), *more)


def _sizes(split: Split, part: np.ndarray) -> tuple[float, ...]:
    return tuple(
        _short(1e3 * size(part, columns)) for columns in (POSITION, VELOCITY) for size in (split.rms, split.peak)
    )


def _short(value: float) -> float:
    return float(f"{value:.3g}")
