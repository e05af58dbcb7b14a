"""Figure 9: the twin's design, and a frontal section through its hip, both from the bill of parts."""

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.ticker import MaxNLocator

from stages.biped.accuracy.scales import size
from stages.drawing import style
from stages.figures import view
from stages.figures.entry import Entry, Given
from stages.figures.view import COLOURS, TINTS, of_twin, tinted
from stages.twin.exports.solids import solid_parts
from stages.twin.machine.parts import Part


@dataclass(frozen=True)
class Cut:
    """A rectangle of a part in the plane x = 0: lower left corner (z, y), width and height [m].

    What is not `solid` is seen behind the cut, or before it.
    """

    part: Part
    z: float
    y: float
    width: float
    height: float
    solid: bool = True

    @property
    def pair(self) -> str:
        """inner or outer."""
        return self.part.group.split("_")[0]


def cuts(part: Part) -> Iterator[Cut]:
    """The rectangles of a part and of its mirror image; what the plane misses is given as it is seen along x."""
    for side in (1.0, -1.0)[: part.pieces]:
        x, y, z = part.position[0], part.position[1], side * part.position[2]
        for low, wide, bottom, high, solid in _of_shape(part, x):
            yield Cut(part, z + low, y + bottom, wide, high, solid)


def _of_shape(part: Part, x: float) -> Iterator[tuple[float, float, float, float, bool]]:
    """Of one piece about its reference point: z, width, y, height and whether the plane cuts it."""
    size = part.size
    if part.shape == "box":
        yield -size[2] / 2, size[2], -size[1] / 2, size[1], abs(x) <= size[0] / 2
    elif part.shape == "arc":
        outer, thickness, width, _ = size
        yield -width / 2, width, -outer, thickness, True
    elif part.shape in ("cylinder", "tube"):
        radius, length = size[0], size[-1]
        inner = size[1] if part.shape == "tube" else 0.0
        yield from _round(part.axis, radius, inner, length, abs(x))


def _round(axis: str, radius: float, inner: float, length: float, aside: float
           ) -> Iterator[tuple[float, float, float, float, bool]]:  # fmt: skip
    if axis == "x" or aside > radius:  # a round end, or beside the plane: its outline
        across = radius if axis != "z" else length / 2
        up = radius if axis != "y" else length / 2
        yield -across, 2 * across, -up, 2 * up, False
        return
    half, hole = math.sqrt(radius**2 - aside**2), math.sqrt(max(0.0, inner**2 - aside**2))
    bands = [(-half, half)] if hole == 0.0 else [(-half, -hole), (hole, half)]
    for low, high in bands:
        if axis == "z":
            yield -length / 2, length, low, high - low, True
        else:
            yield low, high - low, -length / 2, length, True


AZIMUTH, ELEVATION = np.radians(38.0), np.radians(18.0)
#: The section shows what lies above this height below the hip axis [m], and a margin around, for Table 1's leg.
BELOW, MARGIN = 0.07, 0.012
#: Where the parts' numbers stand above the section, from its middle, in halves of its width.
NUMBERS = -0.1702, 0.9515


def draw_section(axes: Axes, parts: Iterable[Part]) -> None:
    """The section: cut parts filled and hatched by pair, parts before and behind it as thin outlines."""
    found = sorted((cut for part in parts for cut in cuts(part)), key=lambda cut: -cut.width * cut.height)
    for cut in (cut for cut in found if not cut.solid):
        axes.add_patch(_rectangle(cut, facecolor="none", edgecolor="#AAAAAA", linewidth=0.5, linestyle=(0, (3, 2))))
    for cut in (cut for cut in found if cut.solid):
        colour = tinted(COLOURS[cut.pair], TINTS.get(cut.part.material, 0.0))
        axes.add_patch(_rectangle(cut, facecolor=colour, edgecolor="#222222", linewidth=0.5,
                                  hatch={"inner": "////", "outer": "\\\\\\\\"}[cut.pair]))  # fmt: skip


def _rectangle(cut: Cut, **look: Any) -> Rectangle:
    return Rectangle((1e3 * cut.z, 1e3 * cut.y), 1e3 * cut.width, 1e3 * cut.height, **look)


def numbered(parts: Iterable[Part], below: float) -> list[tuple[Part, np.ndarray]]:
    """Parts of frames that are cut above `below` [m], from the middle outwards, and a point (2,) [m] in each cut."""
    found = []
    for part in parts:
        solid = [cut for cut in cuts(part) if cut.solid and cut.z + cut.width / 2 >= -1e-9]
        if part.group.endswith("frame") and solid:
            cut = max(solid, key=lambda each: each.y)
            shifted = 0.5 if cut.z + cut.width / 2 > 1e-9 else 0.61  # a part in the middle is named beside it
            found.append((part, np.array([cut.z + shifted * cut.width, max(cut.y + 0.5 * cut.height, -0.8 * below)])))
    return sorted(found, key=lambda each: (round(float(each[1][0]), 4), each[0].name))


