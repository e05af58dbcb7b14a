"""Damaged logs: an answer or one clear sentence, never a traceback, never a wrong unit, never a changed source."""

import warnings
from pathlib import Path

import numpy as np
import pytest

from stages.imu.sources.opening import SourceRefused
from tests.imu.damage import HARMFUL, NEVER_ACCEPTED, edited, flipped, overwritten_head, truncated
from tests.imu.stand_in import make_database, make_run, result_of

#: So many seeds are drawn by the quick test: two of each damage.
QUICK = 2 * len(HARMFUL)


@pytest.fixture(scope="module")
def sound() -> bytes:
    return make_database([make_run(1, steps=8, rest_s=1.5)])


def ingest(content: bytes, folder: Path) -> str:
    """What the ingest says; fails if it changes the source, warns, or says more than a sentence."""
    path = folder / "log.sqlite"
    path.write_bytes(content)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            said = result_of(path).summary()
    except SourceRefused as refusal:
        said = f"refused: {refusal}"
    assert path.read_bytes() == content
    assert sorted(child.name for child in folder.iterdir()) == ["log.sqlite"]
    assert said.isprintable() and len(said) < 500
    return said


@pytest.mark.parametrize("seeds", [range(QUICK), pytest.param(range(QUICK, 2210), marks=pytest.mark.slow)],
                         ids=["two of each", "two thousand"])  # fmt: skip
def test_a_damaged_log_gives_an_answer_or_one_sentence(seeds: range, sound: bytes, tmp_path: Path) -> None:
    for seed in seeds:
        rng = np.random.default_rng(seed)
        name = [*HARMFUL][seed % len(HARMFUL)]
        content = HARMFUL[name](sound, rng)
        if rng.random() < 0.2 and content.startswith(b"SQLite"):
            content = (truncated, flipped, overwritten_head)[rng.integers(3)](content, rng)
        try:
            ingest(content, tmp_path)
        except Exception as error:
            raise AssertionError(f"{name} with seed {seed}") from error


@pytest.mark.parametrize("damage", NEVER_ACCEPTED)
def test_wrong_units_and_swapped_sensors_are_refused(damage: str, sound: bytes, tmp_path: Path) -> None:
    assert ingest(NEVER_ACCEPTED[damage](sound, np.random.default_rng(0)), tmp_path).startswith("refused")


#: With a number of its own a row from another year reads as a life of the sensor before a restart.
STALE = "UPDATE sample SET packet = 60000, phone_stamp = 5, server_stamp = 5 WHERE sample_id = 10"


@pytest.mark.parametrize("change", [[], [STALE]], ids=["none", "a row from another year"])
def test_a_sound_log_is_accepted_and_a_stale_row_costs_no_run(change: list[str], sound: bytes, tmp_path: Path) -> None:
    assert ingest(edited(sound, *change), tmp_path).startswith("1 synthetic run,")
