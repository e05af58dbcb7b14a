"""A driven robot that is followed by its encoders: the state of each step, one sample after another.

It is the extended Kalman filter: state and numbers of the robot are Gaussian, and walk from sample to sample with exact
derivatives. What moves the legs in no model is white noise in the rates of the angles shown, as large as makes
innovations of the steps that were fitted as large as they are said to be.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from stages.analytic.model.walker import Vector
from stages.calibration.angles.fit import guess
from stages.calibration.angles.recording import DrivenStep
from stages.calibration.angles.robot import OF_STATE, drive_of
from stages.calibration.angles.same import LOST, FittedEncoders
from stages.calibration.following.step import take_readings

#: A step's first samples, through which its start is guessed; nothing is estimated before them.
BEGIN, ORDER = 12, 2
#: Standard deviation of that guess [rad], and of its rates in pendulum times.
OPEN = 0.05
#: Rates of stance and swing angle by those of the angles that are shown.
BY_SHOWN = np.array([[1.0, 0.0], [-1.0, 1.0]])
#: Noise is what is left of a smooth curve in differences of this order; the sum of squares of their weights.
DIFFERENCES, WEIGHTS = 4, 70.0
#: Times that noise in the rates is set again, with the power of what innovations are larger than said.
ROUNDS, POWER = 10, 1.5
#: Steps of either leg that show it are so many at least, where there are.
ENOUGH = 6


@dataclass(frozen=True)
class Seen:
    """What is known right after a sample at `time` [s]: stance angle, swing angle and their rates (4,), SI, with
    `covariance` (4, 4). `innovation` (2,): the angles less what was expected, in standard deviations and independent.
    """

    time: float
    state: Vector
    covariance: np.ndarray
    innovation: Vector


def follow(robot: FittedEncoders, step: DrivenStep) -> Iterator[Seen]:
    """What is known of a step after each sample, from its first ones on, and as long as its hip does not chatter.

    Numbers that no fitted step shows are as they are.
    """
    names = robot.setup.free
    drive, m = drive_of(robot.setup.robot, step, names), len(names)
    quick = np.sqrt(drive.design.slope.gravity / drive.design.biped.leg_length)
    known = np.append(guess(step, BEGIN, ORDER), np.zeros(m))
    spread = np.zeros((4 + m, 4 + m))
    spread[range(4), range(4)] = np.square(OPEN * np.array([1.0, 1.0, quick, quick]))
    spread[4:, 4:] = np.where(np.abs(robot.covariance) < LOST, robot.covariance, 0.0)
    shown = np.hstack([OF_STATE, drive.by_zeros])
    wander = np.zeros((4 + m, 4 + m))
    wander[2:4, 2:4] = BY_SHOWN @ np.diag(robot.unmodelled[step.leg] * step.interval) @ BY_SHOWN.T
    for number, angles in enumerate(step.angles):
        innovation = take_readings(known, spread, angles - drive.zeros, shown, robot.encoded[step.leg] ** 2, np.inf)
        if number >= BEGIN:
            yield Seen(step.begins + number * step.interval, known[:4].copy(), spread[:4, :4].copy(), innovation)
        driven = drive.along(known[:4], step.interval, slice(number, number + 2))
        if len(driven.states) < 2:
            return
        onwards = np.eye(4 + m)
        onwards[:4, :4] = driven.by_start[1]
        onwards[:4, [4 + place for place in drive.places]] = driven.along[1]
        known[:4] = driven.states[1] + driven.along[1] @ known[4:][drive.places]
        spread = onwards @ spread @ onwards.T + wander


def with_noise(robot: FittedEncoders, steps: Sequence[DrivenStep]) -> FittedEncoders:
    """A robot that was fitted to steps of both legs, with the noise that these have."""
    by_leg = [[step for step in steps if step.leg == leg] for leg in (0, 1)]
    some = [each[:: max(1, len(each) // ENOUGH)] for each in by_leg]
    design = robot.setup.robot.design
    usual = OPEN**2 * (design.slope.gravity / design.biped.leg_length) ** 1.5
    found = replace(robot, encoded=np.array([_roughness(each) for each in by_leg]),
                                unmodelled=np.full((2, 2), usual))  # fmt: skip
    for _ in range(ROUNDS):
        larger = np.array([_larger(found, each) for each in some])
        found = replace(found, unmodelled=found.unmodelled * larger**POWER)
    return found


def _roughness(steps: Sequence[DrivenStep]) -> Vector:
    """Noise (2,) of the angles of steps [rad]."""
    rough = np.concatenate([np.diff(step.angles, DIFFERENCES, axis=0) for step in steps])
    return np.asarray(np.sqrt((rough**2).mean(axis=0) / WEIGHTS))


def _larger(robot: FittedEncoders, steps: Sequence[DrivenStep]) -> Vector:
    """Mean squares (2,) of the innovations of steps, in their standard deviations."""
    return np.asarray(np.mean([one.innovation**2 for step in steps for one in follow(robot, step)], axis=0))