def draw(given: Given) -> Figure:
    """The robot standing, and the section, in which the bill of the plain design is cut."""
    twin, biped = given.parameters.twin, given.parameters.biped
    figure = plt.figure(figsize=(style.TWO_COLUMNS, 3.7))
    places: Any = [["whole", "hip"], ["whole", "key"]]
    panels = figure.subplot_mosaic(places, width_ratios=(1.15, 1.0), height_ratios=(1.0, 0.28))
    whole, hip, key = (panels[name] for name in ("whole", "hip", "key"))
    camera = view.Camera(AZIMUTH, ELEVATION, 0.0)
    natural = biped.leg_length + twin.outsole
    view.paint(whole, camera, [view.upright(natural).robot(of_twin(twin, biped))])
    view.frame(whole)
    parts = [part for part in solid_parts(twin, biped.plain()) if part.shape != "point"]
    below, margin = BELOW * size(biped), MARGIN * size(biped)
    draw_section(hip, parts)
    reach = max(max(abs(cut.z), abs(cut.z + cut.width)) for part in parts for cut in cuts(part))
    top = max(cut.y + cut.height for part in parts for cut in cuts(part))
    half = max(reach + 0.01, 0.9 * (below + top + 2 * margin))  # wide enough for the numbers above a high section
    named = numbered(parts, below)
    for number, ((_, at), place) in enumerate(zip(named, half * np.linspace(*NUMBERS, len(named))), 1):
        x, y = 1e3 * at
        hip.annotate(str(number), (x, y), (1e3 * place, 1e3 * (top + margin)), ha="center", va="bottom", fontsize=7,
                     arrowprops={"arrowstyle": "-", "linewidth": 0.5, "shrinkA": 0, "shrinkB": 0})  # fmt: skip
        hip.plot(x, y, "o", color="#222222", markersize=1.8, zorder=4)
    hip.plot([-1e3 * reach - 8, 1e3 * reach + 8], [0, 0], color="black", linewidth=0.6, linestyle=(0, (8, 2, 1, 2)))
    hip.yaxis.set_major_locator(MaxNLocator(5))
    hip.set(
        xlim=(-1e3 * half, 1e3 * half),
        ylim=(-1e3 * below, 1e3 * (top + 2 * margin)),
        aspect="equal",
        xlabel="along the hip axis [mm]",
        ylabel="above the hip axis [mm]",
    )
    hip.grid(False)
    style.panel_labels((whole, hip))
    for pair, hatch in (("inner", "////"), ("outer", "\\\\\\\\")):
        hip.add_patch(Rectangle((0, 0), 0, 0, facecolor=COLOURS[pair], edgecolor="#222222", hatch=hatch,
                                label=f"{pair} legs"))  # fmt: skip
    words = [f"{number} {part.name}" for number, (part, _) in enumerate(named, 1)]
    half_of = -(-len(words) // 2)
    key.set_axis_off()
    for number, start in enumerate(range(0, len(words), half_of)):
        column = "\n".join(words[start : start + half_of])
        key.text(number / 2, 1.0, column, transform=key.transAxes, va="top", fontsize=7)
    figure.legend(loc="outside upper right", ncols=2)
    return figure


def caption(given: Given) -> str:
    twin, biped = given.parameters.twin, given.parameters.biped
    plain, added = biped.plain(), ", ".join(biped.details)
    parts, rule = twin.bill(plain), twin.bill_rule(plain)
    more = f" Not drawn is what the machine has by {added} of this design." if added else ""
    count = sum(part.pieces for part in parts)
    if not parts:
        return ("The twin without parts, as twin.inertia is planar: point masses at the hip and at the feet, on rods "
                f"that only join them, and the frontal section through the hip axis.{more}")  # fmt: skip
    pieces = f"{count} pieces of assumed size and mass{', ' * bool(rule)}{rule}"
    return (
        f"The twin as its bill of {len(parts)} rows makes it, {pieces}, and the "
        "frontal section through the hip axis. What is inside the bearings turns with the shaft and the inner legs; "
        "the outer legs turn on it. Dashed: parts before and behind the section. Thin rods in the drawing are no parts."
        f"{more}"
    )


FIGURES = {"figure_09_section": Entry("Figure 9: the design and a section of the hip", 9, (), draw, caption)}
