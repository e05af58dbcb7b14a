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
from functools import cache
from pathlib import Path
from types import CodeType, ModuleType

from pipeline.cache.closure import Sources
from pipeline.cache.syntax import beside


@cache
def code_of(path: str, source: bytes) -> CodeType:
    """The code of the source at `path`, compiled once for this process and those it forks.

    Raises SyntaxError or ValueError where it cannot be compiled.
    """
    code: CodeType = compile(source, path, "exec", dont_inherit=True)
    return code


class ObservedSources(importlib.abc.MetaPathFinder):
    """Finder for one package; `loaded` maps each file (from the code root) to the source bytes that were executed."""

    def __init__(self, code_root: Path, package: str) -> None:
        self.sources = Sources(code_root, package, beside(code_root / package))
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
        return code_of(path, source)
