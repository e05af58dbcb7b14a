"""Faults of `faults.py`: nothing valid is lost, nothing wrong is called current. `benchmarks/faults.py` does more."""

import contextlib
import os
import random

import pytest

from tests.pipeline import faults

pytestmark = pytest.mark.skipif(os.name != "posix", reason="kills processes and mounts disks")


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    return faults.Scene(tmp_path_factory.mktemp("study"))


def survives(count):
    assert count.told == [] and (count.survived, count.lost, count.wrong) == (count.runs, 0, 0)
    assert count.runs


def test_an_entry_set_aside_by_a_killed_run_is_not_lost(scene):
    """The run is killed between the two renames that replace an entry: the earlier one is found again."""
    count, moments = faults.Count(), 0
    cache = scene.results / ".cache"

    def killed(scene, chance, number):
        nonlocal moments
        variant = faults.killed_before_each_operation(scene, chance, number)
        moments += any(cache.glob("making-*-old"))
        return variant

    number = 8
    while not moments:  # the first rename of an entry is among a run's first operations
        assert number < 20
        faults.suffer(scene, killed, random.Random(1), number, count)
        number += 1
    survives(count)


def test_no_room_for_new_files(scene):
    survives(faults.counted(scene, faults.full_from_each_operation, 2))


@pytest.mark.slow
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
