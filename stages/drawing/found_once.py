"""What Matplotlib finds many times for one figure is found once: the same figure in two thirds of the time.

Each function stands in for methods of Matplotlib's own as long as it is entered, and gives what those give; only the
fonts in PDFs have fewer tables.
"""

from __future__ import annotations

import functools
import gc
import io
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import matplotlib
import numpy as np
from matplotlib import _mathtext, font_manager
from matplotlib.axis import Axis, Tick
from matplotlib.backends.backend_agg import RendererAgg
from matplotlib.text import Text
from matplotlib.transforms import Bbox, BboxBase

#: Whether Matplotlib asks a font for signs by their places in it, and not by characters.
BY_PLACE = matplotlib.__version_info__ >= (3, 11)
#: Tables of a font that a PDF does not need, as it says itself where each sign is and what it means (ISO 32000-1, 9.9).
UNREAD = ("GDEF", "GPOS", "GSUB", "kern", "MATH", *(("cmap", "post", "OS/2") if BY_PLACE else ()))
#: Bytes of the largest font that text is set in, and some: it is read at one go.
FONT = 1 << 20


@contextmanager
def while_drawing() -> Iterator[None]:
    """All that holds while figures are made."""
    with fonts_once(), whole_fonts(), sizes_once(), ticks_alike(), no_garbage():
        yield


@contextmanager
def replaced(owner: Any, **others: Any) -> Iterator[None]:
    """Attributes of a class or module are others for a while."""
    before = {name: vars(owner)[name] for name in others}
    for name, other in others.items():
        setattr(owner, name, other)
    try:
        yield
    finally:
        for name, own in before.items():
            setattr(owner, name, own)


@contextmanager
def plain_fonts() -> Iterator[None]:
    """Embed fonts without what no PDF reader looks at: cutting that down to the signs in use takes most of the time of
    cutting the font.
    """
    from fontTools import subset  # loaded for PDFs alone

    opened = subset.load_font

    def plain(*asked: Any, **how: Any) -> Any:
        font = opened(*asked, **how)
        for table in UNREAD:
            if table in font:
                del font[table]
        return font

    with replaced(subset, load_font=plain):
        yield


_file_of_font = functools.cache(font_manager.FontManager.findfont)


@contextmanager
def fonts_once() -> Iterator[None]:
    """Find the file of a font once for all figures, which are drawn under the same rules. Matplotlib asks for it with
    each text, fifty times with each formula, and reads eleven rules each time.
    """
    of_formulas = functools.partial(_file_of_font, font_manager.fontManager)
    with replaced(font_manager.FontManager, findfont=_file_of_font), replaced(_mathtext, findfont=of_formulas):
        yield


@contextmanager
def whole_fonts() -> Iterator[None]:
    """Read a font whole when it is opened, where FreeType would ask Python's file for every sign anew: half the time of
    setting text.
    """
    found, opened = font_manager._get_font, io.open  # type: ignore[attr-defined]

    def whole(path: Any, mode: str) -> Any:
        return opened(path, mode, buffering=FONT)

    @functools.cache
    def font(*paths: Any, **how: Any) -> Any:
        with replaced(io, open=whole):
            return found(*paths, **how)

    with replaced(font_manager, _get_font=font):
        yield


@contextmanager
def sizes_once() -> Iterator[None]:
    """Set a font's size once for a text, where Matplotlib sets it for each sign and FreeType then makes ready anew:
    three quarters of the time of a sign.
    """
    name = "_draw_text_glyphs_and_boxes"  # since Matplotlib 3.11
    draw: Any = getattr(RendererAgg, name, None)

    def once(renderer: Any, state: Any, x: float, y: float, angle: float, signs: Iterable[Any], boxes: Any) -> None:
        fonts: dict[Any, _Sized] = {}
        sized = ((fonts.setdefault(font, _Sized(font)), *sign) for font, *sign in signs)
        draw(renderer, state, x, y, angle, sized, boxes)

    with replaced(RendererAgg, **({name: once} if draw else {})):
        yield


