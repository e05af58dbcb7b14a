"""The gait over the slope: where its period doubles, and what its multipliers do there."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from stages.analytic.pictures import families
from stages.analytic.result import RecordedFamily, Turn
from stages.figures.entry import Entry, Given

#: How a gait is called that begins a family: of two steps where the legs differ.
STEPS = {1: "one step", 2: "two steps"}


def draw(given: Given) -> Figure:
    """The picture that `bipedstudy continue` draws."""
    return families.draw_families(given.stability.families, "slope [°]", given.stability.slope_deg)


def caption(given: Given) -> str:
    families = given.stability.families
    first = families[0].steps if families else 1
    text = (
        "Gaits of the constraint model over the slope: (a) duration of each step of a gait, which repeats after "
        f"{STEPS[first]}, or after more where the period has doubled; (b) their multipliers."
    )
    if not families:
        return f"{text} No gait could be followed."
    text = f"{text} {stretches(families[0])}"
    for family in families:
        for turn in family.turns:
            text = f"{text} {said(family, turn)}"
    gone = [f"the cycle of {family.steps} at {value:.3g}°" for family in families
            for value in without_double_stance(family)]  # fmt: skip
    if gone:
        text = f"{text} Multipliers have a kink where a step loses its double stance: {', '.join(gone)}."
    return text


def without_double_stance(family: RecordedFamily) -> list[float]:
    """The slopes about which a step of the cycle begins to have no double stance, each between two gaits [deg]."""
    order = np.argsort(family.value, kind="stable")
    gone = family.double_stance[order].min(axis=1) == 0.0
    changes = np.flatnonzero(gone[1:] != gone[:-1])
    found: list[float] = (0.5 * (family.value[order][changes] + family.value[order][changes + 1])).tolist()
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
    return f"{known}; stable ones lie between {low:.4g}° and {high:.4g}°."


def said(family: RecordedFamily, turn: Turn) -> str:
    """A turn in words."""
    what = {
        "period doubling": f"the cycle of {family.steps} doubles",
        "turning point": f"the cycle of {family.steps} turns back",
        "torus": f"a pair of multipliers of the cycle of {family.steps} leaves the unit circle",
    }[turn.kind]
    return f"At {turn.value:.4f}° {what} (multiplier {turn.multiplier:.6f})."


FIGURE = Entry(
    "The gait over the slope", 22, ("stability",), draw, caption,
    claims=("stable_gait", "multipliers_minimised"),
)  # fmt: skip
