"""The source files a stage can reach by importing, found from their text alone."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from pipeline.cache import durable
from pipeline.cache.syntax import Meaning, SyntaxMemo

#: What was read of modules: file and meaning, or None for a name that is no module.
Known = dict[str, "tuple[str, Meaning] | None"]

_DATA = (".csv", ".html", ".json", ".mplstyle", ".sql", ".txt")


@dataclass(frozen=True)
class Closure:
    """Files by path from the code root with the hash of what they mean, and the foreign modules they import."""

    files: dict[str, str]
    foreign: tuple[str, ...]


class Sources:
    """The package of stages under `code_root`; reads every file afresh each time a closure is asked for.

    Within `one_moment` a file is read once: closures that are asked for at the same time share what they read.
    """

    def __init__(self, code_root: Path, package: str, memo: SyntaxMemo) -> None:
        self.code_root, self.package, self.memo = code_root, package, memo
        self._held: Known | None = None

    @contextlib.contextmanager
    def one_moment(self) -> Iterator[None]:
        """Read every file once until the end of this context."""
        self._held = {}
        try:
            yield
        finally:
            self._held = None

    def closure(self, modules: Iterable[str]) -> Closure:
        """Everything `modules` import, at any depth and also inside functions, with the packages around them.

        A package whose `__init__` reads its `__path__` is a register: it imports every module of its folder. Files
        beside modules that are not Python (style sheets, templates, tables) belong to the closure as well.
        """
        known: Known = {} if self._held is None else self._held
        files: dict[str, str] = {}
        foreign: set[str] = set()
        seen: set[str] = set()
        waiting = [name for module in modules for name in _with_parents(module)]
        while waiting:
            module = waiting.pop()
            if module in seen:
                continue
            seen.add(module)
            found = self._read(module, known)
            if found is None:
                continue
            file, meaning = found
            files[file] = meaning.tree
            for name, names in meaning.imports:
                target = name or module
                if target.split(".")[0] != self.package:
                    foreign.add(target.split(".")[0])
                    continue
                waiting.extend(_with_parents(target))
                beneath = self._read(target, known)
                if beneath is not None and beneath[0].endswith("/__init__.py"):  # in case the names are modules
                    names = self._modules_beside(beneath[0]) if "*" in names else names
                    waiting.extend(f"{target}.{inner}" for inner in names)
        files.update(self._beside(files))
        return Closure(dict(sorted(files.items())), tuple(sorted(foreign)))

    def file(self, module: str) -> str | None:
        """File of a module of the package from the code root, or None: an imported name need not be a module."""
        base = module.replace(".", "/")
        for file in (f"{base}.py", f"{base}/__init__.py"):
            if os.path.isfile(f"{self.code_root}/{file}"):  # noqa: PTH113 - a thousand times in every run
                return file
        return None

    def _read(self, module: str, known: Known) -> tuple[str, Meaning] | None:
        """A module's file and what it means, or None where there is no such file."""
        if module not in known:
            file = self.file(module)
            known[module] = (
                None if file is None else (file, self.memo.meaning(durable.read(self.code_root / file) or b""))
            )
        return known[module]

    def _modules_beside(self, init: str) -> tuple[str, ...]:
        """Names that may be modules of a package."""
        return tuple(path.stem for path in (self.code_root / init).parent.iterdir() if path.name != "__init__.py")

    def _beside(self, files: dict[str, str]) -> Iterator[tuple[str, str]]:
        for folder in {(self.code_root / file).parent for file in files}:
            for path in folder.iterdir():
                if path.suffix in _DATA and not path.name.startswith("."):
                    yield path.relative_to(self.code_root).as_posix(), durable.digest(durable.read(path) or b"")


def _with_parents(target: str) -> Iterator[str]:
    """The module and the packages it lies in."""
    parts = target.split(".")
    for end in range(1, len(parts) + 1):
        yield ".".join(parts[:end])
