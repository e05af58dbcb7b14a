"""What the study of speed against accuracy hands on."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from stages.biped.quantity import count_of, quantity
from stages.studies.result import COMPLETED, Table

#: Names of the errors, in the order of tables and panels.
ERRORS = ("hip_position", "period", "multiplier", "peak_force")


@dataclass(frozen=True)
class Errors:
    """Differences from a reference; NaN where not measured."""

    hip_position: float = quantity("m", "largest distance of the hip over the walk")
    period: float = quantity("s", "difference of the last step's duration")
    multiplier: float = quantity("1", "difference of the leading multiplier's magnitude")
    peak_force: float = quantity("N", "difference of the largest normal force on a foot")


UNKNOWN = Errors(*[math.nan] * 4)


@dataclass(frozen=True)
class Row:
    """One way at one setting: its errors and its cost."""

    model: str = quantity("-", "model")
    way: str = quantity("-", "how it is integrated")
    setting: str = quantity("-", "tolerance and steps [s]")
    mark: str = quantity("-", "paper: the paper's own setting or what stands in for it; default: this study's")
    outcome: str = quantity("-", "completed, or why it did not get to the end of the walk")
    errors: Errors = quantity("-", "differences from the model's reference, no smaller than what that is unsure of")
    evaluations: float = quantity(
        "1", "evaluations of the rates, or of an implicit step's residual, for one step; a linear solve goes with each")
    tolerance: float = quantity("1", "tolerance; NaN for fixed steps")
    largest_step: float = quantity("s", "largest step, or rolling step of fixed steps; NaN if the way has none")
    doubt: Errors = quantity("-", "what the reference may be off by; errors as large are at most so", default=UNKNOWN)

    @property
    def completed(self) -> bool:
        """Whether it walked to the end."""
        return self.outcome == COMPLETED


@dataclass(frozen=True)
class Reference:
    """What a model's errors are taken against, and why that is converged."""

    model: str = quantity("-", "model")
    way: str = quantity("-", "way and setting of the reference")
    period: float = quantity("s", "last step's duration")
    multiplier: float = quantity("1", "leading multiplier's magnitude; NaN if not measured")
    peak_force: float = quantity("N", "largest normal force on a foot")
    second: str = quantity("-", "the second tightest setting of the same way")
    second_differs: Errors = quantity("-", "by how much the second differs")
    independent: str = quantity("-", "another way, or none")
    independent_differs: Errors = quantity("-", "by how much the other way differs")


@dataclass(frozen=True)
class Result:
    """Work and precision of all ways, model by model."""

    walked_steps: int = quantity("1", "steps of each walk")
    references: tuple[Reference, ...] = quantity("-", "one a model")
    rows: tuple[Row, ...] = quantity("-", "all ways of all models")

    def summary(self) -> str:
        """What was found, in one line."""
        failed = sum(not row.completed for row in self.rows)
        said = f", {failed} without a walk" if failed else ""
        models = count_of(len(self.references), "model")
        return f"{len(self.rows)} settings of {models} over {self.walked_steps} steps{said}"

    def tables(self) -> list[Table]:
        """References and rows as (title, columns, rows of text)."""
        names = ["hip [m]", "period [s]", "multiplier [1]", "peak force [N]"]
        shown = [[reference.model, which, *cells(errors)] for reference in self.references for which, errors in (
            (f"{reference.way} against {reference.second}", reference.second_differs),
            (f"against {reference.independent}", reference.independent_differs))]
        rows = [[row.model, row.way, row.setting, row.mark, *cells(row.errors, row.doubt), f"{row.evaluations:.0f}",
                 "" if row.completed else row.outcome] for row in self.rows]
        return [("References and what shows them converged", ["model", "reference", *names], shown),
                ("Ways: errors and evaluations for one step",
                 ["model", "way", "setting", "", *names, "evaluations", "failed because"], rows)]


def cells(errors: Errors, doubt: Errors = UNKNOWN) -> list[str]:
    """Errors as text, a dash where not measured, and < where the reference is no surer."""
    return [f"{'< ' * (value <= getattr(doubt, name))}{value:.1e}" if math.isfinite(value) else "-"
            for name in ERRORS for value in [getattr(errors, name)]]  # fmt: skip


def front(rows: Sequence[Row], costs: Sequence[float], error: str) -> list[int]:
    """Indices of the rows that no other beats in both cost and this error, cheapest first."""
    usable = [i for i, row in enumerate(rows) if row.completed and math.isfinite(getattr(row.errors, error))]
    best, found = math.inf, []
    for i in sorted(usable, key=lambda i: (costs[i], getattr(rows[i].errors, error))):
        if getattr(rows[i].errors, error) < best:
            best = getattr(rows[i].errors, error)
            found.append(i)
    return found


def gain(rows: Sequence[Row], model: str, costs: Sequence[float]) -> float:
    """Cost of the paper's setting over that of the default's way at the same hip error; NaN without both.

    The default's way is taken at the tolerance at which it has the paper's error: costs between two settings are
    interpolated, in logarithms. Where even its loosest setting is more accurate, its cost counts.
    """
    mine = [(row, cost) for row, cost in zip(rows, costs) if row.model == model and row.completed]
    paper = [(row, cost) for row, cost in mine if "paper" in row.mark]
    way = {row.way for row, _ in mine if "default" in row.mark}
    if not paper or not way or paper[0][0].way in way:
        return math.nan
    ours = sorted((row.errors.hip_position, cost) for row, cost in mine if row.way in way)
    return paper[0][1] / cost_at(ours, paper[0][0].errors.hip_position)


def cost_at(points: Sequence[tuple[float, float]], error: float) -> float:
    """Least cost of reaching an error, from (error, cost) of one way; NaN if none does."""
    inside = min((point for point in points if point[0] <= error), key=lambda point: point[1], default=None)
    if inside is None:
        return math.nan
    outside = min((point for point in points if point[0] > error and point[1] < inside[1]), default=None)
    if outside is None:
        return inside[1]
    share = math.log(error / inside[0]) / math.log(outside[0] / inside[0])
    return float(inside[1] * (outside[1] / inside[1]) ** share)
