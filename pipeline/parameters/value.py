"""One parameter: from what stands in the YAML file to a checked Python value.

A parameter is declared by a dataclass field whose metadata carries unit, bound and choices. In the file it is
`key: {value: 0.3, unit: kg, source: "..."}`, or `key: 0.3`; a table is `key: {source: "...", rows: [{...}, ...]}`.

A number may say how far it may be off, by a half-width or half of the last digit of a print:
`{value: 0.1, uncertainty: 0.002, ...}` lets the value lie within 0.002 of 0.1; `{value: 0.1, printed: "0.100", ...}`
says how a source prints it, and so within 0.0005. A value without either is exact, and so is one that is set anew or
edited: it is not the printed one any more.

An entry may say what its value is at each level of accuracy, the least accurate first, the default in the middle:
`{value: 1e-7, levels: [1e-5, 1e-7, 1e-9], ...}`. A value that is not the one of the default level was edited: it holds
at all levels, as one does that is given with `--set`.
"""

import dataclasses
import math
import re
import types
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from decimal import Decimal
from functools import cache
from typing import Any, Union, cast, get_args, get_origin, get_type_hints

from pipeline.errors import nearest
from pipeline.parameters.yaml_text import Node

LEVELS = ("draft", "paper", "reference")
DEFAULT_LEVEL = "paper"
#: Where the level of a study stands.
LEVEL_FILE, LEVEL_KEY = "accuracy", "level"
#: The part of an entry with its value at each level.
OF_LEVELS = "levels"
#: The parts of an entry that say how far its value may be off.
_UNCERTAIN = ("uncertainty", "printed")
_ENTRY_KEYS = ("value", "rows", "unit", "source", OF_LEVELS, *_UNCERTAIN)
#: The metadata of a field of a parameter class that is filled with the half-widths of its file's values.
DERIVED = "half_widths"
#: What follows on a key where a half-width stands among plain parameters.
SUFFIX = " half-width"
_DIGITS = re.compile(r"[-+]?[0-9]+(\.[0-9]*)?$")


class Refused(Exception):
    """Why a value is not accepted, as the second half of a sentence, and the line to look at."""

    def __init__(self, reason: str, line: int) -> None:
        self.reason, self.line = reason, line
        super().__init__(reason)

    def of(self, key: str) -> str:
        """The whole sentence: of `key`."""
        return f"{key}{'' if self.reason.startswith(('[', ':')) else ' '}{self.reason}"


@cache
def derived(cls: type) -> tuple[str, ...]:
    """The fields of a parameter class that are filled with half-widths, key -> half-width, and are no parameters."""
    return tuple(field.name for field in dataclasses.fields(cls) if field.metadata.get(DERIVED))


def half_width(parts: Mapping[str, Any]) -> float | None:
    """The half-width that the parts of an entry (plain) give its value; None for an exact one.

    Raises ValueError with the reason, to follow on the key.
    """
    given = [part for part in _UNCERTAIN if part in parts]
    if not given:
        return None
    value = parts.get("value")
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise ValueError(f'has a part "{given[0]}", which only a number can have')
    if len(given) > 1:
        raise ValueError("has both an uncertainty and digits as printed; give one of them")
    said = parts[given[0]]
    if given[0] == "uncertainty":
        if isinstance(said, bool) or not isinstance(said, (int, float)) or not 0 <= said < math.inf:
            raise ValueError(f"has the uncertainty {shown(said)}; allowed: a number >= 0, in the unit of the value")
        return float(said)
    if not isinstance(said, str) or not _DIGITS.match(said):
        raise ValueError(f'is printed as {shown(said)}; write the digits as text, as in printed: "0.100"')
    if float(said) != value:  # somebody's own value now
        return None
    return 0.5 * 10.0 ** int(Decimal(said).as_tuple().exponent)


def without(section: Any, keys: Collection[str]) -> Any:
    """A section of parameters in which the values of `keys` are exact."""
    kind: type = type(section)
    exact = {
        name: {key: width for key, width in getattr(section, name).items() if key not in keys}
        for name in derived(kind)
    }
    return dataclasses.replace(section, **exact) if exact else section


