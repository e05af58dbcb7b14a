"""Captions: every figure has one, its numbers are the results', and what is synthetic is called so."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import yaml
from made_up import DEFAULTS, make_agreement, make_budget, make_study
from made_up_figures import extreme_points, figures, ladder, pushes, ways

from stages.comparison import captions
from stages.comparison.figures import gait_animation
from stages.comparison.hip_motion import HipDifference


def compared(origin="synthetic", frequency=2.0718):
    gait = SimpleNamespace(step_frequency_hz=frequency, step_length_m=0.16, double_stance_s=4e-3)
    cycle = SimpleNamespace(
        step_frequency_hz=2.0, step_length_m=0.161, peak_normal_force=768.0, largest_penetration=3.1e-5,
        double_stance_s=5e-3, speed_m_s=0.33, period_s=0.5,
    )  # fmt: skip
    settling = SimpleNamespace(step_frequency_hz=2.04, step_length_m=0.159, steps_to_settle=1)
    inputs = {
        "analytic": SimpleNamespace(gait=gait),
        "multibody": SimpleNamespace(cycle=cycle),
        "twin": SimpleNamespace(settling=settling),
        "error_budget": make_budget(),
        "contact_study": make_study(hip=2e-3, chosen=2e-4),
        "twin_ladder": ladder(),
        "twin_pushes": pushes(),
        "tradeoff": ways(),
        "extremes": extreme_points(),
    }
    settings = SimpleNamespace(position_limit=3e-4, velocity_limit=5e-3)
    parameters = SimpleNamespace(contact=DEFAULTS, slope=SimpleNamespace(angle=np.radians(2.0)), settings=settings)
    models = SimpleNamespace(same_start=HipDifference(np.array([1.9e-4, 4e-5]), np.array([3.8e-3, 3.9e-3])))
    return captions.Compared(inputs, parameters, models, None, make_agreement(origin))


def texts(known, drawn):
    return {one["name"]: one["text"] for one in yaml.safe_load(captions.as_yaml(known, drawn))["figures"]}


def test_every_figure_that_is_drawn_has_a_caption():
    missing = {*figures(), gait_animation.NAME} - set(captions.CAPTIONS)
    assert not missing, f"add a caption in stages/comparison/captions.py for {missing}"


def test_captions_state_the_numbers_of_the_results():
    found = texts(compared(), list(captions.CAPTIONS))
    assert list(found) == list(captions.CAPTIONS) and all(found.values())
    assert "2.0718 Hz" in found[gait_animation.NAME]
    assert "1.9999 Hz" in texts(compared(frequency=1.9999), list(captions.CAPTIONS))[gait_animation.NAME]
    assert "768 N with 31 µm" in found["figure_02_ground_reaction"]
    assert "0.19 mm in x and 0.04 mm in y" in found["figure_08_hip_motion"]
    assert "2.00 mm" in found["figure_05_contact_parameters"] and "0.20 mm" in found["figure_05_contact_parameters"]


@pytest.mark.parametrize(("origin", "said"), [("synthetic", True), ("mixed", True), ("measured", False)])
def test_what_is_synthetic_is_called_so(origin, said):
    known = replace(compared(origin))
    words = yaml.safe_load(captions.as_yaml(known, ["figure_16_measurement"]))
    assert ("cannot confirm" in words["synthetic"]) == said
    assert ("cannot confirm" in words["figures"][0]["text"]) == said


def test_a_figure_without_a_caption_comes_last_by_its_name():
    words = yaml.safe_load(captions.as_yaml(compared(), ["new_map", "figure_07_snapshots"]))["figures"]
    assert [one["name"] for one in words] == ["figure_07_snapshots", "new_map"]
    assert words[1]["title"] == "new map"
