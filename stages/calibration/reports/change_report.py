"""Whether runs of a database are of a fitted robot, as text and JSON."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import reduce
from operator import add
from pathlib import Path
from typing import Any

import numpy as np

from stages.analytic.errors import StepFailed
from stages.biped.question import Answer, Asking
from stages.calibration.estimation.least_squares import NotIdentified
from stages.calibration.following import robot_file
from stages.calibration.following.change import LEVEL, Change, Comparison, Held, Verdict
from stages.calibration.information.identifiability import first_model, listed
from stages.calibration.parameters import Parameters
from stages.calibration.recordings import named_runs
from stages.calibration.result import HALF_WIDTH

#: Parts that a table has at most.
SHOWN = 8


def compared(parameters: Parameters, source: Path, folder: Path, names: Sequence[str], asking: Asking) -> Answer:
    """The answer to `same`. Raises WrongOption, NoGait, NotIdentified."""
    robot = robot_file.read(folder)
    comparison = Comparison(robot, first_model(robot.design, (*robot.names, *robot.own), parameters))
    runs, lines = named_runs(source, robot.design, comparison.model, parameters, names, asking)
    held = dict[str, Held]()
    for number, (name, run) in enumerate(runs.items()):
        asking.progress(number / len(runs), name)
        try:
            held[name] = comparison.held(run)
        except StepFailed as reason:
            lines.append(f"{name}: {reason}")
    if not held:
        raise NotIdentified(f"no run can be held against the robot: {'; '.join(lines[:3]) or 'there is none'}")
    verdicts = {name: comparison.verdict_of(one) for name, one in held.items()}
    whole = comparison.verdict_of(reduce(add, held.values()))
    probability = whole.probability
    if len(held) > 1:  # one run may be of another robot, or all by a little
        probability = min(1.0, 2.0 * probability, 2.0 * len(held) * min(one.probability for one in verdicts.values()))
    same = probability >= LEVEL
    said = whole if whole.probability * len(held) <= min(one.probability for one in verdicts.values()) else min(
        verdicts.values(), key=lambda one: one.probability)
    return Answer(
        lines=[sentence(said, probability, same), *lines],
        tables=[_runs_table(verdicts), *([] if same else [_parts_table(said, comparison)])],
        plain={"same": same, "probability": probability, "all_runs": _plain(whole, comparison),
               "runs": {name: _plain(one, comparison) for name, one in verdicts.items()}, "not_compared": lines},
        no=not same,
    )  # fmt: skip


def in_words(change: Change) -> str:
    """A part with its change."""
    return (f"{change.part.name} ({change.change:+.3g} +- {HALF_WIDTH * change.sd:.2g} {change.part.unit})")


def sentence(verdict: Verdict, probability: float, same: bool) -> str:
    """The answer in a sentence."""
    if same:
        return (f"the same robot: nothing that the sensors show differs from it by more than chance (probability "
                f"{probability:.2g}, of which {LEVEL:g} and less says another)")
    named = [in_words(one) for one in verdict.named]
    what = named[0] if len(named) == 1 else f"one of {listed(named)}, which the runs cannot tell apart"
    if verdict.explained:
        return f"not the same robot: what has changed is {what}"
    return f"not the same robot: no single part explains all that differs; {what} explains most"


def _value(comparison: Comparison, change: Change) -> float:
    """The robot's own value of what has changed; of a sensor none."""
    name = change.part.moves[0]
    return comparison.robot.design.value(name) if "." in name else float("nan")


def _runs_table(verdicts: Mapping[str, Verdict]) -> tuple[str, list[str], list[list[Any]]]:
    """Each run by itself."""
    rows: list[list[Any]] = [
        [name, "yes" if one.same else "no", f"{one.probability:.2g}", f"{one.residuals:.2f}", one.changes[0].part.name,
         f"{one.changes[0].sigmas:.1f}"]
        for name, one in verdicts.items()]  # fmt: skip
    return ("Runs, each by itself", ["run", "same", "probability", "residuals over the robot's", "differs most by",
                                     "standard errors"], rows)  # fmt: skip


def _parts_table(verdict: Verdict, comparison: Comparison) -> tuple[str, list[str], list[list[Any]]]:
    """The parts that explain most, each as if it alone had changed."""
    rows: list[list[Any]] = []
    for one in verdict.changes[:SHOWN]:
        value = _value(comparison, one)
        share = f"{100 * one.change / value:+.2f} %" if np.isfinite(value) and value else ""
        rows.append([one.part.name, f"{one.change:+.4g}", f"+- {HALF_WIDTH * one.sd:.2g}", one.part.unit, share,
                     f"{one.sigmas:.1f}"])  # fmt: skip
    return ("Parts, each as if it alone had changed, 95 % intervals",
            ["part", "change", "interval", "unit", "share", "standard errors"], rows)  # fmt: skip


def _plain(verdict: Verdict, comparison: Comparison) -> dict[str, Any]:
    """A verdict as JSON knows it."""
    return {
        "same": verdict.same, "probability": verdict.probability, "residuals_over_the_robots": verdict.residuals,
        "named": [] if verdict.same else [one.part.name for one in verdict.named],
        "explained_by_one_part": verdict.explained,
        "parts": {one.part.name: {"change": one.change, "sd": one.sd, "unit": one.part.unit,
                                  "standard_errors": one.sigmas} for one in verdict.changes},
    }  # fmt: skip
