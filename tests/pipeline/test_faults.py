"""Faults of `faults.py`: nothing valid is lost, nothing wrong is called current. `benchmarks/faults.py` does more."""

import contextlib
import os

import pytest

from tests.pipeline import faults

pytestmark = [pytest.mark.slow, pytest.mark.skipif(os.name != "posix", reason="kills processes and mounts disks")]


def survives(count):
    assert count.problems == [] and count.survived == count.tried > 0


@pytest.mark.parametrize(
    ("fault", "needs_disk"),
    [(line[0], line[3]) for line in faults.FAULTS],
    ids=[line[0].__name__ for line in faults.FAULTS],
)
def test_many_of_every_fault(fault, needs_disk, tmp_path):
    with contextlib.ExitStack() as stack:
        folder = tmp_path / "study"
        folder.mkdir()
        if needs_disk:
            try:
                stack.enter_context(faults.small_disk(folder))
            except OSError as error:
                pytest.skip(f"no small disk can be mounted: {error}")
        survives(faults.counted(faults.Scene(folder), fault, 20))
