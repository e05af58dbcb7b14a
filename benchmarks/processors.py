"""Compares the numbers of two results folders, one of which another processor filled, or one that computes like it.

Run: python -m benchmarks.processors RESULTS [OTHER]. Without OTHER the study of the working folder is computed anew as
an older processor would: other kernels of OpenBLAS, no wide vector instructions in NumPy, plain machine code. These are
set for that run alone. `--levels draft paper reference` in place of RESULTS computes both at each of these levels.
`--library` takes sines and powers of the C library (glibc) without fused multiply-add as well, which is what a solver
outside Python feels: its adaptive steps differ then.
Ends with 1 if a number differs by more than is allowed. The nightly workflow calls it; `docs/faults.md` has its table.

Allowed are the error that the file states, or `TOLERANCE` of the largest number in a field, or of its SI unit. What a
stage tells of its own errors (what an iteration left over, how far two solvers differ, orders of convergence,
multipliers fitted to how a walk settles) is made of rounding errors itself, and words are made of numbers: such fields
are listed, their differences are printed, and they stop nothing.
Beside that stands how many numbers differ by more than the numerical error that the file states of them.
"""

import argparse
import fnmatch
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from pipeline.cache.artefact import CLOSER

TOLERANCE = 1e-5
OLDER = {
    "OPENBLAS_CORETYPE": "Prescott",
    "NPY_DISABLE_CPU_FEATURES": "X86_V3 X86_V4 AVX512_ICL",
    "NUMBA_CPU_NAME": "generic",
    "NUMBA_CPU_FEATURES": "",
}
LIBRARY = {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4,-AVX"}
#: Estimates of errors, and what they are made of.
ESTIMATES = {
    "comparison/claims/*causes*": "words of numbers",
    "comparison/claims/measured": "words of numbers",
    "figures/captions/text": "words of numbers",
    "comparison/biped/twin_multiplier": "fitted to how the twin settles",
    "contact_study/limit/*cycle_score": "a score of small differences of cycles",
    "error_budget/*/convergence/*": "an order of convergence from small differences",
    "tradeoff/*/errors/*": "errors of the finest settings",
    "twin_ladder/rungs/*residual": "what the search for a cycle left over where it crawls",
    "twin_ladder/rungs/*inner_outer_difference": "what that search left over",
    "twin_ladder/rungs/*plane_multipliers": "fitted to how the strides settle",
    "twin_ladder/rungs/*solver_steps": "a count of adaptive steps",
    "twin_ladder/rungs/*strides_walked": "strides until that is small enough",
}


@dataclass(frozen=True)
class Difference:
    """A field that differs: how far in parts of its largest number, of what is allowed and of the error that the file
    states (0 where it states none), and whether it is listed.
    """

    name: str
    relative: float
    of_allowed: float
    estimate: bool
    of_stated: float = 0.0


def differences(one: Path, other: Path) -> Iterator[Difference]:
    """Every field of the artefact `one` that is not the same in `other`."""
    with h5py.File(one) as first, h5py.File(other) as second:
        fields, others, stated = _fields(first), _fields(second), _stated(first)
    for name in sorted({*fields, *others}):
        a, b = fields.get(name), others.get(name)
        full = f"{one.stem}/{name}"
        estimate = any(fnmatch.fnmatch(full, pattern) for pattern in ESTIMATES)
        if a is None or b is None or a.shape != b.shape or a.dtype.kind != b.dtype.kind:
            yield Difference(full, np.inf, np.inf, estimate)
        elif a.dtype.kind not in "biuf":
            if not np.array_equal(a, b):
                yield Difference(full, np.inf, np.inf, estimate)
        elif not np.array_equal(a, b, equal_nan=a.dtype.kind == "f"):
            yield _difference(full, a.astype(float), b.astype(float), estimate, stated.get(name, np.inf))


def _difference(name: str, a: Any, b: Any, estimate: bool, stated: float) -> Difference:
    if not np.array_equal(np.isfinite(a), np.isfinite(b)):
        return Difference(name, np.inf, np.inf, estimate)
    finite = np.isfinite(a)
    apart, size = float(np.max(abs(a[finite] - b[finite]))), float(np.max(abs(a[finite])))
    relative = apart / size if size else np.inf
    return Difference(name, relative, apart / (TOLERANCE * max(1.0, size)), estimate, apart / stated)


def _stated(file: h5py.File) -> dict[str, float]:
    """The numerical errors that the file states of its fields."""
    found: dict[str, float] = {}
    file.visititems(lambda name, item: found.update({name: float(item.attrs["numerical_error"])})
                    if "numerical_error" in item.attrs else None)  # fmt: skip
    return found


def _fields(file: h5py.File) -> dict[str, Any]:
    found: dict[str, Any] = {}

    def take(name: str, item: Any) -> None:
        if isinstance(item, h5py.Dataset) and item.shape is not None and not name.startswith(f"{CLOSER}/"):
            found[name] = np.asarray(item[()])

    file.visititems(take)
    return found


def compare(results: Path, other: Path) -> list[Difference]:
    """Print a line for each artefact; the differences beyond what is allowed."""
    beyond: list[Difference] = []
    print("| artefact | fields that differ | largest difference, in parts of the field | beyond what is allowed "
          "| beyond the error that is stated |")  # fmt: skip
    print("|---|---|---|---|---|")
    for path in sorted(results.glob("*.h5")):
        found = list(differences(path, other / path.name))
        plain = [each for each in found if not each.estimate]
        estimates = [each.relative for each in found if each.estimate]
        most = max((one for one in estimates if np.isfinite(one)), default=0.0)
        listed = f" and {len(estimates)} estimates of errors, by up to {most:.1e}" if estimates else ""
        wrong = [each for each in plain if each.of_allowed > 1 and not 0 < each.of_stated <= 1]
        overtold = sorted((each for each in found if each.of_stated > 1), key=lambda each: -each.of_stated)
        named = f": {overtold[0].name.partition('/')[2]} by {overtold[0].of_stated:.1f} times" if overtold else ""
        largest = max((min(each.relative, each.of_allowed * TOLERANCE) for each in plain), default=0.0)
        print(f"| {path.stem} | {len(plain)}{listed} | {largest:.1e} | {len(wrong)} | {len(overtold)}{named} |")
        beyond += wrong
    return beyond


def compute(results: Path, *options: str, **environment: str) -> Path:
    """The study of the working folder, computed into `results` with these variables for it alone."""
    words = [sys.executable, "-m", "pipeline.cli", "run-all", "--results", str(results), *options]
    subprocess.run(words, check=True, stdout=sys.stderr, env={**os.environ, **environment})
    return results


def main() -> None:
    """Compare, computing first the results that are not given."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("results", nargs="*", type=Path)
    parser.add_argument("--levels", nargs="+", default=[])
    parser.add_argument("--library", action="store_true")
    asked = parser.parse_args()
    beyond, older = [], OLDER | (LIBRARY if asked.library else {})
    with tempfile.TemporaryDirectory() as folder:
        if asked.results:
            other = asked.results[1] if asked.results[1:] else compute(Path(folder, "older"), **older)
            beyond = compare(asked.results[0], other)
        for level in asked.levels:
            here = compute(Path(folder, level), "--accuracy", level)
            there = compute(Path(folder, f"{level}-older"), "--accuracy", level, **older)
            print(f"\n{level}:\n")
            beyond += compare(here, there)
    if beyond:
        sys.exit("\n".join(f"{each.name}: {each.of_allowed:.1f} times what is allowed" for each in beyond))


if __name__ == "__main__":
    main()
