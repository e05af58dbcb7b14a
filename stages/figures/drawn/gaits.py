"""What becomes of disturbances and of gaits: multipliers, basin, slopes, the ladder to the twin, pushes."""

import textwrap
from collections.abc import Sequence

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stages.analytic.pictures import families
from stages.analytic.result import NO_START, REACHES, RecordedFamily, Turn
from stages.drawing import style
from stages.figures.entry import Entry, Given
from stages.twin_ladder.result import Result, RungGait

# What a step leaves of a disturbance in each model, and how the gait answers to its parameters.

#: Multipliers smaller than this are taken for zero.
NONE = 1e-6
#: After what a gait repeats: two steps where the legs differ.
STEPS = {1: "one step", 2: "two steps"}
MEASURES = (("period", style.MULTIBODY), ("step_length", style.SECOND), ("speed", style.ANALYTIC))


def multipliers(given: Given) -> list[tuple[str, np.ndarray, str, str]]:
    """Model, its multipliers (k, 2) [1], and colour and marker."""
    found = [
        ("constraint model", given.analytic.gait.floquet_multipliers, style.ANALYTIC, "o"),
        ("penalty contact", given.multibody.cycle.floquet_multipliers, style.MULTIBODY, "s"),
    ]
    twin = given.twin_ladder.twin if given.twin_ladder else None
    if twin is not None:
        plane = "twin, in the plane" + ", limping" * twin.limps
        found.append((plane, twin.plane_multipliers, style.TWIN, "^"))
        found.append(("twin, across it", twin.side_multipliers, style.MEASURED, "v"))
    return [(name, values[np.hypot(*values.T) > NONE], *look) for name, values, *look in found if len(values)]


def draw_multipliers(given: Given) -> Figure:
    """The unit circle with the multipliers of a gait, and bars for the elasticities."""
    figure, (circle, bars) = plt.subplots(1, 2, figsize=(style.TWO_COLUMNS, 3.0), width_ratios=(1.15, 1.0))
    turn, far = np.linspace(0.0, 2.0 * np.pi, 181), 1.1
    circle.plot(np.cos(turn), np.sin(turn), color="black", linewidth=0.8, label="limit of stability")
    for name, values, colour, mark in multipliers(given):
        circle.plot(values[:, 0], values[:, 1], mark, color=colour, markersize=4.5, markerfacecolor="none", label=name)
        far = max(far, 1.1 * float(np.abs(values[:, 1]).max(initial=0.0)))
    circle.set(
        aspect="equal",
        xlabel="real part [1]",
        ylabel="imaginary part [1]",
        ylim=(-far, 1.5 * far),
        yticks=(-1.0, -0.5, 0.0, 0.5, 1.0),
    )
    circle.legend(loc="upper center", ncols=2, columnspacing=1.0, handlelength=1.2)
    elasticities(bars, given)
    style.panel_labels((circle, bars))
    return figure


def elasticities(axes: Axes, given: Given) -> None:
    """Elasticities of the constraint model's gait, a group of bars for each parameter that is not zero."""
    rows = [row for row in given.analytic.elasticities if row.value]
    places = np.arange(len(rows))
    for number, (measure, colour) in enumerate(MEASURES):
        values = [getattr(row, measure) for row in rows]
        axes.barh(places + 0.26 * (number - 1), values, height=0.24, color=colour, label=measure.replace("_", " "))
    axes.axvline(0.0, color="black", linewidth=0.6)
    axes.set_yticks(places, [row.parameter.partition(".")[2].removesuffix("_deg").replace("_", " ") for row in rows])
    axes.invert_yaxis()
    axes.grid(axis="y", visible=False)
    axes.set_xlabel("change for 1 % of the parameter [%]")
    axes.legend(loc="best")


def caption_multipliers(given: Given) -> str:
    largest = [(name, float(np.hypot(*values.T).max())) for name, values, *_ in multipliers(given)
               if len(values) and not name.endswith("across it")]  # fmt: skip
    listed = ", ".join(f"{value:.3f} ({name})" for name, value in largest)
    of = STEPS[given.analytic.gait.steps]
    text = f"Floquet multipliers of {of}; the largest: {listed}. Inside the circle a disturbance dies out."
    rows = [row for row in given.analytic.elasticities if row.value]
    if not rows:
        return text
    most = max(rows, key=lambda row: abs(row.speed))
    return (
        f"{text} Elasticities of the constraint model are exact derivatives; its speed answers most to "
        f"{most.parameter}, by {most.speed:+.2f} % for 1 %."
    )


