"""What a source file means, and which files a stage can reach by importing, found from their text alone.

A file means its syntax tree without comments, layout and docstrings, and the modules it imports.
"""

from __future__ import annotations

import ast
import contextlib
import hashlib
import importlib.util
import os
import sys
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import astuple, dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

from pipeline.cache import disk

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
        stored: Any = disk.read_sealed(self._path) if self._path else None
        with contextlib.suppress(TypeError, KeyError):
            if stored["for"] == _INTERPRETER:
                return dict(stored["files"])
        return {}

    def meaning(self, source: bytes) -> Meaning:
        """Meaning of a source file's bytes. A file that does not parse means its own bytes."""
        key = disk.digest(source)
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
                disk.write_sealed(self._path, {"for": _INTERPRETER, "files": files})
                self._grown = False


_INTERPRETER = f"{sys.version_info.major}.{sys.version_info.minor} {disk.digest(Path(__file__).read_bytes())}"


def _from_json(tree: str, *imports: Sequence[tuple[str, Sequence[str]]]) -> Meaning:
    whole, heads = (tuple((str(module), tuple(names)) for module, names in each) for each in imports)
    return Meaning(str(tree), whole, heads)


def _parse(source: bytes) -> Meaning:
    try:
        tree = ast.parse(source)
    except (SyntaxError, ValueError):
        return Meaning(disk.digest(source), ())
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


_DATA = (".csv", ".html", ".json", ".mplstyle", ".sql", ".txt")


@dataclass(frozen=True)
class Closure:
    """Files by path from the code root with the hash of what they mean, and the foreign modules they import."""

    files: dict[str, str]
    foreign: tuple[str, ...]


@dataclass(frozen=True)
class _Module:
    """A module's file, what it means, the modules of its package that it needs, and the foreign ones."""

    file: str
    tree: str
    needs: frozenset[str]
    foreign: frozenset[str]


@dataclass
class _Known:
    """What was read: modules by name (None for a name that is no module), and other files by their folder."""

    modules: dict[str, _Module | None] = field(default_factory=dict)
    beside: dict[str, dict[str, str]] = field(default_factory=dict)


class Sources:
    """The package of stages under `code_root`; reads every file afresh each time a closure is asked for.

    Within `one_moment` a file is read once: closures that are asked for at the same time share what they read.
    """

    def __init__(self, code_root: Path, package: str, memo: SyntaxMemo) -> None:
        self.code_root, self.package, self.memo = code_root, package, memo
        self._held: _Known | None = None

    @contextlib.contextmanager
    def one_moment(self) -> Iterator[None]:
        """Read every file once until the end of this context."""
        self._held = _Known()
        try:
            yield
        finally:
            self._held = None

    def closure(self, modules: Iterable[str]) -> Closure:
        """Everything `modules` import, at any depth and also inside functions, with the packages around them.

        A package whose `__init__` reads its `__path__` is a register: it imports every module of its folder. Files
        beside modules that are not Python (style sheets, templates, tables) belong to the closure as well.
        """
        known = _Known() if self._held is None else self._held
        files: dict[str, str] = {}
        foreign: set[str] = set()
        seen: set[str] = set()
        waiting = {name for module in modules for name in with_parents(module)}
        while waiting:
            name = waiting.pop()
            seen.add(name)
            module = self._module(name, known)
            if module is not None:
                files[module.file] = module.tree
                foreign |= module.foreign
                waiting |= module.needs - seen
        for folder in {os.path.dirname(file) for file in files}:  # noqa: PTH120 - a thousand times in every run
            files.update(self._beside(folder, known))
        return Closure(dict(sorted(files.items())), tuple(sorted(foreign)))

    def file(self, module: str) -> str | None:
        """File of a module of the package from the code root, or None: an imported name need not be a module."""
        base = module.replace(".", "/")
        for file in (f"{base}.py", f"{base}/__init__.py"):
            if os.path.isfile(f"{self.code_root}/{file}"):  # noqa: PTH113 - a thousand times in every run
                return file
        return None

    def _module(self, name: str, known: _Known) -> _Module | None:
        if name not in known.modules:
            file = self.file(name)
            known.modules[name] = None if file is None else self._read(name, file)
        return known.modules[name]

    def _read(self, name: str, file: str) -> _Module:
        meaning = self.memo.meaning(disk.read(self.code_root / file) or b"")
        needs: set[str] = set()
        foreign: set[str] = set()
        for target, names in meaning.imports:
            target = target or name
            first = target.partition(".")[0]
            if first != self.package:
                foreign.add(first)
                continue
            needs.update(with_parents(target))
            init = self.file(target) if names else None
            if init is not None and init.endswith("/__init__.py"):  # in case the names are modules
                inner = self._modules_beside(init) if "*" in names else names
                needs.update(f"{target}.{each}" for each in inner)
        return _Module(file, meaning.tree, frozenset(needs), frozenset(foreign))

    def _modules_beside(self, init: str) -> tuple[str, ...]:
        """Names that may be modules of a package."""
        return tuple(path.stem for path in (self.code_root / init).parent.iterdir() if path.name != "__init__.py")

    def _beside(self, folder: str, known: _Known) -> dict[str, str]:
        """Files of a folder that are not Python, with their digests."""
        if folder not in known.beside:
            paths = (path for path in os.scandir(self.code_root / folder) if path.name.endswith(_DATA))
            names = (path.name for path in paths if not path.name.startswith("."))
            places = {f"{folder}/{name}": self.code_root / folder / name for name in names}
            known.beside[folder] = {file: disk.digest(disk.read(path) or b"") for file, path in places.items()}
        return known.beside[folder]


def with_parents(target: str) -> Iterator[str]:
    """The module and the packages it lies in."""
    parts = target.split(".")
    for end in range(1, len(parts) + 1):
        yield ".".join(parts[:end])
