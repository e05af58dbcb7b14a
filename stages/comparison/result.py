"""What the comparison hands on: numbers, determinants, claims, and what the study says of its biped.

A verdict and its causes: what was measured is judged, and every cause is a predicate with its number.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from stages.biped.quantity import LEFT, quantity
from stages.comparison.agreement import ModelAgreement, TwinAgreement
from stages.comparison.determinants import TITLE, Determinants, Digits
from stages.comparison.ingest_score import IngestScore
from stages.comparison.measurement import MeasurementAgreement
from stages.comparison.tables import Table, side_by_side

HOLDS, HOLDS_IF, FAILS, OPEN, DOES_NOT_APPLY = "holds", "holds if", "does not hold", "open", "does not apply"
#: Within the numerical errors of its numbers a claim has more than one verdict.
UNDECIDED = "not decided at this accuracy"
#: Stands beside a verdict on numbers whose errors are not known.
UNKNOWN = "errors unknown here"
#: All verdicts, in the order in which they are counted.
VERDICTS = (HOLDS, HOLDS_IF, FAILS, UNDECIDED, OPEN, DOES_NOT_APPLY)
#: Why work, and the error that it was done for, have no error; and numbers of many units in one column.
AT_TOLERANCES, BESIDE = "it is what solvers did at these tolerances", "each has its error beside it"

#: Whether a reason is true of what was measured, and the reason.
Cause = tuple[bool, str]
#: Named lengths [m] with their signs, and by how much each may be more or less.
Parts = tuple[tuple[str, float, float], ...]


@dataclass(frozen=True)
class Judgement:
    """What was measured, in words, and what follows. `condition` completes the verdict "holds if"."""

    measured: str
    verdict: str
    causes: tuple[Cause, ...]
    condition: str = ""

    @property
    def reasons(self) -> tuple[str, ...]:
        """The causes that are true."""
        return tuple(words for true, words in self.causes if true)


def yes_or_no(holds: bool) -> str:
    """The verdict of a claim without conditions."""
    return HOLDS if holds else FAILS


def percent(share: float, digits: int = 2) -> str:
    """A relative change with its sign."""
    return f"{100 * share:+.{digits}f} %"


def listed(parts: Parts) -> str:
    """Parts in words, largest first."""
    said = []
    for name, value, spread in sorted(parts, key=lambda part: -abs(part[1])):
        either = f" ± {1e3 * spread:.2f}" if spread > 0 else ""
        said.append(f"{name} {1e3 * value:+.2f}{either} mm")
    return ", ".join(said)




@dataclass(frozen=True)
class Number:
    """One number that a claim was judged by."""

    name: str = quantity("-", "field of the claim's numbers, with places inside of it")
    unit: str = quantity("-", "unit of value and error")
    value: float = quantity("-", "value", without_error=BESIDE)
    error: float = quantity("-", "numerical error; NaN if unknown", without_error=LEFT)

    def __str__(self) -> str:
        error = "" if math.isnan(self.error) else f" ± {self.error:.1g}"
        return f"{self.name} {self.value:.6g}{error}"


@dataclass(frozen=True)
class Claim:
    """One claim of the paper against this study, in four parts: what it says, what is measured, verdict, cause."""

    id: str = quantity("-", "short name")
    section: str = quantity("-", "where the paper says it")
    plain: str = quantity("-", "what it says, in one sentence without its terms")
    words: str = quantity("-", "the paper's words")
    implies: str = quantity("-", "the quantity and limit that they imply")
    measured: str = quantity("-", "what this study computes")
    verdict: str = quantity("-", "what follows, one of `VERDICTS`")
    condition: str = quantity("-", "what completes holds if; else empty")
    beside: str = quantity("-", "errors unknown here, where closer solvers do not give its numbers; else empty")
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
    another: tuple[str, ...] = quantity("-", "in what this is another biped than the paper's; none: it is the paper's")
    claims: tuple[Claim, ...] = quantity("-", "the paper's claims")
    level: str = quantity("-", "accuracy of the study")
    files: dict[str, bytes] = quantity("-", "the claims, by path in the results folder")

    def summary(self) -> str:
        """Verdicts counted, in one line."""
        return counted([claim.verdict for claim in self.claims])

    def tables(self) -> list[Table]:
        """This biped, its determinants, and how well the ingest reads what is known: (title, columns, rows)."""
        own = tables_of(self.biped, self.determinants, self.digits)
        return [*own, self.ingest.table(), self.ingest.leg_table()] if self.ingest is not None else own


def tables_of(
    biped: BipedSummary, determinants: dict[str, Determinants], digits: dict[str, Digits]
) -> list[Table]:  # fmt: skip
    """What stands beside the claims; nothing of digits where the parameters have none."""
    stated = any(math.isfinite(value) for one in digits.values() for value in vars(one).values())
    return [
        side_by_side("This biped", {"value": biped}),
        side_by_side("Determinants of gait, from the walks", determinants),
        *([side_by_side(TITLE, digits)] if stated else []),
    ]


def counted(verdicts: list[str]) -> str:
    """How many claims have each verdict that occurs."""
    count = verdicts.count
    many = [f"{count(one)} {IN_WORDS[one][count(one) > 1]}" for one in VERDICTS if one in verdicts]
    return f"of {len(verdicts)} claims " + ", ".join(many)


#: Verdicts of one claim, and of several.
IN_WORDS = dict(zip(VERDICTS, (
    ("holds", "hold"), ("holds on a condition", "hold on a condition"), ("does not hold", "do not hold"),
    ("is not decided at this accuracy", "are not decided at this accuracy"), ("stays open", "stay open"),
    ("does not apply", "do not apply")), strict=True))  # fmt: skip


@dataclass(frozen=True)
class BipedSummary:
    """The biped's gait in few numbers; NaN where a model has none."""

    step_frequency: float = quantity("Hz", "step frequency of the constraint model")
    step_length: float = quantity("m", "step length of the constraint model")
    period_error: float = quantity("s", "estimated numerical error of its step period")
    hip_error: float = quantity("m", "estimated numerical error of its hip over the walk")
    period_difference: float = quantity("s", "step period of the penalty model less the constraint model's")
    length_difference: float = quantity("m", "step length of the penalty model less the constraint model's")
    limit_difference: float = quantity(
        "m", "largest hip difference over one step of the constraint model with Coulomb friction from the rolling one"
    )
    hip_difference: float = quantity("m", "largest hip difference of these models over one step from a common state")
    twin_frequency: float = quantity("Hz", "step frequency of the twin's last four steps")
    multiplier: float = quantity("1", "largest multiplier of the constraint model")
    twin_multiplier: float = quantity("1", "largest multiplier of the twin in the plane")
    friction_single_stance: float = quantity("1", "friction it needs in single stance")
    friction_heel_strike: float = quantity("1", "friction it needs in the impulses of heel strike")
    friction: float = quantity("1", "friction there is")
    specific_cost: float = quantity("1", "cost of transport: what gravity gives over weight and way")
    constraint_work: float = quantity(
        "1", "evaluations a step of the constraint model for the error below", without_error=AT_TOLERANCES)
    penalty_work: float = quantity(
        "1", "evaluations a step of the penalty model for the error below", without_error=AT_TOLERANCES)
    error: float = quantity("m", "hip error at which work is counted", without_error=AT_TOLERANCES)
