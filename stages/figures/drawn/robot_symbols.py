"""The biped with all its symbols: what the parameters mean.

Points are complex numbers x + i y in metres of the slope frame, which the page shows turned, so that gravity points
down it.
"""

from __future__ import annotations

import cmath
import io
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from stages.drawing import style
from stages.figures.entry import Entry, Given

TITLE = "The biped and its symbols"
#: Thin lines and their words; words of a piece stand in its colour.
FAINT = "#5A5A5A"
WORDS = 8
#: What Matplotlib leaves to the reader's program.
BLACK = "#000000"
GREEK = {"phi": r"\varphi", "tau": r"\tau", "theta": r"\theta", "psi": r"\psi", "alpha": r"\alpha"}
#: Ends of the spring and the damper, in lengths of a leg from the hip, and their distance from its line.
SPRING = 0.40, 0.61
BESIDE = 0.035
FIRST, OTHER, INK = style.ANALYTIC, style.MULTIBODY, style.TWIN
#: The slope as it is drawn, and the legs' angles in the paper's half [rad].
SLOPE, THETA, PSI = 0.12, 0.42, 0.46
#: Each colour on a dark page.
DARK = {INK: "#E8E8E8", FIRST: "#56B4E9", OTHER: "#FF9A5C", style.GROUND: "#C9A36D", FAINT: "#B0B0B0",
        "#FFFFFF": "#121416"}  # fmt: skip


def draw(given: Given) -> str:
    """Two bipeds of the study's lengths: with the paper's symbols, and with those that a detailed design adds."""
    biped = given.parameters.biped
    chord = given.parameters.twin.arc(biped.foot_radius)
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
    page.arc(hip, 0.64 * length, -THETA, FIRST)
    page.arc(hip, 0.64 * length, PSI, OTHER)
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
        f"{1e3 * biped.foot_radius:g} mm, mass {1e3 * biped.foot_com:g} mm above the foot's bottom. (a) The symbols of "
        "Table 1. (b) What a detailed design adds. The slope is drawn steeper than it is, legs further apart."
    )


def formula(symbol: str) -> str:
    """A symbol as `stages.biped` writes it, for example L_nat_2, in the signs of mathematics."""
    base, *below = symbol.split("_")
    words = [rf"\mathrm{{{part}}}" if re.fullmatch("nat|g", part) else part for part in below]
    return f"${GREEK.get(base, base)}" + (f"_{{{','.join(words)}}}$" if words else "$")


@dataclass(frozen=True)
class Page:
    """Axes on which the slope frame appears turned by `turn` [rad]."""

    axes: Axes
    turn: float

    def place(self, points: np.ndarray | complex) -> tuple[np.ndarray, np.ndarray]:
        """Points of the slope frame on the page."""
        turned = np.asarray(points) * cmath.exp(-1j * self.turn)
        return turned.real, turned.imag

    def line(self, points: np.ndarray | list[complex], colour: str, width: float = 1.2, style: str = "-") -> None:
        """A line through points."""
        self.axes.plot(*self.place(np.array(points)), color=colour, linewidth=width, linestyle=style,
                       solid_capstyle="round", solid_joinstyle="round")  # fmt: skip

    def area(self, points: np.ndarray, colour: str, strength: float = 0.18) -> None:
        """A faint area."""
        self.axes.fill(*self.place(points), facecolor=colour, alpha=strength, linewidth=0)

    def word(self, text: str, point: complex, colour: str, across: str = "center") -> None:
        """Words at a point."""
        x, y = self.place(point)
        self.axes.text(float(x), float(y), text, color=colour, fontsize=WORDS, ha=across, va="center")

    def arrow(self, start: complex, end: complex, colour: str, heads: str = "-|>") -> None:
        """An arrow; `heads` as Matplotlib has them."""
        (x, y), (u, v) = self.place(start), self.place(end)
        self.axes.update_datalim([(float(x), float(y)), (float(u), float(v))])
        self.axes.annotate(
            "",
            (float(u), float(v)),
            (float(x), float(y)),
            arrowprops={
                "arrowstyle": heads,
                "color": colour,
                "linewidth": 0.7,
                "shrinkA": 0,
                "shrinkB": 0,
                "mutation_scale": 6,
            },
        )

    def arc(self, centre: complex, radius: float, angle: float, colour: str) -> None:
        """An arc from the downward normal of the slope to an angle [rad], forward positive, where it has a head."""
        turn = np.linspace(0.0, angle, 30)
        points = centre - 1j * radius * np.exp(1j * turn)
        self.line(points[:-3], colour, 0.7)
        self.arrow(points[-4], points[-1], colour)

    def mass_centre(self, point: complex, radius: float, colour: str) -> None:
        """The quartered disc of a mass centre."""
        turn = np.linspace(0.0, 0.5 * np.pi, 12)
        for quarter in range(4):
            rim = point + radius * np.exp(1j * (turn + 0.5 * np.pi * quarter))
            face = colour if quarter % 2 else "#FFFFFF"
            self.axes.fill(*self.place(np.append(rim, point)), facecolor=face, edgecolor=colour, linewidth=0.7,
                           zorder=5)  # fmt: skip


