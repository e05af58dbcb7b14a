"""How design searches went: the goal by step from every start, and the best one's parameters within their bounds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from stages.analytic.design.goals import Goal
from stages.analytic.design.search import DesignSearch
from stages.drawing import style


def draw(searches: Sequence[DesignSearch], bounds: Mapping[str, tuple[float, float]], goal: Goal) -> Figure:
    """The goal on the left, the best start drawn last; on the right the parameters, 0 at the lower bound, 1 at the
    upper.
    """
    figure, (progress, places) = plt.subplots(1, 2, figsize=(style.TWO_COLUMNS, 2.8))
    for search in searches[:0:-1]:
        progress.plot(range(len(search.history)), search.history, ".-", color="#bbbbbb", markersize=3)
    best = searches[0]
    steps = range(len(best.history))
    progress.plot(steps, best.history, "o-", color=style.ANALYTIC, markersize=3)
    progress.set_xlabel("step [-]")
    progress.set_ylabel(f"{goal.title} [{'-' if goal.unit == '1' else goal.unit}]")
    low, high = np.array(list(bounds.values())).T
    for name, line in zip(bounds, ((best.path - low) / (high - low)).T, strict=True):
        places.plot(steps, line, ".-", markersize=4, label=name.partition(".")[2].replace("_", " "))
    for bound in (0, 1):
        places.axhline(bound, color="#555555", linewidth=0.6)
    places.set_xlabel("step [-]")
    places.set_ylabel("place between the bounds [-]")
    places.legend(fontsize="x-small")
    return figure
