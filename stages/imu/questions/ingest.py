"""`ingest`: what a lab's measurements are worth, before they are used."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stages.biped.question import Answer, Asking, Question, WrongOption, as_plain, option
from stages.imu.sources.opening import SourceRefused

if TYPE_CHECKING:
    from stages.imu.parameters import Parameters
    from stages.imu.result import RunReport, SensorReport
    from stages.imu.sources.reading import Run
    from stages.imu.trial.trial import Trial

VARIABLE = "env:"
OPEN = "read without TLS, so others on the way can read it too; docs/measurements.md says how to demand TLS"


@dataclass(frozen=True)
class Options:
    """Options of `ingest`."""

    source: str = option("-", "Where the measurements are", metavar="FILE", positional=True)
    column_map: Mapping[str, Any] | None = option(
        "-", "SOURCE is a folder of CSV or TSV files, described in this YAML file", name="map", default=None)
    store: Path | None = option("-", "Keep the raw rows in this SQLite file", default=None)
    export: Path | None = option(
        "-", "Leave events, steps, curves and verdicts in this new folder, as CSV and npz", metavar="DIR", default=None)
    propose: Path | None = option(
        "-", "SOURCE is a file of any kind, or a folder of them: write a first map of what their heads show here",
        default=None)


def ask(parameters: Parameters, options: Options, asking: Asking) -> Answer:
    """Read every run of the source and report on it. Raises WrongOption, also for what the ingest refuses."""
    if options.propose is not None:
        return proposed(options, parameters.settings.gravity, asking)
    from stages.imu.export import picture
    from stages.imu.result import origin_of, tables
    from stages.imu.run import trials

    sensors: list[SensorReport] = []
    runs: list[RunReport] = []
    taken: list[Trial] = []
    try:
        with ExitStack() as open_until_read:
            store = open_until_read.enter_context(asking.new_file(options.store)) if options.store else None
            for trial in trials(read(options, asking, store), parameters, asking.progress):
                sensors.extend(trial.reports)
                runs.append(trial.report())
                if options.export is not None or not taken:
                    taken.append(trial)
    except SourceRefused as refused:
        raise WrongOption(str(refused)) from None
    if options.export is not None:
        from stages.imu.export import exported

        with asking.new_file(options.export) as folder:
            folder.mkdir()
            for name, content in exported(taken).items():
                (folder / name).write_bytes(content)
    accepted = sum(one.accepted for one in runs)
    rows = [as_plain(one) for one in runs]
    return Answer(
        plain={"runs": rows, "sensors": [as_plain(one) for one in sensors]},
        rows=rows,
        tables=tables(sensors, runs, origin_of(runs)),
        draw=lambda save: save(picture(taken[0])),
        remark=remark(runs),
        no=not accepted,
    )


def remark(runs: list[RunReport]) -> str:
    """How many runs can be used, and how many of those with remarks."""
    accepted, remarked = sum(one.accepted for one in runs), sum(one.accepted and bool(one.remarks) for one in runs)
    said = f", {remarked} of them with remarks" if remarked else ""
    return f"{accepted} of {len(runs)} runs can be used{said}"


def proposed(options: Options, gravity: float, asking: Asking) -> Answer:
    """A first map of the file or folder SOURCE, measured where `gravity` [m/s^2] is, written to --propose. Raises
    WrongOption."""
    from stages.imu.sources.proposal import proposals

    assert options.propose is not None
    ((text, lines),) = asking.reading(proposals, Path(options.source), gravity)
    with asking.new_file(options.propose) as file:
        file.write_text(text, encoding="utf-8")
    return Answer(lines=lines, plain={"map": text, "told": list(lines)})


def read(options: Options, asking: Asking, store: Path | None) -> Iterator[Run]:
    """Each run of the source, whose rows go into `store`; says if others can read it.

    Raises SourceRefused, WrongOption.

    A server is asked from here, as it needs the network; a file is read in a process that has none.
    """
    from stages.imu.sources.column_map import CsvSource
    from stages.imu.sources.databases import SqlSource
    from stages.imu.sources.reading import kept, run_of, runs

    source, place = options.source, None if store is None else str(store)
    if options.column_map is None and "://" in source:
        raise WrongOption(f"SOURCE: a connection string would stay in the shell's history; give {VARIABLE}NAME, "
                          "the environment variable that holds it")  # fmt: skip
    if options.column_map is None and source.startswith(VARIABLE):
        name = source.removeprefix(VARIABLE)
        if not os.environ.get(name):
            raise WrongOption(f"SOURCE: the environment variable {name} is not set")
        with SqlSource(os.environ[name]) as server:
            if server.in_the_open:
                asking.note(f"{server.name}: {OPEN}")
            yield from kept(server, place)
        return
    if options.column_map is None and Path(source).is_dir():
        raise WrongOption(f"{Path(source)}: is a folder; --map FILE must say what its files hold, "
                          "and --propose FILE writes a first one")
    if options.column_map is not None:
        if Path(source).is_file():
            raise WrongOption(f"{Path(source)}: is a file; --map FILE wants the folder that holds it")
        CsvSource(options.column_map, Path(source))  # here: the map's lines are not known where files are read
    yield from map(run_of, asking.reading(runs, Path(source), options.column_map, place, writes=store))


QUESTION = Question(
    "ingest",
    """Read the measurements in SOURCE, print the quality of each run and sensor, and change nothing in SOURCE.

    SOURCE is an SQLite file, a folder (with --map), or env:NAME, an environment variable that holds a
    connection string such as postgresql://user:password@host/database, which alone needs the network.
    docs/measurements.md has the schema. Ends with 3 if no run can be used. --propose writes a first map of
    unknown files, --figure draws the first run. To use a file made by --store in the study, set imu.database.
    """,
    Options,
    ask,
    examples=("bipedstudy ingest lab.sqlite", "bipedstudy ingest recordings --map columns.yaml --store lab.sqlite",),
    draws=True,
    rows=True,
)
