"""Builds the stages' parameters from the YAML files and `--set`, and reports every error at once.

A stage's `Parameters` is a dataclass whose fields are parameter classes; each names its file by `FILE`. Two classes
may share a file. A key is known if a class of any stage declares it.
"""

import contextlib
import dataclasses
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cache, partial
from pathlib import Path
from typing import Any

from pipeline.errors import StudyError
from pipeline.parameters import yaml_text
from pipeline.parameters.overrides import Override, applied, home_of, node_of, parsed
from pipeline.parameters.value import (
    DEFAULT_LEVEL,
    LEVEL_FILE,
    LEVEL_KEY,
    SUFFIX,
    Refused,
    broken_rules,
    declared,
    derived,
    half_width,
    plain_value,
    shown,
    value_of,
    values_of,
)
from pipeline.parameters.yaml_text import Node


def load(
    folder: Path,
    settings: Sequence[str],
    wanted: Mapping[str, type],
    known: Iterable[type],
    shown_as: str | None = None,
    requests: Sequence[Any] = (),
    requested: Mapping[str, str] | None = None,
    remark: Callable[[str], object] = str,
) -> dict[str, Any]:
    """Parameters of each stage in `wanted` (stage name -> its `Parameters` class).

    `settings` are the texts given to `--set`; `known` are the `Parameters` classes of all stages, which decide what a
    known key is; `shown_as` is how messages name the folder; `requests` are those of `pipeline.commands.options`,
    `requested` the texts given to them by name; `remark` gets what is taken, but not as the rest of its file is.
    Raises `StudyError` with one sentence for each error.
    """
    loading = _Loading(folder, shown_as or str(folder), known, requests)
    stages = loading.load(settings, wanted, requested or {})
    for sentence in loading.remarks:
        remark(sentence)
    return stages


def as_plain(parameters: Any) -> dict[str, dict[str, Any]]:
    """File -> key -> value of a stage's parameters, with tables as lists of mappings: what a key is made from."""
    plain: dict[str, dict[str, Any]] = {}
    for field in dataclasses.fields(parameters):
        section = getattr(parameters, field.name)
        values = {name: plain_value(getattr(section, name)) for name in declared(section.__class__)}
        for name in derived(section.__class__):
            values |= {f"{key}{SUFFIX}": width for key, width in getattr(section, name).items()}
        plain.setdefault(section.FILE, {}).update(values)
    return plain


def from_plain(cls: type, plain: Mapping[str, Mapping[str, Any]]) -> Any:
    """The parameters of class `cls` that `as_plain` made `plain` of, also by way of JSON, to the last bit.

    Raises `StudyError` for a value that the class does not take, and if anything of `plain` is lost, as a result would
    then stand under a key that is not its own; rules between values are not looked at again.
    """
    parameters = filled(cls, plain)
    if as_plain(parameters) != plain:
        raise StudyError(f"parameters of {cls.__module__} do not come back whole from their values")
    return parameters


def filled(cls: type, plain: Mapping[str, Mapping[str, Any]]) -> Any:
    """The same where some of `plain` may be null and follow from the rest. Raises `StudyError`."""
    return cls(**{name: _section(kind, plain[kind.FILE]) for name, (_, kind) in declared(cls).items()})


def _section(cls: type, plain: Mapping[str, Any]) -> Any:
    values, problems = values_of(cls, {key: Node.of(value) for key, value in plain.items()})
    for *_, sentence in problems:
        raise StudyError(sentence)
    of_file = {key.removesuffix(SUFFIX): width for key, width in plain.items()
               if key.endswith(SUFFIX)}  # fmt: skip
    return cls(**values, **dict.fromkeys(derived(cls), of_file))


def files(parameters: Any) -> dict[str, tuple[str, str]]:
    """Files that a stage's parameters name: key -> (parameter file, path as it stands there)."""
    return {key: (section.FILE, getattr(section, key)) for section in vars(parameters).values()
            for key in file_keys(type(section)) if getattr(section, key) is not None}  # fmt: skip


def file_keys(section: type) -> list[str]:
    """The keys of a parameter class that name files."""
    return [key for key, (field, _) in declared(section).items() if field.metadata.get("file")]


