"""Imports the stages' modules from their source and remembers which text was used.

A source can be edited while a stage runs, and a compiled file beside it can be older than an edit made within the same
second. So the worker reads the source itself and compiles that text, and the run checks afterwards that this is what
the key says.
"""

from __future__ import annotations

import importlib.abc
import importlib.machinery
import importlib.util
import sys
from collections.abc import Sequence
from pathlib import Path
from types import CodeType, ModuleType

from pipeline.cache.closure import Sources
from pipeline.cache.syntax import Imports, SyntaxMemo, beside


class Compiled:
    """Code of sources by path and text, for this process and those it forks, and what the sources mean."""

    def __init__(self, memo: SyntaxMemo) -> None:
        self.memo = memo
        self._code: dict[tuple[str, bytes], CodeType] = {}

    def take(self, path: Path, source: bytes) -> Imports:
        """Have the code of the source at `path`; what it imports at its head.

        A source that cannot be compiled is left to whoever imports it.
        """
        try:
            self.code(str(path), source)
        except (SyntaxError, ValueError):
            return ()
        return self.memo.meaning(source).heads

    def code(self, path: str, source: bytes) -> CodeType:
        """The code of the source at `path`. Raises SyntaxError or ValueError where it cannot be compiled."""
        place = path, source
        if place not in self._code:
            self._code[place] = compile(source, path, "exec", dont_inherit=True)
        return self._code[place]


class ObservedSources(importlib.abc.MetaPathFinder):
    """Finder for one package; `loaded` maps each file (from the code root) to the source bytes that were executed."""

    def __init__(self, code_root: Path, package: str, compiled: Compiled | None = None) -> None:
        self.compiled = compiled or Compiled(beside(code_root / package))
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
        """Code of the source as it is now."""
        path = self.get_filename(fullname)
        source = self.get_data(path)
        name = Path(path).relative_to(self._observed.sources.code_root).as_posix()
        self._observed.loaded[name] = source
        return self._observed.compiled.code(path, source)
