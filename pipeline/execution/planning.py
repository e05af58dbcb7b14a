"""Which stages are current, which can be restored, which must be computed, and why."""

from __future__ import annotations

import enum
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from pipeline.cache import fingerprint
from pipeline.cache.fingerprint import Ingredients
from pipeline.cache.store import Entry
from pipeline.parameters import loading
from pipeline.study import Study


class State(enum.Enum):
    """What a stage needs."""

    CURRENT = "current"
    RESTORABLE = "restorable"
    STALE = "stale"
    WAITING = "waiting"


@dataclass(frozen=True)
class Assessment:
    """State of one stage, its reasons, and, once its inputs are known, what its result would follow from.

    `own` is what else changed about a stage that waits.
    """

    name: str
    state: State
    reasons: tuple[str, ...]
    ingredients: Ingredients | None = None
    entry: Entry | None = None
    own: tuple[str, ...] = ()


class Planner:
    """Assesses stages against the parameters given to it; code and inputs are read afresh for each run or survey."""

    def __init__(self, study: Study, values: Mapping[str, Any]) -> None:
        self.study, self.values = study, values

    def assess(self, name: str, upstream: Mapping[str, Entry]) -> Assessment:
        """State of stage `name`, given the entries of the stages it reads."""
        stage = self.study.graph.stages[name]
        inputs: dict[str, str] = {}
        for path in stage.inputs:
            inputs.update(upstream[self.study.graph.maker(path)].contents(path))
        inputs.update({key: sha256 for key, (_, sha256) in self.study.named_files(self.values[name]).items()})
        plain = loading.as_plain(self.values[name])
        parts = fingerprint.ingredients(stage, self.study.sources, plain, inputs)
        store = self.study.store
        key, last = fingerprint.key(parts), store.current(name)
        entry = last if last is not None and last.key == key else store.entry(key)
        if last is None:
            present = [out for out in stage.outs if store.place(out).exists()]
            reasons = [f"{present[0]} is there, but nothing says how it was made"] if present else ["never run"]
        else:
            reasons = list(fingerprint.changes(last.ingredients, parts)) or store.disturbed(last)
        if entry is None:
            reasons = reasons or ["its stored result is gone"]
            return Assessment(name, State.STALE, tuple(reasons), parts)
        state = State.RESTORABLE if reasons else State.CURRENT
        return Assessment(name, state, tuple(reasons), parts, entry)

    def survey(self, names: Iterable[str]) -> list[Assessment]:
        """State of all `names` (in order, with everything upstream) without running anything."""
        entries: dict[str, Entry] = {}
        found = []
        with self.study.sources.one_moment():
            for name in names:
                waits_for = [above for above in self.study.graph.upstream(name) if above not in entries]
                if waits_for:
                    reasons = tuple(f"input {above} will be computed first" for above in waits_for)
                    found.append(Assessment(name, State.WAITING, reasons, own=self._own_changes(name)))
                    continue
                found.append(self.assess(name, entries))
                entry = found[-1].entry
                if entry is not None:
                    entries[name] = entry
        return found

    def _own_changes(self, name: str) -> tuple[str, ...]:
        """What changed about a stage but its inputs since its result was computed."""
        last = self.study.store.current(name)
        if last is None:
            return ()
        plain, before = loading.as_plain(self.values[name]), last.ingredients["inputs"]
        parts = fingerprint.ingredients(self.study.graph.stages[name], self.study.sources, plain, before)
        return tuple(fingerprint.changes(last.ingredients, parts))
