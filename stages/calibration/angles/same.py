"""Whether steps of a driven walker are of the robot that others were fitted to, and which of its numbers has changed.

Numbers that are fitted to the new steps differ from the robot's by chance, as the covariances of both fits say. Of one
that has changed alone, generalised least squares of these differences tell the change. A recording that was turned or
exchanged is one whose opposite fits the robot better than any change of a number does.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np
from scipy.special import stdtr

from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.model.walker import Vector
from stages.biped.design import Biped
from stages.biped.question import Answer, Asking, refuse
from stages.calibration.angles.fit import AngleFit, fit_robot
from stages.calibration.angles.recording import DrivenStep, read_steps
from stages.calibration.angles.robot import AngleSetup, Robot
from stages.calibration.estimation.least_squares import Known, NotIdentified
from stages.calibration.following.change import ALIKE, LEVEL
from stages.calibration.following.robot_file import OF_ANGLES, signed, signed_content
from stages.calibration.information.identifiability import listed, short
from stages.calibration.result import HALF_WIDTH
from stages.ground.slope import Slope

#: Sum of squares of steps that no robot near this one follows, and a variance of what is not determined.
LOST = 1e12
#: What may be turned of a recording: by its words, the signs of stance angle, angle between the legs and signal as a
#: step has them, and whether the other leg stands.
TURNED = {"sign of the stance angle": (-1, 1, 1, False), "sign of the hip angle": (1, -1, 1, False),
          "sign of the motor's signal": (1, 1, -1, False), "which leg is said to stand": (1, -1, -1, True),
          "legs, one for the other": (1, 1, 1, True)}  # fmt: skip


@dataclass(frozen=True)
class FittedEncoders:
    """How the recording is read and what is looked for, the robot as it was found; the `covariance` (m, m) of its
    numbers by the scatter of `steps` steps; `noise` [rad] that one sample is worth; mean and standard deviation between
    steps of the logarithm of their residuals [rad]; changes that are neither large nor small, by name. While a leg
    stands, a row each: noise of the encoders `encoded` (2, 2) [rad], and by how much the rates of both angles are
    `unmodelled` (2, 2) [rad^2/s^3]."""

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
        return cls(dataclasses.replace(setup, robot=fit.robot), covariance, fit.noise, len(fit.starts),
                   (float(logs.mean()), float(logs.std(ddof=1))), sizes)  # fmt: skip

    def content(self) -> bytes:
        """The file."""
        setup = self.setup
        return signed_content({
            "kind": OF_ANGLES, "biped": dataclasses.asdict(setup.robot.design.biped),
            "slope": dataclasses.asdict(setup.robot.design.slope), "numbers": dict(setup.robot.numbers),
            "parameters": list(setup.free), "known": [[one.name, one.value, one.sd] for one in setup.known],
            "columns": dict(setup.columns), "markers": dict(setup.markers), "left_out_samples": setup.left_out,
            "begun_s": setup.begun, "noise_rad": self.noise, "steps": self.steps, "log_residuals": self.log_size,
            "sizes": self.sizes,
            "covariance": np.where(np.isfinite(self.covariance), self.covariance, LOST).tolist(),
            "encoded": self.encoded.tolist(), "unmodelled": self.unmodelled.tolist(),
        })  # fmt: skip


def read(folder: Path) -> FittedEncoders:
    """The robot of a folder. Raises WrongOption where it has none that was fitted to angles."""
    plain = signed(folder, "as", OF_ANGLES)
    robot = Robot(DesignPoint(Biped(**plain["biped"]), Slope(**plain["slope"])), plain["numbers"])
    setup = AngleSetup(robot, tuple(plain["parameters"]), tuple(Known(*one) for one in plain["known"]),
                       plain["columns"], plain["markers"], plain["left_out_samples"], plain["begun_s"], (), {})
    return FittedEncoders(setup, np.array(plain["covariance"]), plain["noise_rad"], plain["steps"],
                          tuple(plain["log_residuals"]), plain["sizes"], np.array(plain["encoded"]),
                          np.array(plain["unmodelled"]))  # fmt: skip


@dataclass(frozen=True)
class Changed:
    """A number that may have changed, by how much, its standard error, and what it `explains` in chi-square; of what is
    turned in a recording the latter alone."""

    name: str
    change: float
    sd: float
    explains: float


def turned(step: DrivenStep, stance: int, between: int, signal: int, other: bool) -> DrivenStep:
    """A step with signs turned, or as one of the `other` leg."""
    return dataclasses.replace(step, stance=stance * step.stance, between=between * step.between,
                               signal=signal * step.signal, leg=1 - step.leg if other else step.leg)


@dataclass(frozen=True)
class Held:
    """Steps held to the robot: numbers that may have changed, the probability that its own look so different, and the
    sum of squares that is left with what the numbers' differences count for."""

    changes: tuple[Changed, ...] = ()
    probability: float = 0.0
    left: float = LOST


