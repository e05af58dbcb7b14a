"""A robot from many steps: its numbers by least squares, each step's start solved for within it; and other steps.

A step's start touches that step alone, so its four values are eliminated from each step's equations (variable
projection to first order), and what is left are equations for the robot.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from stages.analytic.model.walker import Vector
from stages.calibration.angles.recording import DrivenStep
from stages.calibration.angles.robot import Robot, show
from stages.calibration.estimation.least_squares import (
    Known,
    NotIdentified,
    Point,
    Rule,
    covariance_of,
    information_of,
    known_equations,
    least_squares,
)

#: Of fits: they rest by a share of the cost.
ANGLES = Rule(61, rests=1e-7, at_rest=0.1, longest=3.0)
#: Samples that a first guess of a start is drawn through.
GUESS = 40


@dataclass(frozen=True)
class Steps:
    """Of each step its start, residuals [rad] (n, 2): stance angle, angle between the legs, and the equations for its
    start: right side, by the numbers, matrix; and `pulls` (steps, m): each one's own pull on the numbers."""

    starts: dict[int, Vector]
    residuals: dict[int, np.ndarray]
    pulls: np.ndarray
    solved: dict[int, tuple[Vector, np.ndarray, np.ndarray]]

    def moved(self, move: Vector, share: float) -> dict[int, Vector]:
        """The starts that go with a move of the numbers, by a share of what each is off itself: where the hip comes to
        rest, residuals bend, and all of it may lead away."""
        return {number: self.starts[number] + np.linalg.lstsq(triangle, share * right - cross @ move, rcond=1e-12)[0]
                for number, (right, cross, triangle) in self.solved.items()}  # fmt: skip


@dataclass(frozen=True)
class AngleFit(Steps):
    """The robot and its `names` (m,) that were looked for; `information` (m, m) on them for angles to `noise` [rad],
    what is `known` (m, m) included; and whether it came to rest.
    """

    robot: Robot
    names: tuple[str, ...]
    noise: float
    information: np.ndarray
    known: np.ndarray
    converged: bool
    iterations: int

    def covariance(self, sizes: Vector) -> np.ndarray:
        """Of the numbers (m, m), from how much the steps' pulls differ: residuals of one step hang together (the
        sandwich of Huber and White, with a step as a cluster). Infinite for what has no information.
        """
        inverse = covariance_of(self.information, sizes)
        determined = np.isfinite(np.diag(inverse))
        part = np.where(np.outer(determined, determined), inverse, 0.0)
        spread = self.pulls.T @ self.pulls * len(self.pulls) / max(1, len(self.pulls) - len(self.names))
        found = part @ (spread + self.known) @ part
        alone = np.where(np.eye(len(determined)) > 0, inverse, 0.0)
        return np.asarray(np.where(np.outer(determined, determined), found, alone))

    @property
    def size(self) -> float:
        """Root mean square residual in noises."""
        return float(np.sqrt(np.mean(np.concatenate(list(self.residuals.values())) ** 2))) / self.noise

    def rms(self) -> tuple[float, float]:
        """Root mean square residual of the angle between the legs and of the stance angle [rad]."""
        return _rms(np.concatenate(list(self.residuals.values())))


def _rms(residuals: np.ndarray) -> tuple[float, float]:
    stance, between = np.sqrt((residuals**2).mean(axis=0))
    return float(between), float(stance)


