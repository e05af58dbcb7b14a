"""`bipedstudy run STAGE`, `run-all`, and `sweep SPEC.yaml`, one stage at many points: lock, plan, compute, report."""

import contextlib
import os
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import click

from pipeline import completion, layout
from pipeline.cache import bounds, disk, untouched
from pipeline.cache.fingerprint import compact
from pipeline.commands import house, options
from pipeline.commands.status import survey
from pipeline.errors import ANSWER, Declined, StageFailed, StudyError
from pipeline.execution import display, executor
from pipeline.execution.executor import CURRENT, FAILING, Outcome, bring_up_to_date
from pipeline.execution.process import get_ready
from pipeline.parameters import loading
from pipeline.parameters.value import LEVEL_FILE, LEVEL_KEY, LEVELS
from pipeline.study import Study, shown
from pipeline.sweep import cluster as clusters

#: Follows once stages were computed, given why which of them failed; it returns the file it wrote, if any.
Afterwards = Callable[[Study, Mapping[str, str]], Path | None]


@click.command("run", epilog=options.examples("run"))
@click.argument("stages", nargs=-1, required=True, metavar="STAGE...", shell_complete=completion.stages)
@options.own_study
@options.requests
@options.running
@options.answers_without_rows
def run(study: Study, stages: tuple[str, ...], force: bool, **how: Any) -> None:
    """Bring stages, and first everything they read, up to date; --force applies to the named stages only."""
    for stage in stages:
        study.graph.stage(stage)
    _bring(study, study.graph.needed_for(stages), forced=stages if force else (), **how)


@click.command("run-all", epilog=options.examples("run-all"))
@options.own_study
@options.requests
@options.running
@options.answers_without_rows
def run_all(study: Study, force: bool, dry_run: bool, form: options.Form, verbose: bool, **how: Any) -> None:
    """Bring every stage up to date, then the report; stages that are frozen in dvc.yaml run when they are named.

    Ends with 3 where a stage or a figure is missing for a reason.
    """
    plain, names = form.is_text and not (force or dry_run), study.graph.usual
    if plain and (summaries := untouched.recall(study)):
        shows = display.for_terminal(verbose, False)
        for name, summary in summaries.items():
            shows.finished(name, CURRENT, 0.0, summary)
        shows.close()
        return
    from pipeline.report import page

    lay = untouched.look(study) if plain else None
    outcomes = _bring(study, names, forced=names if force else (), dry_run=dry_run, form=form, verbose=verbose,
                      afterwards=page.refresh, **how)  # fmt: skip
    if not dry_run and (absent := page.undrawn(study)):
        raise Declined(absent)
    if all(outcome.how == CURRENT for outcome in outcomes) and not study.warnings(study.parameters(names)):
        untouched.note(study, lay, {outcome.stage: outcome.summary for outcome in outcomes})


def _bring(
    study: Study, names: tuple[str, ...], *, forced: Iterable[str], jobs: int | None, dry_run: bool, wait: bool,
    form: options.Form, verbose: bool, afterwards: Afterwards | None = None,
) -> list[Outcome]:  # fmt: skip
    """Bring `names` up to date under the results folder's lock, or say what that would take.

    `afterwards` follows under the same lock. Raises `StageFailed` after it where a stage said no or failed.
    """
    if not dry_run and None in map(study.store.current, names):
        get_ready()
    values, limits = study.parameters(names), bounds.read(study.root)
    options.warn(study, values)
    if dry_run:
        survey(study, values, form, frozenset(forced))
        return []
    began, shows = time.perf_counter(), display.for_terminal(verbose, form.as_json)
    failed: StageFailed | None = None
    try:
        with disk.locked(study.results, shown(study.results), _typed(), wait, shows.note):
            outcomes, failed = _compute(study, values, forced, jobs or os.cpu_count() or 1, form, shows, afterwards)
            bounds.hold(study.store, limits, shows.note)
            if any(outcome.how == "computed" for outcome in outcomes):
                _say_if_large(study, shows)
    except disk.NotWritable:
        if forced or {item.state for item in executor.survey(study, values)} - {CURRENT}:
            raise
        outcomes = bring_up_to_date(study, values, shows)  # everything is current, so this writes nothing
    form.give((), {"stages": [{
        "stage": outcome.stage, "how": outcome.how, "summary": outcome.summary, "seconds": round(outcome.seconds, 3),
        "processor_seconds": outcome.processor_seconds, "reasons": list(outcome.reasons), "key": outcome.key,
    } for outcome in outcomes], "seconds": round(time.perf_counter() - began, 3)})  # fmt: skip
    if failed is not None:
        raise failed
    return outcomes


def _compute(
    study: Study, values: Mapping[str, Any], forced: Iterable[str], jobs: int, form: options.Form,
    shows: display.Display, afterwards: Afterwards | None,
) -> tuple[list[Outcome], StageFailed | None]:  # fmt: skip
    """What came of each stage, and what failed; says which file `afterwards` wrote."""
    with contextlib.suppress(OSError):
        study.store.sweep()
    _say_what_gives_way(study, values, shows)
    failed = None
    try:
        outcomes = bring_up_to_date(study, values, shows, force=forced, jobs=jobs)
    except StageFailed as error:
        outcomes, failed = error.outcomes, error
    why = {outcome.stage: outcome.summary for outcome in outcomes if outcome.how == FAILING}
    try:
        if afterwards and (written := afterwards(study, why)) and form.is_text:
            click.echo(f"{written.stem:<{layout.STAGE}} written             {shown(written)}")
    except StudyError as error:
        if failed is None:
            raise
        shows.note(str(error))
    return outcomes, failed


