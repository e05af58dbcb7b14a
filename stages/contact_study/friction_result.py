"""What the contact study hands on of friction: the gait with one transition velocity changed."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

from stages.biped.quantity import quantity

Table = tuple[str, tuple[str, ...], list[tuple[object, ...]]]


@dataclass(frozen=True)
class FrictionVariation:
    """The gait, a fixed point, with one transition velocity changed; NaN where none is found."""

    name: str = quantity("-", "parameter changed")
    factor: float = quantity("1", "factor on its value; 1 is the contact set itself")
    period_s: float = quantity("s", "step period", symbol="T")
    step_length_m: float = quantity("m", "step length", symbol="s")


def table(contact_set: str, variations: Sequence[FrictionVariation]) -> Table:
    """What the transition velocities of friction change, from this contact set."""
    columns = ("velocity", "factor", "period [s]", "change [%]", "step [mm]", "change [%]")
    rows: list[tuple[object, ...]] = [
        (
            variation.name.replace("_", " "), f"{variation.factor:.3g}",
            f"{variation.period_s:.5f}", f"{100 * in_period:+.2f}",
            f"{1e3 * variation.step_length_m:.2f}", f"{100 * in_length:+.2f}",
        )
        for variation, in_period, in_length in changes(variations)
    ]  # fmt: skip
    return f"The gait with one transition velocity of friction changed, {contact_set}", columns, rows


def changes(variations: Sequence[FrictionVariation]) -> Iterator[tuple[FrictionVariation, float, float]]:
    """Each variation with its relative change of period and of step length against factor 1."""
    unchanged = {variation.name: variation for variation in variations if variation.factor == 1.0}
    for variation in variations:
        base = unchanged[variation.name]
        yield variation, variation.period_s / base.period_s - 1.0, variation.step_length_m / base.step_length_m - 1.0


def crossing(variations: Sequence[FrictionVariation], name: str, limit: float) -> tuple[float, float]:
    """Factors on the velocity `name`, below and above 1, at which period or step length has changed by `limit`.

    Interpolated in the logarithm of the factor between the variations computed; NaN where the change stays smaller.
    """
    rows = sorted(
        (math.log(variation.factor), max(abs(in_period), abs(in_length)))
        for variation, in_period, in_length in changes(variations)
        if variation.name == name and math.isfinite(in_period)
    )
    sides = []
    for side in ([row for row in rows[::-1] if row[0] <= 0.0], [row for row in rows if row[0] >= 0.0]):
        sides.append(float("nan"))
        for (near, less), (far, more) in pairwise(side):
            if less < limit <= more:
                sides[-1] = math.exp(near + (far - near) * (limit - less) / (more - less))
                break
    return sides[0], sides[1]
