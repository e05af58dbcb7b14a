"""`calibrate`: the robot that was measured, as parameters with intervals, and what measurements can tell at all."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from stages.biped.quantity import Bound
from stages.biped.question import Answer, Asking, Question, WrongOption, option
from stages.calibration.parameters import Parameters


@dataclass(frozen=True)
class Options:
    """Options of `calibrate`."""

    about: Mapping[str, Any] | None = option(
        "-", "What is known beside the recordings, and what is looked for: this YAML file", name="with", default=None)
    identifiability: bool = option(
        "-", "Say what such measurements can tell, and what would tell more, before anything is fitted", default=False)
    runs: int | None = option(
        "1", "Runs that are planned (default: calibration.planned_runs)", default=None,
        bound=Bound(minimum=1, maximum=10_000))


def ask(parameters: Parameters, options: Options, asking: Asking) -> Answer:
    """Say what the runs can tell. Raises WrongOption, NoGait."""
    from stages.calibration.estimation.asked import asked_of

    asked = asked_of(options.about)
    if options.identifiability:
        from stages.calibration.reports.identifiability_report import told

        return told(parameters, asked, options.runs or parameters.settings.planned_runs)
    raise WrongOption("calibrate: say --identifiability")


QUESTION = Question(
    "calibrate",
    """Find the parameters of the robot that was measured.

    --identifiability computes, before anything is fitted or even measured, how well runs like those of params/ can tell
    each parameter, which combinations no sensor sees, and what further measurement would help most. What is known
    already (a weighed mass, a measured length) stands in the file of --with; docs/calibration.md has its form.
    """,
    Options,
    ask,
    examples=("bipedstudy calibrate --identifiability --runs 30",),
    draws=True,
)
