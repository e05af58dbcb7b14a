"""Runs the study: reads parameters, finds what is stale, runs stages, keeps results. Knows nothing of its subject.

Python believes what it keeps compiled in `__pycache__` beside the sources: one flipped bit there would compute other
results. So what is kept of this program's own packages, and of a study's stages, has a digest of all its bytes at its
end, which Python itself passes over. Without the right one the source is compiled again.
"""

import sys
from collections.abc import Sequence
from hashlib import sha256
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec, PathFinder, SourceFileLoader
from types import ModuleType

#: Packages whose compiled files are sealed.
SEALED = {"pipeline", "bipedstudy", "stages"}
#: Those of studies, of which nothing compiled is read or left: whoever agreed to their code has seen the sources.
AFRESH = set[str]()
_COMPILED, _DIGEST = ".pyc", sha256().digest_size


class SealedLoader(SourceFileLoader):
    """Loads a module of its source, or of what was compiled of it where the seal is right."""

    def get_data(self, path: str) -> bytes:
        """The content of a source, or of a compiled file without its seal. Raises OSError for a wrong one."""
        content = super().get_data(path)
        if not path.endswith(_COMPILED):
            return content
        if _is_afresh(self.name) or sha256(content[:-_DIGEST]).digest() != content[-_DIGEST:]:
            raise OSError("is not believed")
        return content[:-_DIGEST]

    def set_data(self, path: str, data: bytes, *, _mode: int = 0o666) -> None:  # type: ignore[override]
        """Leave what was compiled, with its seal."""
        if not _is_afresh(self.name):
            super().set_data(path, data + sha256(data).digest(), _mode=_mode)


class _Finder(MetaPathFinder):
    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Spec of a module of a sealed package; None for all others."""
        if (path is None and fullname not in AFRESH) or fullname.partition(".")[0] not in SEALED | AFRESH:
            return None
        return spec_of(fullname, path)


def spec_of(fullname: str, path: Sequence[str] | None) -> ModuleSpec | None:
    """Spec of a module, as Python finds it on a path, that is loaded of what is sealed."""
    found = PathFinder.find_spec(fullname, path)
    if found is not None and type(found.loader) is SourceFileLoader:
        found.loader = SealedLoader(found.loader.name, found.loader.path)
    return found


def _is_afresh(module: str) -> bool:
    return module.partition(".")[0] in AFRESH


sys.meta_path.insert(0, _Finder())
