"""What the difference between the two models is made of, and what of it no contact set removes."""

from collections.abc import Callable
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stages.biped.quantity import mm
from stages.comparison.stride import NoEvidence
from stages.contact_study.result import PARTS, Distance, Result as ContactStudy, RigidLimit
from stages.drawing import style
from stages.error_budget.result import (
    CREEP,
    EFFECTS,
    IMPACT,
    INTEGRATION_CONSTRAINT,
    INTEGRATION_PENALTY,
    POSITION,
    SLIP,
    UNEXPLAINED,
    Result,
    Split,
)
from stages.figures.drawn.contact_laws import walked
from stages.figures.entry import Entry, Given

# What the difference between the two models is made of: signed contributions that add up to it.

#: Effects drawn, with colour and line; integration errors are below the width of a line and are left to the caption.
DRAWN = (
    (SLIP, style.SECOND, "-"),
    (CREEP, style.MULTIBODY, "-"),
    (IMPACT, style.ANALYTIC, "-"),
    (UNEXPLAINED, style.MEASURED, "--"),
)
COMPONENTS = (
    ("$x_{hip}$", 0, "[mm]"),
    ("$y_{hip}$", 1, "[mm]"),
    (r"$\dot x_{hip}$", 2, "[mm/s]"),
    (r"$\dot y_{hip}$", 3, "[mm/s]"),
)


def draw_error_budget(given: Given) -> Figure:
    """Left over one step from the same mid-stance state, right between cycles at equal phase; either may be alone."""
    budget = given.error_budget
    if not budget.known():
        raise NoEvidence(budget.outcome)
    sides: list[tuple[np.ndarray, Split, str, str]] = []
    if budget.step is not None:
        label = "time from the common mid-stance state [s]"
        sides.append((budget.step.time, budget.step.split, "one step, same start", label))
    if budget.cycle is not None:
        label = "phase of the stride from heel strike [1]"
        sides.append((budget.cycle.phase, budget.cycle.split, "settled cycles, equal phase", label))
    shape = style.TWO_COLUMNS, 6.6
    figure, axes = plt.subplots(4, len(sides), figsize=shape, sharex="col", squeeze=False)
    for side, (abscissa, split, title, label) in enumerate(sides):
        for row, (name, column, unit) in enumerate(COMPONENTS):
            panel = axes[row, side]
            panel.plot(abscissa, 1e3 * split.total[:, column], color=style.TWIN, linewidth=1.8, label="total")
            for effect, colour, line in DRAWN:
                part = 1e3 * split.part(effect)[:, column]
                panel.plot(abscissa, part, line, color=colour, linewidth=1.0, label=effect.replace("v_s", "$v_s$"))
                least, most = (1e3 * end[:, column] for end in split.interval(effect))
                panel.fill_between(abscissa, least, most, color=colour, alpha=0.3, linewidth=0.0)
            panel.set_ylabel(f"{name} {unit}")
            style.panel_label(panel, "abcdefgh"[len(sides) * row + side])
        axes[0, side].set_title(title)
        axes[-1, side].set_xlabel(label)
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=5)
    return figure


def caption_error_budget(given: Given) -> str:
    return (
        "Penalty model minus constraint model, split into signed contributions that add up to it. Bands show how far a "
        "contribution depends on whether slow sliding (creep) or impact is added first. Integration errors are too "
        f"small to draw. {given.error_budget.summary()}."
    )


# What the difference between the two models is made of, in one look: signed bars that add up to the total.

#: Rows from above: what a reader is shown, the contributions that it adds up, its colour.
ROWS = (
    ("trailing foot slips", (SLIP,), style.SECOND),
    ("feet creep below $v_s$", (CREEP,), style.MULTIBODY),
    ("impact of finite stiffness", (IMPACT,), style.ANALYTIC),
    ("integration", (INTEGRATION_CONSTRAINT, INTEGRATION_PENALTY), style.THIRD),
    ("unexplained", (UNEXPLAINED,), style.MEASURED),
)
#: Bars shorter than this part of the axis get a black line, or they could not be seen.
THIN = 0.004


