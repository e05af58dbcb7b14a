"""A driven robot that is followed by its encoders: the state of each step, one sample after another.

It is the extended Kalman filter: state and numbers of the robot are Gaussian, and walk from sample to sample with exact
derivatives. What moves the legs in no model is white noise in the rates of the angles shown, as large as makes
innovations of the steps that were fitted as large as they are said to be.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.model.walker import Vector
from stages.biped.design import Biped
from stages.calibration.angles.fit import guess
from stages.calibration.angles.recording import DrivenStep
from stages.calibration.angles.robot import OF_STATE, Robot, drive_of
from stages.calibration.following.robot_file import OF_ANGLES, signed, signed_content
from stages.ground.slope import Slope

#: A step's first samples, through which its start is guessed; nothing is told before them.
BEGIN, ORDER = 12, 2
#: Standard deviation of that guess [rad], and of its rates in pendulum times.
OPEN = 0.05
#: Rates of stance and swing angle by those of the angles that are shown.
BY_SHOWN = np.array([[1.0, 0.0], [-1.0, 1.0]])
#: Noise is what is left of a smooth curve in differences of this order; the sum of squares of their weights.
DIFFERENCES, WEIGHTS = 4, 70.0
#: Times that noise in the rates is set again, with the power of what innovations are larger than said.
ROUNDS, POWER = 10, 1.5
#: Steps of either leg that tell it are so many at least, where there are.
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


@dataclass(frozen=True)
class Encoded:
    """A driven robot with the numbers `names` (m,), their `covariance` (m, m), where steps tell them, and how its
    `recording` is read. While a leg stands, encoders have `noise` (2, 2) [rad], and rates of both angles wander by
    `unmodelled` (2, 2) [rad^2/s^3]; rows are the legs."""

    robot: Robot
    names: tuple[str, ...]
    covariance: np.ndarray
    noise: Vector
    unmodelled: Vector
    recording: Mapping[str, Any]

    def follow(self, step: DrivenStep) -> Iterator[Seen]:
        """What is known of a step after each sample, from its first ones on, and as long as its hip does not chatter.
        """
        drive, m = drive_of(self.robot, step, self.names), len(self.names)
        quick = np.sqrt(drive.design.slope.gravity / drive.design.biped.leg_length)
        state, numbers = guess(step, BEGIN, ORDER), np.zeros(m)
        spread = np.zeros((4 + m, 4 + m))
        spread[range(4), range(4)] = np.square(OPEN * np.array([1.0, 1.0, quick, quick]))
        spread[4:, 4:] = self.covariance
        shown = np.hstack([OF_STATE, drive.by_zeros])
        wander = np.zeros((4 + m, 4 + m))
        wander[2:4, 2:4] = BY_SHOWN @ np.diag(self.unmodelled[step.leg] * step.interval) @ BY_SHOWN.T
        for number, angles in enumerate(step.angles):
            across = spread @ shown.T
            expected = shown @ across + np.diag(self.noise[step.leg] ** 2)
            left = angles - shown @ np.append(state, numbers) - drive.zeros
            moved = across @ np.linalg.solve(expected, left)
            state, numbers = state + moved[:4], numbers + moved[4:]
            spread = spread - across @ np.linalg.solve(expected, across.T)
            spread = 0.5 * (spread + spread.T)
            if number >= BEGIN:
                yield Seen(step.begins + number * step.interval, state, spread[:4, :4],
                           np.linalg.solve(np.linalg.cholesky(expected), left))  # fmt: skip
            driven = drive.along(state, step.interval, slice(number, number + 2))
            if len(driven.states) < 2:
                return
            onwards = np.eye(4 + m)
            onwards[:4, :4] = driven.by_start[1]
            onwards[:4, [4 + place for place in drive.places]] = driven.along[1]
            state = driven.states[1] + driven.along[1] @ numbers[drive.places]
            spread = onwards @ spread @ onwards.T + wander

    def content(self) -> bytes:
        """The file that `calibrate --into` leaves."""
        design = self.robot.design
        return signed_content({
            "kind": OF_ANGLES, "biped": dataclasses.asdict(design.biped), "slope": dataclasses.asdict(design.slope),
            "numbers": dict(self.robot.numbers), "parameters": list(self.names), "covariance": self.covariance.tolist(),
            "noise": self.noise.tolist(), "unmodelled": self.unmodelled.tolist(), "recording": dict(self.recording),
        })  # fmt: skip


def read(folder: Path) -> Encoded:
    """The robot of a folder. Raises WrongOption where it has none that was fitted to angles."""
    plain = signed(folder, "as", OF_ANGLES)
    robot = Robot(DesignPoint(Biped(**plain["biped"]), Slope(**plain["slope"])), plain["numbers"])
    return Encoded(robot, tuple(plain["parameters"]), np.array(plain["covariance"]), np.array(plain["noise"]),
                   np.array(plain["unmodelled"]), plain["recording"])  # fmt: skip


def encoded(
    robot: Robot, names: tuple[str, ...], covariance: np.ndarray, steps: Sequence[DrivenStep],
    recording: Mapping[str, Any],
) -> Encoded:  # fmt: skip
    """A robot that was fitted to steps, with the noise that these have. Numbers that nothing tells are as they are."""
    by_leg = [[step for step in steps if step.leg == leg] for leg in (0, 1)]
    noise = np.array([_roughness(each) for each in by_leg])
    told = np.where(np.isfinite(covariance), covariance, 0.0)
    quick = np.sqrt(robot.design.slope.gravity / robot.design.biped.leg_length)
    found = Encoded(robot, names, told, noise, np.full((2, 2), OPEN**2 * quick**3), recording)
    some = [each[:: max(1, len(each) // ENOUGH)] for each in by_leg]
    for _ in range(ROUNDS):
        larger = np.array([_larger(found, each) for each in some])
        found = dataclasses.replace(found, unmodelled=found.unmodelled * larger**POWER)
    return found


def _roughness(steps: Sequence[DrivenStep]) -> Vector:
    """Noise (2,) of the angles of steps [rad]."""
    rough = np.concatenate([np.diff(step.angles, DIFFERENCES, axis=0) for step in steps])
    return np.asarray(np.sqrt((rough**2).mean(axis=0) / WEIGHTS))


def _larger(robot: Encoded, steps: Sequence[DrivenStep]) -> Vector:
    """Mean squares (2,) of the innovations of steps, in their standard deviations."""
    return np.asarray(np.mean([one.innovation**2 for step in steps for one in robot.follow(step)], axis=0))
