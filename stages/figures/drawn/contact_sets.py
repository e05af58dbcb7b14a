"""Contact sets and the rigid limit: how far, at what cost, and how much of a distance cancels over one step."""

from __future__ import annotations

from collections.abc import Callable

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stages.contact_study.result import PARTS, Distance, Result, RigidLimit
from stages.drawing import style
from stages.figures.entry import Entry, Given

FAMILY, CHOSEN, DEFAULT, SEARCHED, LIMIT = style.ANALYTIC, style.MULTIBODY, style.TWIN, style.MEASURED, style.SECOND
#: Colours of the parts of a distance.
COLOURS = dict(zip(PARTS, (style.SEQUENCE[2], style.SEQUENCE[1], style.MEASURED)))


def draw(given: Given) -> Figure:
    """Above, distance over one step over cost and stiffness; below, its parts, and distance between cycles."""
    study = given.contact_study
    figure, ((cost, stiffness), (parts, cycles)) = plt.subplots(2, 2, figsize=(style.TWO_COLUMNS, 6.0))
    if study.limit is None or study.candidates is None:
        cost.set_title(study.limit_outcome)
        return figure
    limit = study.limit
    _over(cost, study, limit, lambda one: one.evaluations, study.candidates.evaluations)
    cost.axvline(limit.most_evaluations, color="black", linewidth=0.8, linestyle=":", label="most a choice may cost")
    cost.set_xlabel("cost: evaluations of a step [1]")
    _over(stiffness, study, limit, lambda one: one.law.contact_stiffness, study.candidates.contact_stiffness)
    stiffness.set_xlabel("contact stiffness $k_c$ [N/mm$^e$]")
    style.round_ticks(cost.xaxis)
    for panel in (cost, stiffness):
        panel.set_ylabel("distance of the hip\nover one step [mm]")
    figure.legend(*cost.get_legend_handles_labels(), loc="outside upper center", ncols=3)
    _parts(parts, limit)
    _cycles(cycles, limit)
    style.panel_labels((cost, stiffness, parts, cycles))
    return figure


def distance(one: Distance) -> float:
    """Sizes of the parts of a set's distance over one step, added [mm]."""
    return float(1e3 * one.position_parts.sum())


def _over(
    axes: Axes, study: Result, limit: RigidLimit, abscissa: Callable[[Distance], float], searched: np.ndarray
) -> None:
    """Distances of all sets over `abscissa` of a set; `searched` holds that of the sets searched."""
    assert study.candidates is not None
    axes.plot(
        searched, 1e3 * study.candidates.position_parts.sum(axis=1), ".", color=SEARCHED, markersize=5,
        label="sets of the search",
    )  # fmt: skip
    axes.plot(
        [abscissa(one) for one in limit.family], [distance(one) for one in limit.family], "o-", color=FAMILY,
        markersize=3.5, label="family of the chosen set, towards the limit",
    )  # fmt: skip
    for one, mark, colour, label in (
        (limit.default, "D", DEFAULT, "Adams' defaults"), (limit.chosen, "*", CHOSEN, "chosen set")
    ):  # fmt: skip
        size = 11 if mark == "*" else 5
        axes.plot(abscissa(one), distance(one), mark, color=colour, markersize=size, label=label, zorder=3)
    far = 1e3 * limit.hard.hip_position.max()
    axes.axhline(far, color=LIMIT, linewidth=1.0, linestyle="--", label="the limit itself from rolling feet")
    axes.set(xscale="log", yscale="log")
    style.round_ticks(axes.yaxis)


