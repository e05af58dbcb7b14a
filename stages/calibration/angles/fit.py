"""A robot from many steps: its numbers by least squares, each step's start solved for within it.

A step's start touches that step alone, so its four values are eliminated from each step's equations (variable
projection to first order), and what is left are equations for the robot.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stages.analytic.model.walker import Vector
from stages.calibration.angles.recording import DrivenStep
from stages.calibration.angles.robot import Robot, show
from stages.calibration.errors import NotIdentified
from stages.calibration.estimation.campaign import covariance_of
from stages.calibration.estimation.known import Known, information_of

#: Iterations, the share of the cost at which it rests, and samples that a first guess of a start is drawn through.
MOST, RESTS, GUESS = 60, 1e-7, 40
#: Longest move at once, in usual changes; and the fall of the cost that is no fall.
LONGEST, AT_REST = 3.0, 0.1


@dataclass(frozen=True)
class AngleFit:
    """The robot and its `names` (m,) that were looked for; `information` (m, m) on them for angles to `noise` [rad],
    what is `known` (m, m) included; `pulls` (steps, m): each step's own pull on them; starts by step; residuals [rad]
    by step (n, 2): stance angle, angle between the legs; and whether it came to rest.
    """

    robot: Robot
    names: tuple[str, ...]
    noise: float
    information: np.ndarray
    known: np.ndarray
    pulls: np.ndarray
    starts: dict[int, Vector]
    residuals: dict[int, np.ndarray]
    converged: bool
    iterations: int

    def covariance(self, sizes: Vector) -> np.ndarray:
        """Of the numbers (m, m), from how much the steps' pulls differ: residuals of one step hang together (the
        sandwich of Huber and White, with a step as a cluster). Infinite for what nothing is told of.
        """
        inverse = covariance_of(self.information, sizes)
        told = np.isfinite(np.diag(inverse))
        part = np.where(np.outer(told, told), inverse, 0.0)
        spread = self.pulls.T @ self.pulls * len(self.pulls) / max(1, len(self.pulls) - len(self.names))
        found = part @ (spread + self.known) @ part
        return np.asarray(np.where(np.outer(told, told), found, np.where(np.eye(len(told)) > 0, inverse, 0.0)))

    @property
    def size(self) -> float:
        """Root mean square residual in noises."""
        return float(np.sqrt(np.mean(np.concatenate(list(self.residuals.values())) ** 2))) / self.noise

    def rms(self) -> tuple[float, float]:
        """Root mean square residual of the angle between the legs and of the stance angle [rad]."""
        every = np.concatenate(list(self.residuals.values()))
        stance, between = np.sqrt((every**2).mean(axis=0))
        return float(between), float(stance)


def guess(step: DrivenStep) -> Vector:
    """A start from cubics through the first samples, (4,)."""
    n = min(GUESS, len(step.stance))
    time = step.interval * np.arange(n)
    stance, between = np.polyfit(time, step.stance[:n], 3), np.polyfit(time, step.between[:n], 3)
    return np.array([stance[-1], between[-1] - stance[-1], stance[-2], between[-2] - stance[-2]])


def fit_robot(
    robot: Robot, steps: Sequence[DrivenStep], names: tuple[str, ...], sizes: Mapping[str, float],
    low: Mapping[str, float], known: Sequence[Known], noise: float, starts: Mapping[int, Vector] | None = None,
    again: int = 2,
) -> AngleFit:
    """Fit the numbers `names` and every step's start; with no names the starts alone.

    `sizes`: usual changes; `low`: least values; `noise` [rad] weighs the angles against the known values.
    Where it does not come to rest it begins `again` so often, with fresh starts: a step's own can be lost for good.
    Raises NotIdentified where the robot's angles do not stay finite from the first guess on.
    """
    size = np.array([sizes[name] for name in names])
    least = np.array([low.get(name, -np.inf) for name in names])
    x = np.array([robot.value(name) for name in names])
    own = {step.number: (starts or {}).get(step.number, guess(step)) for step in steps}
    damping, iterations, converged = 1e-3, 0, False
    at = _equations(robot.with_values(dict(zip(names, x, strict=True))), steps, own, names, known, noise)
    if not np.isfinite(at.cost):
        raise NotIdentified("the robot as drawn does not follow these angles through one step: check the columns' "
                            "units and signs, and the design's values")
    while iterations < MOST:
        iterations += 1
        free = ~((x <= least) & (at.right <= 0.0))
        matrix = (at.matrix * size * size[:, None])[np.ix_(free, free)]
        move = np.zeros(len(names))
        if free.any():
            damped = matrix + damping * np.diag(np.diag(matrix)) + 1e-9 * np.eye(len(matrix))
            move[free] = np.linalg.lstsq(damped, (at.right * size)[free], rcond=1e-13)[0] * size[free]
        move /= max(1.0, float(np.abs(move / size).max(initial=0.0)) / LONGEST)
        there = np.maximum(x + move, least)
        moved = {number: own[number] + at.start_step(number, there - x) for number in own}
        tried = _equations(robot.with_values(dict(zip(names, there, strict=True))), steps, moved, names, known, noise)
        if not tried.cost <= at.cost:  # written so that NaN is refused
            damping *= 10.0
            if damping > 1e8:
                converged = at.foreseen(names, least, x) < AT_REST
                break
            continue
        rests = at.cost - tried.cost < RESTS * at.cost
        x, own, at, damping = there, moved, tried, max(damping / 10.0, 1e-9)
        if rests:
            converged = True
            break
    final = robot.with_values(dict(zip(names, x, strict=True)))
    if not converged and again:
        return fit_robot(final, steps, names, sizes, low, known, noise, None, again - 1)
    return AngleFit(final, names, noise, at.matrix, information_of(known, names), at.pulls, own, at.residuals,
                    converged, iterations)


@dataclass(frozen=True)
class _At:
    cost: float
    matrix: np.ndarray
    right: Vector
    pulls: np.ndarray
    residuals: dict[int, np.ndarray]
    solved: dict[int, tuple[Vector, np.ndarray, np.ndarray]]

    def foreseen(self, names: tuple[str, ...], least: Vector, x: Vector) -> float:
        """By how much the cost should fall with an undamped step."""
        free = ~((x <= least) & (self.right <= 0.0))
        return 0.5 * float(self.right[free] @ np.linalg.lstsq(
            self.matrix[np.ix_(free, free)], self.right[free], rcond=1e-13)[0]) if names and free.any() else 0.0

    def start_step(self, number: int, move: Vector) -> Vector:
        """How a step's start moves with the numbers."""
        right, cross, triangle = self.solved[number]
        return np.asarray(np.linalg.lstsq(triangle, right - cross @ move, rcond=1e-12)[0])


