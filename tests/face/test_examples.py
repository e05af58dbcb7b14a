"""The examples page and the docstrings of the package that people import run as they stand."""

from __future__ import annotations

import doctest
import importlib
import re

import numpy as np
import pytest

import bipedstudy

BLOCK = re.compile(r"```python\n(.*?)```", re.S)


def test_the_examples_page_runs_from_top_to_bottom(repository, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    known: dict[str, object] = {}
    blocks = BLOCK.findall((repository / "docs/examples.md").read_text(encoding="utf-8"))
    assert len(blocks) >= 6
    first = BLOCK.findall((repository / "README.md").read_text(encoding="utf-8"))
    assert len(first) == 1
    for block in [*first, *blocks]:
        exec(compile(block, "docs/examples.md", "exec"), known)
    said = capsys.readouterr().out
    assert known["gait"].stable and "foot_radius = -1 m is not allowed" in said
    assert (tmp_path / "walk.png").stat().st_size > 10_000
    slower = known["frequencies"]
    assert len(set(slower)) == len(slower), "another mass is another gait"


def test_the_docstrings_show_what_is_so():
    done = doctest.testmod(importlib.import_module("bipedstudy.results"))
    assert done.attempted > 10 and done.failed == 0


def test_every_name_that_is_offered_is_there():
    assert all(callable(getattr(bipedstudy, name)) for name in bipedstudy.__all__)
    assert {*dir(bipedstudy)} > {*bipedstudy.__all__} and "ask" in dir(bipedstudy)
    with pytest.raises(AttributeError, match="it has Array, StudyError"):
        bipedstudy.gaits  # noqa: B018


def test_settings_are_texts_or_mappings_of_values():
    given = {"biped.hip_mass": np.float64(0.4), "biped.strike_time": None, "analytic.steps": np.int64(5)}
    one, other = (bipedstudy.parameters("analytic", *settings) for settings in (
        [given], ["biped.hip_mass=0.4", "analytic.steps=5"]))  # fmt: skip
    assert one == other and one.biped.hip_mass == 0.4
    for wrong, words in ((3, "3 is no setting"), ({"biped.hip_mass": -1}, "hip_mass = -1 kg is not allowed")):
        with pytest.raises(bipedstudy.StudyError, match=words):
            bipedstudy.parameters("analytic", wrong)
