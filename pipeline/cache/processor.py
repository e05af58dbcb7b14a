"""What of the processor decides last bits, and can be decided for it.

OpenBLAS has other kernels for each kind of processor, and they round differently: of 95 numerical fields of an analytic
result 15 differ between its kernels for SkylakeX and Haswell, by rounding errors. So all workers are told to take those
of one kind, where the processor has what they need. What is left is the mathematical library of the system and NumPy's
own choice of vector instructions: between machines, results are the same within rounding errors, not bit by bit.
"""

from __future__ import annotations

import contextlib
import os
import platform
import sys
from functools import lru_cache
from pathlib import Path

VARIABLE = "OPENBLAS_CORETYPE"
_KERNELS = {"x86_64": "Haswell", "AMD64": "Haswell", "aarch64": "ARMV8"}
_AVX2_ON_WINDOWS = 40


def settings() -> dict[str, str]:
    """Environment of processes that compute. What the user chose himself stays."""
    kernels = os.environ.get(VARIABLE) or _chosen()
    return {VARIABLE: kernels} if kernels else {}


def words() -> str:
    """Whose kernels are taken, for people: OpenBLAS Haswell."""
    kernels = settings().get(VARIABLE)
    return f"OpenBLAS {kernels}" if kernels else "OpenBLAS as the processor has it, if it is used at all"


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
        flags = next((line for line in _described() if line.startswith("flags")), "").split()
        return "avx2" in flags and "fma" in flags
    return False


def _described() -> list[str]:
    return Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace").splitlines()
