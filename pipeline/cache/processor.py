"""What of the processor decides last bits, and can be decided for it.

OpenBLAS has other kernels for each kind of processor, and they round differently: of 95 numerical fields of an analytic
result 15 differ between its kernels for SkylakeX and Haswell, by rounding errors. So all that computes, workers and
commands, notebooks and tests, takes those of one kind, where the processor has what they need, and one thread: matrices
are small here, and threads that wait for each other spin meanwhile. What is left is the mathematical library of the
system and the choice of vector instructions, by NumPy, by that library and in machine code: between machines, results
are the same within rounding errors, not bit by bit. `words` says all of this, so that results can show where bits may
differ.
"""

import contextlib
import os
import platform
import sys
from functools import lru_cache
from pathlib import Path

VARIABLE = "OPENBLAS_CORETYPE"
_KERNELS = {"x86_64": "Haswell", "AMD64": "Haswell", "aarch64": "ARMV8"}
_ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
_AVX2_ON_WINDOWS = 40
_SWITCHES = ("NPY_DISABLE_CPU_FEATURES", "NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES")
_WIDEST = {"avx512f": "AVX-512", "avx2": "AVX2", "avx": "AVX"}  # by the names in /proc/cpuinfo, the widest first


def settings() -> dict[str, str]:
    """Kernels of processes that compute. What the user chose himself stays."""
    kernels = os.environ.get(VARIABLE) or _chosen()
    return {VARIABLE: kernels} if kernels else {}


def environment() -> dict[str, str]:
    """What all that computes finds in its environment."""
    return {**_ONE_THREAD, **settings()}


def take() -> None:
    """Let this process compute in that environment. The libraries read it when they are loaded: call this before."""
    os.environ.update(environment())


def words() -> str:
    """What decides last bits here, for people: OpenBLAS Haswell, x86_64 with AVX-512, glibc 2.36, and what was set."""
    kernels = settings().get(VARIABLE)
    switched = [f"{name}={os.environ[name]}" for name in _SWITCHES if os.environ.get(name)]
    library = " ".join(platform.libc_ver())
    parts = [f"OpenBLAS {kernels or 'as the processor has it'}", _instructions(), library, *switched]
    return ", ".join(part for part in parts if part)


@lru_cache(maxsize=1)
def _chosen() -> str:
    kernels = _KERNELS.get(platform.machine(), "") if sys.platform in ("linux", "win32") else ""
    return kernels if kernels != "Haswell" or _has_avx2() else ""


def _has_avx2() -> bool:
    """Whether kernels for Haswell run here; a processor without these instructions would end the process."""
    with contextlib.suppress(OSError, AttributeError):
        if sys.platform == "win32":
            import ctypes

            return bool(ctypes.windll.kernel32.IsProcessorFeaturePresent(_AVX2_ON_WINDOWS))
        return {"avx2", "fma"} <= _flags()
    return False


def _instructions() -> str:
    """Kind of processor, with the widest vector instructions where the system shows them."""
    found = set[str]()
    with contextlib.suppress(OSError):
        found = _flags()
    widest = next((name for flag, name in _WIDEST.items() if flag in found), "")
    return f"{platform.machine()} with {widest}" if widest else platform.machine()


def _flags() -> set[str]:
    described = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace").splitlines()
    return set(next((line for line in described if line.startswith("flags")), "").split())