def along(split: Split) -> np.ndarray:
    """What each contribution has of the rms displacement in both orders, (2, 6) [m]."""
    return np.array([[split.along(part, POSITION) for part in parts] for parts in split.orders])


def measures(budget: Result) -> list[tuple[str, np.ndarray]]:
    """Label of each panel, and the contributions in both orders, (2, 6), in its unit."""
    found = []
    if budget.step is not None:
        split = budget.step.split
        found.append(("one step: hip x at its end [mm]", 1e3 * split.orders[:, :, -1, 0]))
        found.append(("one step: hip, rms [mm]", 1e3 * along(split)))
    if budget.cycle is not None:
        found.append(("cycles: period of a step [ms]", 1e3 * budget.cycle.scalar_orders[:, :, 0]))
        found.append(("cycles: length of a step [mm]", 1e3 * budget.cycle.scalar_orders[:, :, 1]))
        found.append(("cycles: hip, rms over a stride [mm]", 1e3 * along(budget.cycle.split)))
    return found


def draw_error_bars(given: Given) -> Figure:
    """A panel for each measure, with a bar for each effect and one for their sum."""
    shown = measures(given.error_budget)
    if not shown:
        raise NoEvidence(given.error_budget.outcome)
    figure, axes = plt.subplots(len(shown), 1, figsize=(style.ONE_COLUMN, 0.3 + 1.3 * len(shown)), squeeze=False)
    for panel, (label, ways), letter in zip(axes[:, 0], shown, "abcde"):
        bars(panel, ways)
        style.panel_label(panel, letter)
        panel.set_xlabel(label)
    return figure


def bars(panel: Axes, ways: np.ndarray) -> None:
    """Means of both orders with their intervals; `ways` (2, 6). The values stand in a column beside the bars."""
    values = [ways[:, [EFFECTS.index(name) for name in names]].sum(axis=1) for _, names, _ in ROWS]
    values.append(ways.sum(axis=1))
    low, high = min(0.0, *map(np.min, values)), max(0.0, *map(np.max, values))
    span = max(high - low, 1e-12)
    panel.set_xlim(low - 0.05 * span, high + 0.05 * span)
    panel.axvline(0.0, color=style.TWIN, linewidth=0.6)
    colours = [colour for *_, colour in ROWS] + [style.TWIN]
    for row, (both, colour) in enumerate(zip(values, colours)):
        mean, half = float(both.mean()), 0.5 * float(np.ptp(both))
        panel.barh(row, mean, height=0.66, color=colour)
        if abs(mean) < THIN * span:
            panel.plot([mean, mean], [row - 0.33, row + 0.33], color=style.TWIN, linewidth=0.8)
        words = f"{mean:+.3f}".replace("-", "\u2212") if abs(mean) >= 5e-4 else "  0.000"
        if half >= 5e-4:
            panel.errorbar(mean, row, xerr=half, color=style.TWIN, linewidth=0.8, capsize=2.0)
            words += f" \u00b1 {half:.3f}"
        panel.text(1.02, row, words, va="center", ha="left", fontsize=7, transform=panel.get_yaxis_transform())
    panel.set_yticks(range(len(values)), [*(name for name, *_ in ROWS), "total"], fontsize=7)
    panel.get_yticklabels()[-1].set_fontweight("bold")
    panel.set_ylim(len(values) - 0.5, -0.5)
    panel.tick_params(axis="y", length=0)
    panel.grid(axis="y", visible=False)


def caption_error_bars(given: Given) -> str:
    said = [
        f"Over {name} the hips differ by {1e3 * split.rms(split.total, POSITION):.3g} mm rms, of which "
        f"{1e3 * split.rms(split.part(UNEXPLAINED), POSITION):.2g} mm rms are left"
        for name, split in ((name, budget.split) for name, budget in given.error_budget.known())
    ]
    return (
        "Penalty model minus constraint model. Bars add up to the total; of an rms each effect has its part along the "
        "whole difference. Slow sliding (creep) and impact affect each other: bars are the mean of both orders in "
        f"which they can be added, whiskers reach to each. {'. '.join(said)}."
    )


# Contact sets and the rigid limit: how far, at what cost, and how much of a distance cancels over one step.

