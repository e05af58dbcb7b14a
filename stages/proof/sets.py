"""Sets of states that are carried through flow, events and impacts: parallelepipeds about a centre (Lohner).

A set holds what becomes of a box of starts z + delta. Its state is x + B (s + R delta): x thin, B a thin frame, s a
small ball that the centre's own errors fill, and R a matrix of balls, so that B R holds the derivative by the start.
The frame is made anew at each step from the longest sides (scaled QR), so that it turns with the flow and the balls do
not wrap around.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from flint import arb, arb_mat

from stages.proof.flow import Ball, Matrix, column
from stages.proof.jets import gradient


class Scalar(NamedTuple):
    """A number that depends on the start: its value at the centre, and its derivative (1, n) over the box."""

    value: Ball
    row: Matrix

    def over(self, delta: Matrix) -> Ball:
        """Its values over a box of starts (n, 1) about the centre."""
        return self.value + (self.row * delta)[0, 0]

    def more(self, other: Scalar) -> Scalar:
        """The sum of both."""
        return Scalar(self.value + other.value, self.row + other.row)


class Carried(NamedTuple):
    """A set of states over a box of starts `delta` (n, 1)."""

    x: Matrix
    frame: Matrix
    s: Matrix
    by_start: Matrix
    delta: Matrix

    @classmethod
    def box(cls, centre: Sequence[Ball], delta: Matrix) -> Carried:
        """The box of starts itself, about a thin centre."""
        size = len(centre)
        one = arb_mat(size, size, [arb(int(i == j)) for i in range(size) for j in range(size)])
        return cls(column(centre), one, arb_mat(size, 1), one, delta)

    @property
    def spread(self) -> Matrix:
        """States less x, as a box (n, 1)."""
        return self.frame * (self.s + self.by_start * self.delta)

    @property
    def hull(self) -> list[Ball]:
        """A box that holds the states."""
        return list((self.x + self.spread).entries())

    @property
    def derivative(self) -> Matrix:
        """The derivative of the states by the start."""
        return self.frame * self.by_start

    @property
    def centre(self) -> list[Ball]:
        """A box that holds what becomes of the centre."""
        return list((self.x + self.frame * self.s).entries())

    def after(self, end: Matrix, derivative: Matrix) -> Carried:
        """The set after a map that takes x to `end` and has this derivative over the hull."""
        moved = derivative * self.frame
        radii = self.s + self.by_start * self.delta
        sides = np.array([[float(moved[i, j].mid()) for j in range(moved.ncols())] for i in range(moved.nrows())])
        sides = sides * np.array([max(float(each.abs_upper()), 1e-300) for each in radii.entries()])
        order = np.argsort(-np.linalg.norm(sides, axis=0))
        q, _ = np.linalg.qr(sides[:, order] / max(np.abs(sides).max(), 1e-300))
        frame = arb_mat(q.shape[0], q.shape[1], [arb(float(each)) for each in q.ravel()])
        back = frame.inv()
        turned, x = back * moved, end.mid()
        return Carried(x, frame, turned * self.s + back * (end - x), turned * self.by_start, self.delta)

    def scalar(self, function: Callable[[Sequence[Any]], Any]) -> Scalar:
        """A function of the states, by the mean value theorem."""
        row = arb_mat(1, self.x.nrows(), gradient(function, self.hull))
        at = function(list(self.x.entries()))
        return Scalar(at + (row * self.frame * self.s)[0, 0], row * self.frame * self.by_start)
