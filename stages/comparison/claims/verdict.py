"""A verdict and its causes: what was measured is judged, and every cause is a predicate with its number."""

from __future__ import annotations

from dataclasses import dataclass

HOLDS, HOLDS_IF, FAILS, OPEN, DOES_NOT_APPLY = "holds", "holds if", "does not hold", "open", "does not apply"
#: Within the numerical errors of its numbers a claim has more than one verdict.
UNDECIDED = "not decided at this accuracy"
#: Stands beside a verdict on numbers whose errors are not known.
UNKNOWN = "errors unknown here"
#: All verdicts, in the order in which they are counted.
VERDICTS = (HOLDS, HOLDS_IF, FAILS, UNDECIDED, OPEN, DOES_NOT_APPLY)

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


def mm(value: float) -> str:
    """A length [m] in mm."""
    return f"{1e3 * value:.2f} mm"


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