# The basin of attraction of the gait, over angle and rate of the stance leg.


def draw_basin(given: Given) -> Figure:
    """The picture that `bipedstudy basin` draws; of an unstable gait none."""
    if given.stability.basin is not None:
        return families.draw_basin(given.stability.basin)
    figure, axes = plt.subplots(figsize=(style.TWO_COLUMNS, 1.0))
    axes.set_axis_off()
    axes.text(0.5, 0.5, "the gait is unstable: it has no basin", ha="center")
    return figure


def caption_basin(given: Given) -> str:
    basin = given.stability.basin
    if basin is None:
        return "The gait is unstable; no start stays with it."
    share = {number: 100 * float((basin.ending == number).mean()) for number in range(len(basin.endings))}
    others = ", ".join(f"{words} {share[number]:.1f} %" for number, words in enumerate(basin.endings)
                       if share[number] and number not in (REACHES, NO_START))  # fmt: skip
    steps = basin.steps[basin.ending == REACHES]
    return "".join((
        f"Walks of the constraint model from {basin.ending.size} starts just after heel strike: angle and rate of the "
        f"stance leg as on the axes, all else as in the gait. {share[REACHES]:.1f} % come within {basin.near:g} of it "
        f"in all coordinates of the section",
        f", after {steps.min()} to {steps.max()} steps, half of them after {np.median(steps):.0f}"
        if steps.size else "",
        f"; others: {others}." if others else ".",
        f" In {share[NO_START]:.1f} % the trailing leg, as long as in the gait, reaches no ground." if share[NO_START]
        else ""))


# The gait over the slope: where its period doubles, and what its multipliers do there.


def draw_bifurcation(given: Given) -> Figure:
    """The picture that `bipedstudy continue` draws."""
    return families.draw_families(given.stability.families, "slope [°]", given.stability.slope_deg)


def caption_bifurcation(given: Given) -> str:
    families = given.stability.families
    first = families[0].steps if families else 1
    text = (
        "Gaits of the constraint model over the slope: (a) duration of each step of a gait, which repeats after "
        f"{STEPS[first]}, or after more where the period has doubled; (b) their multipliers."
    )
    if not families:
        return f"{text} No gait could be followed."
    gone = [f"the cycle of {family.steps} at {value:.3g}°" for family in families
            for value in without_double_stance(family)]  # fmt: skip
    kinks = [f"Multipliers have a kink where a step loses its double stance: {', '.join(gone)}."] if gone else []
    turns = (label(family, turn) for family in families for turn in family.turns)
    return " ".join([text, stretches(families[0]), *turns, *kinks])


def without_double_stance(family: RecordedFamily) -> list[float]:
    """The slopes about which a step of the cycle begins to have no double stance, each between two gaits [deg], in the
    order of the family: where it has turned back, others have the same slopes."""
    gone = family.double_stance.min(axis=1) == 0.0
    changes = np.flatnonzero(gone[1:] != gone[:-1])
    found: list[float] = (0.5 * (family.value[changes] + family.value[changes + 1])).tolist()
    return found


def stretches(family: RecordedFamily) -> str:
    """Over which slopes gaits of one step are known, and stable, in words."""
    order = np.argsort(family.value, kind="stable")
    stable = family.value[order][family.stable[order]]
    known = f"The gait of {STEPS[family.steps]} is known from {family.value.min():.3g}° to {family.value.max():.3g}°"
    if not stable.size:
        return f"{known} and nowhere stable."
    turns = [turn.value for turn in family.turns]
    low = max((value for value in turns if value <= stable.min()), default=stable.min())
    high = min((value for value in turns if value >= stable.max()), default=stable.max())
    between = family.value[~family.stable]
    others = ", unstable ones too" * bool(((between > stable.min()) & (between < stable.max())).any())
    return f"{known}; stable ones lie between {low:.4g}° and {high:.4g}°{others}."


