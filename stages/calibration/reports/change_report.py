"""Whether runs of a database are of a fitted robot, as text and JSON."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import reduce
from operator import add, attrgetter
from pathlib import Path
from typing import Any

import numpy as np

from stages.analytic.errors import StepFailed
from stages.biped.question import Answer, Asking
from stages.calibration.following.change import Comparison, Evidence
from stages.calibration.following.robot_file import FittedRobot
from stages.calibration.following.score_test import LEVEL, Change, Verdict
from stages.calibration.information.identifiability import listed
from stages.calibration.parameters import Parameters
from stages.calibration.recordings import named_runs, none_of
from stages.calibration.result import HALF_WIDTH

#: Parts that a table has at most.
SHOWN = 8
Table = tuple[str, list[str], list[list[Any]]]


def compared(parameters: Parameters, source: Path, folder: Path, names: Sequence[str], asking: Asking) -> Answer:
    """The answer to `same`. Raises WrongOption, NoGait, NotIdentified."""
    robot = FittedRobot.read(folder)
    parameters = robot.read_by(parameters)
    comparison = Comparison(robot, robot.fitted_by(parameters))
    runs, lines = named_runs(source, robot.began, comparison.model, parameters, names, asking)
    held = dict[str, Evidence]()
    for number, (name, run) in enumerate(runs.items()):
        asking.progress(number / len(runs), name)
        try:
            held[name] = comparison.held(run)
        except StepFailed as reason:
            lines.append(f"{name}: {reason}")
    if not held:
        raise none_of("held against the robot", lines)
    verdicts = {name: comparison.verdict(one) for name, one in held.items()}
    whole = comparison.verdict(reduce(add, held.values()))
    farthest = min(verdicts.values(), key=attrgetter("probability"))
    probability = by_chance(whole.probability, farthest.probability, len(held))
    said = whole if whole.probability * len(held) <= farthest.probability else farthest
    plain = {"all_runs": _plain(whole), "runs": {name: _plain(one) for name, one in verdicts.items()},
             "not_compared": lines}  # fmt: skip
    return answered(replace(said, probability=probability), plain, lines, [_runs_table(verdicts)])


def by_chance(whole: float, least: float, runs: int) -> float:
    """The probability that runs of the same robot look so different, by all together or by the one that does most.

    `whole` is that of all together, `least` that of the one: a run may be of another robot, or all by a little.
    """
    return min(1.0, 2.0 * whole, 2.0 * runs * least) if runs > 1 else whole


def answered(
    verdict: Verdict, plain: Mapping[str, Any], lines: Sequence[str] = (), tables: Sequence[Table] = ()
) -> Answer:
    """A verdict as the answer to `same`, with what else is reported."""
    changed = [] if verdict.same or not verdict.changes[0].part.moves else [_parts_table(verdict)]
    return Answer(lines=[sentence(verdict), *lines], tables=[*tables, *changed],
                  plain={**_plain(verdict), **plain}, no=not verdict.same)  # fmt: skip


def in_words(change: Change) -> str:
    """A part with its change."""
    if not change.part.moves:
        return f"{change.part.name} (turned)"
    return f"{change.part.name} ({change.change:+.3g} +- {HALF_WIDTH * change.sd:.2g} {change.part.unit})"


def sentence(verdict: Verdict) -> str:
    """The answer in a sentence."""
    if verdict.same:
        return ("the same robot: nothing that was measured differs from it by more than chance (probability "
                f"{verdict.probability:.2g}, of which {LEVEL:g} and less says another)")
    named = [in_words(one) for one in verdict.named]
    what = named[0] if len(named) == 1 else f"one of {listed(named)}, which the runs cannot distinguish"
    if verdict.explained:
        return f"not the same robot: what has changed is {what}"
    return f"not the same robot: no single part explains all that differs; {what} explains most"


def _runs_table(verdicts: Mapping[str, Verdict]) -> Table:
    """Each run by itself."""
    return ("Runs, each by itself",
            ["run", "same", "probability", "residuals over the robot's", "differs most by", "standard errors"],
            [[name, "yes" if one.same else "no", f"{one.probability:.2g}", f"{one.residuals:.2f}",
              one.changes[0].part.name, f"{one.changes[0].sigmas:.1f}"] for name, one in verdicts.items()])


def _parts_table(verdict: Verdict) -> Table:
    """The parts that explain most, each as if it alone had changed."""
    return ("Parts, each as if it alone had changed, 95 % intervals",
            ["part", "change", "interval", "unit", "share", "standard errors"],
            [[one.part.name, f"{one.change:+.4g}", f"+- {HALF_WIDTH * one.sd:.2g}", one.part.unit,
              f"{100 * one.change / one.part.value:+.2f} %" if np.isfinite(one.part.value) and one.part.value else "",
              f"{one.sigmas:.1f}"] for one in verdict.changes[:SHOWN]])


def _plain(verdict: Verdict) -> dict[str, Any]:
    """A verdict as JSON knows it."""
    return {
        "same": verdict.same, "probability": verdict.probability,
        "named": [] if verdict.same else [one.part.name for one in verdict.named],
        "residuals_over_the_robots": verdict.residuals, "explained_by_one_part": verdict.explained,
        "parts": {one.part.name: {"change": one.change, "sd": one.sd, "unit": one.part.unit,
                                  "standard_errors": one.sigmas} for one in verdict.changes if one.part.moves},
    }  # fmt: skip
