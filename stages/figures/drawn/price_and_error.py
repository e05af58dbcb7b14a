"""What a number of the gait costs by each model, and how far it may be from the twin's."""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullLocator

from stages.comparison.stride import NoEvidence
from stages.drawing import style
from stages.figures.entry import Entry, Given
from stages.model_error.measures import MEASURES
from stages.model_error.result import MODELS, PRICES, Result

COLOURS = style.ANALYTIC, style.SECOND, style.MULTIBODY, style.THIRD
MARKERS = "osD^"
#: Measures with a panel: frequency and period have the same share of error.
SHOWN = ("step_frequency", "step_length", "speed", "multiplier")
#: Errors below this are not drawn apart: it is round-off of what is measured.
LEAST = 1e-9


def draw(given: Given) -> Figure:
    """A panel for each measure: price over error, the solver's open, with the model's filled."""
    result = given.model_error
    if not np.isfinite(result.at_the_design[..., 0]).any():
        raise NoEvidence("none of the designs sampled around this one has a gait")
    figure, panels = plt.subplots(1, len(SHOWN), sharey=True, figsize=(style.TWO_COLUMNS, 2.6))
    for axes, name in zip(panels, SHOWN, strict=True):
        place = next(number for number, (measure, _, _) in enumerate(MEASURES) if measure == name)
        panel(axes, result, place)
        axes.set_title(name.replace("_", " "), fontsize=8)
        axes.set_xlabel("error, share of it [1]" if MEASURES[place][2] else "error [1]")
    panels[0].set_ylabel("processor time [s]")
    handles, names = panels[0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside upper center", ncols=4)
    return figure


def panel(axes: Axes, result: Result, measure: int) -> None:
    """One measure; a model's own error is a floor, drawn as a line: no setting of its solver goes below it."""
    axes.set(xscale="log", yscale="log", ylim=(0.5 * PRICES[0], 3.0 * PRICES[-1]), xlim=(LEAST, 2.0))
    for rung, (name, colour, marker) in enumerate(zip(MODELS, COLOURS, MARKERS, strict=True)):
        solver, _, model = result.at_the_design[rung, measure]
        price = PRICES[rung]
        if np.isfinite(solver):
            axes.plot(max(solver, LEAST), price, marker, color=colour, markerfacecolor="none", markersize=4)
        whole = max(solver + model, LEAST)
        if np.isfinite(whole):
            axes.plot(whole, price, marker, color=colour, label=name, markersize=5)
            axes.plot([max(solver, LEAST), whole], [price, price], color=colour, linewidth=0.8)
        else:
            axes.plot([], [], marker, color=colour, label=name, markersize=5)
        axes.axvline(model, color=colour, linewidth=0.8, linestyle=":")
    axes.xaxis.set_major_locator(LogLocator(numticks=4))
    axes.xaxis.set_minor_locator(NullLocator())


def caption(given: Given) -> str:
    return (
        "Price of a gait by each model, and how far its measures may be from the twin's at this design. Open: what the "
        "solver leaves. Filled: with the model's error beside its known bias. Dotted: the model's own part, which "
        "no setting of its solver removes. The command ask takes the cheapest model whose filled mark lies left of the "
        "error that is wanted. "
        f"Learnt at {len(given.model_error.numbers)} designs sampled around this one; prices are those of one computer."
    )


FIGURES = {
    "price_and_error": Entry("What a number costs and how far off it may be", 57, ("model_error",), draw, caption),
}
