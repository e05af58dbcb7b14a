"""What a source file means, and which files a stage can reach by importing, found from their text alone.

A file means its syntax tree without comments, layout and docstrings, and the modules it imports.
"""

from __future__ import annotations

import ast
import contextlib
import importlib.util
import os
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

from pipeline.cache import disk

Imports = list[tuple[str, list[str]]]
_DOCUMENTED = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)


class Meaning(NamedTuple):
    """Hash of a file's syntax tree, and its imports as (module, names) in the manner of `from module import names`.

    What stands under `if TYPE_CHECKING` is never imported. `heads` are the imports that are made whenever the file is:
    outside of functions, with nothing around them.
    Relative imports do not count: a stage with one is refused where it runs, as its key would not know the file.
    """

    tree: str
    imports: Imports
    heads: Imports


def beside(package: Path) -> SyntaxMemo:
    """What is known of a package's sources. It is kept where Python keeps what it compiled of them.

    So it is as trustworthy as they are, which a folder of results need not be, and serves all of these. What is known
    of an installed package, beside which there is no study, is kept in the user's cache: uninstalling leaves no rest.
    """
    if (package.parent / "dvc.yaml").is_file():
        compiled = importlib.util.cache_from_source(str(package / "__init__.py"))
        return SyntaxMemo(Path(compiled).with_suffix(".syntax.json"))
    known = {"win32": "~/AppData/Local", "darwin": "~/Library/Caches"}.get(sys.platform, "~/.cache")
    wished = Path(os.environ.get("LOCALAPPDATA" if sys.platform == "win32" else "XDG_CACHE_HOME") or known)
    base = wished if wished.is_absolute() else Path(os.path.expanduser(known))  # noqa: PTH111 - it never raises
    return SyntaxMemo(base / "bipedstudy" / f"{disk.digest(str(package).encode())[:16]}.syntax.json")


class SyntaxMemo:
    """Meanings by content hash, kept in a file so that unchanged sources are never parsed again."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._grown = False

    @cached_property
    def _known(self) -> dict[str, Any]:
        """What was kept, read when the first source is requested."""
        stored: Any = disk.read_sealed(self.path)
        with contextlib.suppress(TypeError, KeyError):
            if stored["for"] == _INTERPRETER:
                return dict(stored["files"])
        return {}

    def meaning(self, source: bytes) -> Meaning:
        """Meaning of a source file's bytes. A file that does not parse means its own bytes."""
        key = disk.digest(source)
        if key not in self._known:
            self._known[key] = _parsed(source)
            self._grown = True
        return Meaning(*self._known[key])

    def save(self) -> None:
        """Keep what was learnt; a folder that cannot be written costs only time."""
        if self._grown:
            with contextlib.suppress(OSError):
                disk.write_sealed(self.path, {"for": _INTERPRETER, "files": self._known})
                self._grown = False


_INTERPRETER = f"{sys.version_info.major}.{sys.version_info.minor} {disk.digest(Path(__file__).read_bytes())}"


def _parsed(source: bytes) -> Meaning:
    try:
        tree = ast.parse(source)
    except (SyntaxError, ValueError):
        return Meaning(disk.digest(source), [], [])
    imports: Imports = []
    reads_docstrings = False
    for node in _executed(tree):
        imports += _imports(node)
        if isinstance(node, ast.Name) and node.id == "__path__":  # a package that lists its own folder: "" is itself
            imports.append(("", ["*"]))
        reads_docstrings |= isinstance(node, ast.Attribute) and node.attr == "__doc__"
    heads = [found for node in tree.body for found in _imports(node)]
    for node in () if reads_docstrings else ast.walk(tree):
        if isinstance(node, _DOCUMENTED) and ast.get_docstring(node, clean=False) is not None:
            del node.body[0]
    return Meaning(disk.digest(ast.dump(tree).encode()), imports, heads)


def _executed(tree: ast.Module) -> Iterator[ast.AST]:
    """All nodes but those that only type checkers see."""
    waiting: list[ast.AST] = [tree]
    while waiting:
        node = waiting.pop()
        yield node
        typing = isinstance(node, ast.If) and isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING"
        waiting += node.orelse if typing else ast.iter_child_nodes(node)  # type: ignore[attr-defined]


def _imports(node: ast.AST) -> Imports:
    """What a statement imports, as in `Meaning`."""
    if isinstance(node, ast.Import):
        return [(alias.name, []) for alias in node.names]
    if isinstance(node, ast.ImportFrom) and node.module and not node.level:
        return [(node.module, [alias.name for alias in node.names])]
    return []


_DATA = (".csv", ".html", ".json", ".mplstyle", ".sql", ".txt")


@dataclass(frozen=True)
class Closure:
    """Files by path from the code root with the hash of what they mean, and the foreign modules they import."""

    files: dict[str, str]
    foreign: tuple[str, ...]


class Sources:
    """The package of stages under `code_root`; reads every file afresh each time a closure is requested."""

    def __init__(self, code_root: Path, package: str, memo: SyntaxMemo) -> None:
        self.code_root, self.package, self.memo = code_root, package, memo

    def closure(self, modules: Iterable[str]) -> Closure:
        """Everything `modules` import, at any depth and also inside functions, with the packages around them.

        A package whose `__init__` reads its `__path__` is a register: it imports every module of its folder. Files
        beside modules that are not Python (style sheets, templates, tables) belong to the closure as well.
        """
        files: dict[str, str] = {}
        foreign: set[str] = set()
        seen: set[str] = set()
        waiting = {name for module in modules for name in with_parents(module)}
        while waiting:
            name = waiting.pop()
            seen.add(name)
            file = self.file(name)
            if file is None:
                continue
            meaning = self.memo.meaning(disk.read(self.code_root / file) or b"")
            files[file] = meaning.tree
            for target, names in meaning.imports:
                first = (target or name).partition(".")[0]
                if first == self.package:
                    waiting |= self._needed(target or name, names) - seen
                else:
                    foreign.add(first)
        for folder in {os.path.dirname(file) for file in files}:  # noqa: PTH120 - a thousand times in every run
            files.update(self._beside(folder))
        return Closure(dict(sorted(files.items())), tuple(sorted(foreign)))

    def file(self, module: str) -> str | None:
        """File of a module of the package from the code root, or None: an imported name need not be a module."""
        base = module.replace(".", "/")
        for file in (f"{base}.py", f"{base}/__init__.py"):
            if os.path.isfile(f"{self.code_root}/{file}"):  # noqa: PTH113 - a thousand times in every run
                return file
        return None

    def _needed(self, target: str, names: list[str]) -> set[str]:
        """Modules of the package that are needed to import these names from a target in it."""
        needs = {*with_parents(target)}
        init = self.file(target) if names else None
        if init is not None and init.endswith("/__init__.py"):  # in case the names are modules
            beside = (self.code_root / init).parent.iterdir() if "*" in names else ()
            inner = [path.stem for path in beside if path.name != "__init__.py"] or names
            needs.update(f"{target}.{each}" for each in inner)
        return needs

    def _beside(self, folder: str) -> dict[str, str]:
        """Files of a folder that are not Python, with their digests."""
        names = [path.name for path in os.scandir(self.code_root / folder) if path.name.endswith(_DATA)]
        return {f"{folder}/{name}": disk.digest(disk.read(self.code_root / folder / name) or b"")
                for name in names if not name.startswith(".")}  # fmt: skip


def with_parents(target: str) -> Iterator[str]:
    """The module and the packages it lies in."""
    parts = target.split(".")
    for end in range(1, len(parts) + 1):
        yield ".".join(parts[:end])
