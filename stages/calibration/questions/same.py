"""`same`: whether recorded runs are still of the robot that was fitted, and which part of it has changed."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from stages.biped.question import Answer, Asking, Question, option, refuse
from stages.calibration.questions.calibrate import has_angles

if TYPE_CHECKING:
    from stages.calibration.parameters import Parameters


@dataclass(frozen=True)
class Options:
    """Options of `same`."""

    source: str = option("-", "The recordings, as for `calibrate`", metavar="FILE", positional=True)
    robot: str = option("-", "The folder that calibrate --into left", name="as", metavar="FOLDER")
    runs: tuple[str, ...] = option("-", "Look at only the run of this name; repeatable", name="run", default=())


def ask(parameters: Parameters, options: Options, asking: Asking) -> Answer:
    """Test the runs. Raises WrongOption, NoGait, NotIdentified."""
    if has_angles(options.source):
        from stages.calibration.angles import same

        refuse((bool(options.runs), "--run: a recording of encoders has none"))
        return same.answer(Path(options.source), Path(options.robot), asking)
    from stages.calibration.reports.change_report import compared

    return compared(parameters, Path(options.source), Path(options.robot), options.runs, asking)


QUESTION = Question(
    "same",
    """Say whether runs are still of the robot that calibrate --into left, and which part of it has changed.

    SOURCE is as for `calibrate`; of angles turned signs and exchanged legs are named too. Of runs of the same robot one
    in a hundred is said to be another's. The answer names the part of the robot or place of a sensor that explains
    most, how much it has changed, and parts that cannot be distinguished from it. It ends with 3 for another robot.
    """,
    Options,
    ask,
    examples=("bipedstudy same lab.sqlite --as robot", "bipedstudy same lab.sqlite --as robot --run 'run 04' --json"),
)
