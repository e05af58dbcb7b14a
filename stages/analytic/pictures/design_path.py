"""How a design search went: the largest multiplier by iteration, and by how much each parameter changed."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from stages.analytic.gait.design_search import DesignSearch
from stages.drawing import style


def draw(search: DesignSearch, names: Sequence[str]) -> Figure:
    """Progress on the left; change of the parameters `names` on the right."""
    figure, (progress, changes) = plt.subplots(1, 2, figsize=(style.TWO_COLUMNS, 2.8))
    progress.plot(range(len(search.history)), search.history, "o-", color=style.ANALYTIC, markersize=3)
    progress.set_xlabel("accepted step [-]")
    progress.set_ylabel("largest multiplier,\nwith the price of missed targets [-]")
    start = np.array([search.start.design.value(name) for name in names])
    best = np.array([search.best.design.value(name) for name in names])
    changes.barh(range(len(names)), 100 * (best / start - 1), color=style.MULTIBODY)
    changes.set_yticks(range(len(names)), [name.partition(".")[2].replace("_", " ") for name in names])
    changes.axvline(0, color="#555555", linewidth=0.6)
    changes.set_xlabel("change [%]")
    return figure