def guess(step: DrivenStep, samples: int = GUESS, order: int = 3) -> Vector:
    """A start (4,) from polynomials through the first samples."""
    seen = step.angles[:samples]
    stance, between = np.polyfit(step.interval * np.arange(len(seen)), seen, order).T
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
    own = {step.number: (starts or {}).get(step.number, guess(step)) for step in steps}

    def evaluate(x: Vector, before: Point[Steps] | None, share: float) -> Point[Steps] | None:
        begin = own if before is None else before.state.moved(x - before.x, share)
        return _equations(robot.with_values(dict(zip(names, x, strict=True))), steps, begin, names, known, noise)

    try:
        at, evaluations, why = least_squares(
            evaluate, np.array([robot.value(name) for name in names]), np.array([sizes[name] for name in names]),
            np.array([low.get(name, -np.inf) for name in names]), ANGLES)
    except ValueError:
        raise NotIdentified("the robot as given does not follow these angles through one step: check the columns' "
                            "units and signs, and the design's values") from None
    final = robot.with_values(dict(zip(names, at.x, strict=True)))
    if why and again:
        return fit_robot(final, steps, names, sizes, low, known, noise, None, again - 1)
    return AngleFit(**vars(at.state), robot=final, names=names, noise=noise, information=at.matrix,
                    known=information_of(known, names), converged=not why, iterations=evaluations - 1)


def _equations(
    robot: Robot, steps: Sequence[DrivenStep], starts: dict[int, Vector], names: tuple[str, ...],
    known: Sequence[Known], noise: float,
) -> Point[Steps] | None:
    """The equations for the numbers, starts eliminated; None where a walk runs away."""
    m = len(names)
    matrix, right, cost = known_equations(known, [robot.value(one.name) for one in known], names)
    pulls, residuals = [], {}
    solved: dict[int, tuple[Vector, np.ndarray, np.ndarray]] = {}
    for step in steps:
        angles, by_start, by = show(robot, step, starts[step.number], names)
        n = len(angles)
        left = step.angles[:n] - angles
        if not np.isfinite(left).all():
            return None
        residuals[step.number] = left
        counts = step.weights[:n].reshape(2 * n, 1) / noise
        r, jacobian = left.ravel() * counts[:, 0], by.reshape(2 * n, m) * counts
        q, triangle = np.linalg.qr(by_start.reshape(2 * n, 4) * counts)
        solved[step.number] = q.T @ r, q.T @ jacobian, triangle
        reduced = jacobian - q @ (q.T @ jacobian)
        pulls.append(reduced.T @ (r - q @ (q.T @ r)))
        matrix += reduced.T @ reduced
        right += pulls[-1]
        cost += 0.5 * float(r @ r) + 1e6 * (len(step.stance) - n)
    return Point(np.array([robot.value(name) for name in names]), cost, matrix, right,
                 Steps(starts, residuals, np.array(pulls).reshape(len(steps), m), solved), cost)


@dataclass(frozen=True)
class HeldOut:
    """Root mean square errors [rad] on steps that were not fitted, between the legs and of the stance angle: `fit` with
    the start fitted on the whole step, `predicted` with the start from a first part of it and errors over the rest.
    """

    fit: tuple[float, float]
    predicted: tuple[float, float]
    residuals: Mapping[int, np.ndarray]


def held_out(robot: Robot, steps: Sequence[DrivenStep], begun: float) -> HeldOut:
    """Errors on steps that were not fitted, predicted from the first `begun` [s] of each."""
    count = [round(begun / step.interval) for step in steps]
    begins = [replace(step, stance=step.stance[:n], between=step.between[:n])
              for n, step in zip(count, steps, strict=True)]  # fmt: skip
    guesses = {step.number: guess(step, len(step.stance), 2) for step in begins}
    whole, first = (fit_robot(robot, each, (), {}, {}, (), 1e-3, starts)
                    for each, starts in ((steps, None), (begins, guesses)))  # fmt: skip
    errors = [_errors(robot, step, first.starts[step.number])[n:] for n, step in zip(count, steps, strict=True)]
    return HeldOut(whole.rms(), _rms(np.concatenate(errors)), whole.residuals)


def _errors(robot: Robot, step: DrivenStep, start: Vector) -> np.ndarray:
    """What a walk from a start leaves of the angles (n, 2)."""
    shown, _, _ = show(robot, step, start, ())
    return np.asarray(step.angles[: len(shown)] - shown)
