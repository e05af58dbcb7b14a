"""YAML as this study reads it: with line numbers, YAML 1.2 numbers, and no key twice.

PyYAML alone reads `1e-7` as a string and keeps the last of two equal keys in silence.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import yaml

from pipeline.errors import StudyError

_Loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_INTEGER = re.compile(r"[-+]?[0-9]+$")
_NUMBER = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?$")
_SPECIAL = re.compile(r"([-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN))$")
_WORDS = {"null": None, "Null": None, "NULL": None, "~": None, "": None}
_BOOLEANS = {"true": True, "True": True, "TRUE": True, "false": False, "False": False, "FALSE": False}


@dataclass(frozen=True)
class Node:
    """A value and the line it stands on. `value` is a scalar, a list of nodes, or a dict of key -> node."""

    value: Any
    line: int

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
    and `with_lines` tells whether an error of syntax has a line worth naming.
    """
    try:
        root = yaml.compose(text, Loader=_Loader)
        if root is None:
            return Node({}, 1)
        problems: list[str] = []
        node = _convert(root, where, problems)
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
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise StudyError(f"{where}: there is no such file") from None
    except UnicodeDecodeError:
        raise StudyError(f"{where}: not a text file in UTF-8") from None
    except OSError as error:
        raise StudyError(f"{where}: cannot be read: {error.strerror}") from None
    return parse(text, where)


def scalar(text: str) -> Any:
    """A plain scalar by the core rules of YAML 1.2: null, boolean, integer, number, or else a word."""
    if text in _WORDS:
        return None
    if text in _BOOLEANS:
        return _BOOLEANS[text]
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


def _convert(node: yaml.Node, where: str, problems: list[str]) -> Node:
    line = node.start_mark.line + 1
    if isinstance(node, yaml.MappingNode):
        return Node(dict(_pairs(node, where, problems)), line)
    if isinstance(node, yaml.SequenceNode):
        return Node([_convert(item, where, problems) for item in node.value], line)
    quoted = node.style in ("'", '"', "|", ">")
    return Node(node.value if quoted else scalar(node.value), line)


def _pairs(node: yaml.MappingNode, where: str, problems: list[str]) -> Iterator[tuple[str, Node]]:
    first_line: dict[str, int] = {}
    for key_node, value_node in node.value:
        line = key_node.start_mark.line + 1
        key = str(key_node.value)
        if not isinstance(key_node, yaml.ScalarNode):
            problems.append(f"{where}:{line}: a key must be a single word")
        elif key in first_line:
            problems.append(f'{where}:{line}: the key "{key}" is given twice, first on line {first_line[key]}')
        else:
            first_line[key] = line
            yield key, _convert(value_node, where, problems)