@dataclass(frozen=True)
class DrawnLeg:
    """A leg on a page: `hip` its upper end, `angle` [rad] positive with the foot ahead; lengths [m].

    `frame_com` 0 draws no frame.
    """

    page: Page
    hip: complex
    angle: float
    length: float
    radius: float
    foot_com: float
    colour: str
    foot_offset: float = 0.0
    frame_com: float = 0.0
    frame_offset: float = 0.0
    chord: float = 0.112

    def at(self, forward: float, down: float) -> complex:
        """The point so far forward of the leg's line and down from the hip [m]."""
        return self.hip + (forward - 1j * down) * cmath.exp(1j * self.angle)

    def draw(self) -> None:
        """Frame, spring and damper, lower leg, foot."""
        page, colour = self.page, self.colour
        top, bottom = (share * self.length for share in SPRING)
        centre, low = self.length - self.radius, self.length - self.foot_com
        page.line([self.at(0.0, 0.0), self.at(0.0, top)], colour, 1.6)
        self._spring(-BESIDE * self.length, top, bottom)
        self._damper(BESIDE * self.length, top, bottom)
        page.line([self.at(0.0, bottom), self.at(0.0, centre)], colour, 1.6)
        half = np.arcsin(min(1.0, 0.5 * self.chord / self.radius)) if self.radius else 0.0
        turn = np.linspace(-half, half, 24)
        sole = np.array([self.at(self.radius * np.sin(a), centre + self.radius * np.cos(a)) for a in turn])
        page.area(np.append(sole, self.at(0.0, centre)), colour)
        page.line(sole, colour, 2.4)
        for end in (sole[0], sole[-1]):
            page.line([self.at(0.0, centre), end], colour, 0.7)
        if self.foot_offset:
            page.line([self.at(0.0, low), self.at(self.foot_offset, low)], colour, 1.2)
        page.mass_centre(self.at(self.foot_offset, low), 0.027 * self.length, colour)
        if self.frame_com:
            self._frame()

    def _frame(self) -> None:
        along, across = 2.0 * self.frame_com, self.frame_offset
        turn = np.linspace(0.0, 2.0 * np.pi, 40)
        outline = [
            self.at(0.6 * across + 0.085 * self.length * np.sin(a), 0.5 * along - 0.6 * along * np.cos(a)) for a in turn
        ]
        self.page.area(np.array(outline), self.colour, 0.22)
        self.page.line([self.at(0.0, self.frame_com), self.at(across, self.frame_com)], self.colour, 1.2)
        self.page.mass_centre(self.at(across, self.frame_com), 0.027 * self.length, self.colour)

    def _spring(self, beside: float, top: float, bottom: float) -> None:
        turns, swing = 5, 0.022 * self.length
        lead = 0.12 * (bottom - top)
        down = np.linspace(top + lead, bottom - lead, 2 * turns + 1)
        across = beside + swing * np.array([0.0, *([1.0, -1.0] * turns)[:-1], 0.0])
        points = [self.at(0.0, top), self.at(beside, top), *map(self.at, across, down)]
        self.page.line([*points, self.at(beside, bottom), self.at(0.0, bottom)], self.colour, 0.9)

    def _damper(self, beside: float, top: float, bottom: float) -> None:
        swing, middle = 0.020 * self.length, 0.5 * (top + bottom)
        reach = 0.22 * (bottom - top)
        cup = [(swing, middle - reach), (swing, middle + reach), (-swing, middle + reach), (-swing, middle - reach)]
        self.page.line([self.at(0.0, top), self.at(beside, top), self.at(beside, middle)], self.colour, 0.9)
        self.page.line([self.at(beside - swing, middle), self.at(beside + swing, middle)], self.colour, 1.6)
        self.page.line([self.at(beside + across, down) for across, down in cup], self.colour, 0.9)
        self.page.line([self.at(beside, middle + reach), self.at(beside, bottom), self.at(0.0, bottom)],
                       self.colour, 0.9)  # fmt: skip

    def dimension(self, text: str, start: tuple[float, float], end: tuple[float, float], beside: float) -> None:
        """A distance along the leg between two of its points (forward, down), drawn `beside` its line [m]."""
        for forward, down in (start, end):
            self.page.line([self.at(forward, down), self.at(beside * 1.06, down)], FAINT, 0.4, ":")
        self.page.arrow(self.at(beside, start[1]), self.at(beside, end[1]), FAINT, "<|-|>")
        room, across = 0.03 * self.length * np.sign(beside), "left" if beside > 0.0 else "right"
        self.page.word(text, self.at(beside + room, 0.5 * (start[1] + end[1])), self.colour, across)

    def offset(self, text: str, end: tuple[float, float], below: float) -> None:
        """A distance from the leg's line to a point (forward, down), drawn so far below that point [m]."""
        forward, down = end
        level = down + below
        self.page.line([self.at(forward, down), self.at(forward, level)], FAINT, 0.4, ":")
        self.page.arrow(self.at(0.0, level), self.at(forward, level), FAINT, "<|-|>")
        self.page.word(text, self.at(forward + 0.02 * self.length, level), self.colour, "left")

    def foot_radius(self, symbol: str) -> None:
        """The radius of the foot, from its centre to its sole."""
        centre, turn = self.length - self.radius, 0.45
        point = self.at(-self.radius * np.sin(turn), centre + self.radius * np.cos(turn))
        self.page.arrow(self.at(0.0, centre), point, self.colour)
        self.words(symbol, -0.13 * self.radius, centre + 0.68 * self.radius)

    def words(self, symbols: str, forward: float, down: float, across: str = "center") -> None:
        """Symbols in this leg's colour at one of its points."""
        self.page.word(listed(symbols), self.at(forward, down), self.colour, across)