def _equations(
    robot: Robot, steps: Sequence[DrivenStep], starts: Mapping[int, Vector], names: tuple[str, ...],
    known: Sequence[Known], noise: float,
) -> _At:
    """The equations for the numbers, starts eliminated."""
    m = len(names)
    matrix, right, cost = np.zeros((m, m)), np.zeros(m), 0.0
    pulls, residuals = [], {}
    solved: dict[int, tuple[Vector, np.ndarray, np.ndarray]] = {}
    for step in steps:
        shown = show(robot, step, starts[step.number], names)
        n = len(shown.angles)
        left = np.column_stack([step.stance[:n], step.between[:n]]) - shown.angles
        if n < len(step.stance):
            cost += 1e6 * (len(step.stance) - n)
        residuals[step.number] = left
        if not np.isfinite(left).all():  # the walk ran away, so the try is refused
            return _At(math.inf, matrix, right, np.zeros((len(steps), m)), residuals, solved)
        r, jacobian = left.ravel() / noise, shown.by.reshape(2 * n, m) / noise
        q, triangle = np.linalg.qr(shown.by_start.reshape(2 * n, 4) / noise)
        solved[step.number] = q.T @ r, q.T @ jacobian, triangle
        reduced = jacobian - q @ (q.T @ jacobian)
        rest = r - q @ (q.T @ r)
        matrix += reduced.T @ reduced
        pull = reduced.T @ rest
        right += pull
        pulls.append(pull)
        cost += 0.5 * float(r @ r)
    for one in known:
        row = one.row(names)
        off = (sum(share * robot.value(name) for name, share in one.parts().items()) - one.value) / one.sd
        matrix += np.outer(row, row) / one.sd**2
        right -= row * off / one.sd
        cost += 0.5 * off**2
    return _At(cost, matrix, right, np.array(pulls).reshape(len(steps), m), residuals, solved)