@cache
def declared(cls: type) -> dict[str, tuple[dataclasses.Field[Any], Any]]:
    """Name -> (field, type) of a parameter dataclass; without what follows from parameters (`derived`)."""
    hints = get_type_hints(cls)
    fields = (field for field in dataclasses.fields(cls) if field.name not in derived(cls))
    return {field.name: (field, hints[field.name]) for field in fields}


def value_of(entry: Node, field: dataclasses.Field[Any], kind: Any, level: str = DEFAULT_LEVEL) -> Any:
    """The checked value of a file's entry at a level; those at the others are checked as well.

    Raises `Refused`, also for a wrong unit or a misspelt part of the entry.
    """
    try:
        values = {each: checked(_unwrapped(at_level(entry, each), field, kind), field, kind)
                  for each in (LEVELS if has_levels(entry) else (level,))}  # fmt: skip
    except ValueError as reason:
        raise Refused(str(reason), entry.line) from None
    return values[level]


def has_levels(entry: Node) -> bool:
    """Whether an entry has a value for each level."""
    return isinstance(entry.value, dict) and OF_LEVELS in entry.value


def at_level(entry: Node, level: str) -> Node:
    """The entry with its value at a level; as it is where it says nothing of levels, or was edited.

    Raises ValueError with the reason, to follow on the key, if there is not one value for each level.
    """
    if not has_levels(entry):
        return entry
    values = entry.value[OF_LEVELS].value
    if not isinstance(values, list) or len(values) != len(LEVELS):
        raise ValueError(f"has {OF_LEVELS} that are not a list of {len(LEVELS)} values: {', '.join(LEVELS)}")
    by_hand = entry.value.get("value", Node(None, 0)).plain() != values[LEVELS.index(DEFAULT_LEVEL)].plain()
    return entry if by_hand else Node({**entry.value, "value": values[LEVELS.index(level)]}, entry.line)


def checked(node: Node, field: dataclasses.Field[Any], kind: Any) -> Any:
    """The value of `node` as type `kind`, inside the bounds that `field` declares. Raises `Refused`."""
    if node.value is None and type(None) in options_of(kind):
        return None
    if len(options_of(kind)) > 1:
        kind = (isinstance(node.value, dict) and _row_of(kind, node.value)) or present(kind)
    if kind is Any:
        return node.plain()
    if get_origin(kind) is Mapping:
        items = _of(node, dict, f"is not a table; allowed: {allowed(field, kind)}")
        return {name: _inner(item, field, get_args(kind)[1], f": {name}") for name, item in items.items()}
    if get_origin(kind) is tuple:
        items = _of(node, list, f"is not a list; allowed in it: {allowed(field, kind)}")
        return tuple(_inner(item, field, get_args(kind)[0], f"[{at}]") for at, item in enumerate(items))
    if hasattr(kind, "__dataclass_fields__"):
        return _row(node, kind)
    if kind is bool:
        return _of(node, bool, "is not true or false")
    return _word(node, field) if kind is str else _number(node, field, kind)


def values_of(
    cls: type, entries: Mapping[str, Node], take: Callable[[Node, dataclasses.Field[Any], Any], Any] = checked
) -> tuple[dict[str, Any], list[tuple[str, int, str]]]:
    """Values of a dataclass's fields by name, and of what is missing or refused the name, the line and a sentence."""
    values, problems = {}, []
    for name, (field, kind) in declared(cls).items():
        if name in entries:
            try:
                values[name] = take(entries[name], field, kind)
            except Refused as refused:
                problems.append((name, refused.line, refused.of(name)))
        elif field.default is dataclasses.MISSING:
            problems.append((name, 0, f"{name} is missing; allowed: {allowed(field, kind)}"))
    return values, problems


def allowed(field: dataclasses.Field[Any], kind: Any) -> str:
    """What a field of a type accepts, for the end of a sentence: `>= 0 kg`, the choices, or what else it is."""
    about = field.metadata
    if about["choices"]:
        either = about.get("otherwise")
        return ", ".join(about["choices"]) + (f", or {either}" if either else "")
    free = "a table" if _row_of(kind) else "true, false" if kind is bool else "a word" if about["unit"] == "-" else ""
    return free or with_unit(str(about["bound"]), field)


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


def options_of(kind: Any) -> tuple[Any, ...]:
    """The types that a value may have: of `float | None` both."""
    return get_args(kind) if get_origin(kind) in (Union, types.UnionType) else (kind,)


