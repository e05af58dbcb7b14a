"""What the extremes stage hands on: of every point what was tried there and what is said of the answer.

An answer is right, inaccurate, refused, failed, unconfirmed, or wrong without a sign.
"""

import math
import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from stages.biped.quantity import quantity
from stages.extremes.parameters import INACCURATE, RIGHT, STATUSES, WRONG
from stages.studies.result import Table

#: An answer may depart by so many tolerances: errors grow over a step's thousand integration steps and its impact.
GROWTH = 100.0
#: What a table leaves out of a reason, such as the range that was searched.
DETAIL = re.compile(r"^(the reference|no gait to start from): |(?!^)( in the range| found:| \(|: |;).*")


@dataclass(frozen=True)
class Finding:
    """The verdict on one point: distance from the reference and what the model's own audit leaves open."""

    status: str
    error: float = math.nan
    audit: float = math.nan
    reference: str = ""
    reason: str = ""


def judged(error: float, audit: float, requested: float, limit: float, reference: str) -> Finding:
    """Verdict on an answer: `error` is its distance from the reference and `audit` its own energy residual.

    `requested` is the tolerance requested, `limit` the error up to which an answer is called right. NaN as audit: the
    model has none.
    """
    if error <= limit:
        return Finding(RIGHT, error, audit, reference)
    if error <= GROWTH * requested:
        return Finding(INACCURATE, error, audit, reference, f"within {GROWTH:g} times the requested tolerance")
    if audit > limit:
        return Finding(INACCURATE, error, audit, reference, "its own energy audit does not close")
    return Finding(WRONG, error, audit, reference, "the reference contradicts it and nothing shows")


@dataclass(frozen=True)
class Result:
    """The map: a row a point, n rows, sorted by engine and axis."""

    resolution: str = quantity("-", "few, coarse or full")
    engine: tuple[str, ...] = quantity("-", "which model was tried")
    axis: tuple[str, ...] = quantity("-", "what was varied")
    value: np.ndarray = quantity("1", "value on the axis, shape (n,); of draws their number")
    changes: tuple[str, ...] = quantity("-", "parameters changed, by name, as name=value; ...")
    status: tuple[str, ...] = quantity("-", "right, inaccurate, refused, failed, unconfirmed, wrong, crashed or hung")
    error: np.ndarray = quantity("1", "distance from the reference in leg lengths and pendulum times, or NaN, (n,)")
    audit: np.ndarray = quantity("1", "part of the energy turned over that the model's own balance lacks, or NaN, (n,)")
    reference: tuple[str, ...] = quantity("-", "what the answer was checked against")
    reason: tuple[str, ...] = quantity("-", "why it is not right")

    def summary(self) -> str:
        """One line of what was found."""
        count = Counter(self.status)
        parts = ", ".join(f"{count[status]} {status}" for status in STATUSES if count[status])
        return f"{len(self.status)} points ({self.resolution}): {parts}"

    def rows(self) -> Iterator[tuple[str, str, float, str, float, float, str, str]]:
        """Engine, axis, value, status, error, audit, reference, reason of every point."""
        yield from zip(self.engine, self.axis, self.value.tolist(), self.status, self.error.tolist(),
                       self.audit.tolist(), self.reference, self.reason, strict=True)  # fmt: skip

    def tables(self) -> list[Table]:
        """Counts, and for every engine and axis the span that is right, as (title, columns, rows of text)."""
        return [self.counts(), self.spans()]

    def counts(self) -> Table:
        """How many points of every engine have which status."""
        present = [status for status in STATUSES if status in self.status]
        pairs = Counter(zip(self.engine, self.status, strict=True))
        rows = [
            [engine, *(str(pairs[engine, status]) for status in present),
             str(sum(pairs[engine, status] for status in present))]
            for engine in dict.fromkeys(self.engine)
        ]  # fmt: skip
        return "Points by engine", ["engine", *present, "all"], rows

    def spans(self) -> Table:
        """For every engine and axis: values tried, those right, the largest error, and the reasons for the rest."""
        rows = []
        for engine, axis in dict.fromkeys(zip(self.engine, self.axis, strict=True)):
            own = [row for row in self.rows() if row[:2] == (engine, axis)]
            right = [row[2] for row in own if row[3] == RIGHT]
            errors = [row[4] for row in own if row[3] in (RIGHT, INACCURATE)]
            why = Counter(f"{row[3]}: {DETAIL.sub('', row[7])}" for row in own if row[3] != RIGHT)
            rows.append([
                engine, axis, f"{own[0][2]:g}..{own[-1][2]:g}",
                f"{len(right)} of {len(own)}" + (f", {min(right):g}..{max(right):g}" if right else ""),
                f"{max(errors):.1e}" if errors else "", "; ".join(f"{n} {text}" for text, n in why.most_common(2)),
            ])  # fmt: skip
        return "Axes", ["engine", "axis", "tried", "right", "largest error", "the rest, mostly"], rows
