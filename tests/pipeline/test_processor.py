"""Kernels of OpenBLAS are pinned for all that is keyed, where the processor has them, and what was taken is said."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from pipeline.cache import artefact, processor


@pytest.mark.parametrize(
    ("system", "machine", "flags", "expected"),
    [
        ("linux", "x86_64", "flags : fpu avx avx2 fma", "Haswell"),
        ("linux", "x86_64", "flags : fpu avx", ""),
        ("linux", "aarch64", "", "ARMV8"),
        ("linux", "riscv64", "", ""),
        ("darwin", "arm64", "", ""),
    ],
)
def test_kernels_are_pinned_where_they_run(monkeypatch, system, machine, flags, expected):
    monkeypatch.delenv(processor.VARIABLE, raising=False)
    monkeypatch.setattr(processor.sys, "platform", system)
    monkeypatch.setattr(processor.platform, "machine", lambda: machine)
    monkeypatch.setattr(processor, "_flags", lambda: {*flags.split()})
    processor._chosen.cache_clear()
    try:
        assert processor.settings() == ({processor.VARIABLE: expected} if expected else {})
    finally:
        monkeypatch.undo()
        processor._chosen.cache_clear()


def test_a_choice_of_the_users_own_stays(monkeypatch):
    monkeypatch.setenv(processor.VARIABLE, "Prescott")
    assert processor.settings() == {processor.VARIABLE: "Prescott"}
    assert processor.words().startswith("OpenBLAS Prescott, ")


def test_workers_take_them_and_artefacts_say_so(done):
    wanted = processor.settings().get(processor.VARIABLE, "")
    check = f"assert os.environ.get('OPENBLAS_CORETYPE', '') == {wanted!r}"
    done.edit("PACKAGE/side/run.py", "import random\n", "import os\nimport random\n")
    done.edit("PACKAGE/side/run.py", "    return Result(", f"    {check}\n    return Result(")
    assert done.run(names=("side",)) == {"side": "computed"}
    about = artefact.provenance((done.root / "results/side.h5").read_bytes(), "side")
    assert about["processor"] == processor.words()


def test_the_pinned_kernels_are_the_ones_that_run(monkeypatch):
    """What OpenBLAS itself says it took. It gives some of those that a user may have chosen another name."""
    if not processor._chosen():
        pytest.skip("none are pinned on this machine")
    monkeypatch.setenv(processor.VARIABLE, processor._chosen())
    threadpoolctl = pytest.importorskip("threadpoolctl", reason="asks OpenBLAS")
    assert threadpoolctl
    code = "import numpy, threadpoolctl as t; print({i.get('architecture') for i in t.threadpool_info()})"
    done = subprocess.run([sys.executable, "-c", code], env={**os.environ, **processor.settings()},
                          capture_output=True, text=True, check=True)  # fmt: skip
    assert processor._chosen() in done.stdout
