"""Families of gaits over a parameter, and the basin of attraction of a gait."""

from collections.abc import Sequence
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from stages.analytic.result import BACK, FORWARD, NO_START, OTHERWISE, REACHES, STILL, WALKS_ON, Basin, RecordedFamily
from stages.biped.quantity import count_of
from stages.drawing import style

COLOURS = (style.ANALYTIC, style.MULTIBODY, style.SECOND, style.THIRD, style.TWIN)
MARKS = {"turning point": "s", "period doubling": "D", "torus": "^"}
UNSTABLE = (0, (2, 2))
#: Multipliers smaller than this all along a family are not drawn.
NONE = 1e-3


def draw_families(families: Sequence[RecordedFamily], label: str, here: float | None = None) -> Figure:
    """Duration of every step, and multipliers, one colour a cycle; marks are where families turn or double.

    Full lines are stable gaits, dashed ones unstable. `label` is that of the parameter, `here` the design's own value.
    """
    figure, (forks, multipliers) = plt.subplots(2, 1, figsize=(style.ONE_COLUMN, 4.6), sharex=True)
    cycles = sorted({family.steps for family in families})
    for family in families:
        colour = COLOURS[cycles.index(family.steps) % len(COLOURS)]
        for column in family.step_duration.T:
            _curve(forks, family, column, colour)
        for turn in family.turns:
            at = np.full(turn.step_duration.size, turn.value)
            forks.plot(at, turn.step_duration, MARKS[turn.kind], color=colour, markersize=4.5, label="_turn")
            multipliers.plot(turn.value, turn.multiplier, MARKS[turn.kind], color=colour, markersize=4.5, label="_turn")
        # sorted by their real parts they are continuous along the family
        ordered = np.sort(family.floquet_multipliers[..., 0], axis=1)
        for column in ordered.T[np.abs(ordered).max(axis=0) > NONE]:
            _curve(multipliers, family, column, colour)
    for axes in (forks, multipliers):
        if here is not None:
            axes.axvline(here, color="#777777", linewidth=0.8, linestyle=":")
    for limit in (-1.0, 1.0):
        multipliers.axhline(limit, color="black", linewidth=0.8)
    forks.set_ylabel("duration of a step [s]")
    multipliers.set(ylim=(-1.9, 1.4), ylabel="multipliers, real part [1]", xlabel=label)
    beyond = style.mark_beyond(multipliers)
    for axes, letter in ((forks, "a"), (multipliers, "b")):
        style.panel_label(axes, letter)
    _legend(figure, families, cycles, here is not None, beyond)
    return figure


def _curve(axes: Axes, family: RecordedFamily, column: np.ndarray, colour: str) -> None:
    """A curve whose stable stretches are full; the piece between a stable and an unstable gait is of both."""
    stable = family.stable
    beside = stable.copy()
    beside[1:] |= stable[:-1]
    beside[:-1] |= stable[1:]
    name, unstable = f"cycle of {family.steps}", np.where(stable, np.nan, column)
    axes.plot(family.value, unstable, color=colour, linestyle=UNSTABLE, label=f"{name}, unstable")
    axes.plot(family.value, np.where(beside, column, np.nan), color=colour, label=f"{name}, stable")


def _legend(
    figure: Figure, families: Sequence[RecordedFamily], cycles: Sequence[int], here: bool, beyond: bool
) -> None:
    looks: list[tuple[str, dict[str, Any]]] = [
        (f"cycle of {count_of(cycle, 'step')}", {"color": COLOURS[number % len(COLOURS)]})
        for number, cycle in enumerate(cycles)
    ]
    looks.append(("unstable", {"color": "#555555", "linestyle": UNSTABLE}))
    looks += [(kind, {"color": "#555555", "marker": MARKS[kind], "linestyle": "none", "markersize": 4.5})
              for kind in sorted({turn.kind for family in families for turn in family.turns})]  # fmt: skip
    if here:
        looks.append(("the design", {"color": "#777777", "linestyle": ":", "linewidth": 0.8}))
    handles = [Line2D([], [], label=name, **look) for name, look in looks]
    figure.legend(handles=handles + [style.wedge("#555555", "v")] * beyond, loc="outside upper center", ncols=2)


#: Light to dark in grey as well, so that kinds of ending are distinguished in print.
LOOKS = {FORWARD: "#C9C9C9", BACK: "#8E8E8E", STILL: "#5E5E5E", OTHERWISE: "#2B2B2B", WALKS_ON: style.MULTIBODY,
         NO_START: "#FFFFFF"}  # fmt: skip


def draw_basin(basin: Basin) -> Figure:
    """Basin over stance angle and stance rate just after heel strike.

    Starts that reach the gait by the number of their steps, in colour; others by how they end, in greys.
    """
    figure, axes = plt.subplots(figsize=(style.ONE_COLUMN, 3.6))
    angles, rates = np.degrees(basin.stance_angle), basin.stance_rate
    order = [number for number in LOOKS if (basin.ending == number).any()]

    def steps_of(number: int) -> np.ndarray:
        return np.where(basin.ending == number, basin.steps, np.nan).T

    for number in order:
        axes.pcolormesh(
            angles, rates, steps_of(number), cmap=ListedColormap([LOOKS[number]]), shading="nearest", rasterized=True,
            label=f"{basin.endings[number]}, steps",
        )  # fmt: skip
    caught = steps_of(REACHES)
    few, most = (int(end) for end in (np.nanmin(caught), np.nanmax(caught))) if basin.share else (0, 1)
    limits = np.arange(few, most + 2) - 0.5
    colours = plt.get_cmap("viridis_r", len(limits) - 1)
    shades = axes.pcolormesh(
        angles, rates, caught, cmap=colours, norm=BoundaryNorm(limits, colours.N), shading="nearest",
        rasterized=True, label=f"{basin.endings[REACHES]}, steps",
    )  # fmt: skip
    gait = axes.plot(np.degrees(basin.gait_angle), basin.gait_rate, "o", color="white", markeredgecolor="black",
                     label="the gait")  # fmt: skip
    axes.set(xlabel="stance angle at heel strike [°]", ylabel="stance rate after heel strike [rad/s]")
    handles = [*gait,
               *(Patch(facecolor=LOOKS[number], edgecolor="#555555", linewidth=0.4, label=basin.endings[number])
                 for number in order)]  # fmt: skip
    figure.legend(handles=handles, loc="outside upper center", ncols=2)
    bar = figure.colorbar(shades, label="steps until it reaches the gait [1]")
    whole = MaxNLocator(6, integer=True, min_n_ticks=1).tick_values(few, most)
    bar.set_ticks([tick for tick in whole if few <= tick <= most])
    bar.minorticks_off()
    axes.grid(visible=False)
    return figure
