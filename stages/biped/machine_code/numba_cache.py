"""Numba's cache of a compiled function, in a folder that we name, in files whose seal tells damage.

The one file that uses private parts of numba: what its own caches are made of, the same from 0.60 on. Where they have
changed, importing this or `attach` raises ImportError, AttributeError or TypeError, and numba's own cache serves.
"""

from __future__ import annotations

import hashlib
import pickle
import sys
from pathlib import Path
from typing import Any, Protocol

from numba.core import caching

#: Numba's own annotations are partly missing.
Cache: Any = caching.FunctionCache
Files: Any = caching.IndexDataCacheFile
_SEAL = hashlib.sha256().digest_size


class Code(Protocol):
    """What is to be known of the machine code of some sources; see `machine_code.MachineCode`."""

    folder: Path
    stamp: str
    refusal: str
    shipped: Path | None

    def begin(self) -> None:
        """Make the folder."""


def attach(dispatcher: Any, code: Code) -> None:
    """Let a compiled function load its machine code, from the shipped folder or its own, and leave it in its own."""
    dispatcher._cache = _FunctionCache(dispatcher.py_func, code)


class _Files(Files):  # type: ignore[misc]
    """The machine code of one function: a file for each choice of types, named by it, whose seal tells damage.

    Numba numbers such files and keeps an index. Two processes that compile at once may then give one number twice, and
    a file that holds another choice's machine code is run.
    """

    def load(self, key: Any) -> Any:
        """What was saved for these types, or None. What is damaged, or was made of other sources, counts as missing."""
        try:
            content = self._file(key).read_bytes()
        except OSError:
            return None
        if hashlib.sha256(content[_SEAL:]).digest() != content[:_SEAL]:
            return None
        *known, data = pickle.loads(content[_SEAL:])
        return data if known == self._known(key) else None

    def save(self, key: Any, data: Any) -> None:
        """Keep it; whoever else saves the same just now keeps as good a one."""
        content: bytes = self._dump([*self._known(key), data])
        with self._open_for_write(self._file(key)) as file:
            file.write(hashlib.sha256(content).digest() + content)

    def _known(self, key: Any) -> list[Any]:
        return [self._version, self._source_stamp, key]

    def _file(self, key: Any) -> Path:
        number = int.from_bytes(hashlib.sha256(repr(key).encode()).digest()[:8], "big")
        return Path(self._data_path(self._data_name(number)))


class _FunctionCache(Cache):  # type: ignore[misc]
    def __init__(self, function: Any, code: Code) -> None:
        self._code = code
        self._impl_class = lambda py_func: _Kept(py_func, code)
        super().__init__(function)
        folders = [*([code.shipped] if code.shipped else []), *([] if code.refusal else [code.folder])]
        self._read = [_Files(str(folder), self._impl.filename_base, code.stamp) for folder in folders]
        self._cache_file = _Files(str(code.folder), self._impl.filename_base, code.stamp)

    def _load_overload(self, sig: Any, target_context: Any) -> Any:
        key = self._index_key(sig, target_context.codegen())
        found = next((data for files in self._read for each in (key, for_any_processor(key))
                      if (data := files.load(each)) is not None), None)  # fmt: skip
        return None if found is None else self._impl.rebuild(target_context, found)

    def _save_overload(self, sig: Any, data: Any) -> None:
        if not self._code.refusal:
            super()._save_overload(sig, data)


def for_any_processor(key: Any) -> Any:
    """The key in numba's index of the same function, compiled with NUMBA_CPU_NAME=generic: each processor runs it."""
    signature, (triple, _, _), code = key
    return signature, (triple, "generic", ""), code


class _Kept(caching.CompileResultCacheImpl):
    """Names the files of one function by its full name: the path of its source says nothing."""

    def __init__(self, function: Any, code: Code) -> None:
        self._lineno = function.__code__.co_firstlineno
        self._locator = _Place(code, self._lineno)
        name: Any = super().get_filename_base
        full = f"{function.__module__}.{function.__qualname__}"
        self._filename_base = name(full, getattr(sys, "abiflags", ""))


class _Place(caching._CacheLocator):
    """Tells numba the folder and the stamp."""

    def __init__(self, code: Code, line: int) -> None:
        self._code, self._line, self._py_file = code, line, ""

    def ensure_cache_path(self) -> None:
        """Make the folder."""
        self._code.begin()

    def get_cache_path(self) -> str:
        """The folder."""
        return str(self._code.folder)

    def get_source_stamp(self) -> str:
        """The digest of the sources."""
        return self._code.stamp

    def get_disambiguator(self) -> str:
        """The line, as functions of one file may share a name."""
        return str(self._line)
