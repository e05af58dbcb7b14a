"""Numbers with their derivatives along several directions: forward differentiation of any kind of number."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

Number = Any


class Jet:
    """A number `v` and its derivatives `d` (n,); None is a derivative that is zero."""

    __slots__ = ("d", "v")

    def __init__(self, v: Number, d: Sequence[Number]) -> None:
        self.v, self.d = v, d

    def __add__(self, other: Number) -> Jet:
        if not isinstance(other, Jet):
            return Jet(self.v + other, self.d)
        return Jet(self.v + other.v, [b if a is None else a if b is None else a + b for a, b in zip(self.d, other.d)])

    __radd__ = __add__

    def __neg__(self) -> Jet:
        return Jet(-self.v, [None if a is None else -a for a in self.d])

    def __sub__(self, other: Number) -> Jet:
        if not isinstance(other, Jet):
            return Jet(self.v - other, self.d)
        return Jet(self.v - other.v, [
            a if b is None else -b if a is None else a - b for a, b in zip(self.d, other.d)])

    def __rsub__(self, other: Number) -> Jet:
        return (-self).__add__(other)

    def __mul__(self, other: Number) -> Jet:
        if not isinstance(other, Jet):
            return Jet(self.v * other, [None if a is None else a * other for a in self.d])
        v, w = self.v, other.v
        return Jet(v * w, [
            (None if b is None else v * b) if a is None else a * w if b is None else a * w + v * b
            for a, b in zip(self.d, other.d)])

    __rmul__ = __mul__

    def __rtruediv__(self, other: Number) -> Jet:
        v = other / self.v
        slope = -(v / self.v)
        return Jet(v, [None if a is None else slope * a for a in self.d])

    def sin_cos(self) -> tuple[Jet, Jet]:
        sine, cosine = self.v.sin_cos()
        minus = -sine
        return (Jet(sine, [None if a is None else cosine * a for a in self.d]),
                Jet(cosine, [None if a is None else minus * a for a in self.d]))


def jets(values: Sequence[Number], one: Number = 1) -> list[Jet]:
    """Numbers with unit derivatives `one` along themselves."""
    return [Jet(value, [one if i == j else None for j in range(len(values))]) for i, value in enumerate(values)]


def gradient(function: Callable[[Sequence[Number]], Number], values: Sequence[Number]) -> list[Number]:
    """Derivatives of a function of numbers at them."""
    found = function(jets(values))
    return [0 if a is None else a for a in found.d]


def jacobian(function: Callable[[Sequence[Number]], Sequence[Number]], values: Sequence[Number]) -> list[list[Number]]:
    """Rows of derivatives of functions of numbers at them."""
    return [[0 if a is None else a for a in one.d] for one in function(jets(values))]
