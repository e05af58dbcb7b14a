"""The decorator that compiles this package's functions and keeps the machine code on disk.

Numba knows a cached function is old by its own file only, not by the files of the functions it calls. The cache
folder is therefore named by a digest of all sources of this package: any edit compiles afresh, undoing it does not.
"""

from __future__ import annotations

import hashlib
import os
import tempfile
from pathlib import Path

import numba

FOLDER = Path(__file__).parent


def cache_folder() -> Path:
    """Folder for the machine code of these sources: beside them, or in the temporary folder if that is read-only."""
    digest = hashlib.sha256(numba.__version__.encode())
    for source in sorted(FOLDER.glob("*.py")):
        digest.update(source.read_bytes())
    home = FOLDER if os.access(FOLDER, os.W_OK) else Path(tempfile.gettempdir())
    return home / "__pycache__" / f"numba-{digest.hexdigest()[:16]}"


numba.config.CACHE_DIR = str(cache_folder())
#: No relaxed arithmetic, not even fused multiply-add: where the compiler fuses depends on what it inlines, and that on
#: what the cache already holds, so the last bits would depend on the order of calls. Threads may run side by side.
compiled = numba.njit(cache=True, error_model="numpy", nogil=True)
