"""Enclosures of a flow over one step of time, and of its derivative by the start: Taylor polynomials and their defects.

A polynomial p(t) of thin coefficients nearly solves y' = f(y). Its defect d = f(p) - p' has enclosed coefficients of
all powers below the order n, and a last one that holds at any time of the step (Taylor's theorem). For a solution y
with y(0) near p(0), the difference e = y - p has |e|' <= M |e| + |d|, where M bounds f's derivative over the tube
p + E: entries beside the diagonal by their size, on it by their upper end. So |e| is at most
|e(0)| + Psi (|M| |e(0)| + max |d|), with Psi the integral of exp(M s) over the step, as long as this stays within E; as
it is less than E, it does. The same holds for the columns of the derivative, whose field is linear.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from flint import arb, arb_mat, arb_series, ctx

from stages.proof.jets import Jet, jets

Ball = Any
Matrix = Any
#: A field of rates at a state, for numbers of any kind.
Field = Callable[[Sequence[Any]], list[Any]]
#: Order of the polynomials, bits of all balls, and how small a step's last coefficient makes its term.
ORDER, BITS, TINY = 28, 128, 1e-25
#: A step with a larger error of its own, or of its derivative by the start, is made shorter by this factor.
ERROR, BY_START, SHORTER = 1e-25, 1e-10, 0.7
#: A first guess of the tube is so many times what would do without curvature; it is widened this often, the step
#: made shorter this often.
WIDER, WIDENINGS, SHORTENINGS = 4, 2, 25


class NotProven(Exception):
    """A condition of the theorem could not be shown; the message says which one, and where."""


def column(values: Sequence[Ball]) -> Matrix:
    """Numbers as a matrix of one column."""
    return arb_mat(len(values), 1, list(values))


def sizes(matrix: Matrix) -> Matrix:
    """Upper bounds of the sizes of all entries."""
    return arb_mat(matrix.nrows(), matrix.ncols(), [upper(entry) for entry in matrix.entries()])


def upper(ball: Ball) -> Ball:
    """The largest size of a number in a ball, thin."""
    return arb(ball.abs_upper())


def widest(matrix: Matrix) -> float:
    """The largest radius of an entry."""
    return max(float(each.rad()) for each in matrix.entries())


def around(matrix: Matrix) -> Matrix:
    """Balls about zero of these radii."""
    return arb_mat(matrix.nrows(), matrix.ncols(), [arb(0, entry.abs_upper()) for entry in matrix.entries()])


class Polynomial(NamedTuple):
    """Coefficients of a polynomial in time by power, each (n,), and the enclosed coefficients of its defect."""

    coefficients: list[list[Ball]]
    defects: list[list[Ball]]

    def at(self, time: Ball) -> list[Ball]:
        """Its values (n,) at a ball of times."""
        middle, rest = time.mid(), time - time.mid()
        moved = self.moved(middle) if not rest.is_zero() else self
        found = list(moved.coefficients[-1])
        for one in reversed(moved.coefficients[:-1]):
            found = [a * (rest if moved is not self else middle) + b for a, b in zip(found, one)]
        return found

    def moved(self, time: Ball) -> Polynomial:
        """The polynomial in the time since `time`, which may be a ball."""
        size = len(self.coefficients)
        table = arb_mat(size, len(self.coefficients[0]), [each for row in self.coefficients for each in row])
        found = shift(size, time) * table
        return Polynomial([[found[i, j] for j in range(found.ncols())] for i in range(size)], [])


def shift(size: int, time: Ball) -> Matrix:
    """The matrix that takes coefficients of a polynomial in t to those in t - time."""
    powers = [arb(1)]
    for _ in range(size - 1):
        powers.append(powers[-1] * time)
    return arb_mat(size, size, [
        arb.bin_uiui(j, i) * powers[j - i] if j >= i else arb(0) for i in range(size) for j in range(size)])


def expanded(field: Field, start: Sequence[Ball]) -> Polynomial:
    """The solution's Taylor polynomial from a thin `start`."""
    coefficients, defects = [list(start)], []
    for k in range(ORDER):
        ctx.cap = k + 1
        rates = field([arb_series([row[i] for row in coefficients]) for i in range(len(start))])
        exact = [rate[k] for rate in rates]
        following = [(rate / (k + 1)).mid() for rate in exact]
        coefficients.append(following)
        defects.append([rate - (k + 1) * after for rate, after in zip(exact, following)])
    return Polynomial(coefficients, defects)


def differentiated(field: Field, coefficients: Sequence[Sequence[Ball]], cap: int, width: Sequence[Ball]
                   ) -> tuple[list[Any], list[Matrix]]:  # fmt: skip
    """Rates along a polynomial as series of `cap` powers, and the derivative's matrices by power, for all states that
    are nearer to the polynomial than `width`.
    """
    ctx.cap = cap
    size = len(width)
    states = [arb_series([coefficients[0][i] + width[i], *(row[i] for row in coefficients[1:])]) for i in range(size)]
    found = field(jets(states, arb_series([1])))
    entries = [[None] * size if not isinstance(one, Jet) else one.d for one in found]
    zero = arb(0)
    matrices = [arb_mat(size, size, [zero if e is None else e if isinstance(e, int) else e[k]
                                     for row in entries for e in row]) for k in range(cap)]  # fmt: skip
    return [one.v for one in found], matrices