def held(robot: FittedEncoders, steps: Sequence[DrivenStep], again: int = 2) -> Held:
    """Steps as they are, held to the robot; a fit that does not come to rest begins `again` so often."""
    setup, sizes = robot.setup, robot.sizes
    try:
        fit = fit_robot(setup.robot, steps, setup.free, sizes, setup.low(), setup.known, robot.noise, None, again)
    except NotIdentified:
        return Held()
    scales = np.array([sizes[name] for name in setup.free])
    spread = fit.covariance(scales)
    both = robot.covariance + np.where(np.isfinite(spread), spread, LOST * np.diag(scales**2))
    inverse = np.linalg.inv(both / np.outer(scales, scales)) / np.outer(scales, scales)
    off = np.array([fit.robot.value(name) - setup.robot.value(name) for name in setup.free])
    sd, pull = np.diag(inverse) ** -0.5, inverse @ off
    freedom = max(1, min(robot.steps, len(steps)) - len(scales))
    by_number = 2.0 * len(scales) * float(stdtr(freedom, -max(abs(pull * sd))))
    logs, (mean, wide) = log_sizes(fit), robot.log_size
    apart = wide * math.sqrt(1.0 / len(logs) + 1.0 / robot.steps)
    by_size = float(stdtr(robot.steps - 1, (mean - logs.mean()) / apart))
    same = min(1.0, 2.0 * by_number, 2.0 * by_size) if fit.converged else 0.0
    left = sum(float((one**2).sum()) for one in fit.residuals.values()) / robot.noise**2
    return Held(tuple(Changed(short(name), float(one * width**2), float(width), float((one * width) ** 2))
                      for name, one, width in zip(setup.free, pull, sd, strict=True)),
                same, left + float(off @ pull))  # fmt: skip


def log_sizes(fit: AngleFit) -> Vector:
    """Logarithms of the root mean square residuals [rad] of each step."""
    return np.array([0.5 * math.log(float((one**2).mean())) for one in fit.residuals.values()])


def changes(robot: FittedEncoders, steps: Sequence[DrivenStep]) -> tuple[list[Changed], float]:
    """What may have changed, the most telling first, and the probability that the same robot looks so different."""
    as_it_is = held(robot, steps)
    found = list(as_it_is.changes)
    if as_it_is.probability < LEVEL:
        found += [Changed(words, math.nan, math.nan,
                          as_it_is.left - held(robot, [turned(one, *how) for one in steps], 0).left)
                  for words, how in TURNED.items()]  # fmt: skip
    return sorted(found, key=attrgetter("explains"), reverse=True), as_it_is.probability


def answer(source: Path, folder: Path, asking: Asking) -> Answer:
    """The answer to `same` for a recording of encoders. Raises WrongOption."""
    robot = read(folder)
    setup = robot.setup
    steps = read_steps(source, setup.columns, setup.left_out, setup.markers, asking.reading)
    refuse((len(steps) <= len(setup.free), f"{source}: has {len(steps)} steps, and more than {len(setup.free)} are "
            "needed to tell as many numbers of the robot"))  # fmt: skip
    return compared(robot, steps)


def compared(robot: FittedEncoders, steps: Sequence[DrivenStep]) -> Answer:
    """The answer to `same` for steps of encoders."""
    found, probability = changes(robot, steps)
    same = probability >= LEVEL
    named = [one for one in found if one.explains > found[0].explains - ALIKE]
    unit = robot.setup.robot.unit
    full = {short(name): name for name in robot.setup.free}
    words = [f"{one.name} ({one.change:+.3g} +- {HALF_WIDTH * one.sd:.2g} {unit(full[one.name])})"
             if one.name in full else f"{one.name} (turned)" for one in named]  # fmt: skip
    what = words[0] if len(words) == 1 else f"one of {listed(words)}, which the steps cannot tell apart"
    line = (f"the same robot: no number differs by more than chance (probability {probability:.2g}, of which {LEVEL:g} "
            "and less says another)" if same else f"not the same robot: what has changed is {what}")
    rows: list[list[Any]] = [[one.name, f"{one.change:+.4g}", f"+- {HALF_WIDTH * one.sd:.2g}", unit(full[one.name]),
                              f"{abs(one.change) / one.sd:.1f}"] for one in found if one.name in full]  # fmt: skip
    return Answer(
        lines=[line],
        tables=[] if same or named[0].name in TURNED else [("Numbers, each as if it alone had changed, 95 % intervals",
                                 ["number", "change", "interval", "unit", "standard errors"], rows)],
        plain={"same": same, "probability": probability, "named": [] if same else [one.name for one in named],
               "steps": len(steps), "numbers": {one.name: {"change": one.change, "sd": one.sd}
                                                for one in found if one.name in full}},
        no=not same,
    )  # fmt: skip
