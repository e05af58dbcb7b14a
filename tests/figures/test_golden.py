"""Every figure against a golden picture, and against itself: drawn from made-up results, so that physics may change.

Golden pictures hold for one version of Matplotlib, named in drawn_by.txt, which is edited by hand for another.
For a new figure and after a wanted change: `python -m pytest tests/figures/test_golden.py --write-golden`, and look at
what it wrote.
"""

from __future__ import annotations

from pathlib import Path

import matplotlib
import matplotlib.pyplot as plt
import pytest

from pipeline.report.figures import TOLERANCE, difference, rms
from stages.drawing import style
from stages.figures.drawn import NAMES, figure
from tests.figures.made_up_results import drawn, shown

GOLDEN = Path(__file__).parents[1] / "baseline"
DRAWN_BY = GOLDEN / "drawn_by.txt"
DPI = 80
VERSION = "matplotlib " + ".".join(matplotlib.__version__.split(".")[:2])
#: Matplotlib 3.8 and 3.11 set text so differently that pictures differ by 20 to 35 of 255 rms.
same_version = pytest.mark.skipif(
    DRAWN_BY.read_text().strip() != VERSION, reason=f"golden pictures are of {DRAWN_BY.read_text().strip()}"
)


#: All but the fragments of pages.
PICTURES = [name for name in NAMES if figure(name).draw.__annotations__["return"] == "Figure"]
#: Drawings of the robot, and errors over nine decades: a thousandth more in every number is not seen, a tenth is.
DRAWINGS = (*(f"figure_{name}" for name in (
    "03_simple_model", "09_section", "12_ramp", "13_steps", "14_data_way", "15_sensors")),
    "price_and_error")  # fmt: skip
#: Two figures that are drawn quickly, and a drawing; the others are drawn again by the slow tests.
QUICK = ("figure_03_simple_model", "twin_ladder", "extremes")
DRAWN_AGAIN = [name if name in QUICK else pytest.param(name, marks=pytest.mark.slow) for name in PICTURES]


pytestmark = pytest.mark.usefixtures("drawing")


def draw(name, scale, path):
    """A figure of the made-up results times a factor, at a low resolution."""
    picture = shown(name) if scale == 1.0 else drawn(name, scale)
    with style.laid_out(picture, DPI):
        picture.savefig(path, dpi=DPI)
    plt.close(picture)
    return path


@pytest.mark.parametrize("name", DRAWN_AGAIN)
def test_a_figure_has_the_same_bytes_twice(name):
    first, second = (style.pictures(name, one, DPI) for one in (shown(name), drawn(name)))
    assert set(first) - {f"figures/{name}.csv"} == {f"figures/{name}.png", f"figures/{name}.pdf"}
    assert second == first


@same_version
@pytest.mark.parametrize("name", PICTURES)
def test_a_figure_is_the_golden_picture(name, tmp_path, request):
    golden, now = GOLDEN / f"{name}.png", draw(name, 1.0, tmp_path / f"{name}.png")
    if request.config.getoption("--write-golden"):
        golden.write_bytes(now.read_bytes())
    assert golden.is_file(), "it has no golden picture: --write-golden makes one"
    found = difference(golden, now, tmp_path / "differences", TOLERANCE)
    assert not found.fails, f"{found.name} {found.what}; look at {found.picture}"


@same_version
@pytest.mark.parametrize("name", DRAWN_AGAIN)
def test_a_thousandth_more_in_the_data_is_seen(name, tmp_path):
    changed = draw(name, 1.1 if name in DRAWINGS else 1.001, tmp_path / f"{name}.png")
    assert rms(GOLDEN / f"{name}.png", changed) > 3 * TOLERANCE


def test_every_golden_picture_belongs_to_a_figure():
    assert {path.stem for path in GOLDEN.glob("*.png")} == set(PICTURES)
