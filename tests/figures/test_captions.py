"""Captions: every figure has one, its numbers are the results', and what is synthetic is called so."""

from __future__ import annotations

import dataclasses
import math
import re
from types import SimpleNamespace

import matplotlib.pyplot as plt
import pytest
import yaml

from stages.biped import processes
from stages.comparison.claims.judge import STATEMENTS
from stages.comparison.stride import NoEvidence
from stages.comparison.tables import as_yaml
from stages.figures import drawn, run
from stages.figures.drawn import NAMES, figure
from stages.figures.entry import Inputs
from stages.figures.result import Caption
from stages.figures.run import synthetic
from tests.comparison.made_up import make_agreement
from tests.figures.made_up_results import analytic, comparison, given, parameters, results
from tests.figures.made_up_results import drawn as made_up_figure


def text(name, **other):
    return figure(name).caption(given(name, **other))


@pytest.mark.parametrize("name", NAMES)
def test_every_figure_has_a_title_and_a_caption_from_the_results_that_it_names(name):
    assert figure(name).title and isinstance(figure(name).place, int) and text(name).endswith(".")
    assert set(figure(name).inputs) <= {field.name for field in dataclasses.fields(Inputs)}


@pytest.mark.parametrize(("name", "other", "words"), [
    ("gait_animation", {}, ["2.0718 Hz"]),
    ("gait_animation", {"analytic": analytic(frequency=1.9999)}, ["1.9999 Hz"]),
    ("figure_02_ground_reaction", {}, ["768 N with 31 µm"]),
    ("figure_08_hip_motion", {}, ["0.19 mm in x and 0.04 mm in y", "the paper states 0.3 mm and 5 mm/s"]),
    ("figure_05_contact_parameters", {}, ["2.00 mm", "0.20 mm"]),
    ("bifurcation", {}, [
        "known from 1° to 4°; stable ones lie between 1° and 3.333°.",
        "At 3.3333° the cycle of 1 doubles (multiplier -1.000000). At 1.0000° the cycle of 1 turns back",
        "loses its double stance: the cycle of 2 at 3.4°."]),
    ("basin", {}, ["from 42 starts", "14.3 % come within 0.001", "after 1 to 5 steps", "falls forward: 14.3 %",
                   "In 14.3 % the trailing leg"]),
    ("rough_ground", {}, ["of 0.5 mm, where the design makes 60 steps", "Within 25 % it makes more than 300;",
                          "bounds reached: speed, biped.hip_mass lower."]),
    ("bifurcation", {"stability": SimpleNamespace(slope_deg=2.0, families=(), basin=None)},
     ["No gait could be followed."]),
    ("basin", {"stability": SimpleNamespace(slope_deg=2.0, families=(), basin=None)}, ["unstable"]),
])
def test_captions_state_the_numbers_of_the_results(name, other, words):
    said = text(name, **other)
    assert all(each in said for each in words), said
    if "stability" in other:
        plt.close(made_up_figure(name, **other))


def test_without_a_statement_that_applies_the_paper_is_not_named():
    assert "paper" not in text("figure_08_hip_motion", comparison=comparison(verdict="does not apply"))


def test_gaits_of_legs_that_differ_are_counted_in_steps():
    two = dataclasses.replace(given("bifurcation").stability.families[1], cycle=1)
    said = text("bifurcation", stability=SimpleNamespace(slope_deg=2.0, families=(two,), basin=None))
    assert "repeats after two steps, or" in said and "The gait of two steps is known" in said


def test_claims_that_figures_name_are_judged_and_one_figure_opens_the_report_and_one_the_parameters():
    named = {claim for name in NAMES for claim in figure(name).claims}
    assert named <= set(STATEMENTS) and len(named) > 10
    assert [name for name in NAMES if figure(name).opens] == ["robot_in_space"]
    assert [name for name in NAMES if figure(name).beside_parameters] == ["robot_symbols"]


@pytest.mark.parametrize(("origin", "said"), [("synthetic", True), ("mixed", True), ("measured", False)])
def test_what_is_synthetic_is_called_so(origin, said):
    assert ("cannot confirm" in synthetic(make_agreement(origin))) == said
    assert ("cannot confirm" in text("figure_16_measurement", comparison=comparison(origin))) == said


def test_without_a_fit_there_is_the_reason_and_no_picture():
    nothing = {"fits": (), "held_out": (), "followed": (), "failed": (SimpleNamespace(name="run 01", why="it fell"),)}
    empty = {"robots": (), "reasons": ("run 01: it fell",), "summary": lambda: "no run could be fitted"}
    for name in ("calibration_fit", "calibration_held_out", "calibration_followed", "calibrated_robot"):
        with pytest.raises(NoEvidence, match=r"^no run .*; run 01: it fell$"):
            made_up_figure(name, calibration=SimpleNamespace(**nothing), calibrated_twin=SimpleNamespace(**empty))


