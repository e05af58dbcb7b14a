"""The designs of a map, each answered within an error by the cheapest rung that has it.

A block of designs is answered from its numbers alone. The search of each begins at the gait of the nearest design of
the block that has one.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.maps.box import Box
from stages.analytic.model.walker import Vector
from stages.biped.question import Column
from stages.model_error.choice import Answered, Ladder
from stages.model_error.measures import UNITS, Allowed
from stages.model_error.miss import Learnt
from stages.model_error.parameters import Parameters
from stages.model_error.result import MODELS, Result

#: What answered a design: a rung, none as no rung has the error, none as the values break a rule.
WAYS = (*MODELS, "no model", "not allowed")


def columns(allowed: Mapping[str, Allowed]) -> list[Column]:
    """The columns of a map of these measures: value, error of solver and model, and which model it is of."""
    found = []
    for name in allowed:
        unit = UNITS[name]
        found += [Column(name, unit, "less what the model misses of the twin; NaN where no model has the error"),
                  Column(f"{name}_error", unit, "what solver and model leave of it"),
                  Column(f"{name}_model", "-", "what it is of", WAYS)]  # fmt: skip
    return found


def learnt_of(plain: Sequence[Any]) -> Learnt:
    """What was learnt, from kind, numbers and values of the stage's result, as JSON gives them back."""
    kind, numbers, values = plain
    return Learnt(Result(0, kind, np.array(numbers), np.array(values), np.zeros_like(values), np.zeros(0), ()))


def block(
    parameters: Parameters, box: Box, base: DesignPoint, allowed: Mapping[str, Allowed], learnt: Learnt, first: int,
    end: int
) -> list[list[float]]:  # fmt: skip
    """The rows of `columns` of the designs `first` to before `end` of the box."""
    shares = box.shares(first, end)
    rows, known = [], list[tuple[np.ndarray, dict[str, Vector]]]()
    for share, values in zip(shares, box.at(shares), strict=True):
        design = box.design(base, values)
        if not design.is_legal():
            rows.append([np.nan, np.nan, float(WAYS.index("not allowed"))] * len(allowed))
            continue
        near = min(known, key=lambda one: float(np.abs(one[0] - share).max()), default=(share, {}))[1]
        ladder = Ladder(parameters.with_exact(design.biped, design.slope), learnt, near=near)
        rows.append([number for name, one in allowed.items()
                     for number in numbers_of(ladder.within(name, one.error, one.share))])  # fmt: skip
        known.append((share, ladder.design.searched))
    return rows


def numbers_of(answer: Answered) -> list[float]:
    """Value, error in its unit, and place of its model among `WAYS`."""
    if not answer.met:
        return [np.nan, np.nan, float(WAYS.index("no model"))]
    error = (answer.solver + answer.model) * (answer.value if answer.share else 1.0)
    return [answer.value, error, float(WAYS.index(answer.rung))]
