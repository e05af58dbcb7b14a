"""Damaged logs: an answer or one clear sentence, never a traceback, never a wrong unit, never a changed source."""

import warnings
from pathlib import Path

import numpy as np
import pytest

from stages.imu.sources.opening import SourceRefused
from tests.imu.damage import HARMFUL, NEVER_ACCEPTED, edited
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


def fuzz(sound: bytes, folder: Path, first: int, last: int) -> None:
    for seed in range(first, last):
        rng = np.random.default_rng(seed)
        damage = HARMFUL[seed % len(HARMFUL)]
        content = damage(sound, rng)
        if rng.random() < 0.2 and content.startswith(b"SQLite"):
            content = HARMFUL[:3][rng.integers(3)](content, rng)
        try:
            ingest(content, folder)
        except Exception as error:
            raise AssertionError(f"{damage.__name__} with seed {seed}") from error


def test_damaged_logs(sound: bytes, tmp_path: Path) -> None:
    fuzz(sound, tmp_path, 0, QUICK)


@pytest.mark.slow
def test_two_thousand_damaged_logs(sound: bytes, tmp_path: Path) -> None:
    fuzz(sound, tmp_path, QUICK, 2210)


@pytest.mark.parametrize("damage", NEVER_ACCEPTED, ids=lambda damage: damage.__name__)
@pytest.mark.parametrize("seed", [0, 1, 11])  # with these each is drawn that a damage may be
def test_wrong_units_and_swapped_sensors_are_refused(damage, seed: int, sound: bytes, tmp_path: Path) -> None:
    said = ingest(damage(sound, np.random.default_rng(seed)), tmp_path)
    assert said.startswith("refused")


def test_a_row_from_another_year_costs_its_sensor_only(sound: bytes, tmp_path: Path) -> None:
    """With a number of its own it reads as a life of the sensor before a restart; all time between would be lost."""
    stale = "UPDATE sample SET packet = 60000, phone_stamp = 5, server_stamp = 5 WHERE sample_id = 10"
    assert ingest(edited(sound, (stale, ())), tmp_path).startswith("1 synthetic run,")


def test_the_sound_log_is_accepted(sound: bytes, tmp_path: Path) -> None:
    assert ingest(sound, tmp_path).startswith("1 synthetic run,")
