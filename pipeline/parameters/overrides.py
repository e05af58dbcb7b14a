"""`--set file.key=value`: one parameter changed for one command, without touching its file.

A table's entry is reached by its row: `--set fall.parts.2.mass=0.1` (rows count from 0). `rewritten` puts such changes
into the text of the files.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

import yaml

from pipeline.errors import StudyError, nearest
from pipeline.parameters import yaml_text
from pipeline.parameters.yaml_text import Node

NOTHING: Mapping[str, str] = MappingProxyType({})
_FORM = "the form is --set file.key=value, for example --set ground.gravity=9.81"


@dataclass(frozen=True)
class Override:
    """One `--set`: how messages name it, the file and key it changes, the path inside a table, and the value."""

    text: str
    file: str
    key: str
    inner: tuple[str, ...]
    value: Node


def parsed(text: str, known: Mapping[str, Sequence[str]], beyond: Mapping[str, str] = NOTHING) -> Override:
    """Read the text after `--set`. `known` maps each file to its keys, `beyond` to what follows on an unknown one.

    Raises `StudyError`.
    """
    name, equals, value = text.partition("=")
    path = name.strip().split(".")
    if not equals or len(path) < 2 or not all(path) or not value.strip():
        raise StudyError(f"--set {text}: {_FORM}")
    file, key, *inner = path
    if file not in known:
        raise StudyError(f'--set {text}: there is no parameter file "{file}"{nearest(file, known)}')
    if key not in known[file]:
        hint = home_of(key, file, known) + beyond.get(file, "")
        raise StudyError(f'--set {text}: there is no parameter "{key}" in {file}{hint}')
    said = f"--set {text}"
    return Override(said, file, key, tuple(inner), Node.of(yaml_text.parse(value, said, with_lines=False).plain()))


def home_of(key: str, file: str, known: Mapping[str, Sequence[str]]) -> str:
    """What a key that a file does not have may have meant: the same in another file, or the nearest."""
    homes = [f'; did you mean "{other}.{key}"?' for other, keys in known.items() if key in keys]
    return homes[0] if homes else nearest(key, known[file])


def node_of(request: Any, text: str) -> Node:
    """The text given to a request (`pipeline.commands.options`) as it would stand in a file. Raises `StudyError`."""
    said = f"--{request.NAME} {text}"
    try:
        requested = request.parsed(text)
    except KeyError as unknown:
        raise StudyError(f"{said}: the form is {request.FORM}{nearest(unknown.args[0], request.words())}") from None
    if isinstance(requested, str):
        return Node(requested, 0)
    values = {key: yaml_text.scalar(value) for key, value in requested.items()}
    for key, value in values.items():
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise StudyError(f"{said}: {key} = {requested[key]!r} is not a number; allowed: > 0")
    return Node({key: Node(float(value), 0) for key, value in values.items()}, 0)


def applied(override: Override, entry: Node | None) -> Node:
    """The entry of a file with the override put in its place. Raises `StudyError` if its inner path leads nowhere."""
    if not override.inner:
        return override.value
    if entry is None:
        raise StudyError(f"{override.text}: {override.key} has no rows in the file")
    parts: dict[str, Node] = entry.value if isinstance(entry.value, dict) else {}
    table = parts.get("rows") or parts.get("value") or entry
    return _replaced(table, override.inner, override)


def _replaced(node: Node, path: tuple[str, ...], override: Override) -> Node:
    if not path:
        return override.value
    step, rest = path[0], path[1:]
    if isinstance(node.value, list):
        if not (step.isascii() and step.isdigit()) or int(step) >= len(node.value):
            raise StudyError(f"{override.text}: there is no row {step}; rows are 0 to {len(node.value) - 1}")
        items: list[Any] = list(node.value)
        items[int(step)] = _replaced(items[int(step)], rest, override)
        return Node(items, node.line)
    if isinstance(node.value, dict):
        inside = node.value.get(step, Node(None, 0))
        return Node({**node.value, step: _replaced(inside, rest, override)}, node.line)
    raise StudyError(f"{override.text}: {override.key} is not a table, so .{step} leads nowhere")


def rewritten(folder: Path, values: Mapping[str, Any], settings: Sequence[str], source: str) -> dict[str, bytes]:
    """Every parameter file of `folder` by its name, with the texts of `--set` and then `values` ("file.key") put in.

    What changed has its unit as before and `source` as its source. Raises `StudyError` for an entry of a table.
    """
    given = {}
    for setting in settings:
        name, _, value = setting.partition("=")
        given[name.strip()] = yaml_text.parse(value, name, with_lines=False).plain()
    files = {path.stem: path.read_text(encoding="utf-8").rstrip() + "\n" for path in sorted(folder.glob("*.yaml"))}
    for name, value in {**given, **values}.items():
        file, _, key = name.partition(".")
        entry = yaml_text.parse(files[file], f"{file}.yaml").value.get(key)
        if "." in key:
            raise StudyError(f"{name}: an entry of a table cannot be written; change it in its file instead")
        described = entry.plain() if entry is not None else None
        unit = {"unit": described["unit"]} if isinstance(described, dict) and "unit" in described else {}
        whole = isinstance(value, dict) and not {"value", "rows"}.isdisjoint(value)  # an entry of its own
        parts = {**(value if whole else {"value": value}), **unit, "source": source}
        line = f"{key}: {{{', '.join(f'{part}: {json.dumps(said)}' for part, said in parts.items())}}}\n"
        start, end = _lines_of(key, files[file])
        files[file] = files[file][:start] + line + files[file][end:]
        yaml_text.parse(files[file], f"{file}.yaml, with {key} put in")  # an alias may name what went
    return {f"{name}.yaml": text.encode() for name, text in files.items()}


def _lines_of(key: str, text: str) -> tuple[int, int]:
    """Where the lines of a key's entry begin and end in the text of a file; where it has none, the end twice."""
    root = yaml.compose(text, Loader=yaml.SafeLoader)
    for name, node in root.value if root else ():
        if name.value == key:
            while isinstance(node, yaml.CollectionNode) and node.value and not node.flow_style:
                node = node.value[-1][1] if isinstance(node, yaml.MappingNode) else node.value[-1]
            start, end = (text.rfind("\n", 0, mark.index) + 1 for mark in (name.start_mark, node.end_mark))
            return start, end if end == node.end_mark.index else (text + "\n").index("\n", end) + 1
    return len(text), len(text)