FAMILY, CHOSEN, DEFAULT, SEARCHED, LIMIT = style.ANALYTIC, style.MULTIBODY, style.TWIN, style.MEASURED, style.SECOND
#: Colours of the parts of a distance.
COLOURS = dict(zip(PARTS, (style.SEQUENCE[2], style.SEQUENCE[1], style.MEASURED)))


def draw_contact_sets(given: Given) -> Figure:
    """Above, distance over one step over cost and stiffness; below, its parts, and distance between cycles."""
    study = walked(given.contact_study)
    figure = plt.figure(figsize=(style.TWO_COLUMNS, 6.6))
    places: Any = [["cost", "stiffness"]] * 2 + [["parts", "period"], ["parts", "length"]]
    panels = figure.subplot_mosaic(places, width_ratios=(1.0, 1.1))
    cost, stiffness, parts = (panels[name] for name in ("cost", "stiffness", "parts"))
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
    _parts(parts, limit, best(study))
    _cycles(panels["period"], limit, "period", "difference of\nperiods [ms]")
    _cycles(panels["length"], limit, "step_length", "difference of\nlengths [mm]")
    panels["period"].sharex(panels["length"])
    panels["period"].tick_params(labelbottom=False)
    panels["length"].set_xlabel("contact stiffness $k_c$ [N/mm$^e$]")
    style.panel_labels(panels.values())
    return figure


def distance(one: Distance) -> float:
    """Sizes of the parts of a set's distance over one step, added [m]."""
    return float(one.position_parts.sum())


def best(study: ContactStudy) -> str:
    """What the best set of the search is: the chosen one, where a set was chosen."""
    return "best set tried" if study.undecided else "chosen set"


def _over(
    axes: Axes, study: ContactStudy, limit: RigidLimit, abscissa: Callable[[Distance], float], searched: np.ndarray
) -> None:
    """Distances of all sets over `abscissa` of a set; `searched` holds that of the sets searched."""
    assert study.candidates is not None
    axes.plot(
        searched, 1e3 * study.candidates.position_parts.sum(axis=1), ".", color=SEARCHED, markersize=5,
        label="sets of the search",
    )  # fmt: skip
    axes.plot(
        [abscissa(one) for one in limit.family], [1e3 * distance(one) for one in limit.family], "o-", color=FAMILY,
        markersize=3.5, label=f"family of the {best(study)}, towards the limit",
    )  # fmt: skip
    for one, mark, colour, label in (
        (limit.default, "D", DEFAULT, "starting set"), (limit.chosen, "*", CHOSEN, best(study))
    ):  # fmt: skip
        size = 11 if mark == "*" else 5
        axes.plot(abscissa(one), 1e3 * distance(one), mark, color=colour, markersize=size, label=label, zorder=3)
    far = 1e3 * limit.hard.hip_position.max()
    if far > 0.0:
        axes.axhline(far, color=LIMIT, linewidth=1.0, linestyle="--", label="the limit itself from rolling feet")
    axes.set(xscale="log", yscale="log")
    style.round_ticks(axes.yaxis)


def _parts(axes: Axes, limit: RigidLimit, first: str) -> None:
    """Parts of the distance as bars, one set a bar, and what is left of them when they cancel; `first` is the best."""
    second = [one for one in limit.finalists if one.law != limit.chosen.law]
    harder = [(f"family, {share:g}", one) for share, one in zip(limit.family_share, limit.family) if share < 1.0][:1]
    rows = [(first, limit.chosen), *((f"no. {place}", one) for place, one in enumerate(second, 2)), *harder]
    for row, (_, one) in enumerate(rows):
        left = np.concatenate([[0.0], np.cumsum(1e3 * one.position_parts)])
        for part, start, end in zip(PARTS, left, left[1:]):
            label = {"rest": "what is left"}.get(part, part) if row == 0 else None
            axes.barh(row, end - start, left=start, height=0.6, color=COLOURS[part], label=label)
        whole = 1e3 * one.hip_position.max()
        axes.plot([whole] * 2, [row - 0.42, row + 0.42], color="black", linewidth=2.0,
                  label="all at once" if row == 0 else None)  # fmt: skip
    axes.set_yticks(range(len(rows)), [f"{name}\n{_law(one)}" for name, one in rows])
    axes.set_ylim(len(rows) + 0.7, -0.5)  # below the bars is room for the legend
    axes.set_title("below names: $k_c$ [$10^5$ N/mm$^e$], $c_{max}$ [N s/mm],\n$d$ [mm], $v_s$ [mm/s]", fontsize=7)
    axes.set_xlabel("largest difference of the hip\nover one step [mm]")
    axes.legend(loc="lower right")


