"""Where a figure can be cut into pieces that a phone shows one below the other. A box is left, top, right, bottom."""

from __future__ import annotations

from operator import itemgetter

from matplotlib.figure import Figure
from matplotlib.transforms import Bbox

#: Width that a piece may have, about what a phone shows at the size of print, and the empty edge around it [inches];
#: room of a legend's handle before its words, in their size.
PHONE, EDGE, HANDLE = 3.6, 0.04, 3.0
Box = tuple[float, float, float, float]


def pieces(figure: Figure) -> str:
    """The size of a figure that was drawn, then left, top, width and height of its pieces [inches], as words."""
    (width, height), dpi = figure.get_size_inches(), figure.dpi
    found = [[width, height]]
    for group in whole_parts(figure):
        boxes = [(box.x0 / dpi, height - box.y1 / dpi, box.x1 / dpi, height - box.y0 / dpi) for box in group]
        found += [[left - EDGE, top - EDGE, right - left + 2 * EDGE, bottom - top + 2 * EDGE]
                  for left, top, right, bottom in (cut(boxes) if boxes else ())]  # fmt: skip
    return "; ".join(" ".join(f"{value:.3f}" for value in box) for box in found) + ";"


def whole_parts(figure: Figure) -> list[list[Bbox]]:
    """What must stay whole [pixels]: entries of each legend; then axes with their labels and colour bars, and words."""
    bars = {axes: [one.colorbar.ax for one in (*axes.images, *axes.collections) if one.colorbar is not None]
            for axes in figure.get_axes()}  # fmt: skip
    apart = [axes for axes in bars if axes.get_visible() and not any(axes in own for own in bars.values())]
    legends: list[list[Bbox]] = []
    found = [Bbox.union([box for one in (axes, *bars[axes]) if (box := one.get_tightbbox()) is not None])
             for axes in apart]  # fmt: skip
    for level in (figure, *figure.subfigs):
        found += [text.get_window_extent() for text in level.texts if text.get_text()]
        for legend in level.legends:
            room = HANDLE * legend.prop.get_size_in_points() / 72.0 * figure.dpi
            entries = [text.get_window_extent() for text in legend.get_texts()]
            legends.append([Bbox([[box.x0 - room, box.y0], [box.x1, box.y1]]) for box in entries])
    return [*legends, found]


def cut(boxes: list[Box]) -> list[Box]:
    """The pieces of boxes as they are read: columns, as many together as fit; rows where there are no columns."""
    left, top, right, bottom = zip(*boxes, strict=True)
    for axis in (0, 1) if max(right) - min(left) > PHONE else ():
        groups: list[list[Box]] = []
        for run in runs(boxes, axis):
            both = [*(groups[-1] if groups else ()), *run]
            narrow = max(box[2] for box in both) - min(box[0] for box in both) <= PHONE
            if groups and (narrow if axis == 0 else len(runs(both, 0)) > 1):
                groups[-1] = both
            else:
                groups.append(run)
        if len(groups) > 1:
            return [piece for group in groups for piece in cut(group)]
    return [(min(left), min(top), max(right), max(bottom))]


def runs(boxes: list[Box], axis: int) -> list[list[Box]]:
    """Boxes in groups that do not overlap, from left to right (axis 0) or from top to bottom (1)."""
    groups: list[list[Box]] = []
    for box in sorted(boxes, key=itemgetter(axis)):
        if groups and box[axis] < max(each[axis + 2] for each in groups[-1]):
            groups[-1].append(box)
        else:
            groups.append([box])
    return groups
