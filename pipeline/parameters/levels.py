"""How accurate a study is: the key `level` of params/accuracy.yaml, and what parameters are at each level.

An entry of a parameter file may say what its value is at each level, the least accurate first, the default in the
middle: `{value: 1e-7, levels: [1e-5, 1e-7, 1e-9], ...}`. A value that is not the one of the default level was edited:
it holds at all levels, as one does that is given with `--set`.
"""

from __future__ import annotations

from pipeline.parameters.yaml_text import Node

LEVELS = ("draft", "paper", "reference")
DEFAULT = "paper"
#: Where the level stands.
FILE, KEY = "accuracy", "level"
#: The part of an entry with its value at each level.
PART = "levels"


def has(entry: Node) -> bool:
    """Whether an entry has a value for each level."""
    return isinstance(entry.value, dict) and PART in entry.value


def at(entry: Node, level: str) -> Node:
    """The entry with its value at a level; as it is where it says nothing of levels, or was edited.

    Raises ValueError with the reason, to follow on the key, if there is not one value for each level.
    """
    if not has(entry):
        return entry
    values = entry.value[PART].value
    if not isinstance(values, list) or len(values) != len(LEVELS):
        raise ValueError(f"has {PART} that are not a list of {len(LEVELS)} values: {', '.join(LEVELS)}")
    by_hand = entry.value.get("value", Node(None, 0)).plain() != values[LEVELS.index(DEFAULT)].plain()
    return entry if by_hand else Node({**entry.value, "value": values[LEVELS.index(level)]}, entry.line)
