"""What `run` and `run-all` have in common: lock, plan, run, report."""

from __future__ import annotations

import contextlib
import os
import sys
import time
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

import click

from pipeline.cache import disk
from pipeline.cache.fingerprint import compact
from pipeline.commands import clean
from pipeline.commands.options import print_json
from pipeline.commands.status import print_survey
from pipeline.errors import StageFailed, StudyError
from pipeline.execution import display
from pipeline.execution.executor import FAILING, Outcome, Planner, State, bring_up_to_date
from pipeline.parameters import levels, loading
from pipeline.study import Study, shown


def run_stages(
    study: Study,
    names: tuple[str, ...],
    *,
    forced: Iterable[str],
    jobs: int | None,
    dry_run: bool,
    wait: bool,
    as_json: bool,
    verbose: bool,
    afterwards: Callable[[Study, Mapping[str, str]], Path | None] | None = None,
) -> list[Outcome]:
    """Bring `names` up to date under the results folder's lock, or say what that would take.

    `afterwards` follows under the same lock, given why which stages failed; it returns the file it wrote, if any.
    Raises `StageFailed` after it where a stage said no or failed.
    """
    if not dry_run and any(study.store.current(name) is None for name in names):
        from pipeline.execution.process import get_ready

        get_ready()
    values = study.parameters(names)
    for sentence in study.warnings(values):
        click.echo(f"warning: {sentence}", err=True)
    if dry_run:
        survey = Planner(study, values).survey(names)
        print_survey(study, survey, as_json, frozenset(forced))
        return []
    began = time.perf_counter()
    shows = display.for_terminal(verbose, as_json)
    command = " ".join(["bipedstudy", *sys.argv[1:]])
    failed: StageFailed | None = None
    try:
        with disk.locked(study.results, shown(study.results), command, wait, shows.note):
            with contextlib.suppress(OSError):
                study.store.sweep()
            _say_what_gives_way(study, values, shows)
            try:
                outcomes = bring_up_to_date(study, values, shows, force=forced, jobs=jobs or os.cpu_count() or 1)
            except StageFailed as error:
                outcomes, failed = error.outcomes, error
            why, written = {outcome.stage: outcome.summary for outcome in outcomes if outcome.how == FAILING}, None
            try:
                written = afterwards(study, why) if afterwards else None
            except StudyError as error:
                if failed is None:
                    raise
                shows.note(str(error))
            if written is not None and not as_json:
                click.echo(f"{written.stem:<13} written             {shown(written)}")
            if any(outcome.how == "computed" for outcome in outcomes):
                _say_if_large(study, shows)
    except disk.NotWritable:
        if forced or any(item.state is not State.CURRENT for item in Planner(study, values).survey(names)):
            raise
        outcomes = bring_up_to_date(study, values, shows)  # everything is current, so this writes nothing
    seconds = time.perf_counter() - began
    if as_json:
        print_json({"stages": [_plain(outcome) for outcome in outcomes], "seconds": round(seconds, 3)})
    if failed is not None:
        raise failed
    return outcomes


def _say_what_gives_way(study: Study, values: Mapping[str, Any], shows: display.Display) -> None:
    """Results of a higher level, or of other parameters than --set gives, do not give way without a word."""
    kept, asked = 0, 0
    changed: dict[str, str] = {}
    given = [setting.partition("=")[0].partition(".") for setting in study.settings]
    for name, parameters in values.items():
        last = study.store.current(name)
        before, now = last.ingredients["parameters"] if last else {}, loading.as_plain(parameters)
        kept, asked = max(kept, _rank(before)), max(asked, _rank(now))
        for file, _, key in given:
            was, will = before.get(file, {}).get(key), now.get(file, {}).get(key)
            if was is not None and was != will:
                changed[f"{file}.{key}"] = f"{file}.{key} = {compact(was)} give way to those of {compact(will)}"
    if kept > asked:
        shows.note(f"these results are of accuracy {levels.LEVELS[kept]} and give way to {levels.LEVELS[asked]}; they "
                   "are kept, and come back at once when that accuracy is asked for again")  # fmt: skip
    if changed:
        shows.note(f"results of {', of '.join(changed.values())}; they are kept, and come back at once without "
                   "--set; --results DIR leaves them where they are")  # fmt: skip


def _rank(plain: Mapping[str, Mapping[str, Any]]) -> int:
    """Place of the level among plain parameters, the least accurate first; that one where they have none."""
    level = plain.get(levels.FILE, {}).get(levels.KEY)
    return levels.LEVELS.index(level) if level in levels.LEVELS else 0


def _say_if_large(study: Study, shows: display.Display) -> None:
    size = sum(clean.size_of(folder) for folder, _ in clean.earlier(study.store))
    if size > clean.WORTH_A_WORD:
        place = shown(study.store.folder)
        shows.note(f"earlier results take {clean.told(size)} in {place}; bipedstudy clean removes them")


def _plain(outcome: Outcome) -> dict[str, object]:
    return {
        "stage": outcome.stage,
        "how": outcome.how,
        "summary": outcome.summary,
        "seconds": round(outcome.seconds, 3),
        "processor_seconds": outcome.processor_seconds,
        "reasons": list(outcome.reasons),
        "key": outcome.key,
    }
