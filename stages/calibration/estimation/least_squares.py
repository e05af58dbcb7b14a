"""Least squares by Levenberg and Marquardt's method, for fits of sensors and of angles, and what is known beside data.

Every fit brings equations of its own (matrix and right side), with what touches one run or step alone eliminated.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Generic, TypeVar

import numpy as np

from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.model.walker import Vector

State = TypeVar("State")
TOTAL_MASS = "total_mass"
#: A direction has information if it may not change by so many usual changes, in one over their square: by about all
#: that a parameter is. What round-off and curvature leave of one that no run shows is a millionth.
SEEN = 1e-3
#: A parameter known to a third of itself, in one over the square of that, is taken by its logarithm.
WELL = 9.0
#: How much of each parameter a known sum has.
SUMS = {TOTAL_MASS: {"biped.hip_mass": 1.0, "biped.foot_mass": 2.0, "biped.frame_mass": 2.0}}


class NotIdentified(ValueError):
    """The measurements do not determine what is sought; the message says what is missing."""


@dataclass(frozen=True)
class Known:
    """A value with its standard deviation: of the parameter `name` ("biped.leg_length"), of a sum ("total_mass"), or of
    parameters times `weights` (by name). Of those in `about` it has the logarithm of their share of a value: the scale
    of mass moves it nowhere, however far the parameters are from there."""

    name: str
    value: float
    sd: float
    source: str = ""
    weights: Mapping[str, float] = field(default_factory=dict, hash=False)
    about: Mapping[str, float] = field(default_factory=dict, hash=False)

    def row(self, names: Sequence[str], design: DesignPoint | None = None) -> Vector:
        """Its derivative by the parameters `names`, (n,), of a design whose legs are alike where these have no other
        leg's; at a `design`, which logarithms need."""
        if self.weights:
            return np.array([self.weights.get(name, 0.0) / (
                design.value(name) if design is not None and name in self.about else 1.0) for name in names])
        parts = dict(SUMS.get(self.name, {self.name: 1.0}))
        for name in (name for name in names if self.name in SUMS and name.startswith("biped.other_")):
            first = name.replace("other_", "")
            if first in parts:
                parts[first], parts[name] = 1.0, 1.0
        return np.array([parts.get(name, 0.0) for name in names])

    def of(self, design: DesignPoint) -> float:
        """What a design has of it."""
        if self.weights:
            return sum(weight * (math.log(design.value(name) / self.about[name]) if name in self.about
                                 else design.value(name)) for name, weight in self.weights.items())
        return design.biped.total_mass if self.name == TOTAL_MASS else design.value(self.name)


def combinations(names: Sequence[str], middle: Vector, information: np.ndarray, sizes: Vector) -> tuple[Known, ...]:
    """What an information matrix (n, n) shows of the parameters `names` about `middle` (n,): a known sum, with a
    standard deviation of one, for each direction that it shows anything of. `sizes` (n,) are changes for numerics."""
    values, vectors = np.linalg.eigh(information * sizes * sizes[:, None])
    rows = (vectors[:, values > SEEN] * np.sqrt(values[values > SEEN])).T / sizes
    shares = np.diag(information) * middle**2 > WELL
    about = {name: float(value) for name, value, by_share in zip(names, middle, shares, strict=True) if by_share}
    return tuple(Known(f"sum {number}", float(row[~shares] @ middle[~shares]), 1.0, "", dict(zip(
        names, (row * np.where(shares, middle, 1.0)).tolist(), strict=True)), about)
        for number, row in enumerate(rows, 1))  # fmt: skip


def information_of(
    known: Iterable[Known], names: Sequence[str], design: DesignPoint | None = None
) -> np.ndarray:
    """What known values add to the information (n, n) about the parameters `names`, at a design."""
    total = np.zeros((len(names), len(names)))
    for one in known:
        row = one.row(names, design)
        total += np.outer(row, row) / one.sd**2
    return total


def known_equations(
    known: Sequence[Known], found: Sequence[float], names: Sequence[str], design: DesignPoint | None = None
) -> tuple[np.ndarray, Vector, float]:
    """What known values add to matrix, right side and cost where what was `found` of them stands, at a design."""
    right, cost = np.zeros(len(names)), 0.0
    for one, value in zip(known, found, strict=True):
        off = value - one.value
        right -= one.row(names, design) * off / one.sd**2
        cost += 0.5 * (off / one.sd) ** 2
    return information_of(known, names, design), right, cost


@dataclass(frozen=True)
class Point(Generic[State]):
    """Where the method stands: unknowns `x` (n,), half the sum of squares, its equations (matrix (n, n), right side
    (n,)), and what the problem keeps of it.

    `spread` is the unit of a fall of the cost that counts, if it is above one: the mean square residual, where noise
    leaves one. `eliminated` is the fall to be had from unknowns that are not in the equations.
    """

    x: Vector
    cost: float
    matrix: np.ndarray
    right: Vector
    state: State
    spread: float = 1.0
    eliminated: float = 0.0