def _law(one: Distance) -> str:
    """The numbers of a set in a line: k_c in 1e5 N/mm^e, c_max in N s/mm, d in mm, v_s in mm/s."""
    law = one.law
    numbers = 1e-5 * law.contact_stiffness, 1e-3 * law.contact_damping, 1e3 * law.damping_depth
    return ", ".join(f"{number:.3g}" for number in (*numbers, 1e3 * law.stiction_velocity))


def _cycles(axes: Axes, limit: RigidLimit, name: str, label: str) -> None:
    """Differences of a measure of the solved cycles over the stiffness; looks are those of the panels above."""
    if not np.isfinite([one.period for one in (*limit.family, limit.default, limit.chosen)]).any():
        axes.text(0.5, 0.5, "no set has a cycle", ha="center", transform=axes.transAxes)
        axes.set_axis_off()
        return
    stiffness = [one.law.contact_stiffness for one in limit.family]
    axes.plot(stiffness, [abs(1e3 * getattr(one, name)) for one in limit.family], "o-", color=FAMILY, markersize=3.5)
    for one, mark, colour, size in ((limit.default, "D", DEFAULT, 5), (limit.chosen, "*", CHOSEN, 11)):
        axes.plot(one.law.contact_stiffness, abs(1e3 * getattr(one, name)), mark, color=colour, markersize=size)
    if far := abs(1e3 * getattr(limit.hard, name)):
        axes.axhline(far, color=LIMIT, linewidth=1.0, linestyle="--")
    axes.set(xscale="log", yscale="log", ylabel=label)
    style.round_ticks(axes.yaxis)


def caption_contact_sets(given: Given) -> str:
    study = given.contact_study
    if study.limit is None:
        return f"No rigid limit: {study.limit_outcome}."
    limit, far = study.limit, study.limit.hard
    last = limit.family[-1]
    own = (
        f"differs from rolling feet by {mm(far.hip_position.max())} over one step and by "
        f"{1e3 * far.period:+.3g} ms and {1e3 * far.step_length:+.3g} mm a step between cycles: no contact parameter "
        "removes that (dashed)"
    ) if far.hip_position.any() else "is the walk of rolling feet"
    return (
        "The limit is the constraint model with Coulomb's transition; the distance adds the sizes of what creep, the "
        "impact's finite stiffness and the rest do over one step, so that they cannot cancel. The limit itself "
        f"{own}. {f'No set was chosen ({study.undecided}). ' * bool(study.undecided)}"
        f"The {best(study)} is {mm(distance(limit.chosen))} away in "
        f"{limit.chosen.evaluations} evaluations ({mm(limit.chosen.hip_position.max())} where its parts "
        f"cancel), the starting set is {mm(distance(limit.default))} in {limit.default.evaluations}, the last of "
        f"the family {mm(distance(last))} in {last.evaluations}. The choice counts the hip's velocity and the "
        "cycles too."
    )


FIGURES = {
    "error_budget": Entry(
        "Error budget",
        30,
        ("error_budget",),
        draw_error_budget,
        caption_error_budget,
        claims=("hip_displacement", "hip_velocity", "integration_tolerance"),
    ),
    "error_budget_bars": Entry(
        "What the difference is made of",
        29,
        ("error_budget",),
        draw_error_bars,
        caption_error_bars,
        claims=("hip_displacement", "integration_tolerance"),
    ),
    "contact_sets": Entry(
        "Contact sets and the rigid limit",
        31,
        ("contact_study",),
        draw_contact_sets,
        caption_contact_sets,
        claims=("contact_set", "contact_set_figure_8"),
    ),
}
