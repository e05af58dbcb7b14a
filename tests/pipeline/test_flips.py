"""A flipped bit in any file of results and cache is never believed, costs no dead end, and is never unexplained."""

import random

import pytest

from pipeline.cache import disk
from tests.pipeline.counts import Count
from tests.pipeline.flips import Flipped


def flipped(toy, flips, seed):
    study, chance, count = Flipped(toy), random.Random(seed), Count()
    for _ in range(flips):
        study.flip(chance, count)
    print(f"{count.tried} flips, survived {count.survived}, problems {count.problems}, {dict(count.hit.most_common())}")
    assert count.problems == [] and count.survived == flips and {*count.hit} == {*study.files(), "computed again"}


@pytest.mark.parametrize(("flips", "seed"), [(18, 1), pytest.param(1000, 2, marks=pytest.mark.slow)])
def test_flips(done, flips, seed):
    flipped(done, flips, seed)


def test_every_flip_of_the_kept_syntax_is_seen(done):
    path = done.kept_syntax()
    content, chance = path.read_bytes(), random.Random(3)
    whole = disk.read_sealed(path)
    assert whole
    for _ in range(200):
        at = chance.randrange(8 * len(content))
        damaged = bytearray(content)
        damaged[at // 8] ^= 1 << at % 8
        path.write_bytes(damaged)
        assert disk.read_sealed(path) in (None, whole)
