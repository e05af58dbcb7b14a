"""The drawing of the biped: all symbols, the design's own lengths, readable on light and dark pages."""

from __future__ import annotations

import dataclasses
import re
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from types import SimpleNamespace

import matplotlib.pyplot as plt
import pytest

from pipeline.parameters.loading import load
from stages.biped.design import Biped
from stages.comparison.parameters import Parameters as Comparison
from stages.drawing import style
from stages.figures.drawn import robot_symbols
from stages.figures.drawn.robot_symbols import DrawnLeg, Page, formula
from stages.figures.parameters import Parameters
from stages.stability.parameters import Parameters as Stability
from tests.figures.test_golden import same_version

ROOT = Path(__file__).parents[2]
COLOUR = re.compile(r"(?:stroke|fill): (#[0-9a-f]{6})")


@pytest.fixture(scope="module")
def picture():
    """The drawing of the study's own parameters."""
    values = load(ROOT / "params", [], {"figures": Parameters}, [Parameters, Comparison, Stability])["figures"]
    with style.drawing():
        return robot_symbols.draw(SimpleNamespace(parameters=values))


def shown(picture):
    """Symbols in the picture, from what Matplotlib notes beside their outlines."""
    return {symbol for words in re.findall("<!-- (.*?) -->", picture) for symbol in re.findall(r"\$[^$]*\$", words)}


def test_every_symbol_of_the_parameters_is_in_the_drawing_and_no_unknown_one(picture):
    symbols = {field.metadata["symbol"] for field in dataclasses.fields(Biped)
               if field.metadata.get("symbol") and field.metadata["unit"] != "s"}  # a time has no place in a drawing
    motion = {formula(symbol) for symbol in ("theta", "psi", "L_1", "L_2", "alpha")} | {"$x$", "$y$", "$g$"}
    assert len(symbols) > 25
    assert shown(picture) == {formula(symbol) for symbol in symbols} | motion


def test_symbols_are_set_as_mathematics():
    assert formula("L_nat_2") == r"$L_{\mathrm{nat},2}$"
    assert formula("tau_h") == r"$\tau_{h}$"
    assert formula("k") == "$k$"


def test_it_is_a_picture_of_its_own_and_has_a_title(picture):
    root = ElementTree.fromstring(picture)
    assert root.tag.endswith("svg") and root.attrib["role"] == "img" and root[0].text == robot_symbols.TITLE
    assert len(picture) < 80_000


def test_every_colour_has_its_place_on_a_dark_page(picture):
    rules, body = picture.split("</style>", 1)
    used = set(COLOUR.findall(body))
    assert {robot_symbols.FIRST.lower(), robot_symbols.OTHER.lower()} < used
    assert used <= set(COLOUR.findall(rules)) == {colour.lower() for colour in robot_symbols.DARK}


def test_words_and_lines_stand_out_from_both_pages():
    """Contrast by WCAG 2: 3 for lines and large signs."""

    def light(colour):
        parts = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
        linear = [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts]
        return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2] + 0.05

    for colour, other in robot_symbols.DARK.items():
        if colour != "#FFFFFF":
            assert light("#FFFFFF") / light(colour) > 3.0
            assert light(other) / light("#121416") > 3.0


def test_a_leg_is_drawn_with_the_designs_lengths():
    figure, axes = plt.subplots()
    leg = DrawnLeg(Page(axes, 0.0), 0.1 + 0.3j, 0.2, 0.333, 0.083, 0.1, "#000000")
    leg.draw()
    x, y = max((line.get_data() for line in axes.lines), key=lambda data: len(data[0]))
    plt.close(figure)
    centre = leg.at(0.0, 0.25)
    assert abs(centre - leg.hip) == pytest.approx(0.25) and centre.real > leg.hip.real
    assert abs(x + 1j * y - centre) == pytest.approx(0.083)
    assert abs(leg.at(0.0, 0.233) - leg.at(0.0, 0.333)) == pytest.approx(0.1)


@same_version
def test_the_picture_of_the_docs_is_that_of_the_parameters(picture):
    assert (ROOT / "docs/robot.svg").read_text() == picture, "make readme"
