"""What a source file means: its syntax tree without comments, layout and docstrings, and the modules it imports."""

from __future__ import annotations

import ast
import contextlib
import hashlib
import importlib.util
import sys
from collections.abc import Iterator, Sequence
from dataclasses import astuple, dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from pipeline.cache import durable

Imports = tuple[tuple[str, tuple[str, ...]], ...]
_DOCUMENTED = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)


@dataclass(frozen=True)
class Meaning:
    """Hash of a file's syntax tree, and its imports as (module, names) in the manner of `from module import names`.

    What stands under `if TYPE_CHECKING` is never imported. `heads` are the imports that are made whenever the file is:
    outside of functions, with nothing around them.
    Relative imports do not count: a stage with one is refused where it runs, as its key would not know the file.
    """

    tree: str
    imports: Imports
    heads: Imports = ()


def beside(package: Path) -> SyntaxMemo:
    """What is known of a package's sources. It is kept where Python keeps what it compiled of them.

    So it is as trustworthy as they are, which a folder of results need not be, and serves all of these.
    """
    return SyntaxMemo(Path(importlib.util.cache_from_source(str(package / "__init__.py"))).with_suffix(".syntax.json"))


class SyntaxMemo:
    """Meanings by content hash, kept in a file so that unchanged sources are never parsed again."""

    def __init__(self, path: Path | None) -> None:
        self._path = path
        self._known: dict[str, Meaning] = {}
        self._grown = False

    @cached_property
    def _stored(self) -> dict[str, Any]:
        """What was kept, read when the first source is asked for."""
        stored: Any = durable.read_sealed(self._path) if self._path else None
        with contextlib.suppress(TypeError, KeyError):
            if stored["for"] == _INTERPRETER:
                return dict(stored["files"])
        return {}

    def meaning(self, source: bytes) -> Meaning:
        """Meaning of a source file's bytes. A file that does not parse means its own bytes."""
        key = durable.digest(source)
        if key not in self._known and key in self._stored:
            with contextlib.suppress(ValueError, TypeError):
                self._known[key] = _from_json(*self._stored[key])
        if key not in self._known:
            self._known[key] = _parse(source)
            self._grown = True
        return self._known[key]

    def save(self) -> None:
        """Keep what was learnt; a folder that cannot be written costs only time."""
        if self._path and self._grown:
            known = {key: astuple(meaning) for key, meaning in self._known.items()}
            files = {**self._stored, **known}
            with contextlib.suppress(OSError):
                durable.write_sealed(self._path, {"for": _INTERPRETER, "files": files})
                self._grown = False


_INTERPRETER = f"{sys.version_info.major}.{sys.version_info.minor} {durable.digest(Path(__file__).read_bytes())}"


def _from_json(tree: str, *imports: Sequence[tuple[str, Sequence[str]]]) -> Meaning:
    whole, heads = (tuple((str(module), tuple(names)) for module, names in each) for each in imports)
    return Meaning(str(tree), whole, heads)


def _parse(source: bytes) -> Meaning:
    try:
        tree = ast.parse(source)
    except (SyntaxError, ValueError):
        return Meaning(durable.digest(source), ())
    return _meaning(tree)


def _meaning(tree: ast.Module) -> Meaning:
    imports: list[tuple[str, tuple[str, ...]]] = []
    reads_docstrings = False
    for node in _executed(tree):
        imports += _imports(node)
        if isinstance(node, ast.Name) and node.id == "__path__":  # a package that lists its own folder: "" is itself
            imports.append(("", ("*",)))
        elif isinstance(node, ast.Attribute) and node.attr == "__doc__":
            reads_docstrings = True
    heads = [found for node in tree.body for found in _imports(node)]
    if not reads_docstrings:
        _drop_docstrings(tree)
    return Meaning(hashlib.sha256(ast.dump(tree).encode()).hexdigest(), tuple(imports), tuple(heads))


def _executed(tree: ast.Module) -> Iterator[ast.AST]:
    """All nodes but those that only type checkers see."""
    waiting: list[ast.AST] = [tree]
    while waiting:
        node = waiting.pop()
        yield node
        typing = isinstance(node, ast.If) and isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING"
        waiting += node.orelse if typing else ast.iter_child_nodes(node)  # type: ignore[attr-defined]


def _imports(node: ast.AST) -> list[tuple[str, tuple[str, ...]]]:
    """What a statement imports, as in `Meaning`."""
    if isinstance(node, ast.Import):
        return [(alias.name, ()) for alias in node.names]
    if isinstance(node, ast.ImportFrom) and node.module and not node.level:
        return [(node.module, tuple(alias.name for alias in node.names))]
    return []


def _drop_docstrings(tree: ast.Module) -> None:
    for node in ast.walk(tree):
        if isinstance(node, _DOCUMENTED) and node.body:
            first = node.body[0]
            if (
                isinstance(first, ast.Expr)
                and isinstance(first.value, ast.Constant)
                and isinstance(first.value.value, str)
            ):
                del node.body[0]
