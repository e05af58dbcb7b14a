"""A driven compass walker and its encoders: what a file says of it, and what they show of a step, with derivatives."""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from stages.analytic.gait.design_point import DesignPoint, parameter_names
from stages.analytic.model.walker import Vector
from stages.analytic.walk.driven_stance import DrivenStance, driven_stance
from stages.biped.accuracy.scales import scales_of
from stages.biped.design import Biped
from stages.biped.quantity import faults
from stages.biped.question import Place, number, only, place_of, refuse
from stages.calibration.angles.recording import COLUMNS, MARKERS, DrivenStep
from stages.calibration.estimation.least_squares import Known, NotIdentified
from stages.calibration.estimation.request import full_name, known_entries, known_value, listed, value_of
from stages.ground.slope import Slope

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

    def usual_change(self, name: str) -> float:
        """A change of a number that is neither large nor small, in its unit."""
        scales, unit = scales_of(self.design.biped, self.design.slope.gravity), self.unit(name)
        return 0.1 * abs(self.value(name)) or SIZES.get(unit, 1.0) * float(scales.size(unit))

    def with_values(self, values: Mapping[str, float]) -> Robot:
        """The robot with some numbers changed."""
        of_design = {name: value for name, value in values.items() if name not in OF_ROBOT}
        own = {name: value for name, value in values.items() if name in OF_ROBOT}
        return Robot(self.design.with_values(of_design) if of_design else self.design, {**self.numbers, **own})


def exchanged(name: str, design: DesignPoint) -> str:
    """The parameter's name when the legs are exchanged."""
    key = name.partition(".")[2]
    other = key.removeprefix("other_") if key.startswith("other_") else f"other_{key}"
    return f"biped.{other}" if hasattr(design.biped, other) else name


@functools.lru_cache(maxsize=4)
def standing_on(leg: int, design: DesignPoint, names: tuple[str, ...]) -> tuple[DesignPoint, tuple[str, ...]]:
    """The design with the leg that stands called the first, and its parameters' names then."""
    if leg == 0:
        return design, names
    other = dataclasses.replace(design, biped=design.biped.exchanged)
    return other, tuple(exchanged(name, other) for name in names)


#: What the angles shown are of stance angle, swing angle and their rates.
OF_STATE = np.array([[1.0, 0.0, 0.0, 0.0], [1.0, 1.0, 0.0, 0.0]])


@dataclass(frozen=True)
class Drive:
    """What drives a robot through a step, whose leg that stands is the first of the `design` and of its parameters
    `of_legs`: `torque` (n,) [N m] with its derivatives `rows` (k, n) by the motor's numbers. `places` (m,) are those of
    both among all names. The angles are off by `zeros` (2,) [rad], by the names (2, names) of them.
    """

    design: DesignPoint
    of_legs: tuple[str, ...]
    torque: Vector
    rows: np.ndarray
    places: list[int]
    zeros: Vector
    by_zeros: np.ndarray

    def along(self, start: Vector, interval: float, samples: slice) -> DrivenStance:
        """The stance from a `start` (4,) at the first of the samples on, SI."""
        return driven_stance(self.design, start, interval, self.torque[samples], self.of_legs, self.rows[:, samples])


def drive_of(robot: Robot, step: DrivenStep, names: tuple[str, ...]) -> Drive:
    """What drives a robot through a step, with derivatives by some of its numbers."""
    of_design = tuple(name for name in names if name not in OF_ROBOT)
    design, of_legs = standing_on(step.leg, robot.design, of_design)
    signal, slope = late(step, robot.value("torque_lag") / step.interval)
    constant = robot.value("torque_constant")
    turn = np.full(len(signal), step.turn)
    rows = {"torque_constant": signal, "torque_offset": turn, "torque_lag": -constant * slope / step.interval}
    of_motor = [name for name in names if name in rows]
    by_zeros, stance = np.zeros((2, len(names))), f"stance_zero_{step.leg}"
    for row, name, sign in ((0, stance, 1.0), (1, "hip_zero", step.turn)):
        if name in names:
            by_zeros[row, names.index(name)] = sign
    return Drive(
        design, of_legs, constant * signal + robot.value("torque_offset") * turn,
        np.array([rows[name] for name in of_motor]).reshape(len(of_motor), len(signal)),
        [names.index(name) for name in (*of_design, *of_motor)],
        np.array([robot.value(stance), step.turn * robot.value("hip_zero")]), by_zeros)  # fmt: skip


