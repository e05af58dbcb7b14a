"""How the gait answers to each parameter: elasticities of its measures, a panel each."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from stages.analytic.derivatives.gait import VariedGait
from stages.analytic.derivatives.multipliers import MultiplierDerivatives, shown
from stages.drawing import style

TITLES = {"step_frequency_hz": "step frequency", "step_length_m": "step length", "speed_m_s": "speed"}
#: So many multipliers have a panel.
PANELS = 2


def draw(gait: VariedGait, multipliers: MultiplierDerivatives) -> Figure:
    """Bars to the right: the measure grows with the parameter. Parameters that are zero have no elasticities."""
    rows = np.flatnonzero(gait.changes.values)
    names = [gait.changes.names[row].partition(".")[2].removesuffix("_deg").replace("_", " ") for row in rows]
    shares = gait.elasticities()
    panels = {title: (shares[name], style.ANALYTIC) for name, title in TITLES.items()}
    for value, values in list(zip(multipliers.values, multipliers.elasticities(), strict=True))[:PANELS]:
        panels[f"|multiplier {shown(complex(round(value.real, 3), round(value.imag, 3)))}|"] = values, style.MULTIBODY
    figure, axes = plt.subplots(
        1, len(panels), figsize=(style.TWO_COLUMNS, 0.6 + 0.24 * max(len(rows), 4)), sharey=True, squeeze=False)
    for panel, (title, (values, colour)) in zip(axes[0], panels.items(), strict=True):
        shown_values = np.nan_to_num(np.asarray(values)[rows])
        panel.barh(range(len(rows)), shown_values, color=colour, height=0.7)
        panel.axvline(0, color="#555555", linewidth=0.6)
        panel.set_title(title)
        limit = 1.1 * max(float(np.abs(shown_values).max(initial=0.0)), 0.1)
        panel.set_xlim(-limit, limit)
        panel.grid(axis="y", visible=False)
    axes[0, 0].set_yticks(range(len(rows)), names)
    axes[0, 0].invert_yaxis()
    figure.supxlabel("elasticity: change in % for 1 % of the parameter [-]", fontsize=8)
    return figure
