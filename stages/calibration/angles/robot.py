"""A driven compass walker and its encoders: what they show of a step, with exact derivatives by everything unknown."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.model.walker import Vector
from stages.analytic.walk.driven_stance import driven_stance
from stages.calibration.angles.recording import DrivenStep

#: Beside the design's: motor torque per signal, torque at no signal (in the recording's sign), by how much the torque
#: comes late; what the angles show where they are zero: the stance angle of either leg, and the angle between.
MOTOR = {"torque_constant": "N m", "torque_offset": "N m", "torque_lag": "s"}
ZEROS = {"stance_zero_0": "rad", "stance_zero_1": "rad", "hip_zero": "rad"}
OF_ROBOT = {**MOTOR, **ZEROS}


@dataclass(frozen=True)
class Robot:
    """A design and the numbers of `OF_ROBOT`."""

    design: DesignPoint
    numbers: Mapping[str, float]

    def value(self, name: str) -> float:
        """One number of either."""
        return float(self.numbers[name]) if name in OF_ROBOT else self.design.value(name)

    def unit(self, name: str) -> str:
        """Its unit."""
        return OF_ROBOT[name] if name in OF_ROBOT else self.design.unit(name)

    def with_values(self, values: Mapping[str, float]) -> Robot:
        """The robot with some numbers changed."""
        of_design = {name: value for name, value in values.items() if name not in OF_ROBOT}
        own = {name: value for name, value in values.items() if name in OF_ROBOT}
        return Robot(self.design.with_values(of_design) if of_design else self.design, {**self.numbers, **own})


@dataclass(frozen=True)
class Shown:
    """Stance angle and angle between the legs (n, 2) [rad], and their derivatives by the step's start (n, 2, 4) and by
    the numbers asked for (n, 2, m). Fewer rows than the step has where the hip's friction chatters."""

    angles: np.ndarray
    by_start: np.ndarray
    by: np.ndarray


def exchanged(name: str, design: DesignPoint) -> str:
    """The parameter's name when the legs are exchanged."""
    key = name.partition(".")[2]
    fields = {field.name for field in dataclasses.fields(design.biped)}
    if key.startswith("other_"):
        return f"biped.{key.removeprefix('other_')}"
    return f"biped.other_{key}" if f"other_{key}" in fields else name


@functools.lru_cache(maxsize=4)
def standing_on(leg: int, design: DesignPoint, names: tuple[str, ...]) -> tuple[DesignPoint, tuple[str, ...]]:
    """The design with the leg that stands called the first, and its parameters' names then."""
    if leg == 0:
        return design, names
    other = dataclasses.replace(design, biped=design.biped.exchanged)
    return other, tuple(exchanged(name, other) for name in names)


def show(robot: Robot, step: DrivenStep, start: Vector, names: tuple[str, ...], samples: int | None = None) -> Shown:
    """What the encoders show of a step from `start` (4,), SI: stance angle, swing angle and their rates."""
    count = len(step.signal) if samples is None else samples
    of_design = tuple(name for name in names if name not in OF_ROBOT)
    design, of_legs = standing_on(step.leg, robot.design, of_design)
    signal, slope = late(step, robot.value("torque_lag") / step.interval)
    constant = robot.value("torque_constant")
    turn = np.full(len(signal), step.turn)
    torque = constant * signal + robot.value("torque_offset") * turn
    rows = {"torque_constant": signal, "torque_offset": turn, "torque_lag": -constant * slope / step.interval}
    of_motor = [name for name in names if name in rows]
    driven = driven_stance(
        design, start, step.interval, torque[:count], of_legs,
        np.array([rows[name][:count] for name in of_motor]).reshape(len(of_motor), count))
    n = len(driven.states)
    both = np.array([[1.0, 0.0, 0.0, 0.0], [1.0, 1.0, 0.0, 0.0]])
    angles = driven.states @ both.T
    angles[:, 0] += robot.value(f"stance_zero_{step.leg}")
    angles[:, 1] += step.turn * robot.value("hip_zero")
    by = np.zeros((n, 2, len(names)))
    moved = np.einsum("ij,njm->nim", both, driven.along)
    for place, name in enumerate((*of_design, *of_motor)):
        by[:, :, names.index(name)] = moved[:, :, place]
    if f"stance_zero_{step.leg}" in names:
        by[:, 0, names.index(f"stance_zero_{step.leg}")] = 1.0
    if "hip_zero" in names:
        by[:, 1, names.index("hip_zero")] = step.turn
    return Shown(angles, np.einsum("ij,njs->nis", both, driven.by_start), by)


def late(step: DrivenStep, lag: float) -> tuple[Vector, Vector]:
    """The samples of a step's signal `lag` samples before, and their slope per sample."""
    number = np.arange(len(step.signal))
    at = np.clip(number - lag, 0.0, len(number) - 1.0)
    return np.asarray(step.spline(at)), np.where(at == number - lag, step.spline(at, 1), 0.0)
