"""`follow`: the state of a fitted robot while it walks, and its next heel strike, from its sensors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stages.biped.question import Answer, Asking, Question, option
from stages.calibration.questions.calibrate import has_angles

if TYPE_CHECKING:
    from stages.calibration.parameters import Parameters


@dataclass(frozen=True)
class Options:
    """Options of `follow`."""

    source: str = option(
        "-", "The recordings: a database of the ingest's, a CSV or C3D file of angles, or - for rows of standard input",
        metavar="FILE", positional=True)
    robot: str = option("-", "The folder that calibrate --into left", name="as", metavar="FOLDER")
    runs: tuple[str, ...] = option("-", "Follow only the run of this name; repeatable", name="run", default=())
    about: Mapping[str, Any] | None = option(
        "-", "What is known of standard input, or the first answer of a stream that broke off", name="with",
        default=None)


def ask(parameters: Parameters, options: Options, asking: Asking) -> Answer:
    """Follow the runs. Raises WrongOption, NoGait, NotIdentified."""
    from stages.calibration.following.report import followed, of_angles, streamed

    if has_angles(options.source):
        return of_angles(Path(options.source), Path(options.robot), options.runs, asking)
    if options.source == "-":
        return streamed(parameters, Path(options.robot), options.about or {}, asking)
    return followed(parameters, Path(options.source), Path(options.robot), options.runs, asking)


QUESTION = Question(
    "follow",
    """Tell the state of a robot while it walks, after each sample of its hip sensor and from nothing later.

    SOURCE is an SQLite file of `ingest`, with a hip and a foot sensor; the robot is the one that calibrate --into left.
    Each row of --csv has state, energy, phase, next heel strike with errors, and shortly before it the chance to fall
    in the steps after it. Runs are followed from their second mid-stance on; where none can be, or the twin does not
    fit one or loses it, it ends with 3.

    Of a CSV or C3D file, as for `calibrate`, each step is followed, and the answer says whether innovations are white.

    As SOURCE, - reads lines of CSV, the first of which names place, device_stamp, ax, ay, az, gx, gy and gz in
    any order. It answers in lines of JSON; given by --with, the first of them begins a broken stream anew.
    """,
    Options,
    ask,
    examples=("bipedstudy follow lab.sqlite --as robot", "bipedstudy follow lab.sqlite --as robot --csv > states.csv",
              "sensors | bipedstudy follow - --as robot"),
    rows=True,
)