def renewed(texts: Mapping[str, str], given: Mapping[str, str], known: Mapping[str, Sequence[str]],
            needed: Mapping[str, Sequence[str]]) -> dict[str, str]:  # fmt: skip
    """Texts of parameter files, by file, that an earlier version laid out: an entry that stands in another file by now
    goes there, and one that is `needed` and missing comes from those `given`. Where two files say it differently both
    stay, and nothing else changes. Raises `StudyError`."""
    files = {name: text.rstrip() + "\n" for name, text in texts.items()}
    entries = {name: own for name, text in files.items()
               if isinstance(own := yaml_text.parse(text, f"{name}.yaml").plain(), dict)}  # fmt: skip
    homes = {key: name for name in entries for key in known.get(name, ())}
    away = [(name, key) for name, own in entries.items() for key in own
            if key in homes and key not in known.get(name, ())]  # fmt: skip
    for name, key in away:
        home, (start, end) = files[homes[key]], _lines_of(key, files[name])
        if key not in entries[homes[key]]:
            files[homes[key]] = home + files[name][start:end]
        if entries[homes[key]].setdefault(key, entries[name][key]) == entries[name][key]:
            files[name] = files[name][:start] + files[name][end:]
    for name, own in entries.items():
        for key in [key for key in needed.get(name, ()) if key not in own]:
            files[name] += given[name][slice(*_lines_of(key, given[name]))]
    return {name: text for name, text in files.items() if text != texts[name].rstrip() + "\n"}
