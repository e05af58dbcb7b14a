"""Numba's cache of a compiled function, in a folder that we name, in files whose seal shows damage.

The one file that uses private parts of numba: what its own caches are made of, the same from 0.60 on. Where they have
changed, importing this or `attach` raises ImportError, AttributeError or TypeError, and numba's own cache serves.
"""

from __future__ import annotations

import hashlib
import pickle
import sys
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numba
from numba.core import caching

if TYPE_CHECKING:
    from stages.biped.machine_code import MachineCode

#: Numba's own annotations are partly missing.
Cache: Any = caching.FunctionCache
Results: Any = caching.CompileResultCacheImpl
dumps: Any = caching.dumps  # type: ignore[attr-defined]
_SEAL = hashlib.sha256().digest_size


def attach(dispatcher: Any, code: MachineCode) -> None:
    """Let a compiled function load its machine code, from the shipped folder or its own, and leave it in its own."""
    dispatcher._cache = _Kept(dispatcher.py_func, code)


class _Results(Results):  # type: ignore[misc]
    """What is kept of a compilation, as numba has it."""

    def __init__(self, function: Any) -> None:
        self._lineno, self._locator = function.__code__.co_firstlineno, SimpleNamespace(_py_file="")


class _Kept(Cache):  # type: ignore[misc]
    """The machine code of one function: a file for each choice of types, named by it, whose seal shows damage.

    Numba numbers such files and keeps an index. Two processes that compile at once may then give one number twice, and
    a file that holds another choice's machine code is run. The path of a source says nothing here: a file is named by
    the function's full name, and by its line, as functions of one file may share a name.
    """

    def __init__(self, function: Any, code: MachineCode) -> None:
        self._py_func, self._code, self._results = function, code, _Results(function)
        self._cache_path = str(code.folder)
        name = f"{function.__module__}.{function.__qualname__}".replace("<", "").replace(">", "")
        python = f"py{sys.version_info.major}{sys.version_info.minor}{getattr(sys, 'abiflags', '')}"
        self._name = f"{name}-{function.__code__.co_firstlineno}.{python}"
        self._keys: Any = super()._index_key

    def load_overload(self, signature: Any, target: Any) -> Any:
        """What was kept for these types, or None. What is damaged, or was made of other sources, counts as missing."""
        target.refresh()
        key = self._keys(signature, target.codegen())
        for path, each in ((folder / self._file(each), each) for folder in self._code.places()
                           for each in (key, for_any_processor(key))):  # fmt: skip
            try:
                content = path.read_bytes()
            except OSError:
                continue
            if hashlib.sha256(content[_SEAL:]).digest() == content[:_SEAL]:
                *known, data = pickle.loads(content[_SEAL:])
                if known == self._known(each):
                    return self._results.rebuild(target, data)
        return None

    def save_overload(self, signature: Any, result: Any) -> None:
        """Keep it; whoever else keeps the same just now keeps as good a one."""
        if self._code.refusal or not self._results.check_cachable(result):
            return
        key = self._keys(signature, result.codegen)
        content: bytes = dumps([*self._known(key), self._results.reduce(result)])
        self._code.leave(self._file(key), hashlib.sha256(content).digest() + content)

    def _known(self, key: Any) -> list[Any]:
        return [numba.__version__, self._code.stamp, key]

    def _file(self, key: Any) -> str:
        number = int.from_bytes(hashlib.sha256(repr(key).encode()).digest()[:8], "big")
        return f"{self._name}.{number}.nbc"


def for_any_processor(key: Any) -> Any:
    """The key in numba's index of the same function, compiled with NUMBA_CPU_NAME=generic: each processor runs it."""
    signature, (triple, _, _), code = key
    return signature, (triple, "generic", ""), code
