"""Where machine code is kept on disk, so that an edit of any source that it was made from is seen.

Numba knows a cached function is old by its own file only, not by the files of the functions it calls. The cache folder
is therefore named by a digest of whole folders of sources: any edit compiles afresh, undoing it does not.
"""

from __future__ import annotations

import hashlib
import os
import tempfile
from pathlib import Path

import numba


def cache_folder(*sources: Path) -> Path:
    """Folder for machine code of the sources in these folders: beside the first, or in the temporary folder if that is
    read-only."""
    digest = hashlib.sha256(numba.__version__.encode())
    for folder in sources:
        for source in sorted(folder.rglob("*.py")):
            digest.update(source.read_bytes())
    home = sources[0] if os.access(sources[0], os.W_OK) else Path(tempfile.gettempdir())
    return home / "__pycache__" / f"numba-{digest.hexdigest()[:16]}"
