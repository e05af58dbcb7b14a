"""A flipped bit in any file of results and cache is never believed, costs no dead end, and is never unexplained."""

from __future__ import annotations

import json
import random

import pytest

from pipeline.cache import durable
from tests.pipeline.flips import Count, Flipped


def flipped(toy, flips, seed):
    study, chance, count = Flipped(toy), random.Random(seed), Count()
    for _ in range(flips):
        study.flip(chance, count)
    print(f"{count.flips} flips, survived {count.survived}, something computed again {count.computed_again}, wrong "
          f"{len(count.wrong)}, lost {len(count.lost)}, without a sentence {len(count.without_a_sentence)}; "
          f"in {dict(count.hit.most_common())}")  # fmt: skip
    assert (count.wrong, count.lost, count.without_a_sentence) == ([], [], [])
    assert count.survived == flips


def test_sixty_flips(done):
    flipped(done, 60, 1)


@pytest.mark.slow
def test_a_thousand_flips(done):
    flipped(done, 1000, 2)


def test_every_flip_of_the_kept_syntax_is_seen(done):
    path = done.root / "results/.cache/syntax.json"
    content, chance = path.read_bytes(), random.Random(3)
    whole = durable.read_sealed(path)
    assert whole
    for _ in range(1000):
        at = chance.randrange(8 * len(content))
        damaged = bytearray(content)
        damaged[at // 8] ^= 1 << at % 8
        path.write_bytes(damaged)
        assert durable.read_sealed(path) in (None, whole)


def test_a_forged_syntax_costs_one_run(done):
    """Its seal is right, so a run goes by it, until a worker reads the code itself: then it is forgotten."""
    path = done.root / "results/.cache/syntax.json"
    body = durable.read_sealed(path)
    body["files"] = {key: ["0" * 64, *imports] for key, (_, *imports) in body["files"].items()}
    durable.write_sealed(path, body)
    with pytest.raises(Exception, match="was edited while it ran"):
        done.run()
    assert set(done.run().values()) == {"current"}


def test_deep_nesting_is_damage(done):
    before = done.results()
    for name in ("syntax.json", "digests.json", "current/fall.json"):
        (done.root / "results/.cache" / name).write_text("[" * 100_000)
    done.run()
    assert done.results() == before
    assert json.loads((done.root / "results/.cache/current/fall.json").read_bytes())["stage"] == "fall"
