"""One parameter: from what stands in the YAML file to a checked Python value.

A parameter is declared by a dataclass field whose metadata carries unit, bound and choices. In the file it is
`key: {value: 0.3, unit: kg, source: "..."}`, or `key: 0.3`; a table is `key: {source: "...", rows: [{...}, ...]}`. A
number may say how far it may be off, see `uncertainty`.
"""

from __future__ import annotations

import dataclasses
import types
import typing
from collections.abc import Iterable, Mapping
from functools import cache
from typing import Any

from pipeline.errors import nearest
from pipeline.parameters import levels, uncertainty
from pipeline.parameters.yaml_text import Node

_ENTRY_KEYS = ("value", "rows", "unit", "source", levels.PART, *uncertainty.PARTS)


class Refused(Exception):
    """Why a value is not accepted, as the second half of a sentence, and the line to look at."""

    def __init__(self, reason: str, line: int) -> None:
        self.reason, self.line = reason, line
        super().__init__(reason)

    def of(self, key: str) -> str:
        """The whole sentence: of `key`."""
        return f"{key}{'' if self.reason.startswith(('[', ':')) else ' '}{self.reason}"


@cache
def declared(cls: type) -> dict[str, tuple[dataclasses.Field[Any], Any]]:
    """Name -> (field, type) of a parameter dataclass; without what follows from parameters (`uncertainty.derived`)."""
    hints = typing.get_type_hints(cls)
    fields = (field for field in dataclasses.fields(cls) if field.name not in uncertainty.derived(cls))
    return {field.name: (field, hints[field.name]) for field in fields}


def value_of(entry: Node, field: dataclasses.Field[Any], kind: Any, level: str = levels.DEFAULT) -> Any:
    """The checked value of a file's entry at a level; those at the others are checked as well.

    Raises `Refused`, also for a wrong unit or a misspelt part of the entry.
    """
    try:
        values = {each: checked(_unwrapped(levels.at(entry, each), field, kind), field, kind)
                  for each in (levels.LEVELS if levels.has(entry) else (level,))}  # fmt: skip
    except ValueError as reason:
        raise Refused(str(reason), entry.line) from None
    return values[level]


def checked(node: Node, field: dataclasses.Field[Any], kind: Any) -> Any:
    """The value of `node` as type `kind`, inside the bounds that `field` declares. Raises `Refused`."""
    if typing.get_origin(kind) in (typing.Union, types.UnionType):
        options = typing.get_args(kind)
        if node.value is None and type(None) in options:
            return None
        row = _row_of(kind, node.value) if isinstance(node.value, dict) else None
        kind = row or next(option for option in options if option is not type(None))
    if kind is Any:
        return node.plain()
    if typing.get_origin(kind) is Mapping:
        return _mapping(node, field, typing.get_args(kind)[1])
    if typing.get_origin(kind) is tuple:
        return _sequence(node, field, typing.get_args(kind)[0])
    if dataclasses.is_dataclass(kind) and isinstance(kind, type):
        return _row(node, kind)
    if kind is str:
        return _word(node, field)
    if kind is bool:
        if not isinstance(node.value, bool):
            raise Refused(f"= {shown(node.value)} is not true or false", node.line)
        return node.value
    return _number(node, field, kind)


def allowed(field: dataclasses.Field[Any]) -> str:
    """What the field accepts, for the end of a sentence: `>= 0 kg`, or the choices."""
    if field.metadata["choices"]:
        either = field.metadata.get("otherwise")
        return ", ".join(field.metadata["choices"]) + (f", or {either}" if either else "")
    return with_unit(str(field.metadata["bound"]), field)


def with_unit(text: str, field: dataclasses.Field[Any]) -> str:
    """`text` followed by the field's unit, unless it is a pure number or a word."""
    unit = field.metadata["unit"]
    return text if unit in ("1", "-") else f"{text} {unit}"


def shown(value: Any) -> str:
    """A value as messages show it: the short form of a number where nothing is lost, words in quotes."""
    if isinstance(value, bool) or value is None:
        return {True: "true", False: "false", None: "null"}[value]
    if isinstance(value, float):
        return f"{value:g}" if float(f"{value:g}") == value or value != value else repr(value)
    if isinstance(value, int):
        return str(value)
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(shown(item.value if isinstance(item, Node) else item) for item in value) + "]"
    return "a table"


def _row_of(kind: Any, keys: Iterable[str] = ()) -> Any:
    """The dataclass among the options of a type that has most of the keys, or None."""
    options = [option for option in typing.get_args(kind) if dataclasses.is_dataclass(option)]
    return max(options, key=lambda cls: len({*keys} & {*declared(typing.cast(type, cls))}), default=None)


