"""Whether there are compiled packages for this machine: `python -m pipeline.wheels`, before anything is installed.

Of all that the study needs Exudyn asks the most: the wheels of the pinned version are for Linux with glibc 2.27 on
x86_64 and aarch64, for macOS 11 on both kinds of Mac, and for Windows on x86_64, each for Python 3.10 to 3.14 (and one
more, for 3.15 on Windows alone). Needs Python alone.
"""

import platform
import sys

_GLIBC = (2, 27)
_MACOS = 11
_PYTHONS = ((3, 10), (3, 14))
_MACHINES = {"linux": ("x86_64", "aarch64"), "win32": ("AMD64",), "darwin": ("arm64", "x86_64")}


def missing() -> str:
    """Why no wheel fits this machine, a sentence, or nothing."""
    known, (library, version) = _MACHINES.get(sys.platform, ()), platform.libc_ver()
    macos = platform.mac_ver()[0]
    least, most = (".".join(map(str, python)) for python in _PYTHONS)
    linux = sys.platform == "linux"
    reasons = (
        (not known, f"there is no Exudyn for {sys.platform}: only for Linux, macOS and Windows"),
        (platform.machine() not in known,
         f"there is no Exudyn for {platform.system()} on {platform.machine()}: only on {' and '.join(known)}"),
        (not _PYTHONS[0] <= sys.version_info[:2] <= _PYTHONS[1],
         f"there is no Exudyn for Python {platform.python_version()}: only for {least} to {most}"),
        (sys.platform == "darwin" and int(macos.split(".")[0] or _MACOS) < _MACOS,
         f"this is macOS {macos}, and Exudyn needs {_MACOS} or newer"),
        (linux and library != "glibc",
         "there is no Exudyn for Linux without glibc, such as Alpine: take a Debian, Ubuntu or Fedora image"),
        (linux and library == "glibc" and tuple(int(part) for part in version.split(".")[:2]) < _GLIBC,
         f"this system has glibc {version}, and Exudyn needs {'.'.join(map(str, _GLIBC))} or newer"),
    )  # fmt: skip
    return next((sentence for holds, sentence in reasons if holds), "")


if __name__ == "__main__":
    sys.exit(missing() or 0)