def quick_enough(polynomial: Polynomial) -> float:
    """A step after which the last terms of a polynomial are tiny."""
    largest = [(power, max(float(upper(each)) for each in row))
               for power, row in enumerate(polynomial.coefficients) if power >= ORDER - 1]  # fmt: skip
    return min(float((TINY / max(size, 1e-200)) ** (1.0 / power)) for power, size in largest)


class Step(NamedTuple):
    """A step of time `length`: its polynomial, how far solutions from the set are from it, where they end, and the
    derivative of the end by the start.
    """

    polynomial: Polynomial
    length: Ball
    width: list[Ball]
    end: Matrix
    derivative: Matrix

    def tube(self, times: Ball) -> list[Ball]:
        """All states at these times."""
        return [a + b for a, b in zip(self.polynomial.at(times), self.width)]


def step(field: Field, polynomial: Polynomial, length: float, spread: Sequence[Ball], exact: bool = False) -> Step:
    """The step of `length`, or, unless that is `exact`, of a part of it, of all solutions that start nearer to the
    polynomial's start than `spread`. Raises NotProven.
    """
    for _ in range(SHORTENINGS):
        for widening in range(WIDENINGS):
            found = _attempt(field, polynomial, arb(length), column(spread), WIDER * 8**widening)
            if found is not None and (exact or (widest(found.end) <= ERROR and widest(found.derivative) <= BY_START)):
                return found
            if found is not None:
                break
        if exact:
            break
        length *= SHORTER
    raise NotProven("the flow could not be enclosed")


def _attempt(field: Field, polynomial: Polynomial, length: Ball, spread: Matrix, wider: int) -> Step | None:
    """The step, if solutions stay in the tube that is guessed."""
    size, power = spread.nrows(), length**ORDER
    over = polynomial.moved(length / 2).moved(arb(0, length / 2))  # at any time of the step
    early = [sum((upper(row[i]) * length**k for k, row in enumerate(polynomial.defects)), arb(0)) for i in range(size)]
    # The guess: as if the derivative along the polynomial were that in the tube, and its last term the defect's.
    _, linear = differentiated(field, over.coefficients[:1], 1, [arb(0)] * size)
    last = [upper(value) * power * 4 for value in polynomial.coefficients[-1]]
    reach = _reached(linear[0], length, spread, [a + b for a, b in zip(early, last)])[0] * arb(wider)
    width = [arb(0, each.abs_upper()) for each in reach.entries()]
    rates, linear = differentiated(field, over.coefficients, ORDER + 1, width)
    if not all(entry.is_finite() for entry in linear[ORDER].entries()):
        return None
    needed, psi, error = _reached(linear[0], length, spread, [a + upper(rate[ORDER]) * power
                                                              for a, rate in zip(early, rates)])  # fmt: skip
    if not all(a < b for a, b in zip(needed.entries(), reach.entries())):
        return None
    thin, variation, beside = _variation(field, polynomial, width, length)
    stacked = arb_mat(ORDER + 1, size * size, [each for one in thin for each in one.entries()])
    moved = (shift(ORDER + 1, arb(length / 2, length / 2)) * stacked).tolist()
    late = arb_mat(size, size)
    for k in range(ORDER + 1):
        late += linear[k] * arb_mat(size, size, moved[ORDER - k])
    end = column(polynomial.at(length)) + around(error)
    return Step(polynomial, length, width, end, variation + around(psi * (beside + sizes(late) * power)))


def _reached(linear: Matrix, length: Ball, spread: Matrix, defect: Sequence[Ball]) -> tuple[Matrix, Matrix, Matrix]:
    """How far from the polynomial solutions come that start within `spread`, given the derivative in the tube and a
    bound of the defect; Psi; and how far the one from its start comes.
    """
    psi, bound = _spreading(linear, length)
    error = psi * column(defect)
    return sizes(spread + psi * sizes(bound) * spread + error), psi, error


def _spreading(linear: Matrix, length: Ball) -> tuple[Matrix, Matrix]:
    """The integral of exp(M s) over the step, and M, which bounds what a derivative `linear` does to sizes."""
    size = linear.nrows()
    bound = arb_mat(size, size, [
        arb(linear[i, j].upper()) if i == j else upper(linear[i, j]) for i in range(size) for j in range(size)])
    whole = arb_mat(2 * size, 2 * size)
    for i in range(size):
        whole[i, size + i] = length
        for j in range(size):
            whole[i, j] = bound[i, j] * length
    found = whole.exp()
    return sizes(arb_mat(size, size, [found[i, size + j] for i in range(size) for j in range(size)])), bound


def _variation(field: Field, polynomial: Polynomial, width: Sequence[Ball], length: Ball
               ) -> tuple[list[Matrix], Matrix, Matrix]:  # fmt: skip
    """Thin coefficients of the derivative by the start, its value after the step, and bounds of its early defects."""
    size = len(width)
    _, linear = differentiated(field, polynomial.coefficients, ORDER, width)
    thin = [arb_mat(size, size, [arb(int(i == j)) for i in range(size) for j in range(size)])]
    beside, power = arb_mat(size, size), arb(1)
    for k in range(ORDER):
        rate = arb_mat(size, size)
        for j in range(k + 1):
            rate += linear[j] * thin[k - j]
        thin.append((rate * (1 / arb(k + 1))).mid())
        beside += sizes(rate - thin[-1] * arb(k + 1)) * power
        power *= length
    value = thin[-1]
    for one in reversed(thin[:-1]):
        value = value * length + one
    return thin, value, beside