def _unwrapped(entry: Node, field: dataclasses.Field[Any], kind: Any) -> Node:
    if not isinstance(entry.value, dict) or (_row_of(kind) and not set(_ENTRY_KEYS) & set(entry.value)):
        return entry
    parts: dict[str, Node] = entry.value
    for key, node in parts.items():
        if key not in _ENTRY_KEYS:
            raise Refused(f'has a part "{key}" that means nothing here (only {", ".join(_ENTRY_KEYS)})'
                          f"{nearest(key, _ENTRY_KEYS)}", node.line)  # fmt: skip
    unit = parts.get("unit")
    if unit is not None and str(unit.value) != field.metadata["unit"]:
        raise Refused(f'has the unit "{unit.value}"; it must be given in "{field.metadata["unit"]}"', unit.line)
    try:
        uncertainty.half_width(entry.plain())
    except ValueError as reason:
        raise Refused(str(reason), entry.line) from None
    values = [parts[key] for key in ("value", "rows") if key in parts]
    if len(values) != 1:
        raise Refused("has no value; write it as {value: ..., unit: ..., source: ...}", entry.line)
    return values[0]


def _number(node: Node, field: dataclasses.Field[Any], kind: Any) -> float | int:
    value = node.value
    noun = "a whole number" if kind is int else "a number"
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise Refused(f"= {shown(value)} is not {noun}; allowed: {allowed(field)}", node.line)
    if not field.metadata["bound"].holds(value):
        raise Refused(f"= {with_unit(shown(value), field)} is not allowed; allowed: {allowed(field)}", node.line)
    if kind is int:
        if value != int(value):
            raise Refused(f"= {shown(value)} is not a whole number; allowed: {allowed(field)}", node.line)
        return int(value)
    return float(value)


def _word(node: Node, field: dataclasses.Field[Any]) -> str:
    if not isinstance(node.value, str):
        raise Refused(f"= {shown(node.value)} is not a word; allowed: {allowed(field)}", node.line)
    choices = field.metadata["choices"]
    if choices and node.value not in choices:
        hint = nearest(node.value, choices)
        raise Refused(f"= {shown(node.value)} is not allowed; allowed: {allowed(field)}{hint}", node.line)
    return node.value


def _sequence(node: Node, field: dataclasses.Field[Any], kind: Any) -> tuple[Any, ...]:
    if not isinstance(node.value, list):
        raise Refused(f"= {shown(node.value)} is not a list", node.line)
    items = []
    for index, item in enumerate(node.value):
        try:
            items.append(checked(item, field, kind))
        except Refused as refused:
            raise Refused(refused.of(f"[{index}]"), refused.line) from None
    return tuple(items)


def _mapping(node: Node, field: dataclasses.Field[Any], kind: Any) -> dict[str, Any]:
    if not isinstance(node.value, dict):
        raise Refused(f"= {shown(node.value)} is not a table; allowed: {allowed(field)}", node.line)
    values = {}
    for name, item in node.value.items():
        try:
            values[name] = checked(item, field, kind)
        except Refused as refused:
            raise Refused(f": {refused.of(name)}", refused.line) from None
    return values


def _row(node: Node, cls: type) -> Any:
    """A row of a table: a mapping of bare values, by a dataclass of its own."""
    if not isinstance(node.value, dict):
        raise Refused(f"= {shown(node.value)} is not a row like {{{', '.join(declared(cls))}}}", node.line)
    fields = declared(cls)
    for key, item in node.value.items():
        if key not in fields:
            raise Refused(f'has an unknown column "{key}"{nearest(key, fields)}', item.line)
    values = {}
    for name, (field, kind) in fields.items():
        if name in node.value:
            try:
                values[name] = checked(node.value[name], field, kind)
            except Refused as refused:
                raise Refused(f": {refused.of(name)}", refused.line) from None
        elif field.default is dataclasses.MISSING:
            raise Refused(f"lacks the column {name} (allowed: {allowed(field)})", node.line)
    row = cls(**values)
    for broken in broken_rules(row):
        value = with_unit(shown(values.get(broken.key)), fields[broken.key][0]) if broken.key in fields else ""
        raise Refused(f": {broken.key} = {value} is not allowed; allowed: {broken.allowed}", node.line)
    return row


def broken_rules(instance: Any) -> tuple[Any, ...]:
    """The rules between values that do not hold, or nothing for a class without such rules."""
    rules = getattr(instance, "broken_rules", None)
    return tuple(rules()) if rules else ()
