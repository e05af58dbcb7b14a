"""The study's look, and the CSV beside a figure: every point of what is drawn."""

import csv
import io
import re

import matplotlib.pyplot as plt
import numpy as np
import pytest
from fontTools.ttLib import TTFont
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.transforms import Bbox
from PIL import Image

from stages.drawing import style
from stages.drawing.style import COLUMNS, as_csv
from tests.figures.made_up_results import shown


def drawn():
    """A figure with shared and logarithmic axes, one of equal scales, and tick labels of several widths."""
    with style.drawing():
        figure, axes = plt.subplots(2, 2, figsize=(4, 3), sharex="col")
        axes[0, 0].plot([0.0, 1.0], [0.0, 12345.678])
        axes[1, 0].semilogy([0.0, 1.0], [1e-7, 1e3], label="line")
        axes[0, 1].plot([1.0, 2.0], [-3.0, 0.5])
        axes[0, 1].set_aspect("equal", adjustable="datalim")
        axes[1, 1].loglog([1.0, 3.0], [2.0, 9.0])
        style.round_ticks(axes[1, 1].xaxis)
        axes[1, 0].legend()
        axes[1, 0].set_xlabel("two\nlines, $10^5$", rotation=10)
        axes[0, 1].get_yticklabels()[-1].set_fontweight("bold")
        axes[1, 0].tick_params(axis="x", length=7, labelcolor="red")
        style.panel_label(axes[0, 0], "a")
        return style.pictures("it", figure, 100)


@pytest.mark.slow
def test_the_last_digits_of_a_layout_are_in_no_picture(monkeypatch):
    before, execute = drawn(), ConstrainedLayoutEngine.execute

    def moved(engine, figure):
        execute(engine, figure)
        for axes in figure.get_axes():
            axes._set_position(Bbox(axes.get_position(original=True).get_points() + 1e-12), which="original")
        for part in figure.subfigs:
            part.bbox_relative.set_points(part.bbox_relative.get_points() + 1e-12)

    monkeypatch.setattr(ConstrainedLayoutEngine, "execute", moved)
    assert drawn() == before


def test_a_font_in_a_pdf_has_what_a_pdf_needs_and_its_text_is_found():
    with style.drawing():
        figure, axes = plt.subplots()
        axes.set_title("Text in a PDF")
        plt.rcParams["pdf.compression"] = 0
        pdf = style.pictures("it", figure, 100)["figures/it.pdf"]
    files = re.findall(rb"/Length1 \d+[^>]*>>\s*stream\r?\n(.*?)\nendstream", pdf, re.DOTALL)
    fonts = [TTFont(io.BytesIO(file)) for file in files]
    assert fonts and all({"glyf", "head", "hhea", "hmtx", "loca", "maxp"} <= {*font.keys()} for font in fonts)
    assert b"/ToUnicode" in pdf and b"/CIDToGIDMap" in pdf


def test_what_is_said_of_a_figure_stands_on_a_strip_above_it_and_moves_nothing():
    def drawn(said: str) -> np.ndarray:
        with style.drawing():
            figure, axes = plt.subplots(figsize=(2.0, 1.0))
            axes.plot([0, 1], [0, 1], label="line")
            figure.legend(loc="outside upper center")
            files = style.pictures("a", figure, 50, pdf=False, said=said)
        return np.asarray(Image.open(io.BytesIO(files["figures/a.png"])).convert("RGB"), dtype=float)

    plain, marked = drawn(""), drawn("not current: twin; make it current with: bipedstudy run twin")
    strip = marked.shape[0] - plain.shape[0]
    assert strip > 10 and marked.shape[1] == plain.shape[1]
    assert np.abs(marked[strip:] - plain).mean() < 2.0, "the figure is what it was"
    assert np.abs(marked[2, 2] - [255, 232, 163]).max() < 8 and marked[:strip].min() < 90, "words on yellow"


# --- The CSV beside a figure: every point of every curve and cloud of points, nothing of drawings.


def rows(figure):
    lines = as_csv(figure).splitlines()
    said = [line for line in lines if line.startswith("# ")]
    return said, list(csv.DictReader(io.StringIO("\n".join(lines[len(said) :]))))