def sections(classes: Iterable[type]) -> dict[str, list[type]]:
    """File -> parameter classes that read it, over all these `Parameters` classes."""
    files: dict[str, list[type]] = {}
    for cls in classes:
        for _, kind in declared(cls).values():
            readers = files.setdefault(kind.FILE, [])
            if kind not in readers:
                readers.append(kind)
    return files


def keys(files: Mapping[str, Iterable[type]]) -> dict[str, list[str]]:
    """File -> the keys that its classes declare."""
    return {file: [key for cls in classes for key in declared(cls)] for file, classes in files.items()}


def needed(files: Mapping[str, Iterable[type]]) -> dict[str, list[str]]:
    """File -> the keys that it must have."""
    return {file: [field.name for cls in classes for field, _ in declared(cls).values()
                   if field.default is dataclasses.MISSING] for file, classes in files.items()}  # fmt: skip


class _Loading:
    """One load: the folder it reads, what is known, and the problems found so far."""

    def __init__(self, folder: Path, shown_as: str, known: Iterable[type], requests: Sequence[Any]) -> None:
        self.folder, self.shown_as, self.requests = folder, shown_as, requests
        self.classes = sections(known)
        #: What the classes of each file say where a key is tried that none of them has.
        self.beyond = {
            file: "".join(f"; {said}" for said in {getattr(cls, "BEYOND", ""): cls for cls in classes} if said)
            for file, classes in self.classes.items()
        }
        self.problems: list[tuple[str, int, str]] = []
        self.remarks: list[str] = []
        self.overrides: dict[str, list[Override]] = {}
        self._entries = cache(self._read)
        self.level = DEFAULT_LEVEL

    def load(self, settings: Sequence[str], wanted: Mapping[str, type], requested: Mapping[str, str]) -> dict[str, Any]:
        self._ask(requested, sections(wanted.values()))
        self._read_settings(settings)
        self._read_level()
        built: dict[type, Any] = {}
        # a file that a stage reads, or that --set changes, is checked whole, also where another stage reads it
        read = {*sections(wanted.values()), *self.overrides}
        for file, classes in self.classes.items():
            entries = self._entries(file) if file in read else None
            if entries is not None:
                built.update({cls: self._build(cls, file, entries) for cls in classes})
        stages: dict[str, Any] = {}
        if not self.problems:
            stages = {name: self._stage(cls, built) for name, cls in wanted.items()}
        if self.problems:
            raise StudyError(sentence for _, _, sentence in sorted(dict.fromkeys(self.problems)))
        return stages

    def _ask(self, requested: Mapping[str, str], read: Mapping[str, list[type]]) -> None:
        """Take a request as a change of the level, and of every file that has its key and is read; `--set` goes before.

        A word is a level, and changes nothing else.
        """
        for request in self.requests:
            if text := requested.get(request.NAME):
                value, said = node_of(request, text), f"--{request.NAME} {text}"
                changes = {LEVEL_FILE: (LEVEL_KEY, Node(request.level(value.plain()), 0))}
                if not isinstance(value.value, str):
                    changes |= {file: (request.NAME, value) for file, classes in read.items() if file in request.FILES
                                and any(request.NAME in declared(cls) for cls in classes)}  # fmt: skip
                for file, (key, node) in changes.items():
                    self.overrides.setdefault(file, []).append(Override(said, file, key, (), node))

    def _read_level(self) -> None:
        """The study's level; what is wrong with it is said where its file is checked."""
        for cls in self.classes.get(LEVEL_FILE, ()):
            entries = self._entries(LEVEL_FILE) or {}
            if LEVEL_KEY in entries:
                with contextlib.suppress(Refused):
                    self.level = value_of(entries[LEVEL_KEY], *declared(cls)[LEVEL_KEY])

    def _read_settings(self, settings: Sequence[str]) -> None:
        known = keys(self.classes)
        for setting in settings:
            try:
                override = parsed(setting, known, self.beyond)
                self.overrides.setdefault(override.file, []).append(override)
            except StudyError as error:
                self.problems += [("", 0, sentence) for sentence in error.sentences]

    def _read(self, file: str) -> dict[str, Node] | None:
        """The entries of a file with what changes them; None if there is something wrong with it."""
        where, path = f"{self.shown_as}/{file}.yaml", self.folder / f"{file}.yaml"
        fields = [field for cls in self.classes[file] for field, _ in declared(cls).values()]
        may_lack = all(field.default is not dataclasses.MISSING for field in fields)
        try:
            tree = Node({}, 0) if may_lack and not path.exists() else yaml_text.read(path, where)
            if not isinstance(tree.value, dict):
                raise StudyError(f"{where}: expected lines of the form key: value")
        except StudyError as error:
            self.problems += [(file, 0, sentence) for sentence in error.sentences]
            return None
        known = keys(self.classes)
        for key, node in tree.value.items():
            if key not in known[file]:
                hint = home_of(key, file, known) + self.beyond[file]
                self._problem(file, node.line, f'there is no parameter "{key}"{hint}')
        self.remarks += _unfounded(where, tree.value, {field.name: field.metadata["unit"] for field in fields})
        self.remarks += _not_as_printed(where, tree.value)
        entries: dict[str, Node] = dict(tree.value)
        for override in self.overrides.get(file, ()):
            try:
                entries[override.key] = applied(override, entries.get(override.key))
            except StudyError as error:
                self.problems += [("", 0, sentence) for sentence in error.sentences]
        return entries

    def _build(self, cls: type, file: str, entries: dict[str, Node]) -> Any:
        """An instance of `cls`, or None if a value or a rule between values is refused."""
        values, problems = values_of(cls, entries, partial(value_of, level=self.level))
        for name, line, sentence in problems:
            self._problem(file, line, sentence, name if name in entries else "")
        if problems:
            return None
        values |= dict.fromkeys(derived(cls), self._half_widths(entries))
        instance = cls(**values)
        for key, sentence in broken_rules(instance):
            self._problem(file, entries[key].line if key in entries else 0, sentence, key)
        return instance

    def _half_widths(self, entries: Mapping[str, Node]) -> dict[str, float]:
        """Half-widths of a file's values, by key, of those that are not exact; what is refused is so with its value."""
        found = {}
        for key, entry in entries.items():
            with contextlib.suppress(ValueError):
                width = half_width(entry.plain()) if isinstance(entry.value, dict) else None
                if width is not None:
                    found[key] = width
        return found

    def _stage(self, cls: type, built: Mapping[type, Any]) -> Any:
        instance = cls(**{name: built[kind] for name, (_, kind) in declared(cls).items()})
        for blamed, sentence in broken_rules(instance):
            file, _, key = blamed.rpartition(".")
            self._problem(file or "params", 0, sentence, key)
        return instance

    def _problem(self, file: str, line: int, text: str, key: str = "") -> None:
        overrides = [override for override in self.overrides.get(file, ()) if override.key == key]
        if line == 0 and overrides:
            self.problems.append(("", 0, f"{overrides[-1].text}: {text}"))
        else:
            place = f"{self.shown_as}/{file}.yaml" + (f":{line}" if line else "")
            self.problems.append((file, line, f"{place}: {text}"))