def label(family: RecordedFamily, turn: Turn) -> str:
    """A turn in words."""
    what = {
        "period doubling": f"the cycle of {family.steps} doubles",
        "turning point": f"the cycle of {family.steps} turns back",
        "torus": f"a pair of multipliers of the cycle of {family.steps} leaves the unit circle",
    }[turn.kind]
    return f"At {turn.value:.4f}° {what} (multiplier {turn.multiplier:.6f})."


# From the simple model to the twin: what each detail adds to a step's period and length, and to its multipliers.

SIMPLE = "constraint model"
SLOWER, QUICKER = style.MULTIBODY, style.ANALYTIC
#: Bars shorter than this part of the axis get a black line, or they could not be seen.
THIN = 0.004
#: Where the wedges stand, from the row before: below the bar, beside which its change is written.
BELOW = 1.38


def draw_ladder(given: Given) -> Figure:
    """Waterfalls of period and step length, and the largest multipliers of each rung."""
    ladder = given.twin_ladder
    rungs = [rung for rung in ladder.rungs if rung.found]
    figure, panels = plt.subplots(1, 3, figsize=(style.TWO_COLUMNS, 3.4), sharey=True, width_ratios=(1.1, 1.1, 1.0))
    changes = ladder.changes()
    waterfall(panels[0], 1e3 * ladder.simple_period_s, [1e3 * change for _, change, _ in changes])
    waterfall(panels[1], 1e3 * ladder.simple_step_length_m, [1e3 * change for *_, change in changes])
    rung_multipliers(panels[2], rungs)
    same_machine(panels, ladder)
    names = [SIMPLE, *(rung.name + (" = the twin" if rung.is_twin else "") for rung in rungs)]
    panels[0].set_yticks(range(len(names)), [textwrap.fill(name, 22) for name in names])
    panels[0].set_ylim(len(names) - 0.4, -0.6)
    of = STEPS[2] if ladder.steps == 2 else "a step"
    labels = "period of a step [ms]", "length of a step [mm]", f"multipliers of {of} [1]"
    for axes, label in zip(panels, labels, strict=True):
        axes.set_xlabel(label)
    style.panel_labels(panels)
    figure.legend(*panels[2].get_legend_handles_labels(), loc="outside upper center", ncols=3)  # bars may be anywhere
    return figure


def waterfall(axes: Axes, first: float, changes: list[float]) -> None:
    """The first value as a dot, then a bar from level to level for each change, written beside it."""
    levels = first + np.cumsum([0.0, *changes])
    low, high = levels.min(), levels.max()
    span = max(high - low, 1e-9)
    axes.set_xlim(low - 0.45 * span, high + 0.45 * span)
    axes.plot(first, 0, "o", color=style.TWIN, markersize=4)
    axes.text(first + 0.04 * span, 0, f"{first:.1f}", va="center", ha="left", fontsize=7)
    for row, change in enumerate(changes, 1):
        begin, end = levels[row - 1], levels[row]
        colour = SLOWER if change > 0 else QUICKER
        axes.plot([begin, begin], [row - 1, row], color=style.MEASURED, linewidth=0.6)
        axes.barh(row, change, left=begin, height=0.55, color=colour)
        if abs(change) < THIN * span:
            axes.plot([end, end], [row - 0.275, row + 0.275], color=style.TWIN, linewidth=1.0)
        ahead = change >= 0
        place = max(begin, end) + 0.04 * span if ahead else min(begin, end) - 0.04 * span
        words = f"{change:+.2f}" if abs(change) >= 5e-3 else "0.00"
        axes.text(place, row, words, va="center", ha="left" if ahead else "right", fontsize=7)


def same_machine(panels: Sequence[Axes], ladder: Result) -> None:
    """Wedges below the bars point at the constraint model of each rung's own machine."""
    rows = [rung.name for rung in ladder.rungs if rung.found]
    name = "constraint model of the same machine"
    for rung, own in ladder.left():
        row = rows.index(rung.name) + BELOW
        values = np.array([1e3 * own.period_s]), np.array([1e3 * own.step_length_m]), own.multipliers[:, 0]
        for axes, places in zip(panels, values, strict=True):
            axes.plot(places, [row] * len(places), "^", color=style.TWIN, markersize=3.5, label=name)
        name = "_"  # said once


