"""Gaits of one design, how one answers to each parameter, and how searches for a better design went."""

from collections.abc import Mapping, Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from stages.analytic.derivatives.gait import GaitTangents
from stages.analytic.derivatives.multipliers import MultiplierDerivatives, shown
from stages.analytic.design.goals import Goal
from stages.analytic.design.search import DesignSearch
from stages.analytic.gait.poincare import FixedPoint, by_stability
from stages.analytic.model.walker import Walker
from stages.analytic.phases.section import section_state
from stages.analytic.walk.recording import record
from stages.analytic.walk.sampling import sample_walk
from stages.drawing import style

COLOURS, RATE_HZ = (style.ANALYTIC, style.MULTIBODY, style.SECOND, style.THIRD), 2000.0


def draw_gaits(walker: Walker, points: Sequence[FixedPoint], tolerance: float) -> Figure:
    """Phase portrait of a leg, and the ground reaction, over one stride each.

    Full lines are stable gaits, dashed ones unstable; the ground carries one foot at a time but in double stance.
    """
    figure, (portrait, force) = plt.subplots(1, 2, figsize=(style.TWO_COLUMNS, 3.2))
    for number, (point, colour) in enumerate(zip(points, COLOURS * len(points), strict=False), 1):
        largest = by_stability(point)
        line = "-" if largest < 1 else (0, (3, 2))
        start = section_state(point.z, walker.p)
        walk = sample_walk(walker, record(walker, start, 2, tolerance), RATE_HZ)
        label = f"gait {number}: |multiplier| {largest:.3g}"
        portrait.plot(np.degrees(walk.leg_angle[:, 0]), walk.leg_rate[:, 0], color=colour, linestyle=line, label=label)
        force.plot(walk.time, walk.ground_reaction[:, 0, 1], color=colour, linestyle=line)
    portrait.set(xlabel="leg angle, foot ahead positive [°]", ylabel="leg rate [rad/s]")
    force.set(xlabel="time since heel strike [s]", ylabel="normal force on that leg's foot [N]")
    figure.legend(*portrait.get_legend_handles_labels(), loc="outside upper center", ncols=3)
    return figure


TITLES = {"step_frequency_hz": "step frequency", "step_length_m": "step length", "speed_m_s": "speed"}
#: So many multipliers have a panel.
PANELS = 2


def draw_elasticities(gait: GaitTangents, multipliers: MultiplierDerivatives) -> Figure:
    """Elasticities of the gait's measures, a panel each. Bars to the right: the measure grows with the parameter.

    Parameters that are zero have no elasticities.
    """
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
        limit = 1.1 * max(float(np.abs(shown_values).max(initial=0.0)), 0.1)
        panel.set(title=title, xlim=(-limit, limit))
        panel.grid(axis="y", visible=False)
    axes[0, 0].set_yticks(range(len(rows)), names)
    axes[0, 0].invert_yaxis()
    of = "; multipliers are of two steps" if len(gait.point.steps) > 1 else ""
    figure.supxlabel(f"elasticity: change in % for 1 % of the parameter [1]{of}", fontsize=8)
    return figure


def draw_searches(searches: Sequence[DesignSearch], bounds: Mapping[str, tuple[float, float]], goal: Goal) -> Figure:
    """The goal by step on the left, the best start drawn last; on the right the best one's parameters.

    They are 0 at the lower bound, 1 at the upper.
    """
    figure, (progress, places) = plt.subplots(1, 2, figsize=(style.TWO_COLUMNS, 2.8))
    for search in searches[:0:-1]:
        progress.plot(range(len(search.history)), search.history, ".-", color="#bbbbbb", markersize=3)
    best = searches[0]
    steps = range(len(best.history))
    progress.plot(steps, best.history, "o-", color=style.ANALYTIC, markersize=3)
    progress.set(xlabel="step [1]", ylabel=f"{goal.title} [{goal.unit}]")
    low, high = np.array(list(bounds.values())).T
    for name, line in zip(bounds, ((best.path - low) / (high - low)).T, strict=True):
        places.plot(steps, line, ".-", markersize=4, label=name.partition(".")[2].replace("_", " "))
    for bound in (0, 1):
        places.axhline(bound, color="#555555", linewidth=0.6)
    places.set(xlabel="step [1]", ylabel="place between the bounds [1]")
    places.legend()
    return figure
