"""Functions that name each number of a kind of walker, written out for each: machine code knows no loop over names."""

from __future__ import annotations

from typing import Any, get_args

from stages.analytic.model.kinds import Detailed, Plain, exchange
from stages.analytic.model.made import Made

#: Detailed kinds, those of stiff legs before what they are made of; and all kinds, stiff or not.
EXCHANGED: list[Any] = [each for kind in get_args(Detailed) for each in (*kind.__subclasses__(), kind)]
ROWS: tuple[Any, ...] = get_args(Plain | Detailed)


def source() -> str:
    """exchanged_KIND(p): the walker with its legs exchanged; row_KIND(p, a, row): a row of `a` (n, fields) as one."""
    lines = ["import numpy as np", "", "from stages.analytic.compiled import compiled",
             "from stages.analytic.model.kinds import *"]
    for kind in EXCHANGED:
        order, hinge = exchange(kind._fields)
        values = [f"p.{kind._fields[place]}" for place in order]
        values[hinge] = f"-{values[hinge]}"
        lines += function(f"exchanged_{kind.__name__}", f"p: {kind.__name__}", kind, values)
    for kind in ROWS:
        lines += function(f"row_{kind.__name__}", f"p: {kind.__name__}, a: np.ndarray, row: int", kind,
                          [f"a[row, {place}]" for place in range(len(kind._fields))])
    return "\n".join(lines)


def function(name: str, arguments: str, kind: Any, values: list[str]) -> list[str]:
    """Source of a function that gives a walker of a kind."""
    return ["", "", "@compiled", f"def {name}({arguments}) -> {kind.__name__}:",
            f"    return {kind.__name__}({', '.join(values)})"]  # fmt: skip


WRITTEN = Made(f"{__name__}.functions", source)


def of_each(called: str, kinds: list[Any] | tuple[Any, ...]) -> dict[Any, Any]:
    """The functions of kinds that are called `called` with the kind's name."""
    return {kind: getattr(WRITTEN, f"{called}_{kind.__name__}") for kind in kinds}
