"""What came of one point."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

COMPUTED = "computed"
NO_ANSWER = "no answer"  # the stage's own reasoned refusal
NOT_ALLOWED = "not allowed"  # the values break a rule between parameters
TIME_LIMIT = "time limit"
CRASH = "crash"
ERROR = "error"
KEPT = (COMPUTED, NO_ANSWER)  # what follows from the point alone; the rest may be the machine's fault


@dataclass(frozen=True)
class Row:
    """Outcome of a point, the reason where there is no result, values by column, and the seconds it took."""

    outcome: str
    reason: str = ""
    values: Mapping[str, Any] = field(default_factory=dict)
    seconds: float = 0.0
