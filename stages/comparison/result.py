"""What the comparison hands on: numbers and claims."""

from __future__ import annotations

from dataclasses import dataclass

from stages.biped.quantity import quantity
from stages.comparison.agreement import ModelAgreement, TwinAgreement
from stages.comparison.ingest_score import IngestScore
from stages.comparison.measurement import MeasurementAgreement


@dataclass(frozen=True)
class Claim:
    """One claim of the paper against this study."""

    id: str = quantity("-", "short name")
    stated: str = quantity("-", "what the paper says, and where")
    found: str = quantity("-", "what this study computes")
    holds: bool | None = quantity("-", "whether the claim holds here; empty if it cannot be decided")
    why: str = quantity("-", "reason for the verdict")


@dataclass(frozen=True)
class Result:
    """Agreement of all sources, and the paper's claims with their verdicts."""

    models: ModelAgreement = quantity("-", "constraint model against penalty model")
    twin: TwinAgreement = quantity("-", "twin against simple model")
    measurement: MeasurementAgreement = quantity("-", "measurements against twin")
    ingest: IngestScore | None = quantity("-", "the ingest against the synthetic truth; empty for other measurements")
    claims: tuple[Claim, ...] = quantity("-", "the paper's claims")
    files: dict[str, bytes] = quantity("-", "the claims, by path in the results folder")

    def summary(self) -> str:
        """Verdicts counted, in one line."""
        verdicts = [claim.holds for claim in self.claims]
        return f"{verdicts.count(True)} claims hold, {verdicts.count(False)} do not, {verdicts.count(None)} undecided"

    def tables(self) -> list[tuple[str, tuple[str, ...], list[tuple[str, ...]]]]:
        """How well the ingest reads what is known: (title, columns, rows)."""
        return [self.ingest.table()] if self.ingest is not None else []