class _Sized:
    """What is drawn of a font, which keeps its size until it is given another."""

    def __init__(self, font: Any) -> None:
        self._set_size = font.set_size
        self._size: tuple[float, ...] = ()
        self._set_transform, self._render_glyph = font._set_transform, font._render_glyph

    def set_size(self, *size: float) -> None:
        if size != self._size:
            self._size = size
            self._set_size(*size)


@contextmanager
def no_garbage() -> Iterator[None]:
    """Look for no garbage among the many objects of ticks and fonts, which takes a fifth of the time of a figure."""
    before = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if before:
            gc.enable()


@contextmanager
def ticks_alike() -> Iterator[None]:
    """Make an axis' further ticks as copies of its first, which Matplotlib builds anew and then makes like the first:
    an eighth of the time of a figure.
    """
    new: Callable[[Axis, bool], Tick] = Axis._get_tick  # type: ignore[attr-defined]

    def another(axis: Axis, major: bool) -> Tick:
        ticks = axis.majorTicks if major else axis.minorTicks
        return _copy(ticks[0]) if ticks else new(axis, major)

    def as_it_is(axis: Axis, first: Tick, tick: Tick) -> None: ...

    with replaced(Axis, _get_tick=another, _copy_tick_props=as_it_is):
        yield


def _copy(tick: Tick) -> Any:
    """A tick as another, its lines and labels included."""
    twin = _alike(tick)
    for part in ("tick1line", "tick2line", "gridline", "label1", "label2"):
        setattr(twin, part, _alike(getattr(tick, part)))
    for label in (twin.label1, twin.label2):
        label._fontproperties = label._fontproperties.copy()
    return twin


def _alike(thing: Any) -> Any:
    """An object with the same attributes; `copy.copy` asks Matplotlib's for a state first, which takes longer."""
    twin = object.__new__(type(thing))
    twin.__dict__.update(thing.__dict__)
    return twin


@contextmanager
def while_nothing_changes() -> Iterator[None]:
    """Find an axis' ticks and the room that their labels take once for each place of the axis, and the lines of a text
    once for each text, while nothing else is changed.

    Matplotlib does so for each spine, for the neighbours' labels, for the layout and for the drawing: a quarter of the
    time of a figure.
    """
    ticks, room, lines = Axis._update_ticks, Axis._get_ticklabel_bboxes, Text._get_layout  # type: ignore[attr-defined]
    known: dict[tuple[Any, Any], tuple[Any, Any]] = {}

    def once(key: tuple[Any, Any], place: Any, find: Callable[[], Any]) -> Any:
        if known.get(key, (None,))[0] != place:
            known[key] = place, find()
        return known[key][1]

    def on_page(axis: Axis) -> tuple[float, ...]:
        return (*axis.get_view_interval(), *axis.axes.bbox.bounds)

    def ticks_once(axis: Axis) -> Any:
        return once((axis, None), on_page(axis), lambda: ticks(axis))

    def room_once(axis: Axis, drawn: Any, renderer: Any) -> Any:
        return once((axis, renderer), on_page(axis), lambda: room(axis, drawn, renderer))

    def lines_once(text: Text, renderer: Any) -> Any:
        if text.get_wrap():  # then its place matters as well
            return lines(text, renderer)
        said = (text.get_text(), text.get_rotation(), text.get_horizontalalignment(), text.get_verticalalignment(),
                hash(text.get_fontproperties()), text.figure.dpi)  # fmt: skip
        return once((text, renderer), said, lambda: lines(text, renderer))

    with (
        replaced(Axis, _update_ticks=ticks_once, _get_ticklabel_bboxes=room_once),
        replaced(Text, _get_layout=lines_once),
        replaced(BboxBase, union=staticmethod(union)),
    ):
        yield


def union(boxes: Sequence[BboxBase]) -> Bbox:
    """The box around some: all numbers at one go, where Matplotlib asks each box for its corners four times."""
    corners = np.array([box.get_points() for box in boxes])
    return Bbox([corners.min((0, 1)), corners.max((0, 1))])
