"""The one list of what every program needs, whatever it computes: what confined processes may read, and what a stage
may without its being an input.
"""

from __future__ import annotations

import mimetypes
import os
import sys
import sysconfig
from pathlib import Path

from pipeline.home import DISTRIBUTION, engine

#: Of whoever reads one file: system libraries, time zones, what tells the processor, and devices that hold nothing.
SYSTEM = (
    "/lib", "/lib64", "/usr/lib", "/usr/lib64", "/usr/local/lib", "/nix/store", "/etc/ld.so.cache", "/etc/localtime",
    "/usr/share/zoneinfo", "/proc/cpuinfo", "/proc/meminfo", "/proc/stat", "/proc/self", "/sys/devices/system",
    "/dev/null", "/dev/zero", "/dev/urandom", "/dev/random", *map(str, mimetypes.knownfiles),
)  # fmt: skip
#: Of stages as well, unless it lies in the study: programs, names of users, fonts, limits; no other process.
STAGES = (
    *SYSTEM,
    "/bin", "/sbin", "/usr", "/opt", "/nix", "/proc/sys", "/sys/fs/cgroup", "/sys/kernel/mm", "/etc/fonts",
    "/etc/passwd", "/etc/group", "/etc/nsswitch.conf", "/etc/os-release", "/etc/ld.so.conf", "/etc/ld.so.conf.d",
    "/etc/alternatives", "/var/cache/fontconfig", "~/.fonts", "~/.local/share/fonts", "~/.cache/fontconfig",
    "~/.cache/matplotlib", "~/.config/matplotlib", "~/.matplotlib", "/System",
    "/Library", "~/Library/Fonts", "~/Library/Caches",
    "~/AppData", os.environ.get("SYSTEMROOT", "/usr"),
)  # fmt: skip
#: Variables that name folders of libraries, wherever these lie.
_NAMED = ("MPLCONFIGDIR", "PYTHONPYCACHEPREFIX", "LOCALAPPDATA")
#: Where processes that are forked share locks.
SHARED = "/dev/shm"


def of_python() -> set[Path]:
    """Folders with Python and its packages."""
    path = {Path(part) for part in sys.path if part.endswith("-packages") or Path(part, "numpy").is_dir()}
    return {Path(sys.prefix), Path(sys.base_prefix), *path}


def of_stages(*homes: Path | str) -> list[Path]:
    """Folders with this program, packages wherever they lie but not above `homes`, and what libraries keep."""
    named = (os.environ[name] for name in _NAMED if os.environ.get(name))
    own = Path(os.environ.get("XDG_CACHE_HOME") or "~/.cache", "matplotlib").expanduser()
    packages = [Path(part) for part in (*sys.path, *sysconfig.get_paths().values()) if part
                and not any(Path(home).is_relative_to(part) for home in (engine(), *homes))]  # fmt: skip
    about = engine() / f"{DISTRIBUTION}.egg-info"  # of an unpacked release, which who looks for plug-ins reads
    return [*of_python(), *packages, engine() / "pipeline", about, machine_code(), own, *map(Path, named)]


def of_code(place: Path, package: str) -> list[Path]:
    """A package of stages in `place`, and the branch that this is on, by which users of machine code are told apart."""
    return [place / package, place / ".git" / "HEAD"]


def machine_code() -> Path:
    """The folder in which stages leave machine code: they say the same."""
    if os.environ.get("NUMBA_CACHE_DIR"):
        return Path(os.environ["NUMBA_CACHE_DIR"]).absolute() / DISTRIBUTION
    wished = Path(os.environ.get("XDG_CACHE_HOME") or "~/.cache")
    return (wished if wished.is_absolute() else Path("~/.cache")).expanduser() / DISTRIBUTION / "machine_code"
