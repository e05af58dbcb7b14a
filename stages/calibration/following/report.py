"""Runs of a database followed: states and next heel strikes as text, JSON and rows."""

import gc
import math
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from stages.analytic.errors import StepFailed
from stages.analytic.model.walker import Vector
from stages.biped.question import Answer, Asking, refuse
from stages.calibration.angles.recording import read_steps
from stages.calibration.angles.same import FittedEncoders
from stages.calibration.following import encoders
from stages.calibration.following.follower import Follower
from stages.calibration.following.present import Instant
from stages.calibration.following.robot_file import FittedRobot
from stages.calibration.following.stream import Stream, rows_of
from stages.calibration.following.track import BEFORE, follow, forecasts, typical
from stages.calibration.intervals.model_error import whiteness
from stages.calibration.observation.measured_run import MeasuredRun
from stages.calibration.parameters import Parameters
from stages.calibration.recordings import named_runs, none_of
from stages.calibration.result import HALF_WIDTH

#: Names of the state's entries with their units; rigid legs have no lengths.
LEGS = (("stance_leg_angle", "rad"), ("stance_leg_length", "m"), ("leg_opening_angle", "rad"),
        ("swing_leg_length", "m"))  # fmt: skip
STANDS = ("inner", "outer")
#: Innovations are white unless so few of white ones are like them.
LEVEL = 0.01
#: A twin fits whose innovations are typically no more times as large as in its own runs, or as they should be, in all
#: of so many in a row.
FITS, LATEST = 1.5, 100


def streamed(parameters: Parameters, folder: Path, about: Mapping[str, Any], asking: Asking) -> Answer:
    """Follow rows of standard input, and say each answer at once. Raises WrongOption, NoGait, NotIdentified."""
    robot = FittedRobot.read(folder)
    parameters = robot.read_by(parameters)
    stream = Stream(Follower.of(robot, robot.fitted_by(parameters), parameters.settings), about, parameters)
    said, lost, latest, strange = 0, "", deque[float](maxlen=LATEST), ""
    try:
        for instant in stream.follow(rows_of(asking.lines(), asking.note, stream.periods)):
            if not said:
                gc.freeze()  # else a collection looks through all that was loaded, for 80 ms
                asking.say(stream.about())
            asking.say(_row("-", _late(instant, robot)))
            said += 1
            latest.append(instant.innovation)
            if not strange and said % LATEST == 0 and (strange := _strange([*latest], robot)):
                asking.note(f"note: at {instant.time:.2f} s {strange}")
    except StepFailed as reason:
        lost = f"lost: {reason}; give the first answer by --with to take it up again"
    words = [one for one in (lost, strange or _strange([*latest], robot), f"{said} states were written") if one]
    return Answer(remark="; ".join(words), no=len(words) > 1)


def followed(parameters: Parameters, source: Path, folder: Path, names: Sequence[str], asking: Asking) -> Answer:
    """The answer to `follow`. Raises WrongOption, NoGait, NotIdentified."""
    robot = FittedRobot.read(folder)
    parameters = robot.read_by(parameters)
    follower = Follower.of(robot, robot.fitted_by(parameters), parameters.settings)
    runs, lines = named_runs(source, robot.began, follower.model, parameters, names, asking)
    rows, plain, table, odd = list[dict[str, Any]](), dict[str, Any](), list[list[Any]](), list[str]()
    for number, (name, run) in enumerate(runs.items()):
        asking.progress(number / len(runs), name)
        instants = list[Instant]()
        try:
            instants.extend(_late(one, robot) for one in follow(follower, run))
        except StepFailed as reason:
            lines.append(f"{name}: lost after {instants[-1].time if instants else 0.0:.2f} s: {reason}")
            odd.append(name)
        if instants:
            if strange := _strange([one.innovation for one in instants], robot):
                lines.append(f"{name}: {strange}")
                odd.append(name)
            rows += [_row(name, one) for one in instants]
            plain[name] = _plain(instants, run)
            table.append([name, *(f"{value:.3g}" for value in plain[name].values())])
    if not plain:
        raise none_of("followed", lines)
    columns = ["run", "steps", "samples", "innovation, sd", f"strikes forecast {BEFORE:g} step ahead",
               "of these inside", "error, ms", "half width, ms"]  # fmt: skip
    return Answer(lines=lines, tables=[("Runs followed, strikes with 95 % intervals", columns, table)],
                  plain={"runs": plain, "states": rows, "unlike": [*dict.fromkeys(odd)]}, rows=rows,
                  no=bool(odd))  # fmt: skip


