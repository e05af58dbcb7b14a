"""Options that several commands share."""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Callable
from typing import Any

import click

from pipeline.study import Study, locate

Command = Callable[..., Any]


def study(function: Command) -> Command:
    """`--params`, `--results` and `--set`; the command gets a `Study` as its first argument."""

    @click.option("--params", metavar="DIR", help="Folder of the parameter files (default: the study's params).")
    @click.option("--results", metavar="DIR", help="Folder of the results (default: the study's results).")
    @click.option("--set", "settings", metavar="FILE.KEY=VALUE", multiple=True, help="Change a parameter; repeatable.")
    @functools.wraps(function)
    def with_study(params: str | None, results: str | None, settings: tuple[str, ...], **options: Any) -> Any:
        found: Study = locate(params, results, settings)
        return function(found, **options)

    return with_study


def accuracy(function: Command) -> Command:
    """`--accuracy` and `--verify`; the command gets a `Study` that knows the error asked for, and `verify`."""

    @click.option("--accuracy", default="", metavar="WORD|KEY=VALUE",
                  help="Solver settings of every walk for an error: draft, paper, reference, or as "
                       "hip_position_m=1e-5. Goes before the key accuracy of the parameter files.")
    @click.option("--verify", is_flag=True,
                  help="Estimate the hip's error by a second run: the best setting measured at no more than half the "
                       "cost, or else the next finer one. The estimate is kept beside the artefact, in "
                       "results/accuracy: an artefact's bytes do not depend on it.")
    @functools.wraps(function)
    def with_accuracy(found: Study, accuracy: str, verify: bool, **options: Any) -> Any:
        asked = dataclasses.replace(found, accuracy=accuracy)
        if not verify:
            return function(asked, **options)
        from pipeline import verification

        choices = verification.choices(asked, options.get("stages") or tuple(asked.graph.stages))
        done = function(asked, **options)
        if not options.get("dry_run"):
            verification.verify(asked, choices, told=not options.get("as_json"))
        return done

    return with_accuracy


def running(function: Command) -> Command:
    """`--jobs`, `--force`, `--dry-run`, `--wait`, `-v`: how stages are run."""
    for option in (
        click.option(
            "--jobs", "-j", metavar="N", type=click.IntRange(min=1), help="Stages side by side (default: cores)."
        ),
        click.option("--force", is_flag=True, help="Compute anew even what is current."),
        click.option("--dry-run", is_flag=True, help="Say what would run and why; run nothing."),
        click.option("--wait", is_flag=True, help="Wait for another run in the same results folder."),
        click.option("-v", "--verbose", is_flag=True, help="Say why each stage runs."),
    ):
        function = option(function)
    return function


as_json = click.option("--json", "as_json", is_flag=True, help="Print JSON.")
"""`--json`: the answer as JSON on standard output, and nothing else there."""


def print_json(value: Any) -> None:
    """Print a value as JSON; a number that JSON does not know (NaN, infinity) as null."""
    import json

    click.echo(json.dumps(_finite(value), indent=2, ensure_ascii=False, allow_nan=False))


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
