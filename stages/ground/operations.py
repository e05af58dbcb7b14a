"""The few elementary functions a contact law is written in.

A law is a formula over these operations, so that its one text serves floats, numpy arrays, the symbols of a multibody
program (`stages.multibody.assembly.contact`) and machine code (`stages.ground.compiled`): each kind of number has its
own table. Symbols are evaluated without sharing common terms: a formula should therefore mention a costly term once.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

#: Slip speed [m/s] added in quadrature where a slip direction is needed, so that no slip has a direction too.
SMALLEST_SLIP = 1e-12


class Operations(NamedTuple):
    """Elementary functions on one kind of number."""

    sqrt: Callable[[Any], Any]
    sign: Callable[[Any], Any]
    absolute: Callable[[Any], Any]
    round: Callable[[Any], Any]
    power: Callable[[Any, float], Any]
    minimum: Callable[[Any, float], Any]
    maximum: Callable[[Any, float], Any]
    #: STEP(x, 0, 0, width, height) of Adams: height s^2 (3 - 2 s) with s = x / width, 0 below and height above.
    step: Callable[[Any, float, Any], Any]
    #: (x, width, height): STEP(x, -width, -height, width, height), odd, and flat at both ends.
    rise: Callable[[Any, float, Any], Any]
    #: (x, width, height): rise / x, for x >= 0.
    creep: Callable[[Any, float, Any], Any]
    #: Length of a vector with two components, no less than is needed to divide by it.
    length: Callable[[Any, Any], Any]


def with_single_terms(
    sin: Callable[[Any], Any], asin: Callable[[Any], Any], sqrt: Callable[[Any], Any], **others: Any
) -> Operations:
    """Operations whose steps mention their argument once: the cubic (3 u - u^3) / 2 is sin(3 asin(u / 2))."""
    minimum, maximum = others["minimum"], others["maximum"]

    def cubic(u: Any) -> Any:
        return sin(3.0 * asin(0.5 * maximum(minimum(u, 1.0), -1.0)))

    def rise(x: Any, width: float, height: Any) -> Any:
        return height * cubic(x * (1.0 / width))

    return Operations(
        sqrt=sqrt,
        step=lambda x, width, height: height * (0.5 + 0.5 * cubic(2.0 * (x * (1.0 / width)) - 1.0)),
        rise=rise,
        creep=lambda x, width, height: rise(x, width, height) / x,
        length=lambda x, z: sqrt(x * x + z * z + SMALLEST_SLIP**2),
        **others,
    )


def _sign(x: float) -> float:
    return float((x > 0) - (x < 0))


SCALARS = with_single_terms(
    math.sin, math.asin, math.sqrt, sign=_sign, absolute=abs, round=round, power=math.pow, minimum=min, maximum=max
)
ARRAYS = with_single_terms(
    np.sin, np.arcsin, np.sqrt, sign=np.sign, absolute=np.abs, round=np.round, power=np.power, minimum=np.minimum,
    maximum=np.maximum,
)  # fmt: skip
