"""`bipedstudy ingest`: what a lab's measurements are worth, before they are used."""

from __future__ import annotations

import contextlib
import importlib
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import click

from pipeline.cache import durable
from pipeline.commands import options
from pipeline.commands.gait import fields_as_plain
from pipeline.commands.show import print_table
from pipeline.errors import ANSWER, StudyError, is_answer
from pipeline.parameters import yaml_text
from pipeline.study import Study, shown

STAGE = "imu"
VARIABLE = "env:"


@click.command("ingest")
@click.argument("source")
@click.option(
    "--map",
    "column_map",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    help="SOURCE is a folder of CSV or TSV files, described in this YAML file.",
)
@click.option("--store", type=click.Path(dir_okay=False, path_type=Path), help="Keep the raw rows in this SQLite file.")
@options.study
@options.as_json
def command(study: Study, source: str, column_map: Path | None, store: Path | None, as_json: bool) -> None:
    """Read the measurements in SOURCE, print the report of each run and sensor, and change nothing in SOURCE.

    SOURCE is an SQLite file, a folder (with --map), or env:NAME, an environment variable that holds a connection
    string such as postgresql://user:password@host/database. docs/measurements.md has the schema. Ends with 3 if no run
    can be used. A file made by --store can be the study's own: set imu.database.
    """
    settings = study.parameters([STAGE])[STAGE].settings
    sensors, runs = [], []
    with _refused(study), _opened(study, source, column_map) as opened, _stored(study, store) as writer:
        for trial in _module(study, "run").trials(writer(opened.runs()), settings):
            sensors.extend(trial.reports)
            runs.append(trial.report())
    if as_json:
        options.print_json({"runs": [fields_as_plain(one) for one in runs],
                            "sensors": [fields_as_plain(one) for one in sensors]})  # fmt: skip
    else:
        reports = _module(study, "trial.run_report")
        for title, columns, rows in reports.tables(sensors, runs, reports.origin_of(runs)):
            print_table(title, columns, rows)
    accepted = sum(one.accepted for one in runs)
    click.echo(f"{accepted} of {len(runs)} runs can be used", err=True)
    if not accepted:
        sys.exit(ANSWER)


def _module(study: Study, name: str) -> Any:
    return importlib.import_module(f"{study.package}.{STAGE}.{name}")


@contextlib.contextmanager
def _refused(study: Study) -> Iterator[None]:
    """What the ingest refuses is bad input, said in its own sentence."""
    try:
        yield
    except Exception as error:
        if not is_answer(error, study.package):
            raise
        raise StudyError(str(error)) from None


def _opened(study: Study, source: str, column_map: Path | None) -> Any:
    """The source as a context manager with runs()."""
    if column_map is not None:
        description = yaml_text.read(column_map, shown(column_map)).plain()
        if not isinstance(description, dict):
            raise StudyError(f"{shown(column_map)}: expected lines of the form key: value")
        return _module(study, "sources.source_csv").CsvSource(description, Path(source))
    if "://" in source:
        raise StudyError(f"SOURCE: a connection string would stay in the shell's history; give {VARIABLE}NAME, "
                         "the environment variable that holds it")  # fmt: skip
    if source.startswith(VARIABLE):
        name = source.removeprefix(VARIABLE)
        if not os.environ.get(name):
            raise StudyError(f"SOURCE: the environment variable {name} is not set")
        return _module(study, "sources.source_sql").SqlSource(os.environ[name])
    if Path(source).is_dir():
        raise StudyError(f"{shown(Path(source))}: is a folder; --map FILE must say what its files hold")
    return _module(study, "sources.source_sqlite").SqliteSource(Path(source))


@contextlib.contextmanager
def _stored(study: Study, store: Path | None) -> Iterator[Any]:
    """A function that passes runs on and, if `store` is given, keeps them; the file appears whole or not at all."""
    if store is None:
        yield lambda runs: runs
        return
    if store.exists():
        raise StudyError(f"{shown(store)}: is there already; --store makes a new file")
    unfinished = store.with_name(f".{store.name}.{os.getpid()}.part")
    try:
        with _module(study, "sources.database").DatabaseWriter(unfinished) as writer:

            def kept(runs: Any) -> Iterator[Any]:
                for experiment, recordings in runs:
                    writer.recordings(experiment, recordings)
                    yield experiment, recordings

            yield kept
        unfinished.replace(store)
        durable.sync_folder(store.parent)
    finally:
        unfinished.unlink(missing_ok=True)
