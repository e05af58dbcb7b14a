"""Imports the stages' modules from their source and remembers which text was used.

A source can be edited while a stage runs, and a compiled file beside it can be older than an edit made within the same
second. So the worker reads the source itself, takes compiled code only for exactly that text, and the run checks
afterwards that this is what the key says.
"""

from __future__ import annotations

import contextlib
import importlib.abc
import importlib.machinery
import importlib.util
import marshal
import py_compile
import sys
from collections.abc import Sequence
from pathlib import Path
from types import CodeType, ModuleType

from pipeline.cache import durable
from pipeline.cache.closure import Sources
from pipeline.cache.syntax import Imports, SyntaxMemo, beside

#: First bytes of a compiled file that holds for the text whose hash follows, whatever the files' times are (PEP 552).
_CHECKED = importlib.util.MAGIC_NUMBER + b"\3\0\0\0"


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
            head = _CHECKED + importlib.util.source_hash(source)
            code = _kept(path, head) or _written(path, head)
            self._code[place] = code or compile(source, path, "exec", dont_inherit=True)
        return self._code[place]


def _kept(path: str, head: bytes) -> CodeType | None:
    """The code in the compiled file beside a source, if it begins with `head` and was compiled at this place."""
    with contextlib.suppress(OSError, ValueError, EOFError, TypeError):
        content = durable.read(Path(importlib.util.cache_from_source(path))) or b""
        if content.startswith(head):
            code = marshal.loads(content[len(head) :])
            if isinstance(code, CodeType) and code.co_filename == path:
                return code
    return None


def _written(path: str, head: bytes) -> CodeType | None:
    """The same, after the file was written anew; a folder that cannot be written costs only time."""
    if sys.dont_write_bytecode:
        return None
    with contextlib.suppress(OSError, py_compile.PyCompileError):
        py_compile.compile(path, doraise=True, invalidation_mode=py_compile.PycInvalidationMode.CHECKED_HASH)
    return _kept(path, head)


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
