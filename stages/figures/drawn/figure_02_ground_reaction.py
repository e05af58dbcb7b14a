"""Figure 2: ground reaction of one foot from its heel strike to its toe-off."""

from __future__ import annotations

from dataclasses import dataclass

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from stages.biped.accuracy.scales import scales_of
from stages.biped.walk import Walk
from stages.drawing import style
from stages.figures.entry import Entry, Given

LEG = 1


@dataclass(frozen=True)
class Contact:
    """Ground reaction of one foot over one contact: time since its heel strike (n,) [s], force (n, 2) [N]."""

    time: np.ndarray
    force: np.ndarray


#: The impact as it is shown, in pendulum times from heel strike.
IMPACT = -0.005, 0.065


def contact(walk: Walk, leg: int, which: int) -> Contact:
    """The `which`-th whole contact of a leg, from its heel strike to its toe-off, counted from 0 (-1 is the last)."""
    strikes = walk.heel_strike_time[walk.heel_strike_leg == leg]
    lifts = walk.toe_off_time[walk.toe_off_leg == leg]
    whole = [(start, lifts[lifts > start][0]) for start in strikes if (lifts > start).any()]
    start, end = whole[which]
    # the penalty model touches and leaves a little earlier and later than its events: a margin shows the zeros
    inside = (walk.time >= start - 0.01) & (walk.time <= end + 0.02)
    return Contact(walk.time[inside] - start, walk.ground_reaction[inside, leg])


def draw(given: Given) -> Figure:
    """Normal and friction force of both models over one contact; a second row shows the impact at its own scale."""
    ours, theirs = contact(given.analytic.walk, LEG, 0), contact(given.multibody.walk, LEG, -1)
    time = scales_of(given.parameters.biped, given.parameters.slope.gravity).time
    figure, axes = plt.subplots(2, 2, figsize=(style.TWO_COLUMNS, 3.9), width_ratios=(2, 1))
    for row, (column, name) in enumerate(((1, "normal force $F_N$ [N]"), (0, "friction force $F_T$ [N]"))):
        whole, impact = axes[row]
        for part, milliseconds in ((whole, False), (impact, True)):
            scale = 1e3 if milliseconds else 1.0
            for shown, look in (
                (ours, {"color": style.ANALYTIC, "label": "constraint model", "zorder": 3}),
                (theirs, {"color": style.MULTIBODY, "label": "penalty contact (Exudyn)", "linewidth": 0.9}),
            ):
                part.plot(scale * shown.time, shown.force[:, column], **look)
        contact_phase = ours.force[ours.time > 0.02, column]
        low, high = contact_phase.min(), contact_phase.max()
        margin = 0.6 * (high - low)
        whole.set(ylim=(min(low - margin, 0 - 0.1 * margin), high + margin), ylabel=name)
        impact.set_xlim(*(1e3 * time * end for end in IMPACT))
    style.panel_labels(axes.T.ravel())
    axes[0, 0].legend(loc="lower center")
    axes[1, 0].set_xlabel("time since heel strike [s]")
    axes[1, 1].set_xlabel("time since heel strike [ms]")
    axes[0, 1].text(0.97, 0.95, "impact, full scale", transform=axes[0, 1].transAxes, ha="right", va="top", fontsize=7)
    return figure


def caption(given: Given) -> str:
    gait, cycle = given.analytic.gait, given.multibody.cycle
    return (
        "Ground reaction of one foot from heel strike to toe-off. Penalty contact peaks at "
        f"{cycle.peak_normal_force:.0f} N with {1e6 * cycle.largest_penetration:.0f} µm of penetration; the constraint "
        f"model has an impulse instead. Both feet are down for {1e3 * gait.double_stance_s:.2f} ms a step with "
        f"constraints and {1e3 * cycle.double_stance_s:.2f} ms with penalty contact."
    )


FIGURE = Entry(
    "Figure 2: ground reaction", 2, ("analytic", "multibody"), draw, caption,
    claims=("rolling_without_slip",),
)  # fmt: skip
