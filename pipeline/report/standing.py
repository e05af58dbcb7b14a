"""Which results in the results folder are not those of the parameters and code at hand: said, before they are shown.

What is said names the stages, what changed, and the command that makes them current. Nothing here ends a command: where
it cannot be told, that is said.
"""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Sequence

import click

from pipeline import layout
from pipeline.cache import untouched
from pipeline.cache.store import Entry
from pipeline.errors import StudyError
from pipeline.execution.executor import Assessment, Planner, State
from pipeline.study import Study, shown

#: Reasons that are named; after an update of the program there may be hundreds.
_SHOWN = 5
#: What of two results must be the same, where both have it, for them to belong together.
_COMMON = ("inputs", "code", "versions")


class Standing:
    """How the results of some stages stand, surveyed once."""

    def __init__(self, study: Study, names: Iterable[str]) -> None:
        self.study, self.doubt = study, ""
        self.found: dict[str, Assessment] = {}
        try:
            wanted = () if untouched.recall(study) else study.graph.needed_for(tuple(names))
            survey = Planner(study, study.parameters(wanted)).survey(wanted) if wanted else ()
            self.found = {item.name: item for item in survey if item.state is not State.CURRENT}
            study.sources.memo.save()
        except (StudyError, OSError) as error:
            why = "; ".join(str(error).splitlines())
            self.doubt = f"whether these results are current cannot be told: {why}"

    def said(self, names: Iterable[str]) -> str:
        """What is to be said of the results of these stages; nothing where all are current."""
        asked = set(names)
        stale = [name for name in self.found if name in asked]
        if self.doubt or not stale:
            return self.doubt
        why: dict[tuple[str, ...], list[str]] = {}
        for name in stale:
            why.setdefault(tuple(self._reasons(name)), []).append(name)
        told = "; ".join(f"{', '.join(alike)} ({in_short(reasons)})" for reasons, alike in why.items())
        last = [name for name in stale if not any(
            name in self.study.graph.needed_for((other,)) for other in stale if other != name)]  # fmt: skip
        command = " ".join(["bipedstudy run", *last, *map(shlex.quote, self._options())])
        return f"not current: {told}; make {'them' if len(stale) > 1 else 'it'} current with: {command}"

    def _reasons(self, name: str) -> dict[str, None]:
        """What changed for a stage, and, where it waits for others, for these."""
        item = self.found[name]
        if item.state is not State.WAITING:
            return dict.fromkeys(item.reasons)
        above = [self._reasons(each) for each in self.study.graph.upstream(name)
                 if each in self.found and self.found[each].entry is None]  # fmt: skip
        return {**dict.fromkeys(item.own), **{reason: None for each in above for reason in each}}

    def _options(self) -> Iterable[str]:
        """What the command at hand was told of the study."""
        for option, place in (("params", self.study.params), ("results", self.study.results)):
            if place != self.study.root / option:
                yield from (f"--{option}", shown(place))
        for setting in self.study.settings:
            yield from ("--set", setting)


def say(study: Study, *names: str) -> None:
    """Say on standard error which results of these stages are not current."""
    echo(Standing(study, names).said(names))


def echo(said: str) -> None:
    """A note on standard error, if there is something to say."""
    if said:
        click.echo("\n".join(layout.folded(f"note: {said}")), err=True)


def made_by(study: Study, name: str) -> Entry | None:
    """What is known of the making of a stage's result that lies there, by its own word; None for a stranger's.

    Where none lies there it is what was put there last, which may be a reason.
    """
    from pipeline.cache import artefact  # with h5py, which takes its time

    last, place = study.store.current(name), study.store.place(study.graph.stages[name].artefact)
    if not place.exists():
        return last
    key = artefact.provenance(place.read_bytes(), shown(place)).get("key", "")
    return last if last is not None and last.key == key else study.store.entry(key) if key.isalnum() else None


def together(study: Study, names: Sequence[str]) -> bool:
    """Whether the results of these stages, as they lie there, were computed from the same parameters, code and inputs.

    They were not if any that they follow from was computed anew since.
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
                  for key, value in own.items()}  # fmt: skip
        if any(one.setdefault(name, value) != value for name, value in parts.items()):
            return False
    return True


def in_short(reasons: Sequence[str]) -> str:
    """The first reasons, and how many more there are."""
    more = f"; and {len(reasons) - _SHOWN} more" if len(reasons) > _SHOWN else ""
    return "; ".join(reasons[:_SHOWN]) + more
