"""Enclosures of a flow and its derivative over a step of time: Taylor polynomials, their defects, and sets of states.

A polynomial p(t) of thin coefficients nearly solves y' = f(y). Its defect d = f(p) - p' has enclosed coefficients of
all powers below the order n, and a last one that holds at any time of the step (Taylor's theorem). For a solution y
with y(0) near p(0), the difference e = y - p has |e|' <= M |e| + |d|, where M bounds f's derivative over the tube
p + E: entries beside the diagonal by their size, on it by their upper end. So |e| is at most
|e(0)| + Psi (|M| |e(0)| + max |d|), with Psi the integral of exp(M s) over the step, as long as this stays within E; as
it is less than E, it does. The same holds for the columns of the derivative, whose field is linear.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import accumulate
from operator import mul
from typing import Any, NamedTuple

import numpy as np
from flint import arb, arb_mat, arb_series, ctx

from stages.proof.equations import Number, Numbers

Ball = Any
Matrix = Any
#: A field of rates at a state, for numbers of any kind.
Field = Callable[[Sequence[Any]], list[Any]]
#: Order of the polynomials, bits of all balls; largest radii of where a step ends, and of its derivative by the start.
ORDER, BITS, ERROR, BY_START = 20, 128, 1e-23, 1e-10
#: The tube is made so many times as wide as what it was found to need, this often.
WIDER, WIDENINGS = 4, 3


class NotProven(Exception):
    """A condition of the theorem could not be shown; the message says which one, and where."""


class Jet:
    """A number `v` and its derivatives `d` (n,); None is a derivative that is zero."""

    def __init__(self, v: Number, d: Numbers) -> None:
        self.v, self.d = v, d

    def to(self, v: Number, slope: Number) -> Jet:
        """A function of this number alone: its value, by the chain rule with its slope."""
        return Jet(v, [None if each is None else slope * each for each in self.d])

    def __add__(self, other: Number) -> Jet:
        if not isinstance(other, Jet):
            return Jet(self.v + other, self.d)
        return Jet(self.v + other.v, [b if a is None else a if b is None else a + b for a, b in zip(self.d, other.d)])

    def __mul__(self, other: Number) -> Jet:
        if not isinstance(other, Jet):
            return self.to(self.v * other, other)
        return self.to(self.v * other.v, other.v) + other.to(0, self.v)

    def __neg__(self) -> Jet:
        return self.to(-self.v, -1)

    def __sub__(self, other: Number) -> Jet:
        return self.__add__(-other)

    def __rsub__(self, other: Number) -> Jet:
        return self.__neg__().__add__(other)

    def __rtruediv__(self, other: Number) -> Jet:
        value = other / self.v
        return self.to(value, -(value / self.v))

    def sin_cos(self) -> tuple[Jet, Jet]:
        sine, cosine = self.v.sin_cos()
        return self.to(sine, cosine), self.to(cosine, -sine)

    __radd__, __rmul__ = __add__, __mul__


def jacobian(
    function: Callable[[Numbers], Numbers], values: Numbers, one: Number = 1
) -> tuple[list[Number], list[list[Number]]]:
    """Functions of numbers at them, and rows of their derivatives; `one` is of their kind."""
    places = range(len(values))
    found = function([Jet(value, [one if i == j else None for j in places]) for i, value in enumerate(values)])
    return [each.v for each in found], [[0 if a is None else a for a in each.d] for each in found]


def column(values: Sequence[Ball]) -> Matrix:
    """Numbers as a matrix of one column."""
    return arb_mat(len(values), 1, list(values))


def identity(size: int) -> Matrix:
    """The matrix of a map that changes nothing."""
    return arb_mat(np.eye(size, dtype=int).tolist())


def sizes(matrix: Matrix) -> Matrix:
    """Upper bounds of the sizes of all entries, thin."""
    return arb_mat(matrix.nrows(), matrix.ncols(), [arb(each.abs_upper()) for each in matrix.entries()])


def around(matrix: Matrix) -> Matrix:
    """Balls about zero of these radii."""
    return arb_mat(matrix.nrows(), matrix.ncols(), [arb(0, each.abs_upper()) for each in matrix.entries()])


def powers(size: int, time: Ball) -> Matrix:
    """1, t, t^2, ... as a row."""
    return arb_mat(1, size, list(accumulate([arb(1), *[time] * (size - 1)], mul)))


def shifted(table: Matrix, time: Ball) -> Matrix:
    """Coefficients by power (k, n) of polynomials in t, as ones in t - time, which may be a ball."""
    size, power = table.nrows(), powers(table.nrows(), time)
    return arb_mat(size, size, [arb.bin_uiui(j, i) * power[0, j - i] if j >= i else arb(0)
                                for i in range(size) for j in range(size)]) * table  # fmt: skip


def at(table: Matrix, time: Ball) -> list[Ball]:
    """Values (n,) of polynomials with these coefficients at a ball of times."""
    if not time.is_exact():
        table, time = shifted(table, time.mid()), time - time.mid()
    return list((powers(table.nrows(), time) * table).entries())


def expanded(field: Field, start: Sequence[Ball]) -> tuple[Matrix, Matrix]:
    """Taylor polynomial of a solution from a thin start, by power, and its defect's coefficients below the order."""
    rows, defects = [list(start)], []
    for k in range(ORDER):
        ctx.cap = k + 1
        exact = [rate[k] for rate in field([arb_series(list(each)) for each in zip(*rows)])]
        rows.append([(rate / (k + 1)).mid() for rate in exact])
        defects.append([rate - (k + 1) * after for rate, after in zip(exact, rows[-1])])
    return arb_mat(rows), arb_mat(defects)