def of_angles(source: Path, folder: Path, names: Sequence[str], asking: Asking) -> Answer:
    """The answer to `follow` for encoders or markers: steps are "step 0" and so on. Raises WrongOption."""
    robot = FittedEncoders.read(folder)
    setup = robot.setup
    found = read_steps(source, setup.columns, setup.left_out, setup.markers, asking.reading)
    steps = {f"step {one.number}": one for one in found}
    refuse(*((name not in steps, f"--run: there is no {name}; there are {', '.join(steps)}") for name in names))
    rows, plain, table = list[dict[str, Any]](), dict[str, Any](), list[list[Any]]()
    for number, (name, step) in enumerate(steps.items()):
        asking.progress(number / len(steps), name)
        if name not in (names or steps):
            continue
        seen = list(encoders.follow(robot, step))
        rows += [{"run": name, "time_s": one.time, "stance_leg": STANDS[step.leg], "phase": "single stance",
                  **_of_state(one.state, one.covariance)} for one in seen]  # fmt: skip
        left = np.array([one.innovation for one in seen])
        size, white = np.sqrt((left**2).mean(axis=0)), [whiteness(column) for column in left.T]
        plain[name] = {"samples": len(seen), "innovation_in_sigmas": size.tolist(), "white": white}
        table.append([name, len(seen), *(f"{value:.2f}" for value in size), *(f"{value:.2g}" for value in white)])
    share = np.mean([np.array(one["white"]) > LEVEL for one in plain.values()], axis=0)
    line = (f"innovations are white at {LEVEL:.0%} in {share[0]:.0%} of the steps (stance angle) and {share[1]:.0%} "
            "(between the legs)")  # fmt: skip
    line += "" if share.min() >= 1.0 - 2 * LEVEL else ("; what is left hangs together, as forces do that the model has "
                                                       "not: states are worse by it than noise alone has them")
    columns = ["step", "samples", "stance, sd", "between, sd", "white, stance", "white, between"]
    return Answer(lines=[line], tables=[("Steps followed: size of innovations, and probability of such ones if white",
                                         columns, table)],
                  plain={"runs": plain, "states": rows}, rows=rows)  # fmt: skip


def _strange(innovations: Sequence[float], robot: FittedRobot) -> str:
    """That the twin does not fit, where so many of the `LATEST` in a row say that it does not."""
    ends = range(len(innovations), min(LATEST, len(innovations)) - 1, -LATEST)
    size = max((typical(innovations[max(end - LATEST, 0) : end]) for end in ends), key=np.nan_to_num)
    return (f"the twin does not fit: readings are typically {size:.1f} standard deviations from it, in its own runs at "
            f"most {robot.innovation:.1f}, so errors of states and strikes are larger than said; same tests what has "
            "changed") * (size > FITS * max(robot.innovation, 1.0))


def _late(one: Instant, robot: FittedRobot) -> Instant:
    """With the next heel strike when it will be found, not when the model has it."""
    return replace(one, strike=one.strike + robot.late, strike_sd=float(np.hypot(one.strike_sd, robot.late_sd)))


def _row(name: str, one: Instant) -> dict[str, Any]:
    """An instant as a row."""
    return {"run": name, "time_s": one.time, "stance_leg": STANDS[one.leg],
            "phase": "double stance" if one.double else "single stance", **_of_state(one.state, one.covariance),
            "energy_J": one.energy[0], "energy_sd": one.energy[1],
            "next_heel_strike_s": one.strike, "next_heel_strike_sd_s": one.strike_sd,
            "step_length_m": one.step[0], "step_length_sd": one.step[1],
            **{f"falls_within_{steps}_steps": float(share) for steps, share in enumerate(one.falls, 1)}}  # fmt: skip


def _of_state(state: Vector, covariance: np.ndarray) -> dict[str, float]:
    """A state (size,) with its standard errors; in place of the swing leg's angle from the normal that between the
    legs."""
    half, row = len(state) // 2, dict[str, float]()
    shown = np.eye(2 * half)
    shown[half // 2, 0] = shown[half // 2 + half, half] = 1.0
    state, sd = shown @ state, np.sqrt(np.diag(shown @ covariance @ shown.T))
    for place, (key, unit) in enumerate(LEGS if half == len(LEGS) else LEGS[::2]):
        for title, at, per in ((key, place, ""), (f"{key}_rate", half + place, "_s")):
            row[f"{title}_{unit}{per}"], row[f"{title}_sd"] = float(state[at]), float(sd[at])
    return row


def _plain(instants: Sequence[Instant], run: MeasuredRun) -> Mapping[str, Any]:
    """How well a run was followed: its readings, and the heel strikes that were forecast."""
    errors, sd = forecasts(instants, run.strikes).T
    widths = HALF_WIDTH * sd
    return {"steps": int(sum(one.leg != other.leg for one, other in pairwise(instants))),
            "samples": len(instants), "innovation_in_sigmas": typical(one.innovation for one in instants),
            "strikes_forecast": len(errors),
            "strikes_inside": int((np.abs(errors) <= widths).sum()),
            "error_ms": 1e3 * math.sqrt(np.mean(errors**2)) if len(errors) else math.nan,
            "half_width_ms": 1e3 * float(np.median(widths)) if len(widths) else math.nan}  # fmt: skip
