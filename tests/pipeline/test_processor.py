"""Kernels of OpenBLAS are pinned for all that is keyed, where the processor has them, and what was taken is said."""

import os
import shutil
import subprocess
import sys

import h5py
import pytest

from benchmarks.processors import OLDER, TOLERANCE, compare, differences
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


# --- Results of another processor: the same numbers within a stated tolerance, and what is further off is named.


def run(repository, results, **environment):
    words = [sys.executable, "-m", "pipeline.cli", "run", "analytic", "--results", str(results)]
    subprocess.run(words, cwd=repository, check=True, capture_output=True, env={**os.environ, **environment})
    return results / "analytic.h5"


@pytest.fixture
def two(done):
    other = done.root / "other"
    shutil.copytree(done.root / "results", other)
    return done.root / "results", other


def test_equal_results_do_not_differ(two, capsys):
    assert compare(*two) == [] and "| fall | 0 | 0.0e+00 | 0 | 0 |" in capsys.readouterr().out


@pytest.mark.parametrize(("change", "beyond"), [(0.5, 0), (2.0, 1)])
def test_a_number_that_moved_is_beyond_what_is_allowed_or_not(two, change, beyond):
    with h5py.File(two[1] / "fall.h5", "a") as file:
        name = next(key for key, item in file.items() if isinstance(item, h5py.Dataset) and item.dtype.kind == "f"
                    and item.shape is not None)  # fmt: skip
        file[name][...] = file[name][()] + change * TOLERANCE * max(1.0, abs(file[name][()]).max())
    (found,) = differences(two[0] / "fall.h5", two[1] / "fall.h5")
    assert found.name == f"fall/{name}" and found.of_allowed == pytest.approx(change, rel=1e-6)
    assert len(compare(*two)) == beyond


def test_a_field_that_is_missing_or_has_another_shape_is_beyond(two):
    with h5py.File(two[1] / "fall.h5", "a") as file:
        del file[next(iter(file))]
    assert compare(*two)


@pytest.mark.slow
def test_another_processor_finds_the_same_gait(repository, tmp_path):
    """Compiles the equations once more, for the other processor."""
    one, other = run(repository, tmp_path / "one"), run(repository, tmp_path / "other", **OLDER)
    found = list(differences(one, other))
    assert not [each for each in found if each.of_allowed > 1]
    said = [artefact.provenance(path.read_bytes(), "")["processor"] for path in (one, other)]
    assert "Prescott" in said[1] and "NUMBA_CPU_NAME=generic" in said[1] and said[0] != said[1]
