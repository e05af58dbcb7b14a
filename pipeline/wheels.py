"""Whether there are compiled packages for this machine: `python -m pipeline.wheels`, before anything is installed.

Of all that the study needs Exudyn asks the most: the wheels of the pinned version are for Linux with glibc 2.27 on
x86_64 and aarch64, for macOS 11 on both kinds of Mac, and for Windows on x86_64, each for Python 3.10 to 3.14 (and one
more, for 3.15 on Windows alone). Needs Python alone.
"""

from __future__ import annotations

import platform
import sys

_GLIBC = (2, 27)
_MACOS = 11
_PYTHONS = ((3, 10), (3, 14))
_MACHINES = {"linux": ("x86_64", "aarch64"), "win32": ("AMD64",), "darwin": ("arm64", "x86_64")}


def missing() -> str:
    """Why no wheel fits this machine, a sentence, or nothing."""
    if sys.platform not in _MACHINES:
        return f"there is no Exudyn for {sys.platform}: only for Linux, macOS and Windows"
    if platform.machine() not in _MACHINES[sys.platform]:
        known = " and ".join(_MACHINES[sys.platform])
        return f"there is no Exudyn for {platform.system()} on {platform.machine()}: only on {known}"
    if not _PYTHONS[0] <= sys.version_info[:2] <= _PYTHONS[1]:
        least, most = (".".join(map(str, python)) for python in _PYTHONS)
        return f"there is no Exudyn for Python {platform.python_version()}: only for {least} to {most}"
    if sys.platform == "darwin" and int(platform.mac_ver()[0].split(".")[0] or _MACOS) < _MACOS:
        return f"this is macOS {platform.mac_ver()[0]}, and Exudyn needs {_MACOS} or newer"
    library, version = platform.libc_ver()
    if sys.platform == "linux" and library != "glibc":
        return "there is no Exudyn for Linux without glibc, such as Alpine: take a Debian, Ubuntu or Fedora image"
    if sys.platform == "linux" and tuple(int(part) for part in version.split(".")[:2]) < _GLIBC:
        return f"this system has glibc {version}, and Exudyn needs {'.'.join(map(str, _GLIBC))} or newer"
    return ""


if __name__ == "__main__":
    sys.exit(missing() or 0)
