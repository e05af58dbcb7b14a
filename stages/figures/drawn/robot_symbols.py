"""The biped with all its symbols: what the parameters mean."""

from __future__ import annotations

import cmath
import io
import math
from typing import TYPE_CHECKING

import matplotlib.pyplot as plt

from stages.biped.accuracy.scales import size as size_of
from stages.drawing import style
from stages.figures.mechanism import FAINT, DrawnLeg, Page, formula, listed, spiral, svg_for_both

if TYPE_CHECKING:
    from stages.figures.inputs import Given

TITLE = "The biped and its symbols"
PLACE = 0
INPUTS = ()
BESIDE_PARAMETERS = True
FIRST, OTHER, INK = style.ANALYTIC, style.MULTIBODY, style.TWIN
#: The slope as it is drawn, and the legs' angles in the paper's half [rad].
SLOPE, THETA, PSI = 0.12, 0.42, 0.46
#: Each colour on a dark page.
DARK = {INK: "#E8E8E8", FIRST: "#56B4E9", OTHER: "#FF9A5C", style.GROUND: "#C9A36D", FAINT: "#B0B0B0",
        "#FFFFFF": "#121416"}  # fmt: skip


def draw(given: Given) -> str:
    """Two bipeds of the study's lengths: with the paper's symbols, and with those that a detailed design adds."""
    biped = given.parameters.biped
    chord = given.parameters.twin.outsole_arc * size_of(biped)
    figure, panels = plt.subplots(1, 2, figsize=(style.TWO_COLUMNS, 2.5), width_ratios=(1.0, 1.4))
    pages = [Page(axes, SLOPE) for axes in panels]
    size = biped.leg_length, biped.foot_radius, biped.foot_com
    paper(pages[0], *size, chord)
    detailed(pages[1], *size, chord)
    for axes, letter in zip(panels, "ab", strict=True):
        axes.set_aspect("equal")
        axes.set_axis_off()
        axes.set_anchor("N")
        axes.margins(0.02)
        axes.autoscale_view()
        style.panel_label(axes, letter)
    buffer = io.StringIO()
    nameless = {"Date": None, "Creator": None, "Format": None, "Type": None}
    with style.laid_out(figure, 72):  # SVG's own
        figure.savefig(buffer, format="svg", transparent=True, metadata=nameless)
    plt.close(figure)
    return svg_for_both(buffer.getvalue(), DARK, TITLE)


def ground(page: Page, start: float, end: float) -> None:
    """The slope's surface."""
    page.line([complex(start, 0.0), complex(end, 0.0)], style.GROUND, 1.8)


def paper(page: Page, length: float, radius: float, foot_com: float, chord: float) -> None:
    """Table 1's biped: coordinates, masses, lengths, springs, slope."""
    hip_height = radius + (length - radius) * math.cos(THETA)
    hip = complex(0.0, hip_height)
    swing_length = 0.96 * length
    ground(page, -0.78 * length, 0.86 * length)
    first = DrawnLeg(page, hip, -THETA, length, radius, foot_com, FIRST, chord=chord)
    other = DrawnLeg(page, hip, PSI, swing_length, radius, foot_com, OTHER, chord=chord)
    for leg in (first, other):
        leg.draw()
    page.line([hip + 0.06j * length, hip - 0.92j * length], FAINT, 0.6, "--")
    page.arc(hip, 0.64 * length, 0.0, -THETA, FIRST)
    page.arc(hip, 0.64 * length, 0.0, PSI, OTHER)
    page.word(formula("theta"), hip - 0.56 * length * 1j * cmath.exp(-0.35j * THETA), FIRST)
    page.word(formula("psi"), hip - 0.56 * length * 1j * cmath.exp(0.35j * PSI), OTHER)
    page.mass_centre(hip, 0.035 * length, INK)
    page.word(formula("M"), hip + complex(0.0, 0.10 * length), INK)
    first.dimension(formula("L_1"), (0.0, 0.0), (0.0, length), -0.36 * length)
    other.dimension(formula("L_2"), (0.0, 0.0), (0.0, swing_length), 0.3 * length)
    first.dimension(formula("l"), (0.0, length - foot_com), (0.0, length), -0.2 * length)
    first.words("k b", -0.08 * length, 0.48 * length, "right")
    first.words("m I", 0.06 * length, length - foot_com + 0.05 * length, "left")
    other.foot_radius("r")
    origin = complex(-0.95 * length, 0.62 * length)
    page.arrow(origin, origin + 0.2 * length, INK)
    page.arrow(origin, origin + 0.2j * length, INK)
    page.word("$x$", origin + 0.25 * length, INK)
    page.word("$y$", origin + 0.25j * length, INK)
    down = -1j * complex(math.cos(SLOPE), math.sin(SLOPE))
    start = complex(0.78 * length, 1.0 * length)
    page.arrow(start, start + 0.2 * length * down, INK)
    page.word("$g$", start + 0.26 * length * down, INK)
    level = complex(math.cos(SLOPE), math.sin(SLOPE))
    corner = complex(0.26 * length, 0.0)
    page.line([corner, corner + 0.56 * length * level], FAINT, 0.6, "--")
    page.word(formula("alpha"), corner + 0.63 * length * complex(math.cos(SLOPE / 2), math.sin(SLOPE / 2)), INK)


