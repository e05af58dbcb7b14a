"""Steps that were not fitted: how well the robot explains them, and how well it foretells them from their beginning."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stages.analytic.model.walker import Vector
from stages.calibration.angles.fit import fit_robot
from stages.calibration.angles.recording import DrivenStep
from stages.calibration.angles.robot import Robot, show

#: Rounds in which a start is fitted at most, and the move, in rad and rad/s, after which it rests.
ROUNDS, AT_REST = 8, 1e-9


@dataclass(frozen=True)
class HeldOut:
    """Root mean square errors [rad], between the legs and of the stance angle: `fit` with the start fitted on the whole
    step, `foretold` with the start from the first `begun` seconds and errors over the rest, `alone` the same without
    belief in the other steps' starts."""

    steps: int
    begun: float
    fit: tuple[float, float]
    foretold: tuple[float, float]
    residuals: Mapping[int, np.ndarray]


def correlation_length(residuals: Mapping[int, np.ndarray]) -> float:
    """How many samples of the residuals together are worth one independent one: 1 + 2 sum of autocorrelations.

    Up to the first that is negative (Geyer's rule in its plainest form).
    """
    every = list(residuals.values())
    power = sum(float((one**2).sum()) for one in every) / sum(one.size for one in every)
    total, shortest = 1.0, min(len(one) for one in every)
    for lag in range(1, shortest):
        products = sum(float((one[lag:] * one[:-lag]).sum()) for one in every)
        rho = products / sum(one[lag:].size for one in every) / power
        if rho <= 0.0:
            break
        total += 2.0 * rho
    return total


def held_out(robot: Robot, steps: Sequence[DrivenStep], begun: float) -> HeldOut:
    """Errors on steps that were not fitted."""
    fitted = fit_robot(robot, steps, (), {}, {}, (), 1e-3)
    errors = np.concatenate([_foretold(robot, step, begun) for step in steps])
    stance, between = np.sqrt((errors**2).mean(axis=0))
    return HeldOut(len(steps), begun, fitted.rms(), (float(between), float(stance)), fitted.residuals)


def _foretold(robot: Robot, step: DrivenStep, begun: float) -> np.ndarray:
    """Errors (n, 2) after the beginning."""
    samples = round(begun / step.interval)
    seen = np.column_stack([step.stance, step.between])
    time = step.interval * np.arange(samples)
    stance, between = np.polyfit(time, seen[:samples], 2).T
    start: Vector = np.array([stance[-1], between[-1] - stance[-1], stance[-2], between[-2] - stance[-2]])
    for _ in range(ROUNDS):
        shown = show(robot, step, start, (), samples)
        n = len(shown.angles)
        move = np.linalg.lstsq(shown.by_start.reshape(2 * n, 4), (seen[:n] - shown.angles).ravel(), rcond=1e-12)[0]
        start = start + move
        if np.abs(move).max() < AT_REST:
            break
    shown = show(robot, step, start, ())
    return np.asarray((seen[: len(shown.angles)] - shown.angles)[samples:])
