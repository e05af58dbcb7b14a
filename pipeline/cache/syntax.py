"""What a source file means: its syntax tree without comments, layout and docstrings, and the modules it imports."""

from __future__ import annotations

import ast
import contextlib
import hashlib
import sys
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from pipeline.cache import durable

_DOCUMENTED = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)


@dataclass(frozen=True)
class Meaning:
    """Hash of a file's syntax tree, and its imports as (module, names) in the manner of `from module import names`.

    Relative imports do not count: a stage with one is refused where it runs, as its key would not know the file.
    """

    tree: str
    imports: tuple[tuple[str, tuple[str, ...]], ...]


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

    def learn(self, source: bytes, tree: ast.Module) -> None:
        """Note the meaning of bytes that were parsed already; the tree loses its docstrings."""
        self._known[durable.digest(source)] = _meaning(tree)

    def save(self) -> None:
        """Keep what was learnt; a folder that cannot be written costs only time."""
        if self._path and self._grown:
            known = {key: (meaning.tree, meaning.imports) for key, meaning in self._known.items()}
            files = {**self._stored, **known}
            with contextlib.suppress(OSError):
                durable.write_sealed(self._path, {"for": _INTERPRETER, "files": files})
                self._grown = False

    def forget(self) -> None:
        """Believe nothing of what was kept, as it contradicts what a worker read."""
        self._known, self._stored, self._grown = {}, {}, True


_INTERPRETER = f"{sys.version_info.major}.{sys.version_info.minor} {durable.digest(Path(__file__).read_bytes())}"


def _from_json(tree: str, imports: list[tuple[str, list[str]]]) -> Meaning:
    return Meaning(str(tree), tuple((str(module), tuple(names)) for module, names in imports))


def _parse(source: bytes) -> Meaning:
    try:
        tree = ast.parse(source)
    except (SyntaxError, ValueError):
        return Meaning(durable.digest(source), ())
    return _meaning(tree)


def _meaning(tree: ast.Module) -> Meaning:
    imports: list[tuple[str, tuple[str, ...]]] = []
    reads_docstrings = False
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            imports += [(alias.name, ()) for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            imports.append((node.module, tuple(alias.name for alias in node.names)))
        elif isinstance(node, ast.Name) and node.id == "__path__":  # a package that lists its own folder: "" is itself
            imports.append(("", ("*",)))
        elif isinstance(node, ast.Attribute) and node.attr == "__doc__":
            reads_docstrings = True
    if not reads_docstrings:
        _drop_docstrings(tree)
    return Meaning(hashlib.sha256(ast.dump(tree).encode()).hexdigest(), tuple(imports))


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
