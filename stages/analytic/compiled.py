"""The decorator that compiles this package's functions and keeps the machine code on disk.

Numba knows a cached function is old by its own file only, not by the files of the functions it calls. The cache
folder is therefore named by a digest of all sources of this package: any edit compiles afresh, undoing it does not.
"""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

import numba

#: What compiled functions take and give besides arrays: a few numbers, such as the tuple p of parameters; one number
#: for each coordinate; the parts of a constrained solution; three Jacobians, each stored by rows.
Numbers = tuple[float, ...]
Four = tuple[float, float, float, float]
Constrained = tuple[Four, Four, float, float, float]
Jacobians = tuple[Numbers, Numbers, Numbers]

F = TypeVar("F", bound=Callable[..., Any])
FOLDER = Path(__file__).parent


def cache_folder() -> Path:
    """Folder for the machine code of these sources: beside them, or in the temporary folder if that is read-only."""
    digest = hashlib.sha256(numba.__version__.encode())
    for source in sorted(FOLDER.rglob("*.py")):
        digest.update(source.read_bytes())
    home = FOLDER if os.access(FOLDER, os.W_OK) else Path(tempfile.gettempdir())
    return home / "__pycache__" / f"numba-{digest.hexdigest()[:16]}"


vars(numba.config)["CACHE_DIR"] = str(cache_folder())


#: No relaxed arithmetic, not even fused multiply-add: where the compiler fuses depends on what it inlines, and that on
#: what the cache already holds, so the last bits would depend on the order of calls. Threads may run side by side.
OPTIONS: dict[str, Any] = {"cache": True, "error_model": "numpy", "nogil": True, "no_cfunc_wrapper": True}


def compiled(function: F) -> F:
    """The function as machine code."""
    return cast(F, numba.njit(**OPTIONS)(function))


def inlined(function: F) -> F:
    """The same, as a part of each function that calls it: for large functions that one or two others call.

    Numba compiles a function together with all that it calls, so each layer in between is compiled again with every
    layer above it. Without these a step map takes 1.5 times as long to compile.
    """
    return cast(F, numba.njit(inline="always", **OPTIONS)(function))