def present(kind: Any) -> Any:
    """The type of a field where it has a value: `float` of `float | None`."""
    return next(option for option in options_of(kind) if option is not type(None))


def _row_of(kind: Any, keys: Iterable[str] = ()) -> Any:
    """The dataclass among several types that has most of the keys, or None."""
    options = [option for option in get_args(kind) if dataclasses.is_dataclass(option)]
    fitting = [len({*keys} & {*declared(cast(type, option))}) for option in options]
    return options[fitting.index(max(fitting))] if options else None


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
        raise Refused(f'has the unit {shown(unit.plain())}; it must be given in "{field.metadata["unit"]}"', unit.line)
    try:
        half_width(entry.plain())
    except ValueError as reason:
        raise Refused(str(reason), entry.line) from None
    values = [parts[key] for key in ("value", "rows") if key in parts]
    if len(values) != 1:
        raise Refused("has no value; write it as {value: ..., unit: ..., source: ...}", entry.line)
    return values[0]


def _of(node: Node, kind: Any, otherwise: str) -> Any:
    """The node's value, if it is of a type. Raises `Refused`."""
    if not isinstance(node.value, kind) or (isinstance(node.value, bool) and kind is not bool):
        raise Refused(f"= {shown(node.value)} {otherwise}", node.line)
    return node.value


def _inner(node: Node, field: dataclasses.Field[Any], kind: Any, name: str) -> Any:
    try:
        return checked(node, field, kind)
    except Refused as refused:
        raise Refused(refused.of(name), refused.line) from None


def _number(node: Node, field: dataclasses.Field[Any], kind: Any) -> float | int:
    noun = "a whole number" if kind is int else "a number"
    value: float | int = _of(node, (int, float), f"is not {noun}; allowed: {allowed(field, kind)}")
    if not field.metadata["bound"].holds(value):
        raise Refused(f"= {with_unit(shown(value), field)} is not allowed; allowed: {allowed(field, kind)}", node.line)
    if kind is int and value != int(value):
        raise Refused(f"= {shown(value)} is not a whole number; allowed: {allowed(field, kind)}", node.line)
    return int(value) if kind is int else float(value)


def _word(node: Node, field: dataclasses.Field[Any]) -> str:
    choices, others = field.metadata["choices"], allowed(field, str)
    word: str = _of(node, str, "is not a word" + (f"; allowed: {others}" if others != "a word" else ""))
    if choices and word not in choices:
        hint = nearest(word, choices)
        raise Refused(f"= {shown(word)} is not allowed; allowed: {others}{hint}", node.line)
    return word


def _row(node: Node, cls: type) -> Any:
    """A row of a table: a mapping of bare values, by a dataclass of its own."""
    fields = declared(cls)
    items = _of(node, dict, f"is not a row like {{{', '.join(fields)}}}")
    for key, item in items.items():
        if key not in fields:
            raise Refused(f'has an unknown column "{key}"{nearest(key, fields)}', item.line)
    values, problems = values_of(cls, items)
    for name, line, sentence in problems:
        if name not in items:
            raise Refused(f"lacks the column {name} (allowed: {allowed(*fields[name])})", node.line)
        raise Refused(f": {sentence}", line)
    row = cls(**values)
    for _, sentence in broken_rules(row):
        raise Refused(f": {sentence}", node.line)
    return row


def broken_rules(instance: Any) -> Iterator[tuple[str, str]]:
    """Of rules between values that do not hold the key to blame, as "file.key" between files, and a sentence for all of
    a key."""
    rules, every = getattr(instance, "broken_rules", None), dict[str, list[str]]()
    known = declared(instance.__class__)
    for broken in rules() if rules else ():
        every.setdefault(broken.key, []).append(broken.allowed)
    for whole, wanted in every.items():
        key, value = whole.rpartition(".")[2], ""
        if whole in known:
            value = f" = {with_unit(shown(plain_value(getattr(instance, key))), known[key][0])}"
        yield whole, f"{key}{value} is not allowed; allowed: {' and '.join(wanted)}"


def plain_value(value: Any) -> Any:
    """A parameter's value with tables as lists of mappings."""
    if isinstance(value, tuple):
        return [plain_value(item) for item in value]
    if dataclasses.is_dataclass(value):
        return {field.name: plain_value(getattr(value, field.name)) for field in dataclasses.fields(value)}
    return value
