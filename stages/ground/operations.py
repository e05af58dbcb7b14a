"""The few elementary functions a contact law is written in.

A law is a formula over these operations, so one text serves floats, numpy arrays and the symbolic user functions of a
multibody program (which supplies its own table, see `stages.multibody.assembly.contact`). Symbolic expressions are
evaluated without sharing common terms: a formula should therefore mention a costly term once.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Operations:
    """Elementary functions on one kind of number."""

    sin: Callable[[Any], Any]
    asin: Callable[[Any], Any]
    sqrt: Callable[[Any], Any]
    sign: Callable[[Any], Any]
    absolute: Callable[[Any], Any]
    round: Callable[[Any], Any]
    power: Callable[[Any, float], Any]
    minimum: Callable[[Any, float], Any]
    maximum: Callable[[Any, float], Any]


def _sign(x: float) -> float:
    return float((x > 0) - (x < 0))


SCALARS = Operations(math.sin, math.asin, math.sqrt, _sign, abs, round, math.pow, min, max)
ARRAYS = Operations(np.sin, np.arcsin, np.sqrt, np.sign, np.abs, np.round, np.power, np.minimum, np.maximum)


def rise(u: Any, ops: Operations) -> Any:
    """Cubic from -1 at u = -1 to +1 at u = +1 with zero slope at both ends, constant beyond.

    (3 u - u^3) / 2 = sin(3 asin(u / 2)) mentions u once.
    """
    return ops.sin(3.0 * ops.asin(0.5 * ops.maximum(ops.minimum(u, 1.0), -1.0)))


def smoothstep(s: Any, ops: Operations) -> Any:
    """s^2 (3 - 2 s) between s = 0 and s = 1, 0 below and 1 above: STEP(s, 0, 0, 1, 1) of Adams."""
    return 0.5 + 0.5 * rise(2.0 * s - 1.0, ops)
