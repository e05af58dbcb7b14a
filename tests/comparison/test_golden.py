"""Every figure against a golden picture, and against itself: drawn from made-up results, so that physics may change.

Golden pictures hold for one version of Matplotlib, named in drawn_by.txt, which is edited by hand for another.
After a wanted change: `python -m pytest tests/comparison/test_golden.py --write-golden`, and look at what it wrote.
"""

from __future__ import annotations

from pathlib import Path

import matplotlib
import matplotlib.pyplot as plt
import pytest
from made_up_figures import figures

from pipeline.report.pictures import TOLERANCE, difference, rms
from stages.drawing import style

GOLDEN = Path(__file__).parents[1] / "baseline"
DRAWN_BY = GOLDEN / "drawn_by.txt"
DPI = 80
VERSION = "matplotlib " + ".".join(matplotlib.__version__.split(".")[:2])
#: Matplotlib 3.8 and 3.11 set text so differently that pictures differ by 20 to 35 of 255 rms.
same_version = pytest.mark.skipif(
    DRAWN_BY.read_text().strip() != VERSION, reason=f"golden pictures are of {DRAWN_BY.read_text().strip()}"
)


#: Of every stage's figures one that is drawn quickly; the others are drawn twice by the slow tests.
QUICK = ("figure_04_normal_force", "twin_ladder", "extremes")


def draw(name, scale, path):
    """A figure of the made-up results times a factor, at a low resolution."""
    with style.drawing():
        figure = figures(scale)[name]()
        figure.savefig(path, dpi=DPI)
        plt.close(figure)
    return path


@pytest.mark.parametrize(
    "name", [name if name in QUICK else pytest.param(name, marks=pytest.mark.slow) for name in figures()]
)
def test_a_figure_has_the_same_bytes_twice(name):
    with style.drawing():
        first, second = (style.pictures(name, figures()[name](), DPI) for _ in range(2))
    assert set(first) == {f"figures/{name}.png", f"figures/{name}.pdf"}
    assert second == first


@same_version
@pytest.mark.parametrize("name", figures())
def test_a_figure_is_the_golden_picture(name, tmp_path, request):
    golden, drawn = GOLDEN / f"{name}.png", draw(name, 1.0, tmp_path / f"{name}.png")
    if request.config.getoption("--write-golden"):
        golden.write_bytes(drawn.read_bytes())
    found = difference(golden, drawn, tmp_path / "differences", TOLERANCE)
    assert not found.fails, f"{found.name} {found.what}; look at {found.picture}"


@same_version
@pytest.mark.parametrize("name", figures())
def test_a_thousandth_more_in_the_data_is_seen(name, tmp_path):
    drawn = draw(name, 1.001, tmp_path / f"{name}.png")
    assert rms(GOLDEN / f"{name}.png", drawn) > 3 * TOLERANCE


def test_every_golden_picture_belongs_to_a_figure():
    assert {path.stem for path in GOLDEN.glob("*.png")} == set(figures())
