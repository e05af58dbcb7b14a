"""`calibrate`: the robot that was measured, as parameters with intervals, and what measurements can show at all."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stages.biped.quantity import Bound
from stages.biped.question import Answer, Asking, Question, WrongOption, option, refuse

if TYPE_CHECKING:
    from stages.calibration.parameters import Parameters


@dataclass(frozen=True)
class Options:
    """Options of `calibrate`."""

    source: str | None = option(
        "-", "The recordings: a database of the ingest's, or a CSV or C3D file of angles", metavar="FILE",
        positional=True, default=None)
    about: Mapping[str, Any] | None = option(
        "-", "What is known beside the recordings, and what is looked for: this YAML file", name="with", default=None)
    identifiability: bool = option(
        "-", "Say how well such measurements determine each parameter, before anything is fitted", default=False)
    robot: str | None = option(
        "-", "Go on from the robot in this folder, which --into left with its runs", name="continue",
        metavar="FOLDER", default=None)
    runs: int | None = option(
        "1", "Runs that are planned (default: calibration.planned_runs)", default=None,
        bound=Bound(minimum=1, maximum=10_000))


def has_angles(source: str) -> bool:
    """Whether recordings are angles of encoders or markers, by the file's name, and not signals of sensors."""
    return source.lower().endswith((".csv", ".c3d"))


def ask(parameters: Parameters, options: Options, asking: Asking) -> Answer:
    """Fit the recordings, or say what runs can show. Raises WrongOption, NoGait, NotIdentified."""
    recorded = "" if options.identifiability else options.source or ""
    refuse((options.robot is not None and (has_angles(recorded) or not recorded),
            "--continue: goes on with recordings of sensors at hip and foot alone, in a database"))
    if has_angles(recorded):
        from stages.calibration.reports.angle_report import answered, calibrated

        asking.progress(0.1, "the robot and each step's start")
        return answered(calibrated(parameters.biped, parameters.slope, options.about, Path(recorded),
                                   asking.reading))
    from stages.calibration.estimation.request import PARTS, request_of

    if recorded:
        from stages.calibration.following.robot_file import FittedRobot
        from stages.calibration.reports.sensor_report import calibrated as from_sensors

        request, before = request_of(options.about), None
        if options.robot is not None:
            of_robot = f"is that of the robot in {options.robot}; leave it out"
            refuse(*((bool(getattr(request, key)), f"--with: {key} {of_robot}")
                     for key in ("known", "free", "fixed", "also")),
                   (request.design == PARTS, "--with: design is that of the robot; leave it out"))  # fmt: skip
            before = FittedRobot.read(Path(options.robot), "continue")
        return from_sensors(parameters, request, Path(recorded), asking, before)
    request = request_of(options.about)
    if options.identifiability:
        from stages.calibration.reports import identifiability_report

        return identifiability_report.answered(parameters, request, options.runs or parameters.settings.planned_runs)
    raise WrongOption("calibrate: name the recordings, or say --identifiability")


QUESTION = Question(
    "calibrate",
    """Find the parameters of the robot that was measured, with 95 % intervals, from the recordings in SOURCE.

    SOURCE is an SQLite file as `ingest` reads and writes it, a CSV file of a driven robot's angles, or a C3D file of
    motion capture with markers at its hip and feet. Some runs or steps are held out, and the errors of their forecast
    are printed. --into writes the fitted robot as parameter files.

    --identifiability computes before any measurement how well runs like those of params/ determine each parameter,
    which combinations no sensor shows, and which further measurement would help most. What you know already (the
    mass, a length) stands in the file of --with; docs/calibration.md has its form.
    """,
    Options,
    ask,
    examples=("bipedstudy calibrate --identifiability --runs 30", "bipedstudy calibrate lab.sqlite --with known.yaml",
              "bipedstudy calibrate more.sqlite --continue robot --into robot_2",
              "bipedstudy calibrate steps.csv --with robot.yaml --figure residuals.png"),
    draws=True,
    pool=True,
    leaves="the robot that was found, as parameter files",
)