@dataclass(frozen=True)
class Rule:
    """How a fit goes and when it ends.

    It rests where the cost is foreseen to fall by less than `enough`, or fell by less than `rests` with a whole step,
    in the point's own unit; and where no step helps but less than `at_rest` is foreseen. A step helps that makes the
    cost larger by no more than a share `larger`. No step is longer than `longest` usual changes. Steps are damped, or
    `halved`: `caution` is the damping, or one over the share of a step, at first, at least, and from where a step is
    hopeless. Damping follows how well a gain was foreseen (H. B. Nielsen, Damping parameter in Marquardt's method,
    IMM-REP-1999-05). `most` counts evaluations; of halved steps those that help, each of which begins as a whole one.
    A combination of unknowns of which no more is known than `blind`, in one over the square of usual changes, stays
    where it is: nearly singular steps lead far along what nothing shows.
    """

    most: int = 150
    enough: float = 0.0
    rests: float = 0.0
    at_rest: float = 0.0
    larger: float = 1e-9
    longest: float = np.inf
    halved: bool = False
    caution: tuple[float, float, float] = (1e-3, 1e-9, 1e8)
    blind: float = 0.0
    step: str = "step"
    counted: str = "evaluations"


#: A fall of the cost this small moves no estimate by a twentieth of its standard error.
ENOUGH = 1e-3
#: What is foreseen along a narrow valley may be round-off: where next to nothing came of it, this little is none.
WHOLE_RUN = Rule(enough=ENOUGH, rests=1e-2, at_rest=1e-2)


#: Gives the point at some unknowns, reached from another by a share of its step; None where there is none.
Evaluate = Callable[[Vector, Point[State] | None, float], Point[State] | None]


def least_squares(
    evaluate: Evaluate[State], begin: Vector, sizes: Vector, low: Vector, rule: Rule = WHOLE_RUN
) -> tuple[Point[State], int, str]:
    """Bring the cost down from `begin` (n,) until it rests: where it ended, after how many evaluations, and why it did
    not come to rest, empty where it did.

    `sizes` (n,) are changes that are neither large nor small; no unknown goes below `low` (n,). Raises ValueError where
    there is no point at the start.
    """
    at = evaluate(begin, None, 1.0)
    if at is None:
        raise ValueError("no value at the start")
    first, least, hopeless = rule.caution
    caution, growth, evaluations, helped = first, 2.0, 1, 0
    while (helped if rule.halved else evaluations) < rule.most:
        newton, unit = _step(at, sizes, low, 0.0, rule.blind), max(at.spread, 1.0)
        if newton[1] < rule.enough * unit:
            return at, evaluations, ""
        if rule.halved:
            share = of_whole = 1.0 / caution
            step, foreseen = newton
        else:
            share, of_whole = 1.0, 1.0 / (1.0 + caution)
            step, foreseen = _step(at, sizes, low, caution, rule.blind)
        whole = max(1.0, float(np.abs(step / sizes).max(initial=0.0)) / rule.longest)
        tried = evaluate(np.maximum(at.x + share * step / whole, low), at, of_whole)
        evaluations += 1
        if tried is not None and tried.cost < at.cost + rule.larger * abs(at.cost):
            gain, at, helped = at.cost - tried.cost, tried, helped + 1
            if max(gain, 0.0 if rule.halved and caution <= first else newton[1]) < rule.rests * unit:
                return at, evaluations, ""
            as_foreseen = float(np.clip(gain / max(foreseen, 1e-300), 0.0, 1.0))
            kept = 0.0 if rule.halved else max(1.0 - (2.0 * as_foreseen - 1.0) ** 3, 0.1)
            caution, growth = max(caution * kept, least), 2.0
            continue
        caution *= growth
        growth *= 1.0 if rule.halved else 2.0
        if caution > hopeless:
            return at, evaluations, "" if newton[1] < rule.at_rest else f"no {rule.step} brings the residuals down"
    return at, evaluations, f"{rule.most} {rule.counted} were not enough"


def _step(at: Point[State], sizes: Vector, low: Vector, damping: float, blind: float) -> tuple[Vector, float]:
    """The damped step of all unknowns that are free to move, and by how much the cost should fall with it."""
    free = ~((at.x <= low) & (at.right <= 0.0))
    unit = sizes[free]
    matrix = at.matrix[np.ix_(free, free)] * unit * unit[:, None]
    right, basis = at.right[free] * unit, np.eye(len(unit))
    values, vectors = np.linalg.eigh(matrix) if blind else (np.ones(0), basis)
    if (values <= blind).any():
        basis = vectors[:, values > blind]
        matrix, right = basis.T @ matrix @ basis, basis.T @ right
    diagonal = np.diag(matrix)
    damped = matrix + np.diag(damping * diagonal + 1e-9)
    equal = 1.0 / np.sqrt(np.diag(damped))
    move = np.linalg.lstsq(damped * equal * equal[:, None], right * equal, rcond=1e-15)[0] * equal
    step = np.zeros(len(at.x))
    step[free] = basis @ move * unit
    return step, float(move @ right - 0.5 * move @ matrix @ move) + at.eliminated


def covariance_of(matrix: np.ndarray, sizes: Vector) -> np.ndarray:
    """Inverse of an information matrix, in equal units for numerics; infinite along what has no information."""
    values, vectors = np.linalg.eigh(matrix * sizes * sizes[:, None])
    seen = values > SEEN
    inverse = (vectors[:, seen] / values[seen]) @ vectors[:, seen].T
    blind = (np.abs(vectors[:, ~seen]) > 1e-3).any(axis=1)
    inverse[blind, blind] = np.inf
    return np.asarray(inverse * sizes * sizes[:, None])
