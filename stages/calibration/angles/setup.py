"""What a file says of a robot with encoders: its design and motor, what is looked for, which steps are held out."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from stages.analytic.gait.design_point import DesignPoint
from stages.biped.design import Biped
from stages.biped.quantity import faults
from stages.biped.question import WrongOption
from stages.calibration.angles.recording import COLUMNS, MARKERS, DrivenStep
from stages.calibration.angles.robot import OF_ROBOT, ZEROS, Robot
from stages.calibration.estimation.least_squares import Known, NotIdentified
from stages.calibration.estimation.request import Place, known_value, number, only
from stages.ground.slope import Slope

KEYS = ("design", "robot", "known", "free", "recording", "held_out")
RECORDING = ("columns", "markers", "left_out_samples", "begun_s")
EVERY_OTHER_PAIR = "every other pair"
#: Looked for where the file does not say what.
USUAL = ("biped.hip_mass", "biped.hip_gravity_mass", "biped.foot_com", "biped.other_foot_com", "biped.hip_damping",
         "biped.hip_friction", *OF_ROBOT)
#: Changes that are neither large nor small where a value is zero.
SIZES = {"N m": 3e-3, "s": 3e-3, "rad": 1e-2, "kg": 0.1, "m": 1e-2, "kg m^2": 1e-4, "N m s/rad": 1e-3, "deg": 0.3,
         "N m/rad": 1e-2}
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
        return {name: 0.1 * abs(self.robot.value(name)) or SIZES.get(self.robot.unit(name), 1.0) for name in self.free}

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
                    "cannot tell the two legs' masses apart. Give steps of both legs, or known values and other free "
                    "parameters for a robot whose legs are alike")
        return fitted, out


def setup_of(about: Mapping[str, Any] | None, biped: Biped, slope: Slope) -> AngleSetup:
    """Read and check what the file says; without one the study's own design. Raises WrongOption with file and line."""
    about = {} if about is None else about
    place: Place = getattr(about, "place", lambda *keys: ".".join(map(str, keys)))
    only(about, KEYS, place, wrong="there is no such entry for angles; known are")
    given = _design(about.get("design") or {}, biped, place)
    biped = dataclasses.replace(biped, **given)
    for broken in faults(biped):
        raise WrongOption(f"{place('design', broken.key)}: {getattr(biped, broken.key)}, must be {broken.allowed}")
    said = only(about.get("robot") or {}, OF_ROBOT, place, "robot", wrong="no such number; known are")
    numbers = dict.fromkeys(OF_ROBOT, 0.0)
    numbers |= {name: _value(entry, OF_ROBOT[name], place, "robot", name) for name, entry in said.items()}
    robot = Robot(DesignPoint(biped, dataclasses.replace(slope, slope_deg=0.0)), numbers)
    free = tuple(_full(name, robot, place, "free", row) for row, name in enumerate(about.get("free") or USUAL))
    names = {name: _full(name, robot, place, "known", name) for name in about.get("known") or {}}
    known = [known_value(full, about["known"][name], robot.unit(full), place, name) for name, full in names.items()]
    known += [Known(name, numbers[name], FARTHEST_ZERO / 3.0) for name in said
              if name in ZEROS and name not in names.values()]  # fmt: skip
    recording = only(about.get("recording") or {}, RECORDING, place, "recording")
    columns, markers = (
        only(recording.get(key) or {}, entries, place, "recording", key, wrong=f"no such {what}; known are")
        for key, entries, what in (("columns", COLUMNS, "column"), ("markers", MARKERS, "marker or axis")))
    left_out = int(number(recording.get("left_out_samples", 7), place("recording", "left_out_samples"), 0, 1000))
    begun = number(recording.get("begun_s", 0.15), place("recording", "begun_s"), 0.02, 10.0)
    out = about.get("held_out", EVERY_OTHER_PAIR)
    if out != EVERY_OTHER_PAIR and not (isinstance(out, list) and all(isinstance(one, int) for one in out)):
        raise WrongOption(f'{place("held_out")}: {out}, must be "{EVERY_OTHER_PAIR}" or a list of numbers of steps')
    held_out = out if isinstance(out, str) else tuple(out)
    return AngleSetup(robot, free, tuple(known), columns, markers, left_out, begun, held_out, given)


def _design(entries: Mapping[str, Any], biped: Biped, place: Place) -> dict[str, Any]:
    """The design's keys that the file gives."""
    fields = {field.name: field for field in dataclasses.fields(biped)}
    given: dict[str, Any] = {}
    for key, entry in entries.items():
        only([key], fields, place, "design", wrong="no such key of biped.yaml; it has")
        if key == "legs" and entry != "rigid":
            raise WrongOption(f"{place('design', key)}: {entry}, must be rigid: the angles are read of such legs")
        given[key] = entry if key == "legs" else _value(entry, fields[key].metadata["unit"], place, "design", key)
    return given


def _value(entry: Any, unit: str, place: Place, *keys: str) -> float:
    """The value of {value, unit, source}."""
    if not isinstance(entry, Mapping) or not {"value", "unit"} <= set(entry):
        raise WrongOption(f"{place(*keys)}: expected {{value, unit, source}}")
    if entry["unit"] != unit:
        raise WrongOption(f"{place(*keys, 'unit')}: {entry['unit']}, must be {unit}")
    return number(entry["value"], place(*keys, "value"), -1e6, 1e6)


def _full(name: Any, robot: Robot, place: Place, key: str, row: Any) -> str:
    """The full name of a number of the robot."""
    for full in (str(name), f"biped.{name}", f"ground.{name}"):
        try:
            robot.value(full)
        except KeyError:
            continue
        return full
    raise WrongOption(f"{place(key, row)}: {name} is no number of the robot; known are {', '.join(OF_ROBOT)} and the "
                      "keys of biped.yaml")  # fmt: skip
