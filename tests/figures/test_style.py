"""A figure whose ticks are found once is the figure that Matplotlib draws by itself."""

from contextlib import nullcontext

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axis import Axis

from stages.drawing import style


def drawn(monkeypatch, plainly):
    """A figure with shared and logarithmic axes, one of equal scales, and tick labels of several widths."""
    if plainly:
        monkeypatch.setattr(style, "places_once", nullcontext)
    with style.drawing():
        figure, axes = plt.subplots(2, 2, figsize=(4, 3), sharex="col")
        axes[0, 0].plot([0.0, 1.0], [0.0, 12345.678])
        axes[1, 0].semilogy([0.0, 1.0], [1e-7, 1e3], label="line")
        axes[0, 1].plot([1.0, 2.0], [-3.0, 0.5])
        axes[0, 1].set_aspect("equal", adjustable="datalim")
        axes[1, 1].loglog([1.0, 3.0], [2.0, 9.0])
        style.round_ticks(axes[1, 1].xaxis)
        axes[1, 0].legend()
        style.panel_label(axes[0, 0], "a")
        return style.pictures("it", figure, 100)


def test_ticks_that_are_found_once_are_those_of_each_place(monkeypatch):
    before = Axis._update_ticks
    once = drawn(monkeypatch, False)
    assert Axis._update_ticks is before
    assert once == drawn(monkeypatch, True)
    assert {*once} == {"figures/it.csv", "figures/it.png", "figures/it.pdf"}


def test_ticks_are_found_anew_where_the_axis_has_moved():
    with style.drawing(), style.places_once():
        figure, axes = plt.subplots(figsize=(4, 3))
        wide = [tick.get_loc() for tick in axes.xaxis._update_ticks()]
        axes.set_xlim(0.0, 0.01)
        near = [tick.get_loc() for tick in axes.xaxis._update_ticks()]
        assert max(wide) > 0.5 > 0.02 > max(near)
        axes.set_position([0.1, 0.1, 0.05, 0.8])
        assert 1 <= len(axes.xaxis._update_ticks()) < len(near)
        plt.close(figure)
    assert np.isfinite(wide).all()
