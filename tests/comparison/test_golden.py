"""Every figure against a golden picture, and against itself: drawn from made-up results, so that physics may change.

After a wanted change: `python -m pytest tests/comparison/test_golden.py --write-golden`, and look at what it wrote.
"""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import pytest
from made_up_figures import figures

from pipeline.pictures import TOLERANCE, difference, rms
from stages.comparison.figures import style

GOLDEN = Path(__file__).parents[1] / "baseline"
DPI = 80


def pictures(name):
    """A figure's files at a low resolution."""
    with style.drawing():
        return style.pictures(name, figures()[name](), DPI)


@pytest.mark.parametrize("name", figures())
def test_a_figure_is_the_golden_picture_and_has_the_same_bytes_twice(name, tmp_path, request):
    first = pictures(name)
    assert set(first) == {f"figures/{name}.png", f"figures/{name}.pdf"}
    assert pictures(name) == first
    golden, drawn = GOLDEN / f"{name}.png", tmp_path / f"{name}.png"
    drawn.write_bytes(first[f"figures/{name}.png"])
    if request.config.getoption("--write-golden"):
        golden.write_bytes(drawn.read_bytes())
    found = difference(golden, drawn, tmp_path / "differences", TOLERANCE)
    assert not found.fails, f"{found.name} {found.what}; look at {found.picture}"


@pytest.mark.parametrize("name", figures())
def test_a_thousandth_more_in_the_data_is_seen(name, tmp_path):
    drawn = tmp_path / f"{name}.png"
    with style.drawing():
        figure = figures(1.001)[name]()
        figure.savefig(drawn, dpi=DPI)
        plt.close(figure)
    assert rms(GOLDEN / f"{name}.png", drawn) > 3 * TOLERANCE


def test_every_golden_picture_belongs_to_a_figure():
    assert {path.stem for path in GOLDEN.glob("*.png")} == set(figures())
