"""Imports the stages' modules straight from their source and remembers which text was used.

A compiled file beside a source can be older than an edit made within the same second, and a source can be edited
while a stage runs. So the worker compiles what it reads, and the run checks afterwards that this is what the key says.
Code that a text was compiled to before, in the process that the worker was forked from, does as well.
"""

from __future__ import annotations

import ast
import importlib.abc
import importlib.machinery
import importlib.util
import sys
from collections.abc import Sequence
from pathlib import Path
from types import CodeType, ModuleType

from pipeline.cache.closure import Sources
from pipeline.cache.syntax import Imports, SyntaxMemo


class Compiled:
    """Sources that were compiled before anything imports them, by path and text, and what they mean."""

    def __init__(self) -> None:
        self.code: dict[tuple[str, bytes], CodeType] = {}
        self.memo = SyntaxMemo(None)

    def take(self, path: Path, source: bytes) -> Imports:
        """Compile the source at `path`, unless it is known; what it imports at its head.

        A source that cannot be compiled is left to whoever imports it.
        """
        place = str(path), source
        if place not in self.code:
            try:
                tree = None if self.memo.knows(source) else ast.parse(source, path)
                self.code[place] = compile(tree or source, path, "exec", dont_inherit=True)
            except (SyntaxError, ValueError):
                return ()
            if tree is not None:
                self.memo.note(source, tree)
        return self.memo.meaning(source).heads


class ObservedSources(importlib.abc.MetaPathFinder):
    """Finder for one package; `loaded` maps each file (from the code root) to the source bytes that were executed."""

    def __init__(self, code_root: Path, package: str, compiled: Compiled | None = None) -> None:
        self.compiled = compiled or Compiled()
        self.sources = Sources(code_root, package, self.compiled.memo)
        self.loaded: dict[str, bytes] = {}

    def install(self) -> None:
        """Take over the import of the package from now on."""
        sys.meta_path.insert(0, self)

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> importlib.machinery.ModuleSpec | None:
        """Spec of a module of the package, None for all others."""
        if fullname.split(".")[0] != self.sources.package:
            return None
        found = self.sources.file(fullname)
        if found is None:
            return None
        file = self.sources.code_root / found
        search = [str(file.parent)] if file.name == "__init__.py" else None
        loader = _Loader(fullname, str(file), self)
        return importlib.util.spec_from_file_location(fullname, file, loader=loader, submodule_search_locations=search)

    def meanings(self) -> dict[str, str]:
        """File -> hash of what was executed."""
        return {file: self.sources.memo.meaning(source).tree for file, source in self.loaded.items()}


class _Loader(importlib.machinery.SourceFileLoader):
    def __init__(self, fullname: str, path: str, observed: ObservedSources) -> None:
        super().__init__(fullname, path)
        self._observed = observed

    def get_code(self, fullname: str) -> CodeType:
        """Compile the source itself, never a compiled file."""
        path = self.get_filename(fullname)
        source = self.get_data(path)
        name = Path(path).relative_to(self._observed.sources.code_root).as_posix()
        self._observed.loaded[name] = source
        known = self._observed.compiled.code.get((path, source))
        if known is not None:
            return known
        code: CodeType = compile(source, path, "exec", dont_inherit=True)
        return code