def _parts(axes: Axes, limit: RigidLimit) -> None:
    """Parts of the distance as bars, one set a bar, and what is left of them when they cancel."""
    second = [one for one in limit.finalists if one.law != limit.chosen.law]
    harder = [(f"family, {share:g}", one) for share, one in zip(limit.family_share, limit.family) if share < 1.0][:1]
    rows = [("chosen set", limit.chosen), *((f"no. {place}", one) for place, one in enumerate(second, 2)), *harder]
    for row, (_, one) in enumerate(rows):
        left = np.concatenate([[0.0], np.cumsum(1e3 * one.position_parts)])
        for part, start, end in zip(PARTS, left, left[1:]):
            label = {"rest": "what is left"}.get(part, part) if row == 0 else None
            axes.barh(row, end - start, left=start, height=0.6, color=COLOURS[part], label=label)
        whole = 1e3 * one.hip_position.max()
        axes.plot([whole] * 2, [row - 0.42, row + 0.42], color="black", linewidth=2.0,
                  label="all at once" if row == 0 else None)  # fmt: skip
    axes.set_yticks(range(len(rows)), [f"{name}\n{_law(one)}" for name, one in rows], fontsize=6.5)
    axes.invert_yaxis()
    axes.set_xlabel("largest difference of the hip over one step [mm]")
    axes.legend(loc="lower right")


def _law(one: Distance) -> str:
    """The numbers of a set in a line: k_c in 1e5 N/mm^e, c_max in N s/mm, d in mm, v_s in mm/s."""
    law = one.law
    numbers = 1e-5 * law.contact_stiffness, 1e-3 * law.contact_damping, 1e3 * law.damping_depth
    return ", ".join(f"{number:.3g}" for number in (*numbers, 1e3 * law.stiction_velocity))


def _cycles(axes: Axes, limit: RigidLimit) -> None:
    """Differences of period and length of the solved cycles over the stiffness."""
    stiffness = [one.law.contact_stiffness for one in limit.family]
    if not np.isfinite([one.period for one in (*limit.family, limit.default, limit.chosen)]).any():
        axes.text(0.5, 0.5, "no set has a cycle", ha="center", transform=axes.transAxes)
        axes.set_axis_off()
        return
    for name, label, line, colour in (
        ("period", "step period [ms]", "o-", FAMILY), ("step_length", "step length [mm]", "s--", style.THIRD)
    ):  # fmt: skip
        sizes = [abs(1e3 * getattr(one, name)) for one in limit.family]
        axes.plot(stiffness, sizes, line, color=colour, markersize=3.5, label=f"{label}, family")
        for one, mark in ((limit.default, "D"), (limit.chosen, "*")):
            size = 11 if mark == "*" else 5
            axes.plot(one.law.contact_stiffness, abs(1e3 * getattr(one, name)), mark, color=colour, markersize=size)
        axes.axhline(abs(1e3 * getattr(limit.hard, name)), color=colour, linewidth=0.8, linestyle=":")
    axes.set(xscale="log", yscale="log")
    style.round_ticks(axes.yaxis)
    axes.set(xlabel="contact stiffness $k_c$ [N/mm$^e$]", ylabel="difference of solved cycles [ms, mm]")
    axes.legend(loc="lower left")


def caption(given: Given) -> str:
    study = given.contact_study
    if study.limit is None:
        return f"No rigid limit: {study.limit_outcome}."
    limit, far = study.limit, study.limit.hard
    last = limit.family[-1]
    return (
        "The limit is the constraint model with Coulomb's transition; the distance adds the sizes of what creep, the "
        "impact's finite stiffness and the rest do over one step, so that they cannot cancel. The limit itself "
        f"differs from rolling feet by {1e3 * far.hip_position.max():.2f} mm over one step and by "
        f"{1e3 * far.period:+.2f} ms and {1e3 * far.step_length:+.2f} mm a step between cycles: no contact parameter "
        f"removes that (dashed and dotted lines). The chosen set is {distance(limit.chosen):.2f} mm away in "
        f"{limit.chosen.evaluations} evaluations ({1e3 * limit.chosen.hip_position.max():.2f} mm where its parts "
        f"cancel), Adams' defaults are {distance(limit.default):.2f} mm in {limit.default.evaluations}, the last of "
        f"the family {distance(last):.2f} mm in {last.evaluations}. The choice counts the hip's velocity and the "
        "cycles too. Numbers of a set: k_c in 1e5 N/mm^e, c_max in N s/mm, d in mm, v_s in mm/s. Stars and diamonds "
        "between cycles: the chosen set and Adams' defaults."
    )


FIGURE = Entry(
    "Contact sets and the rigid limit", 31, ("contact_study",), draw, caption,
    claims=("contact_set", "contact_set_figure_8"),
)  # fmt: skip
