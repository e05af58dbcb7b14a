"""`ingest`: what a lab's measurements are worth, before they are used."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stages.biped.question import Answer, Asking, Question, WrongOption, as_plain, option
from stages.imu.sources.opening import SourceRefused

if TYPE_CHECKING:
    from stages.imu.parameters import Parameters
    from stages.imu.result import RunReport, SensorReport
    from stages.imu.sources.databases import TableSource
    from stages.imu.sources.schema import DatabaseWriter
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
        return proposed(options, asking)
    from stages.imu.export import picture
    from stages.imu.result import origin_of, tables
    from stages.imu.run import trials
    from stages.imu.sources.databases import TableSource
    from stages.imu.sources.schema import DatabaseWriter

    sensors: list[SensorReport] = []
    runs: list[RunReport] = []
    taken: list[Trial] = []
    try:
        with ExitStack() as open_until_read:
            source = open_until_read.enter_context(opened(options, asking))
            read, tabled = source.runs(), isinstance(source, TableSource)
            if options.store is not None:
                file = open_until_read.enter_context(asking.new_file(options.store))
                writer = open_until_read.enter_context(DatabaseWriter(file, keys=not tabled))
                read = copied(source, writer) if tabled else stored(read, writer)
            for trial in trials(read, parameters.read, asking.progress):
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


def proposed(options: Options, asking: Asking) -> Answer:
    """A first map of the file or folder SOURCE, written to --propose. Raises WrongOption."""
    from stages.imu.sources.proposal import proposal

    assert options.propose is not None
    try:
        text, told = proposal(Path(options.source))
    except SourceRefused as refused:
        raise WrongOption(str(refused)) from None
    with asking.new_file(options.propose) as file:
        file.write_text(text, encoding="utf-8")
    return Answer(lines=told, plain={"map": text, "told": list(told)})


def opened(options: Options, asking: Asking) -> Any:
    """The source as a context manager with runs(); says if all can read it. Raises SourceRefused, WrongOption."""
    from stages.imu.sources.column_map import CsvSource
    from stages.imu.sources.databases import SqliteSource, SqlSource

    source = options.source
    if options.column_map is not None:
        return nullcontext(CsvSource(options.column_map, Path(source)))
    if "://" in source:
        raise WrongOption(f"SOURCE: a connection string would stay in the shell's history; give {VARIABLE}NAME, "
                          "the environment variable that holds it")  # fmt: skip
    if source.startswith(VARIABLE):
        name = source.removeprefix(VARIABLE)
        if not os.environ.get(name):
            raise WrongOption(f"SOURCE: the environment variable {name} is not set")
        server = SqlSource(os.environ[name])
        if server.in_the_open:
            asking.note(f"{server.name}: {OPEN}")
        return server
    if Path(source).is_dir():
        raise WrongOption(f"{Path(source)}: is a folder; --map FILE must say what its files hold")
    return SqliteSource(Path(source))


def stored(runs: Iterator[Any], writer: DatabaseWriter) -> Iterator[Any]:
    """Pass runs on, and keep them."""
    for experiment, recordings in runs:
        writer.recordings(experiment, recordings)
        yield experiment, recordings


def copied(source: TableSource, writer: DatabaseWriter) -> Iterator[Any]:
    """Pass runs on, then keep the tables that they are from: each row as it is, in its place."""
    yield from source.runs()
    for table, rows in source.raw():
        writer.copy(table, rows)


QUESTION = Question(
    "ingest",
    """Read the measurements in SOURCE, print the quality of each run and sensor, and change nothing in SOURCE.

    SOURCE is an SQLite file, a folder (with --map), or env:NAME, an environment variable that holds a connection
    string such as postgresql://user:password@host/database. docs/measurements.md has the schema. Ends with 3 if no run
    can be used. --propose writes a first map of unknown files, --figure draws the first run. To use a file made by
    --store in the study, set imu.database.
    """,
    Options,
    ask,
    examples=("bipedstudy ingest lab.sqlite", "bipedstudy ingest recordings --map columns.yaml --store lab.sqlite",),
    draws=True,
    rows=True,
)