def show(
    robot: Robot, step: DrivenStep, start: Vector, names: tuple[str, ...]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """What the encoders show of a step from `start` (4,), SI: stance angle, swing angle and their rates.

    Stance angle and angle between the legs (n, 2) [rad], and their derivatives by the start (n, 2, 4) and by the
    numbers `names` (n, 2, m). Fewer rows than the step has where the hip's friction chatters.
    """
    drive = drive_of(robot, step, names)
    driven = drive.along(start, step.interval, slice(len(step.stance)))
    by = np.repeat(drive.by_zeros[None], len(driven.states), axis=0)
    by[:, :, drive.places] = OF_STATE @ driven.along
    return driven.states @ OF_STATE.T + drive.zeros, OF_STATE @ driven.by_start, by


def late(step: DrivenStep, lag: float) -> tuple[Vector, Vector]:
    """The samples of a step's signal `lag` samples before, and their slope per sample."""
    number = np.arange(len(step.signal))
    at = np.clip(number - lag, 0.0, len(number) - 1.0)
    return np.asarray(step.spline(at)), np.where(at == number - lag, step.spline(at, 1), 0.0)


KEYS = ("design", "robot", "known", "free", "recording", "held_out")
RECORDING = ("columns", "markers", "left_out_samples", "begun_s")
EVERY_OTHER_PAIR = "every other pair"
#: Looked for where the file does not say what.
USUAL = ("biped.hip_mass", "biped.hip_gravity_mass", "biped.foot_com", "biped.other_foot_com", "biped.hip_damping",
         "biped.hip_friction", *OF_ROBOT)
#: Changes that are neither large nor small where a value is zero, in the robot's own scales.
SIZES = {"N m": 3e-4, "s": 0.02, "rad": 1e-2, "kg": 0.03, "m": 0.03, "kg m^2": 4e-4, "N m s/rad": 6e-4, "deg": 0.3,
         "N m/rad": 1e-3}
#: A zero that is farther off [rad] is remarked; of one that the file gives this is three standard errors.
FARTHEST_ZERO = math.radians(2.0)
#: Numbers that cannot be negative.
NOT_NEGATIVE = ("torque_lag",)


@dataclass(frozen=True)
class AngleSetup:
    """The robot as drawn, what is looked for and known, and how the recording is read."""

    robot: Robot
    free: tuple[str, ...]
    known: tuple[Known, ...]
    columns: Mapping[str, str]
    markers: Mapping[str, str]
    left_out: int
    begun: float
    held_out: str | tuple[int, ...]
    given: Mapping[str, Any]

    def sizes(self) -> dict[str, float]:
        """Changes of what is looked for that are neither large nor small."""
        return {name: self.robot.usual_change(name) for name in self.free}

    def low(self) -> dict[str, float]:
        """The least value of each that means something: no friction below none."""
        found = dict.fromkeys(NOT_NEGATIVE, 0.0)
        for name in self.free:
            if name not in OF_ROBOT:
                bound = self.robot.design.bound(name)
                least = bound.minimum if bound.minimum is not None else bound.above
                if least is not None:
                    found[name] = least
        return found

    def split(self, steps: Sequence[DrivenStep]) -> tuple[list[DrivenStep], list[DrivenStep]]:
        """Steps that are fitted and steps that are held out. Raises NotIdentified where one leg never stands."""
        if self.held_out == EVERY_OTHER_PAIR:
            fitted = [step for step in steps if (step.number // 2) % 2 == 0]
        else:
            fitted = [step for step in steps if step.number not in self.held_out]
        out = [step for step in steps if step not in fitted]
        for leg in (0, 1):
            if not any(step.leg == leg for step in fitted):
                raise NotIdentified(
                    f"leg {leg} never stands in the steps that are fitted: what swings and what stands on one leg only "
                    "cannot distinguish the two legs' masses. Give steps of both legs, or known values and other free "
                    "parameters for a robot whose legs are alike")
        return fitted, out


def setup_of(about: Mapping[str, Any] | None, biped: Biped, slope: Slope) -> AngleSetup:
    """Read and check what the file says; without one the study's own design. Raises WrongOption with file and line."""
    about = {} if about is None else about
    place = place_of(about)
    only(about, KEYS, place, wrong="there is no such entry for angles; known are")
    given = _design(about.get("design") or {}, biped, place)
    biped = dataclasses.replace(biped, **given)
    refuse(*((True, f"{place('design', one.key)}: {getattr(biped, one.key)}, must be {one.allowed}")
             for one in faults(biped)))  # fmt: skip
    said = only(about.get("robot") or {}, OF_ROBOT, place, "robot", wrong="no such number; known are")
    numbers = dict.fromkeys(OF_ROBOT, 0.0)
    numbers |= {name: value_of(entry, OF_ROBOT[name], place, "robot", name) for name, entry in said.items()}
    robot = Robot(DesignPoint(biped, dataclasses.replace(slope, slope_deg=0.0)), numbers)
    values = known_entries(about, place)
    free, names = (
        tuple(full_name(name, (*OF_ROBOT, *parameter_names()), place(key, name if key == "known" else row),
                        f"{name} is no number of the robot", f"{', '.join(OF_ROBOT)} and the keys of biped.yaml")
              for row, name in enumerate(asked))
        for key, asked in (("free", listed(about, "free", "numbers of the robot", place) or USUAL), ("known", values)))
    known = [known_value(full, entry, place, key, OF_ROBOT)
             for full, (key, entry) in zip(names, values.items(), strict=True)]  # fmt: skip
    known += [Known(name, numbers[name], FARTHEST_ZERO / 3.0) for name in said if name in ZEROS and name not in names]
    return AngleSetup(robot, free, tuple(known), *_recording(about.get("recording") or {}, place),
                      _held_out(about.get("held_out", EVERY_OTHER_PAIR), place), given)


def _held_out(given: Any, place: Place) -> str | tuple[int, ...]:
    """Which steps are held out."""
    is_list = isinstance(given, list) and all(isinstance(one, int) for one in given)
    refuse((given != EVERY_OTHER_PAIR and not is_list,
            f'{place("held_out")}: {given}, must be "{EVERY_OTHER_PAIR}" or a list of numbers of steps'))
    return tuple(given) if is_list else EVERY_OTHER_PAIR


def _recording(
    given: Mapping[str, Any], place: Place
) -> tuple[Mapping[str, str], Mapping[str, str], int, float]:
    """Columns, markers, samples left out and seconds begun with, as the file says them."""
    only(given, RECORDING, place, "recording")
    columns, markers = (
        only(given.get(key) or {}, entries, place, "recording", key, wrong=f"no such {what}; known are")
        for key, entries, what in (("columns", COLUMNS, "column"), ("markers", MARKERS, "marker or axis")))
    left_out = int(number(given.get("left_out_samples", 7), place("recording", "left_out_samples"), 0, 1000))
    return columns, markers, left_out, number(given.get("begun_s", 0.15), place("recording", "begun_s"), 0.02, 10.0)


def _design(entries: Mapping[str, Any], biped: Biped, place: Place) -> dict[str, Any]:
    """The design's keys that the file gives."""
    fields = {field.name: field for field in dataclasses.fields(biped)}
    only(entries, fields, place, "design", wrong="no such key of biped.yaml; it has")
    legs = entries.get("legs", "rigid")
    refuse((legs != "rigid", f"{place('design', 'legs')}: {legs}, must be rigid: the angles are read of such legs"))
    return {key: entry if key == "legs" else value_of(entry, fields[key].metadata["unit"], place, "design", key)
            for key, entry in entries.items()}  # fmt: skip
