"""The study's look: the same bytes from the same data, fonts in PDFs, words above a figure."""

import io
import re

import matplotlib.pyplot as plt
import numpy as np
from fontTools.ttLib import TTFont
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.transforms import Bbox
from PIL import Image

from stages.drawing import style


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
