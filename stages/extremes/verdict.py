"""What is said of a point: the answer is right, inaccurate, refused, failed, unconfirmed, or wrong without a sign."""

from __future__ import annotations

import math
from dataclasses import dataclass

#: The answer agrees with the reference; it does not, but its own audit or the tolerance asked for tell so; input or
#: design refused with a reason; the run ended early with a reason; an answer whose reference gave none.
RIGHT, INACCURATE, REFUSED, FAILED, UNCONFIRMED = "right", "inaccurate", "refused", "failed", "unconfirmed"
#: An answer that the reference contradicts and nothing in it tells: a defect. A process that died or did not return.
WRONG, CRASHED, HUNG = "wrong", "crashed", "hung"
STATUSES = (RIGHT, INACCURATE, REFUSED, FAILED, UNCONFIRMED, WRONG, CRASHED, HUNG)

#: An answer may depart by so many tolerances: errors grow over a step's thousand integration steps and its impact.
GROWTH = 100.0


@dataclass(frozen=True)
class Finding:
    """The verdict on one point: distance from the reference and what the model's own audit leaves open."""

    status: str
    error: float = math.nan
    audit: float = math.nan
    reference: str = ""
    reason: str = ""


def judged(error: float, audit: float, asked: float, limit: float, reference: str) -> Finding:
    """Verdict on an answer: `error` is its distance from the reference and `audit` its own energy residual.

    `asked` is the tolerance asked for, `limit` the error up to which an answer is called right. NaN as audit: the
    model has none.
    """
    if error <= limit:
        return Finding(RIGHT, error, audit, reference)
    if error <= GROWTH * asked:
        return Finding(INACCURATE, error, audit, reference, f"within {GROWTH:g} times the tolerance asked for")
    if audit > limit:
        return Finding(INACCURATE, error, audit, reference, "its own energy audit does not close")
    return Finding(WRONG, error, audit, reference, "the reference contradicts it and nothing tells")


def refused(reason: str) -> Finding:
    """The input or the design is refused."""
    return Finding(REFUSED, reason=reason)


def failed(reason: str) -> Finding:
    """The run ended early."""
    return Finding(FAILED, reason=reason)
