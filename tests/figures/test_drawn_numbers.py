"""The CSV beside a figure: every point of every curve and cloud of points, nothing of drawings."""

import csv
import io

import matplotlib.pyplot as plt
import numpy as np
import pytest
from PIL import Image

from stages.drawing import style
from stages.drawing.style import COLUMNS, as_csv
from tests.figures.made_up_results import analytic, shown


def rows(figure):
    plt.close(figure)
    lines = as_csv(figure).splitlines()
    said = [line for line in lines if line.startswith("# ")]
    return said, list(csv.DictReader(io.StringIO("\n".join(lines[len(said) :]))))


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


def test_a_figures_numbers_are_those_of_the_walk():
    _, found = rows(shown("figure_08_hip_motion"))
    walk = analytic().walk
    hip = [float(row["y"]) for row in found if row["panel"] == "a" and row["series"].startswith("constraint")]
    assert hip == pytest.approx(walk.hip_position[: len(hip), 0], rel=1e-5) and len(hip) > 10


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
    plt.close(figure)
    whole = Image.open(buffer)
    few = style.in_few_colours(whole)
    one, other = (np.asarray(each.convert("RGB"), dtype=float) for each in (whole, Image.open(io.BytesIO(few))))
    assert one.shape == other.shape and np.sqrt(np.mean((one - other) ** 2)) < 4.0
    assert style.in_few_colours(whole) == few