def spiral(page: Page, centre: complex, radius: float, start: float, end: float, colour: str) -> None:
    """A torsion spring around a hip, between two leg angles [rad]: one turn and what lies between them."""
    turn = np.linspace(start, end + 2.0 * np.pi, 70)
    grow = np.linspace(0.6, 1.0, len(turn)) * radius
    ends = [centre - 1.7j * radius * np.exp(1j * end)]
    page.line([*(centre - 1j * grow * np.exp(1j * turn)), *ends], colour, 0.9)


def listed(symbols: str) -> str:
    """Some symbols, as `formula` takes them, in a row."""
    return ", ".join(map(formula, symbols.split()))


def svg_for_both(svg: str, dark: Mapping[str, str], title: str) -> str:
    """Matplotlib's SVG picture as a fragment of a page and a file of its own, both for light and for dark readers.

    `dark` has for each colour, and for black, the one on a dark page. Nothing in it acts on the page around it.
    """
    rules = f".drawn{{fill:{dark[BLACK]}}}" + "".join(
        f'.drawn [style*="{what}: {light.lower()}"]{{{what}:{other}!important}}'
        for light, other in dark.items()
        for what in ("stroke", "fill")
    )
    style = f"<title>{title}</title><style>@media (prefers-color-scheme:dark){{{rules}}}</style>"
    body = re.sub(r"<style.*?</style>", "", svg[svg.index("<svg") :], flags=re.DOTALL)
    body = re.sub(r' d="[^"]*"', lambda path: re.sub(r"(\.\d\d)\d+", r"\1", path[0]).replace("\n", ""), body)
    head, _, rest = body.partition(">")
    head = re.sub(r' (width|height)="[^"]*"', "", head)
    return f'{head} role="img" class="drawn" stroke-linejoin="round">{style}{rest}'


FIGURES = {"robot_symbols": Entry(TITLE, 0, (), draw, caption, beside_parameters=True)}
