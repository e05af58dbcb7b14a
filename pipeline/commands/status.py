"""Which results are those of the parameters and code at hand, and why the others are not: `status`, and `graph`.

What is not current is said before a result is shown: the stages, what changed, and the command that makes them current.
That ends no command: where it is not known, that is said.
"""

import shlex
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import click

from pipeline import layout
from pipeline.cache import untouched
from pipeline.cache.store import Entry
from pipeline.commands import options
from pipeline.errors import StudyError
from pipeline.execution import executor
from pipeline.execution.executor import CURRENT, RESTORABLE, STALE, WAITING, Assessment
from pipeline.study import Study, shown

#: Reasons that are named; after an update of the program there may be hundreds.
_SHOWN = 5
#: What of two results must be the same, where both have it, for them to belong together.
_COMMON = ("inputs", "code", "versions")
#: What the state of a stage that can be restored is called.
_IN_CACHE = {RESTORABLE: "in cache"}


@click.command("status", epilog=options.examples("status"))
@options.own_study
@options.cached
@options.answers
def status(study: Study, form: options.Form) -> None:
    """Say which stages are current, and why the others are not. Runs nothing."""
    survey(study, study.parameters(study.graph.stages), form)


def survey(
    study: Study, values: Mapping[str, Any], form: options.Form, forced: frozenset[str] = frozenset()
) -> None:  # fmt: skip
    """Give the state and the reasons of each stage in `values`, its parameters; `forced` ones would run in any case."""
    rows: list[dict[str, Any]] = []
    for item in executor.survey(study, values):
        state, reasons = item.state, item.reasons
        if item.name in forced:
            state, reasons = STALE, ("requested by --force",)
        elif state == CURRENT and item.entry is not None and item.entry.refused:
            state, reasons = "refused", (item.entry.summary,)
        elif study.graph.stages[item.name].frozen and study.store.current(item.name) is None:
            state, reasons = "frozen", ("runs when it is named",)
        rows.append({"stage": item.name, "state": _IN_CACHE.get(state, state), "reasons": list(reasons)})
    study.sources.memo.save()
    form.give(
        (layout.beside(f"{row['stage']:<{layout.STAGE}} {row['state']:<8} ", in_short(row["reasons"])) for row in rows),
        rows, ({**row, "reasons": "; ".join(row["reasons"])} for row in rows),
    )  # fmt: skip


@click.command("graph", epilog=options.examples("graph"))
@options.study
@options.answers
def graph(study: Study, form: options.Form) -> None:
    """Print the stages in order: what each reads, which parameters it uses, what it makes."""
    rows: list[dict[str, Any]] = [
        {
            "stage": stage.name,
            "reads": list(stage.inputs),
            "upstream": list(study.graph.upstream(stage.name)),
            "params": {file: list(keys) if keys else None for file, keys in stage.parameters.items()},
            "makes": list(stage.outs),
            "code": list(stage.code),
        }
        for stage in study.graph.stages.values()
    ]
    flat = ({key: " ".join(value) if key != "stage" else value for key, value in row.items()} for row in rows)
    form.give((line for row in rows for line in _flow(row)), rows, flat)


def _flow(row: Mapping[str, Any]) -> Iterator[str]:
    """A stage, and below it what it reads, which parameters it uses and what it makes."""
    yield row["stage"]
    files = [f"{file}.yaml" + (f" ({', '.join(keys)})" if keys else "") for file, keys in row["params"].items()]
    for word, items in (("reads", row["reads"]), ("params", files), ("makes", row["makes"])):
        if items:
            yield layout.beside(f"  {word:<7} ", ", ".join(items))


