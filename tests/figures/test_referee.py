"""Figures of the study, of questions and of the package as a referee reads them."""

from __future__ import annotations

import csv
import dataclasses
import json
from types import SimpleNamespace

import matplotlib.pyplot as plt
import numpy as np
import pytest

from benchmarks import tradeoff
from benchmarks.extremes_table import DOCS
from stages.extremes.result import Result as Extremes
from stages.figures.drawn import at_level, figure, given_to, work_and_extremes
from tests.figures import question_pictures
from tests.figures.made_up_results import comparison, drawn, parameters, results
from tests.figures.referee import complaints
from tests.figures.test_golden import PICTURES

pytestmark = pytest.mark.usefixtures("drawing")


def all_extremes():
    """The map of extremes that is kept in the docs."""
    with open(DOCS / "extremes.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    columns = {name: tuple(row[name] for row in rows) for name in rows[0]}
    none = np.full(len(rows), np.nan)
    columns |= {"value": np.array([float(value) for value in columns["value"]]), "error": none, "audit": none}
    return work_and_extremes.draw_extremes(SimpleNamespace(extremes=Extremes("full", **columns)))


def all_prices():
    """Work and precision of every model, as it is kept in the docs."""
    result, times = tradeoff.as_result(json.loads(tradeoff.KEPT.read_text(encoding="utf-8")))
    return work_and_extremes.work_and_precision(result, times, "time of a step [yardsticks]")


def without_bandwidth():
    """Figure 16 with sensors of unknown bandwidth."""
    measured = dataclasses.replace(comparison("measured").measurement, bandwidth=float("nan"))
    return drawn("figure_16_measurement", comparison=SimpleNamespace(measurement=measured))


def at_draft():
    """A figure that says how accurate its study is."""
    given = given_to("error_budget_bars", parameters("draft"), results())
    return at_level(figure("error_budget_bars").draw(given), "draft")


LARGE = {"extremes, all": all_extremes, "tradeoff, all": all_prices, "figure 16, no bandwidth": without_bandwidth,
         "at draft": at_draft}  # fmt: skip


@pytest.mark.parametrize("name", PICTURES)
def test_a_figure_passes_a_referee(name):
    assert complaints(drawn(name), phone=True) == []


@pytest.mark.parametrize("name", [*question_pictures.PICTURES, *LARGE])
def test_a_picture_of_a_question_and_a_large_one_pass_a_referee(name):
    assert complaints((question_pictures.PICTURES | LARGE)[name]()) == []


def test_enough_figures_are_refereed():
    assert len(PICTURES) + len(question_pictures.PICTURES) + len(LARGE) >= 40


def test_a_referee_sees_what_is_wrong():
    picture, (good, empty) = plt.subplots(2, 1, figsize=(3.0, 3.0))
    good.plot([0, 1], [0, 1])
    good.set(xlabel="time [s]", ylabel="speed")
    empty.plot([0, 1], [5, 6])
    empty.set(xlabel="time [s]", ylabel="speed [m/s]", ylim=(0, 1))
    good.text(0.4, 0.5, "one above")
    good.text(0.42, 0.5, "the other", fontsize=6)
    good.text(0.9, 0.2, "words that go on to the right of the picture", in_layout=False)
    said = complaints(picture)
    for words in ("'one above' overlaps 'the other'", "leaves the picture", "'the other' has 6 points",
                  "'speed' has no unit along y", "'speed [m/s]' shows nothing"):
        assert any(words in one for one in said), said
    assert len(said) == 5, said


@pytest.mark.parametrize("width, readable", [(3.5, True), (3.9, False)])
def test_a_referee_has_a_phone(width, readable):
    _, axes = plt.subplots(figsize=(width, 3.0))
    axes.set(xlabel="x [m]", ylabel="y [m]")
    axes.plot([0, 1], [0, 1])
    said = [] if readable else ["the smallest letter has 6.7 points on a phone"]
    assert complaints(axes.figure, phone=True) == said


@pytest.mark.parametrize("apart, count", [(0.15, 0), (0.02, 1)])
def test_turned_texts_overlap_only_where_they_meet(apart, count):
    _, axes = plt.subplots(figsize=(3.0, 3.0))
    axes.set(xlabel="x [m]", ylabel="y [m]")
    axes.plot([0, 1], [0, 1])
    for shift in (0.0, apart):
        axes.text(0.2 + shift, 0.2, "a long turned text", rotation=60)
    assert len(complaints(axes.figure)) == count
