"""What the commands share that put a question to the analytic model: the design, and an answer that is no."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import click

from pipeline.commands import options
from pipeline.errors import ANSWER, StudyError, is_answer
from pipeline.study import Study, shown

STAGE = "analytic"


def module(study: Study, name: str) -> Any:
    """A module of the analytic stage."""
    return importlib.import_module(f"{study.package}.{STAGE}.{name}")


@contextmanager
def or_reason(study: Study, name: str, as_json: bool) -> Iterator[None]:
    """Print the reason and exit with 3 if the question has no answer, as a design without a gait."""
    try:
        yield
    except Exception as reason:
        if not is_answer(reason, study.package):
            raise
        if as_json:
            options.print_json({name: None, "reason": str(reason)})
        else:
            click.echo(str(reason), err=True)
        sys.exit(ANSWER)


def number_of_design(point: Any, name: str) -> float:
    """Value of a design parameter by its name in the parameter files. Raises `StudyError` with the known names."""
    try:
        return float(point.value(name))
    except KeyError as error:
        raise StudyError(str(error.args[0])) from None


def interval(text: str, what: str) -> tuple[float, float]:
    """Two numbers "low:high" with low < high. Raises `StudyError`."""
    low, colon, high = text.partition(":")
    try:
        limits = float(low), float(high)
    except ValueError:
        limits = (1.0, 0.0)
    if not colon or not limits[0] < limits[1] or not all(abs(value) < float("inf") for value in limits):
        raise StudyError(f"{what}: {text!r} is not two numbers LOW:HIGH with LOW < HIGH")
    return limits


figure = click.option(
    "--figure", type=click.Path(dir_okay=False, path_type=Path), help="Draw into FILE (its ending names the format)."
)


def save(path: Path, drawn: Any) -> None:
    """Write a figure and say where. Raises `StudyError` for an ending that is no picture format."""
    known = sorted(drawn.canvas.get_supported_filetypes())
    if path.suffix.lstrip(".").lower() not in known:
        raise StudyError(f"{shown(path)}: the ending names the format, one of {', '.join(known)}")
    drawn.savefig(path, dpi=150)
    click.echo(f"drawn: {shown(path)}", err=True)