def rung_multipliers(axes: Axes, rungs: list[RungGait]) -> None:
    """Real parts of the two largest in the plane and of the largest out of it; the limits of stability dashed."""
    rows = np.arange(1, len(rungs) + 1)
    for limit in (-1.0, 1.0):
        axes.axvline(limit, color=style.TWIN, linewidth=0.7, linestyle="--")
    for number in (0, 1):
        values = [rung.plane_multipliers[number, 0] for rung in rungs]
        name = "two largest in the plane" if number == 0 else None
        axes.plot(values, rows, "o", color=style.MULTIBODY, markersize=4, label=name)
    sideways = [(rung.side_multipliers[0, 0], row) for rung, row in zip(rungs, rows, strict=True)
                if len(rung.side_multipliers)]  # fmt: skip
    if sideways:
        axes.plot(*zip(*sideways, strict=True), "D", color=style.SECOND, markersize=3.5, label="largest out of it: yaw")
    far = max(1.2, *(1.1 * abs(x) for line in axes.lines for x in np.ravel(line.get_xdata()) if np.isfinite(x)))
    axes.set_xlim(-far, far)


def caption_ladder(given: Given) -> str:
    beside = " Wedges: the constraint model of the same robot." if given.twin_ladder.left() else ""
    return f"What each detail does to a step: {given.twin_ladder.summary()}.{beside}"


# After a push to the side: roll dies out, yaw and drift stay, and a hard push ends in a fall.


def draw_pushes(given: Given) -> Figure:
    """Histories of roll, yaw and drift after the pushes of the first kind; a cross marks a fall."""
    pushes = given.twin_pushes
    kind = pushes.walks[0].kind
    walks = [walk for walk in pushes.walks if walk.kind == kind]
    figure, panels = plt.subplots(1, 3, figsize=(style.TWO_COLUMNS, 2.8), sharex=True)
    shades = plt.get_cmap("cividis")(np.linspace(0.0, 0.85, len(walks)))
    for walk, colour in zip(walks, shades, strict=True):
        name = f"{walk.size:.3g} {walk.unit}" + ("" if walk.survived else ", falls")
        for axes, values in zip(
            panels, (np.degrees(walk.roll), np.degrees(walk.yaw), 1e3 * (walk.lateral - walk.lateral[0])), strict=True
        ):
            axes.plot(walk.time, values, color=colour, linewidth=1.0, label=name)
            if not walk.survived:
                axes.plot(walk.time[-1], values[-1], "x", color=colour, markersize=6, markeredgewidth=1.6)
    for axes, label, letter in zip(panels, ("roll [°]", "yaw [°]", "drift of the hip [mm]"), "abc", strict=True):
        axes.set(xlabel="time since the push [s]", ylabel=label)
        style.panel_label(axes, letter)
    named = panels[0].get_legend_handles_labels()
    figure.legend(*named, loc="outside upper center", ncols=len(walks), title=f"push: {kind}")
    return figure


def caption_pushes(given: Given) -> str:
    return f"{given.twin_pushes.summary()}."


FIGURES = {
    "multipliers": Entry(
        "Multipliers and elasticities",
        21,
        ("analytic", "multibody", "twin_ladder"),
        draw_multipliers,
        caption_multipliers,
        claims=("stable_gait", "multipliers_minimised", "chaos_amplifies"),
        without=("twin_ladder",),
    ),
    "basin": Entry("Basin of attraction", 23, ("stability",), draw_basin, caption_basin, claims=("stable_gait",)),
    "bifurcation": Entry(
        "The gait over the slope",
        22,
        ("stability",),
        draw_bifurcation,
        caption_bifurcation,
        claims=("stable_gait", "multipliers_minimised"),
    ),
    "twin_ladder": Entry(
        "From the simple model to the twin",
        20,
        ("twin_ladder",),
        draw_ladder,
        caption_ladder,
        claims=("twin_like_simple", "outsole_slows"),
    ),
    "twin_pushes": Entry(
        "Pushes to the side", 40, ("twin_pushes",), draw_pushes, caption_pushes, claims=("push_converges",)
    ),
}