def differentiated(field: Field, table: Matrix, width: Matrix, cap: int) -> tuple[list[Any], list[Matrix]]:
    """Rates along a polynomial as series of `cap` powers, and the derivative's matrices by power, for all states that
    are nearer to the polynomial than `width`.
    """
    ctx.cap, size = cap, table.ncols()
    coefficients = table.transpose().tolist()
    states = [arb_series([first + wide, *rest]) for (first, *rest), wide in zip(coefficients, around(width).entries())]
    rates, rows = jacobian(field, states, arb_series([1]))
    entries = [each if isinstance(each, arb_series) else arb_series([each]) for row in rows for each in row]
    return rates, [arb_mat(size, size, [each[k] for each in entries]) for k in range(cap)]


class Step(NamedTuple):
    """A step of time `length`: coefficients (k, n) of its polynomial, how far solutions from the set are from it, where
    the one from its start ends, and the derivative of the end by the start over the set.
    """

    table: Matrix
    length: Ball
    width: list[Ball]
    end: Matrix
    derivative: Matrix

    def tube(self, times: Ball) -> list[Ball]:
        """All states at these times."""
        return [a + b for a, b in zip(at(self.table, times), self.width)]


def step(field: Field, polynomial: tuple[Matrix, Matrix], length: Ball, spread: Matrix) -> Step | None:
    """The step of `length` of all solutions that start nearer to the polynomial's start than `spread`; None if they are
    not shown to stay in a tube, or end in too wide a box.
    """
    (table, defects), size, last = polynomial, spread.nrows(), length**ORDER
    early = (powers(ORDER, length) * sizes(defects)).transpose()
    always = shifted(shifted(table, length / 2), arb(0, length / 2))  # at any time of the step
    width = arb_mat(size, 1)
    for _ in range(WIDENINGS):
        rates, linear = differentiated(field, always, width, ORDER + 1)
        bound, m = sizes(linear[0]), sizes(linear[0])
        for i in range(size):
            m[i, i] = arb(linear[0][i, i].upper())
        upper = [a + b for a, b in zip((m * length).tolist(), (identity(size) * length).tolist())]
        block = arb_mat(upper + arb_mat(size, 2 * size).tolist()).exp()
        psi = sizes(arb_mat([row[size:] for row in block.tolist()[:size]]))  # the integral of exp(M s)
        error = psi * (early + sizes(column([rate[ORDER] for rate in rates])) * last)
        needed = sizes(spread + psi * bound * spread + error)
        if all(a < b for a, b in zip(needed.entries(), width.entries())):
            break
        width = sizes(needed * WIDER)
    else:
        return None
    _, along = differentiated(field, table, width, ORDER)
    thin, early = [identity(size)], arb_mat(size, size)
    for k in range(ORDER):
        rate = sum((along[j] * thin[k - j] for j in range(k + 1)), arb_mat(size, size))
        thin.append((rate * (1 / arb(k + 1))).mid())
        early += sizes(rate - thin[-1] * arb(k + 1)) * length**k
    variation = arb_mat([list(each.entries()) for each in thin])
    later = shifted(variation, arb(length / 2, length / 2)).tolist()
    late = sum((linear[k] * arb_mat(size, size, later[ORDER - k]) for k in range(ORDER + 1)), arb_mat(size, size))
    derivative = arb_mat(size, size, at(variation, length)) + around(psi * (early + sizes(late) * last))
    end = column(at(table, length)) + around(error)
    for matrix, most in ((end, ERROR), (derivative, BY_START)):
        if not all(each.rad() < most for each in matrix.entries()):
            return None
    return Step(table, length, list(around(width).entries()), end, derivative)


class Carried(NamedTuple):
    """What becomes of a box of starts z + delta, `delta` (n, 1): the states x + frame (s + by_start delta).

    x is thin, the frame too, s a small ball that the centre's own errors fill; frame times by_start, a matrix of balls,
    is the derivative by the start. The frame is made anew after each map from the longest sides (scaled QR), so that it
    turns with the flow and the balls do not wrap around (Lohner).
    """

    x: Matrix
    frame: Matrix
    s: Matrix
    by_start: Matrix
    delta: Matrix

    @property
    def spread(self) -> Matrix:
        """States less x, as a box (n, 1)."""
        return self.frame * (self.s + self.by_start * self.delta)

    @property
    def hull(self) -> list[Ball]:
        """A box that holds the states."""
        return list((self.x + self.spread).entries())

    def after(self, end: Matrix, derivative: Matrix) -> Carried:
        """The set after a map that takes x to `end` and has this derivative over the hull."""
        turned, x = derivative * self.frame, end.mid()
        radii = np.array([float(each.abs_upper()) for each in (self.s + self.by_start * self.delta).entries()])
        sides = np.array(turned.mid().tolist(), dtype=float) * np.maximum(radii, 1e-300)
        order = np.argsort(-np.linalg.norm(sides, axis=0))
        frame = arb_mat(np.linalg.qr(sides[:, order] / max(np.abs(sides).max(), 1e-300))[0].tolist())
        back = frame.inv()
        turned = back * turned
        return Carried(x, frame, turned * self.s + back * (end - x), turned * self.by_start, self.delta)