def test_a_run_that_cannot_be_foretold_is_shown_as_it_is_fitted():
    usual = given("calibration_held_out").calibration
    falls = dataclasses.replace(usual.held_out[0], name="run 03", foretold_force=math.nan)
    for runs, words in (((falls,), "run 03, with outsole, was not fitted: .* fitted to all of it, .* off by 0.020 m"),
                        ((falls, *usual.held_out), "run 02, with outsole, was not fitted: .* those of its first")):
        shown = SimpleNamespace(**vars(usual) | {"held_out": runs})
        assert re.match(words, text("calibration_held_out", calibration=shown))


@pytest.mark.parametrize("unforeseen", [False, True])
def test_a_figure_that_fails_leaves_its_reason_and_the_account_of_what_was_not_foreseen(monkeypatch, unforeseen):
    def draw(*_):
        raise ZeroDivisionError("by\nnought") if unforeseen else NoEvidence("it fell")

    monkeypatch.setattr(run, "draw", draw)
    files, words = run._draw(parameters(), results(), "extremes")
    if unforeseen:
        assert words.startswith("Not drawn: unexpected ZeroDivisionError in test_captions.py:")
        assert words.endswith(": by nought.") and b"Traceback" in files["figures/extremes.log"]
    else:
        assert (files, words) == ({}, "Not drawn: it fell.")
    assert run._caption("rough_ground", words).claims == () != run._caption("rough_ground", "Drawn.").claims


def test_captions_survive_yaml():
    one = Caption("a", 'quotes " and: colons', "µ ≤ 3 # no comment", ("b",), True, False, ("twin",))
    first = {"title": "a title: one", "synthetic": "line\nbreak", "answers": [{"answer": "ä # no comment"}]}
    read = yaml.safe_load(as_yaml("a test", {**first, "figures": [vars(one)]}))
    assert read == {
        **first,
        "figures": [
            {"name": "a", "title": 'quotes " and: colons', "text": "µ ≤ 3 # no comment", "claims": ["b"], "opens": True,
             "beside_parameters": False, "shows": ["twin"]}
        ],
    }


def test_the_stage_draws_all_in_their_places_with_captions_beside(monkeypatch):
    monkeypatch.setattr(run, "NAMES", ("extremes", "figure_04_normal_force", "gait_animation"))
    monkeypatch.setattr(processes.os, "cpu_count", lambda: 1)
    monkeypatch.setattr(run, "answers", lambda inputs: ())
    monkeypatch.setattr(run, "title", lambda parameters: {"title": "a title"})
    said = []
    made = run.run(parameters(), SimpleNamespace(**results()), lambda share, what: said.append(share))
    assert [caption.name for caption in made.captions] == ["gait_animation", "figure_04_normal_force", "extremes"]
    assert yaml.safe_load(made.files["captions.yaml"])["figures"] == [
        vars(caption) | {"claims": list(caption.claims), "shows": list(caption.shows)} for caption in made.captions
    ]
    assert set(made.files) == {
        "captions.yaml", "figures/gait_animation.html",
        *(f"figures/{name}.{kind}" for name in ("figure_04_normal_force", "extremes")
          for kind in ("png", "pdf", "csv")),
    }  # fmt: skip
    assert said[-1] == 1.0


@pytest.mark.parametrize("level", ["draft", "paper"])
@pytest.mark.parametrize("name", ["extremes", "gait_animation"])
def test_a_figure_of_another_accuracy_than_the_usual_says_so(name, level, monkeypatch):
    pictures = []
    monkeypatch.setattr(drawn.style, "pictures", lambda name, figure, *_, **__: pictures.append(figure) or {})
    files, _ = drawn.draw(name, parameters(level), results())
    said = " ".join([content.decode() for content in files.values()]
                    + [text.get_text() for picture in pictures for text in picture.texts])  # fmt: skip
    assert ("accuracy: draft" in said, "accuracy:" in said) == (level == "draft", level == "draft")


def test_that_mark_stands_on_no_label():
    with drawn.style.drawing():
        picture, axes = plt.subplots(figsize=(3.0, 1.5))
        axes.set_xlabel("as wide as the axes are, and some more of it")
        drawn.at_level(picture, "draft")
        with drawn.style.laid_out(picture, 80):
            marks = [text.get_window_extent() for text in (*picture.texts, axes.xaxis.label)]
    plt.close(picture)
    assert not marks[0].overlaps(marks[1])
