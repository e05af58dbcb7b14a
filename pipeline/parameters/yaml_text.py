"""YAML as this study reads it: with line numbers, YAML 1.2 numbers, and no key twice.

PyYAML alone reads `1e-7` as a string and keeps the last of two equal keys in silence.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import yaml

from pipeline.cache import disk
from pipeline.errors import StudyError

_Loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_INTEGER = re.compile(r"[-+]?[0-9]+$")
_NUMBER = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?$")
_SPECIAL = re.compile(r"([-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN))$")
_WORDS = {
    "null": None, "Null": None, "NULL": None, "~": None, "": None,
    "true": True, "True": True, "TRUE": True, "false": False, "False": False, "FALSE": False,
}  # fmt: skip
#: Most values of a document: through aliases a short text can mean more than any memory holds.
_MOST_VALUES = 200_000
_DEEPEST = 1000


@dataclass(frozen=True)
class Node:
    """A value and the line it stands on. `value` is a scalar, a list of nodes, or a dict of key -> node."""

    value: Any
    line: int

    @classmethod
    def of(cls, plain: Any) -> Node:
        """A plain value as if it had been read; it stands on no line."""
        if isinstance(plain, (list, tuple)):
            return cls([cls.of(item) for item in plain], 0)
        if isinstance(plain, dict):
            return cls({key: cls.of(item) for key, item in plain.items()}, 0)
        return cls(plain, 0)

    def plain(self) -> Any:
        """The value without its line numbers."""
        if isinstance(self.value, dict):
            return {key: node.plain() for key, node in self.value.items()}
        if isinstance(self.value, list):
            return [node.plain() for node in self.value]
        return self.value


def parse(text: str, where: str, *, with_lines: bool = True) -> Node:
    """Read one YAML document.

    Raises `StudyError` with a sentence for each repeated key, or for the first error of syntax; `where` names the file
    and `with_lines` shows whether an error of syntax has a line worth naming.
    """
    problems: list[str] = []
    try:
        problems += _tags(text, where, with_lines)
        root = yaml.compose(text, Loader=_Loader)
        if root is None:
            return Node({}, 1)
        node = _Conversion(where, problems).node(root)
    except yaml.MarkedYAMLError as error:
        line = f":{_line_of(error, text)}" if with_lines else ""
        reason = " ".join(part for part in (error.context, error.problem) if part)
        raise StudyError(f"{where}{line}: not valid YAML: {reason}") from None
    except yaml.YAMLError as error:
        raise StudyError(f"{where}: not valid YAML: {str(error).splitlines()[0]}") from None
    except RecursionError:
        raise StudyError(f"{where}: not valid YAML: nested too deeply, or an alias inside itself") from None
    if problems:
        raise StudyError(problems)
    return node


def read(path: Any, where: str) -> Node:
    """Read the YAML file `path`; `where` is how messages name it."""
    return parse(text_of(path, where), where)


def text_of(path: Any, where: str) -> str:
    """The text of the file `path`, which messages call `where`. Raises `StudyError` if it cannot be read as text."""
    disk.check(path, where, disk.TEXT)
    with disk.readable(where):
        text: str = path.read_text(encoding="utf-8")
    return text


def scalar(text: str) -> Any:
    """A plain scalar by the core rules of YAML 1.2: null, boolean, integer, number, or else a word."""
    if text in _WORDS:
        return _WORDS[text]
    if _INTEGER.match(text):
        return int(text) if len(text) < 300 else float(text)
    if _NUMBER.match(text):
        return float(text)
    if _SPECIAL.match(text):
        return float(text.replace(".", "", 1))
    return text


def _line_of(error: yaml.MarkedYAMLError, text: str) -> int:
    """The line to look at: where the problem is, or, if that is only the end of the text, where it began."""
    problem, context = error.problem_mark, error.context_mark
    mark = problem if problem and (context is None or problem.line < len(text.splitlines())) else context
    return int(mark.line) + 1 if mark else 1


def _tags(text: str, where: str, with_lines: bool) -> list[str]:
    """A sentence for each tag: a value here is what it looks like, and nothing can make it something else.

    Raises RecursionError for a text that is nested deeper than the C library can compose without running out of stack;
    one with few brackets, dashes and question marks cannot be.
    """
    if "!" not in text and sum(text.count(sign) for sign in "[{-?") <= _DEEPEST:
        return []
    depth, sentences = 0, []
    for event in yaml.parse(text, Loader=_Loader):
        depth += isinstance(event, yaml.CollectionStartEvent) - isinstance(event, yaml.CollectionEndEvent)
        if depth > _DEEPEST:
            raise RecursionError
        if getattr(event, "tag", None) is not None:
            line = f":{event.start_mark.line + 1}" if with_lines else ""
            sentences.append(f"{where}{line}: the tag {event.tag} is not allowed; write the value as it is")
    return sentences


class _Conversion:
    """Makes nodes of what the parser found; counts them, since an alias stands for all that it names."""

    def __init__(self, where: str, problems: list[str]) -> None:
        self.where, self.problems, self.count = where, problems, 0

    def node(self, node: yaml.Node) -> Node:
        self.count += 1
        if self.count > _MOST_VALUES:
            raise StudyError(f"{self.where}: more than {_MOST_VALUES} values, counted through its aliases")
        line = node.start_mark.line + 1
        if isinstance(node, yaml.MappingNode):
            return Node(dict(self._pairs(node)), line)
        if isinstance(node, yaml.SequenceNode):
            return Node([self.node(item) for item in node.value], line)
        quoted = node.style in ("'", '"', "|", ">")
        return Node(node.value if quoted else scalar(node.value), line)

    def _pairs(self, node: yaml.MappingNode) -> Iterator[tuple[str, Node]]:
        first_line: dict[str, int] = {}
        for key_node, value_node in node.value:
            line = key_node.start_mark.line + 1
            key = str(key_node.value)
            if not isinstance(key_node, yaml.ScalarNode):
                self.problems.append(f"{self.where}:{line}: a key must be a single word")
            elif key in first_line:
                said = f'the key "{key}" is given twice, first on line {first_line[key]}'
                self.problems.append(f"{self.where}:{line}: {said}")
            else:
                first_line[key] = line
                yield key, self.node(value_node)