def detailed(page: Page, length: float, radius: float, foot_com: float, chord: float) -> None:
    """What a detailed design adds: frames, masses off the line, a hip with springs, legs that differ."""
    ground(page, -1.1 * length, 1.2 * length)
    back, ahead, smaller = 0.68, 0.70, 0.93
    hip = complex(0.0, radius + (length - radius) * math.cos(back))
    frame = {"foot_offset": 0.1 * length, "frame_com": 0.2 * length, "frame_offset": 0.09 * length}
    first = DrawnLeg(page, hip, -back, length, radius, foot_com, FIRST, chord=chord, **frame)
    other = DrawnLeg(page, hip, ahead, smaller * length, smaller * radius, 0.9 * foot_com, OTHER,
                     chord=smaller * chord, **frame)  # fmt: skip
    for leg, mark, side in ((first, "", -1.0), (other, "_2", 1.0)):
        leg.draw()
        low = leg.length - leg.foot_com
        leg.dimension(formula("L_nat" + mark), (0.0, 0.0), (0.0, leg.length), side * 0.42 * length)
        leg.dimension(formula("l" + mark), (0.0, low), (0.0, leg.length), side * 0.31 * length)
        leg.dimension(formula("l_f" + mark), (0.0, 0.0), (leg.frame_offset, leg.frame_com), side * 0.25 * length)
        leg.offset(formula("e" + mark), (leg.foot_offset, low), -0.07 * length)
        leg.offset(formula("e_f" + mark), (leg.frame_offset, leg.frame_com), 0.07 * length)
        leg.words(f"m{mark} I{mark}", leg.foot_offset + 0.03 * length, low + 0.05 * length, "left")
        leg.words(f"k{mark} b{mark}", -0.08 * length, 0.5 * length, "right")
        leg.foot_radius("r" + mark)
    first.words("m_f I_f", 0.135 * length, 0.2 * length, "left")
    other.words("m_f_2 I_f_2", 0.14 * length, 0.16 * length, "left")
    spiral(page, hip, 0.1 * length, -back, ahead, INK)
    page.mass_centre(hip, 0.035 * length, INK)
    page.word(listed("M M_g"), hip + 0.16j * length, INK)
    page.word(listed("k_h b_h tau_h phi_h"), hip + 0.28j * length, INK)


def caption(given: Given) -> str:
    biped = given.parameters.biped
    return (
        f"The biped and its symbols, of the study's lengths: leg {1e3 * biped.leg_length:g} mm, foot radius "
        f"{1e3 * biped.foot_radius:g} mm, mass {1e3 * biped.foot_com:g} mm above the foot's bottom. (a) The design of "
        "Table 1. (b) What a detailed design adds. The slope is drawn steeper than it is, legs further apart."
    )