@pytest.mark.parametrize("values", [(0.0, 1e-7), (0.0, 1.1e6), (1e6, 1e6 + 1.0)])
def test_no_power_of_ten_and_no_offset_stands_on_a_panels_letter(values):
    with style.drawing():
        figure, axes = plt.subplots()
        axes.plot(values)
        figure.draw_without_rendering()
        assert axes.yaxis.get_offset_text().get_text() == ""


@pytest.mark.parametrize("height", [1.4, 1.5, 1.52, 1.6, 2.0])
def test_titles_of_panels_with_equal_scales_stay_in_the_picture(height):
    with style.drawing():
        figure, panels = plt.subplots(1, 6, figsize=(style.TWO_COLUMNS, 2.15))
        for axes in panels:
            axes.set(xlim=(0.0, 1.0), ylim=(0.0, height), aspect="equal")
            axes.set_axis_off()
            axes.set_title("step", fontsize=7)
        figure.legend(handles=[plt.Line2D([], [], label="legs")], loc="outside lower center")
        with style.laid_out(figure, 100):
            figure.draw_without_rendering()
            assert panels[0].title.get_window_extent().y1 < 0.995 * figure.bbox.y1


def test_curves_and_points_are_all_there_with_their_labels():
    figure, (axes, other) = plt.subplots(1, 2)
    x = np.linspace(0.0, 1.0, 5)
    axes.plot(x, np.sqrt(x), label="root")
    axes.axhline(0.5, label="level")
    axes.scatter(x[:2], x[:2] ** 2, label="squares")
    axes.set_xlabel("x [m]")
    axes.set_ylabel("y\n[s]")
    style.panel_label(axes, "a")
    other.plot([1.0], [2.0])
    other.set_axis_off()
    axes.set_xlim(0.2, 2.0)
    said, found = rows(figure)
    assert tuple(found[0]) == COLUMNS and {row["panel"] for row in found} == {"a"}
    assert [float(row["y"]) for row in found if row["series"] == "root"] == pytest.approx(np.sqrt(x[1:]), rel=1e-5)
    assert [float(row["y"]) for row in found if row["series"] == "squares"] == [0.0625]
    assert not [row for row in found if row["series"] == "level"], "a level has no points of its own"
    assert said == ["# panel a: x: x [m]; y: y [s]"]


def test_a_map_has_every_cell_and_an_axis_of_words_its_words():
    figure, (axes, other) = plt.subplots(1, 2)
    x, y = np.array([0.0, 1.0, 2.0]), np.array([5.0, 7.0])
    axes.pcolormesh(x, y, np.array([[1.0, np.nan, 2.0], [1.0, 2.0, 2.0]]), shading="nearest", label="steps")
    other.plot([0.5, 0.7], [0, 1], "o", label="right")
    other.set_yticks([0, 1], ["hip\nmass", "slope"])
    _, found = rows(figure)
    cells = {(row["series"], float(row["x"]), float(row["y"])) for row in found if row["panel"] == "1"}
    assert cells == {("steps: 1", 0.0, 5.0), ("steps: 1", 0.0, 7.0), ("steps: 2", 2.0, 5.0), ("steps: 2", 1.0, 7.0),
                     ("steps: 2", 2.0, 7.0)}  # fmt: skip
    assert [row["y"] for row in found if row["panel"] == "2"] == ["hip mass", "slope"]


def test_a_drawing_has_no_numbers():
    assert rows(shown("figure_12_ramp")) == ([], [])


def test_few_colours_are_the_same_picture():
    figure, axes = plt.subplots()
    axes.imshow(np.linspace(0.0, 1.0, 40 * 60).reshape(40, 60), cmap="viridis")
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png")
    whole = Image.open(buffer)
    few = style.in_few_colours(whole)
    one, other = (np.asarray(each.convert("RGB"), dtype=float) for each in (whole, Image.open(io.BytesIO(few))))
    assert one.shape == other.shape and np.sqrt(np.mean((one - other) ** 2)) < 4.0
    assert style.in_few_colours(whole) == few