def _typed() -> str:
    """The command as it was typed: who waits for its lock is told."""
    return " ".join(["bipedstudy", *sys.argv[1:]])


def _say_what_gives_way(study: Study, values: Mapping[str, Any], shows: display.Display) -> None:
    """Results of a higher level, or of other parameters than --set gives, do not give way without a word."""
    ranks: list[tuple[int, int]] = []
    changed: dict[str, str] = {}
    for name, parameters in values.items():
        last = study.store.current(name)
        before, now = last.ingredients["parameters"] if last else {}, loading.as_plain(parameters)
        ranks.append((_rank(before), _rank(now)))
        for file, _, key in (setting.partition("=")[0].partition(".") for setting in study.settings):
            was, will = before.get(file, {}).get(key), now.get(file, {}).get(key)
            if was is not None and was != will:
                changed[f"{file}.{key}"] = f"{file}.{key} = {compact(was)} give way to those of {compact(will)}"
    kept, wanted = map(max, zip((0, 0), *ranks))
    if kept > wanted:
        shows.note(f"these results are of accuracy {LEVELS[kept]} and give way to {LEVELS[wanted]}; they "
                   "are kept, and come back at once when that accuracy is requested again")  # fmt: skip
    if changed:
        shows.note(f"results of {', of '.join(changed.values())}; they are kept, and come back at once without "
                   "--set; --results DIR leaves them where they are")  # fmt: skip


def _rank(plain: Mapping[str, Mapping[str, Any]]) -> int:
    """Place of the level among plain parameters, the least accurate first; that one where they have none."""
    level = plain.get(LEVEL_FILE, {}).get(LEVEL_KEY)
    return LEVELS.index(level) if level in LEVELS else 0


def _say_if_large(study: Study, shows: display.Display) -> None:
    size = sum(one.size for one in bounds.beyond(study.store, bounds.Bounds()))
    if size > house.WORTH_A_WORD:
        shows.note(f"earlier results take {bounds.in_units(size)} in {shown(study.store.folder)}; bipedstudy clean "
                   f"removes them, and {bounds.FILE_NAME} bounds them (see its --help)")  # fmt: skip


@click.command("sweep", epilog=options.examples("sweep"))
@click.argument("spec", type=click.Path(dir_okay=False, path_type=Path), metavar="SPEC")
@click.option("--out", type=click.Path(dir_okay=False, path_type=Path), help="The table (default: results/sweeps).")
@clusters.offered
@click.option("--dry-run", is_flag=True, help="Say how many points there are and what each computes; run nothing.")
@click.option("--wait", is_flag=True, help="Wait for another sweep in the same results folder.")
@options.own_study
@options.answers
def sweep(
    study: Study, spec: Path, out: Path | None, jobs: int | None, connect: clusters.Connect, dry_run: bool,
    wait: bool, form: options.Form,
) -> None:  # fmt: skip
    """Compute a stage at every point that the file SPEC describes, and write one table with a row for each.

    docs/sweeps.md shows how a SPEC is written. Points that were computed before, also by a sweep that was stopped, are
    not computed again. A point without a result is a row with its reason; ends with 3 if no point has a result.
    """
    from pipeline.sweep import spec as specs
    from pipeline.sweep.sweep import Sweep

    shows = display.for_terminal(False, not form.is_text)
    made = Sweep(study, specs.read(spec), shows)
    if dry_run:
        names, varied = ", ".join(made.chain.touched), ", ".join(made.spec.names)
        for line in layout.folded(f"{made.spec.size} points, each computes {names}; varied: {varied}"):
            click.echo(line)
        return
    target = disk.replaceable(out or made.folder / f"{spec.stem}.h5")
    with (
        disk.locked(made.folder, shown(made.folder), _typed(), wait, shows.note),
        connect(shows.note) as (client, workers),
    ):
        summary = made.run(target, workers or jobs or os.cpu_count() or 1, client)
    form.give(_lines(summary, target), {**summary, "table": shown(target)}, _rows(target))
    if not summary["outcomes"].get("computed"):
        sys.exit(ANSWER)


def _lines(summary: Mapping[str, Any], target: Path) -> Iterator[str]:
    """A sweep's summary: outcomes, what it cost, and where its table is."""
    parts = [f"{count} {outcome}" for outcome, count in sorted(summary["outcomes"].items())]
    yield from layout.folded(f"{summary['points']} points: {', '.join(parts)}; {summary['reused']} were known")
    if summary["busy"] is not None:
        yield from layout.folded(
            f"{summary['computed_now']} points in {summary['seconds']:.1f} s on {summary['workers']} worker"
            f"{'s' * (summary['workers'] > 1)}; "
            f"{100 * summary['busy']:.0f} % of their time went into points")  # fmt: skip
    yield f"table: {shown(target)}"


def _rows(path: Path) -> Iterator[dict[str, Any]]:
    """The rows of a sweep's table."""
    import h5py

    from pipeline.commands.show import plain_values

    with h5py.File(path) as file:
        columns = {name: plain_values(item) for name, item in file["table"].items()}
    yield from (dict(zip(columns, row)) for row in zip(*columns.values()))