def _not_as_printed(where: str, entries: Mapping[str, Node]) -> Iterator[str]:
    """Values that are not the printed ones beside them, so that their half widths are lost."""
    for key, node in entries.items():
        parts = node.plain() if isinstance(node.value, dict) else {}
        with contextlib.suppress(ValueError):
            if "printed" in parts and half_width(parts) is None:
                yield (f'{where}:{node.line}: {key} = {shown(parts["value"])} is not the printed "{parts["printed"]}": '
                       "it is taken as exact; with uncertainty in place of printed it has a half width")  # fmt: skip


def _unfounded(where: str, entries: Mapping[str, Node], units: Mapping[str, str]) -> Iterator[str]:
    """Values with a dimension that state no unit or no source, in a file where others state both."""
    stated = {key: set(node.value) if isinstance(node.value, dict) else set() for key, node in entries.items()}
    if not any({"unit", "source"} <= parts for parts in stated.values()):
        return
    for key, parts in stated.items():
        lacks = [f"no {part}" for part in ("unit", "source") if part not in parts]
        if lacks and units.get(key, "-") not in ("-", "1"):
            yield (f"{where}:{entries[key].line}: {key} states {' and '.join(lacks)}, which others of this file do; it "
                   f"is taken in {units[key]}")  # fmt: skip
