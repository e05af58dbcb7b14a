"""What the comparison hands on: numbers, determinants, and claims."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from stages.biped.quantity import quantity
from stages.comparison.agreement import ModelAgreement, TwinAgreement
from stages.comparison.claims.verdict import VERDICTS
from stages.comparison.determinants import TITLE, Determinants, Digits
from stages.comparison.runs.ingest_score import IngestScore
from stages.comparison.runs.measurement import MeasurementAgreement
from stages.comparison.summary import BipedSummary
from stages.comparison.tables import Table, prices, side_by_side


@dataclass(frozen=True)
class Number:
    """One number that a claim was judged by."""

    name: str = quantity("-", "field of the claim's numbers, with places inside of it")
    unit: str = quantity("-", "unit of value and error")
    value: float = quantity("-", "value")
    error: float = quantity("-", "numerical error; NaN if unknown")

    def __str__(self) -> str:
        error = "" if math.isnan(self.error) else f" ± {self.error:.1g}"
        return f"{self.name} {self.value:.6g}{error}"


@dataclass(frozen=True)
class Claim:
    """One claim of the paper against this study, in four parts: what it says, what is measured, verdict, cause."""

    id: str = quantity("-", "short name")
    section: str = quantity("-", "where the paper says it")
    words: str = quantity("-", "the paper's words")
    implies: str = quantity("-", "the quantity and limit that they imply")
    measured: str = quantity("-", "what this study computes")
    verdict: str = quantity("-", "what follows, one of `claims.verdict.VERDICTS`")
    condition: str = quantity("-", "what completes holds if; else empty")
    beside: str = quantity("-", "errors unknown here, where no error of its numbers was measured; else empty")
    causes: tuple[str, ...] = quantity("-", "the causes that are true of what was measured")
    rests_on: tuple[str, ...] = quantity("-", "parameters other than the biped's that it follows from")
    numbers: tuple[Number, ...] = quantity("-", "what it was judged by, with numerical errors")


@dataclass(frozen=True)
class Result:
    """Agreement of all sources, empty where one is not there, and the paper's claims with their verdicts."""

    models: ModelAgreement | None = quantity("-", "constraint model against penalty model")
    twin: TwinAgreement | None = quantity("-", "twin against simple model")
    measurement: MeasurementAgreement | None = quantity("-", "measurements against twin")
    ingest: IngestScore | None = quantity("-", "the ingest against the synthetic truth; empty for other measurements")
    determinants: dict[str, Determinants] = quantity("-", "determinants of gait, by model")
    digits: dict[str, Digits] = quantity("-", "what rounded parameters leave open of each model's gait")
    biped: BipedSummary = quantity("-", "what the study says of this biped")
    claims: tuple[Claim, ...] = quantity("-", "the paper's claims")
    level: str = quantity("-", "accuracy of the study")
    files: dict[str, bytes] = quantity("-", "the claims, by path in the results folder")

    def summary(self) -> str:
        """Verdicts counted, in one line."""
        return counted([claim.verdict for claim in self.claims])

    def tables(self) -> list[Table]:
        """This biped, its determinants, and how well the ingest reads what is known: (title, columns, rows)."""
        own = tables_of(self.biped, self.determinants, self.digits, self.level, self.claims)
        return [*own, self.ingest.table(), self.ingest.leg_table()] if self.ingest is not None else own


def tables_of(
    biped: BipedSummary, determinants: dict[str, Determinants], digits: dict[str, Digits], level: str,
    claims: Sequence[Claim],
) -> list[Table]:  # fmt: skip
    """What stands beside the claims; prices with their errors where these are of this robot and ground."""
    measured = any(math.isfinite(number.error) for claim in claims for number in claim.numbers)
    return [
        side_by_side("This biped", {"value": biped}),
        side_by_side("Determinants of gait, from the walks", determinants),
        side_by_side(TITLE, digits),
        *([prices(level)] if measured else []),
    ]


def counted(verdicts: list[str]) -> str:
    """How many claims have each verdict that occurs."""
    many = [f"{verdicts.count(verdict)} {PLURAL[verdict]}" for verdict in VERDICTS if verdict in verdicts]
    return f"of {len(verdicts)} claims " + ", ".join(many)


#: Verdicts of several claims.
PLURAL = dict(zip(
    VERDICTS,
    ("hold", "hold on a condition", "do not hold", "are not decided at this accuracy", "stay open", "do not apply"),
    strict=True))  # fmt: skip
