"""Results of another processor: the same numbers within a stated tolerance, and what is further off is named."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys

import h5py
import pytest

from benchmarks.processors import OLDER, TOLERANCE, compare, differences
from pipeline.cache import artefact


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
