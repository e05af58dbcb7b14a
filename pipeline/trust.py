"""Whose study it is: what lies in a study can run as whoever calls a command there, and so is agreed to once.

As git and direnv do it. A study of another owner is refused, and root is one as well. One with code of its own is
named. Where all its code is the user's own, the agreement is to its folder. Where some is another's, or was unpacked,
or the system knows no owners, it is to the content: another content is requested anew. The checkout that this program
was installed from is trusted, whoever owns it, as its code runs already.
"""

import json
import os
import sys
from collections.abc import Iterable, Iterator, Sequence
from importlib.machinery import all_suffixes
from pathlib import Path

from pipeline.cache import disk
from pipeline.errors import StudyError
from pipeline.home import DISTRIBUTION, engine

#: Digests of the contents that are agreed to, for containers and CI.
VARIABLE = "BIPEDSTUDY_TRUST"
_GRAPH, _RESULTS, _COMPILED = "dvc.yaml", "results", "__pycache__"
_HAS_OWNERS = os.name == "posix"
#: Between the time of a file's text and of its last change [s], beyond which it was brought and not written here.
_BROUGHT_S = 60.0
_OTHERS = 0o022
_agrees = _is_command = False


def agree(requested: bool, is_command: bool = False) -> None:
    """Say whether this process, perhaps that of a command, agrees to the study it meets (`--trust`)."""
    global _agrees, _is_command
    _agrees, _is_command = requested, is_command


def check(root: Path, package: str, has_code: bool) -> bool:
    """Raise `StudyError` unless the study in `root` is the user's and, where it `has_code` in `package`, agreed to.

    Whether some of that code is somebody else's, and this is a command.
    """
    theirs = _others([root, root / _GRAPH])
    if root == engine() or not (theirs or has_code):
        return False
    files = sorted(_code(root, package))
    own = not theirs and _are_own(files)
    rows, folder = _rows(), {"folder": str(root), "content": ""}
    if own and folder in rows:
        return False
    as_it_is = {"folder": str(root), "content": content(root, files)}
    agreed = as_it_is in rows or as_it_is["content"] in os.environ.get(VARIABLE, "").split()
    if not agreed and not _agrees:
        why = f"belongs to {theirs}, not to you" if theirs else "has code of its own"
        raise StudyError(f"{root} {why}, and what lies there would run as you: look at it, then agree once with "
                         f"{DISTRIBUTION} --trust before your command, or by {VARIABLE}={as_it_is['content']}")
    if not agreed:
        _keep([*rows, folder if own else as_it_is])
        print(f"note: agreed to {root}{'' if own else ' as it is now'}", file=sys.stderr)
    return not own and _is_command


def vouch(root: Path, digest: str) -> None:
    """Remember that a proof of this digest was made or checked here."""
    if not vouched(root, digest):
        _keep([*_rows(), _proof(root, digest)])


def vouched(root: Path, digest: str) -> bool:
    """Whether a proof of this digest was made or checked here."""
    return _proof(root, digest) in _rows()


def _proof(root: Path, digest: str) -> dict[str, str]:
    return {"folder": str(root), "content": f"proof {digest}"}


def content(root: Path, files: Iterable[Path]) -> str:
    """Digest of a study's graph and code, with their names, as the variable has it."""
    found = [[path.relative_to(root).as_posix(), disk.file_digest(path)] for path in (root / _GRAPH, *files)]
    return disk.digest(json.dumps(found).encode())[:32]


def _code(root: Path, package: str) -> Iterator[Path]:
    """Files that can be run: all of the package of stages but what is compiled of them, which is not read, and what
    can be imported from elsewhere in the study. Links are followed, as Python does; in order, as what two names have is
    told by the first.
    """
    suffixes, seen = tuple(all_suffixes()), set[str]()
    for place, folders, names in os.walk(root, followlinks=True):
        here, real = Path(place), os.path.realpath(place)
        inside = (root / package) in (here, *here.parents)
        folders[:] = sorted(name for name in folders if not name.startswith(".") and real not in seen and not (
            inside and name == _COMPILED) and here / name != root / _RESULTS)  # fmt: skip
        yield from (here / name for name in names if (here / name).is_file() and real not in seen and
                    (inside or name.endswith(suffixes)))  # fmt: skip
        seen.add(real)


def _others(places: Iterable[Path]) -> str:
    """The name of an owner of one of these files and folders who is another; nothing where all are the user's.

    Who became root by sudo is still himself.
    """
    if not _HAS_OWNERS:
        return ""
    mine = {os.geteuid()} | ({int(os.environ.get("SUDO_UID") or 0)} if not os.geteuid() else set())
    owner = next((owner for place in {*places} if (owner := place.stat().st_uid) not in mine), None)
    if owner is None:
        return ""
    import pwd

    try:
        return pwd.getpwuid(owner).pw_name
    except KeyError:
        return f"user {owner}"


def _are_own(files: Sequence[Path]) -> bool:
    """Whether files and their folders are the user's, and none was brought: an archive keeps the times of its files'
    texts, so that a file from one has an older text than place.
    """
    times = [path.stat() for path in files]
    brought = any(found.st_ctime - found.st_mtime > _BROUGHT_S for found in times)
    return _HAS_OWNERS and not brought and not _others([*files, *(path.parent for path in files)])


def place() -> Path:
    """The file of what the user agreed to, in his folder of settings."""
    known = {"win32": "~/AppData/Roaming", "darwin": "~/Library/Application Support"}.get(sys.platform, "~/.config")
    wished = os.environ.get("APPDATA" if sys.platform == "win32" else "XDG_CONFIG_HOME") or known
    base = wished if os.path.isabs(wished) else os.path.expanduser(known)  # noqa: PTH111, PTH117 - it never raises
    return Path(base, DISTRIBUTION, "trusted.jsonl")


def _rows() -> list[dict[str, str]]:
    """What was agreed to: folder and content, or "" for the folder whatever it holds; none where others may write."""
    try:
        found = place().stat()
        if _HAS_OWNERS and (found.st_uid != os.geteuid() or found.st_mode & _OTHERS):
            return []
        return [json.loads(line) for line in (disk.read(place(), disk.TEXT) or b"").splitlines()]
    except (OSError, ValueError):
        return []


def _keep(rows: list[dict[str, str]]) -> None:
    """Write what was agreed to; where that cannot be, it holds for this command."""
    try:
        disk.write(place(), [json.dumps(row).encode() + b"\n" for row in rows])
    except OSError as error:
        print(f"note: {place()}: cannot be written ({error.strerror}), so this will be asked again", file=sys.stderr)
