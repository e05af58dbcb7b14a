"""Whether steps of a driven walker are of the robot that others were fitted to, and which of its numbers has changed.

Numbers that are fitted to the new steps differ from the robot's by chance, as the covariances of both fits say. Of one
that has changed alone, generalised least squares of these differences show the change, which are a score test too. A
recording that was turned or exchanged is one whose opposite fits better than any change of a number does.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from operator import attrgetter
from pathlib import Path

import numpy as np

from stages.analytic.model.walker import Vector
from stages.biped.question import Answer, Asking, refuse
from stages.calibration.angles.fit import AngleFit, fit_robot
from stages.calibration.angles.recording import DrivenStep, read_steps
from stages.calibration.angles.robot import AngleSetup
from stages.calibration.estimation.least_squares import NotIdentified
from stages.calibration.following.robot_file import KINDS, Kept
from stages.calibration.following.score_test import Change, Part, Verdict, by_chance, shifts, verdict
from stages.calibration.information.identifiability import short
from stages.calibration.reports.change_report import answered

#: Sum of squares of steps that no robot near this one follows, and a variance of what is not determined.
LOST = 1e12
#: What may be turned of a recording: by its words, the signs of stance angle, angle between the legs and signal as a
#: step has them, and whether the other leg stands.
TURNED = {"sign of the stance angle": (-1, 1, 1, False), "sign of the hip angle": (1, -1, 1, False),
          "sign of the motor's signal": (1, 1, -1, False), "which leg is said to stand": (1, -1, -1, True),
          "legs, one for the other": (1, 1, 1, True)}  # fmt: skip


@dataclass(frozen=True)
class FittedEncoders(Kept):
    """How the recording is read and what is looked for, the robot as it was found; the `covariance` (m, m) of its
    numbers by the scatter of `steps` steps; `noise` [rad] that one sample is worth; mean and standard deviation between
    steps of the logarithm of their residuals [rad]; changes that are neither large nor small, by name. While a leg
    stands, a row each: noise of the encoders `encoded` (2, 2) [rad], and by how much the rates of both angles are
    `unmodelled` (2, 2) [rad^2/s^3]."""

    KIND = KINDS[1]

    setup: AngleSetup
    covariance: np.ndarray
    noise: float
    steps: int
    log_size: tuple[float, float]
    sizes: Mapping[str, float]
    encoded: np.ndarray = field(default_factory=lambda: np.zeros((2, 2)))
    unmodelled: np.ndarray = field(default_factory=lambda: np.zeros((2, 2)))

    @classmethod
    def of(cls, setup: AngleSetup, fit: AngleFit) -> FittedEncoders:
        """That of a fit."""
        sizes, logs = setup.sizes(), log_sizes(fit)
        covariance = fit.covariance(np.array(list(sizes.values())))
        covariance = np.where(np.isfinite(covariance), covariance, LOST)
        return cls(replace(setup, robot=fit.robot), covariance, fit.noise, len(fit.starts),
                   (float(logs.mean()), float(logs.std(ddof=1))), sizes)  # fmt: skip


def turned(step: DrivenStep, stance: int, between: int, signal: int, other: bool) -> DrivenStep:
    """A step with signs turned, or as one of the `other` leg."""
    return replace(step, stance=stance * step.stance, between=between * step.between, signal=signal * step.signal,
                   leg=1 - step.leg if other else step.leg)


def held(robot: FittedEncoders, steps: Sequence[DrivenStep], again: int = 2) -> tuple[Verdict, float]:
    """Steps as they are, held to the robot, and the sum of squares that is left with what the numbers' differences
    count for; a fit that does not come to rest begins `again` so often."""
    setup, sizes = robot.setup, robot.sizes
    try:
        fit = fit_robot(setup.robot, steps, setup.free, sizes, setup.low(), setup.known, robot.noise, None, again)
    except NotIdentified:
        return Verdict(0.0, (), math.inf, False), LOST
    scales = np.array([sizes[name] for name in setup.free])
    spread = fit.covariance(scales)
    both = robot.covariance + np.where(np.isfinite(spread), spread, LOST * np.diag(scales**2))
    information = np.linalg.inv(both / np.outer(scales, scales)) / np.outer(scales, scales)
    off = np.array([fit.robot.value(name) - setup.robot.value(name) for name in setup.free])
    parts = [Part(short(name), setup.robot.unit(name), (name,), setup.robot.value(name)) for name in setup.free]
    freedom = max(1, min(robot.steps, len(steps)) - len(scales))
    found = [Change(part, float(change), float(sd), float(change / sd) ** 2, freedom)
             for part, (change, sd) in zip(parts, shifts(information @ off, information), strict=True)]  # fmt: skip
    logs, (mean, wide) = log_sizes(fit), robot.log_size
    larger = logs.mean() - mean
    of_residuals = by_chance(larger / (wide * math.sqrt(1.0 / len(logs) + 1.0 / robot.steps)), robot.steps - 1)
    judged = verdict(found, math.exp(larger), of_residuals)
    left = sum(float((one**2).sum()) for one in fit.residuals.values()) / robot.noise**2
    return judged if fit.converged else replace(judged, probability=0.0), left + float(off @ information @ off)


def log_sizes(fit: AngleFit) -> Vector:
    """Logarithms of the root mean square residuals [rad] of each step."""
    return np.array([0.5 * math.log(float((one**2).mean())) for one in fit.residuals.values()])


def judged(robot: FittedEncoders, steps: Sequence[DrivenStep]) -> Verdict:
    """Whether steps are the robot's, and if not what has changed or was turned."""
    as_it_is, left = held(robot, steps)
    if as_it_is.same:
        return as_it_is
    ways = {words: held(robot, [turned(one, *how) for one in steps], 0) for words, how in TURNED.items()}
    others = [Change(Part(words), math.nan, math.nan, left - least) for words, (_, least) in ways.items()]
    found = sorted([*as_it_is.changes, *others], key=attrgetter("explains"), reverse=True)
    best, _ = ways.get(found[0].part.name, (as_it_is, left))
    return replace(as_it_is, changes=tuple(found), explained=best.explained)


def answer(source: Path, folder: Path, asking: Asking) -> Answer:
    """The answer to `same` for a recording of encoders. Raises WrongOption."""
    robot = FittedEncoders.read(folder)
    setup = robot.setup
    steps = read_steps(source, setup.columns, setup.left_out, setup.markers, asking.reading)
    refuse((len(steps) <= len(setup.free), f"{source}: has {len(steps)} steps, and more than {len(setup.free)} are "
            "needed to show as many numbers of the robot"))  # fmt: skip
    return answered(judged(robot, steps), {"steps": len(steps)})
