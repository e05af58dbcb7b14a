"""The source files a stage can reach by importing, found from their text alone."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

from pipeline.cache import durable
from pipeline.cache.syntax import SyntaxMemo

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
        meaning = self.memo.meaning(durable.read(self.code_root / file) or b"")
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
            known.beside[folder] = {file: durable.digest(durable.read(path) or b"") for file, path in places.items()}
        return known.beside[folder]


def with_parents(target: str) -> Iterator[str]:
    """The module and the packages it lies in."""
    parts = target.split(".")
    for end in range(1, len(parts) + 1):
        yield ".".join(parts[:end])