class Standing:
    """How the results of some stages stand, surveyed once."""

    def __init__(self, study: Study, names: Iterable[str]) -> None:
        self.study, self.doubt = study, ""
        self.found: dict[str, Assessment] = {}
        try:
            wanted = () if untouched.recall(study) else study.graph.needed_for(tuple(names))
            surveyed = executor.survey(study, study.parameters(wanted)) if wanted else ()
            self.found = {item.name: item for item in surveyed if item.state != CURRENT}
            study.sources.memo.save()
        except (StudyError, OSError) as error:
            why = "; ".join(str(error).splitlines())
            self.doubt = f"whether these results are current cannot be told: {why}"

    def sentence(self, names: Iterable[str]) -> str:
        """What is to be said of the results of these stages; nothing where all are current."""
        requested = set(names)
        stale = [name for name in self.found if name in requested]
        if self.doubt or not stale:
            return self.doubt
        why: dict[tuple[str, ...], list[str]] = {}
        for name in stale:
            why.setdefault(tuple(self._reasons(name)), []).append(name)
        causes = "; ".join(f"{', '.join(alike)} ({in_short(reasons)})" for reasons, alike in why.items())
        last = [name for name in stale if not any(
            name in self.study.graph.needed_for((other,)) for other in stale if other != name)]  # fmt: skip
        command = " ".join(["bipedstudy run", *last, *map(shlex.quote, self._options())])
        return f"not current: {causes}; make {'them' if len(stale) > 1 else 'it'} current with: {command}"

    def _reasons(self, name: str) -> dict[str, None]:
        """What changed for a stage, and, where it waits for others, for these."""
        item = self.found[name]
        if item.state != WAITING:
            return dict.fromkeys(item.reasons)
        above = [self._reasons(each) for each in self.study.graph.upstream(name)
                 if each in self.found and self.found[each].entry is None]  # fmt: skip
        return {**dict.fromkeys(item.own), **{reason: None for each in above for reason in each}}

    def _options(self) -> Iterable[str]:
        """What the command at hand found of the study."""
        for option, place in (("params", self.study.params), ("results", self.study.results)):
            if place != self.study.root / option:
                yield from (f"--{option}", shown(place))
        for setting in self.study.settings:
            yield from ("--set", setting)


def say(study: Study, *names: str) -> None:
    """Say on standard error which results of these stages are not current."""
    echo(Standing(study, names).sentence(names))


def echo(said: str) -> None:
    """A note on standard error, if there is something to say."""
    if said:
        click.echo("\n".join(layout.folded(f"note: {said}")), err=True)


def made_by(study: Study, name: str) -> Entry | None:
    """What is known of the making of a stage's result that lies there, by its own word; None for a stranger's.

    Where none lies there it is what was put there last, which may be a reason.
    """
    last, place = study.store.current(name), study.store.place(study.graph.stages[name].artefact)
    if not place.exists():
        return last
    key = study.provenance(place).get("key", "")
    return last if last is not None and last.key == key else study.store.entry(key) if key.isalnum() else None


def together(study: Study, names: Sequence[str]) -> bool:
    """Whether the results of these stages, as they lie there, were computed from the same parameters, code and inputs.

    They were not if any that they follow from was computed anew since. A null is no value: one stage keeps it as it is
    where another has what it stands for.
    """
    entries = [made_by(study, name) for name in (study.graph.needed_for(tuple(names)) if len(names) > 1 else names)]
    one: dict[tuple[str, ...], object] = {}
    for entry in entries:
        if entry is None:
            return False
        parts = {(kind, name): value for kind in _COMMON for name, value in entry.ingredients[kind].items()
                 if kind != "inputs" or name.startswith("results/")}  # fmt: skip
        parts |= {("inputs", path): out.content for path, out in entry.outs.items()}
        parts |= {(file, key): value for file, own in entry.ingredients["parameters"].items()
                  for key, value in own.items() if value is not None}  # fmt: skip
        if any(one.setdefault(name, value) != value for name, value in parts.items()):
            return False
    return True


def in_short(reasons: Sequence[str]) -> str:
    """The first reasons, and how many more there are."""
    more = f"; and {len(reasons) - _SHOWN} more" if len(reasons) > _SHOWN else ""
    return "; ".join(reasons[:_SHOWN]) + more
