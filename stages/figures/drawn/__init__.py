"""The register of figures: every module of this folder is one, called by the name of its file.

A figure is a TITLE, its PLACE in the report (the paper's have their number, the others more than that), INPUTS (the
results it shows: it is given no others), `draw` and `caption`. `draw` gives a Matplotlib figure, or text: a fragment of
a page.
"""

from __future__ import annotations

from importlib import import_module
from pkgutil import iter_modules
from typing import TYPE_CHECKING, Protocol, cast

from matplotlib.figure import Figure

if TYPE_CHECKING:
    from stages.figures.inputs import Given

NAMES = tuple(module.name for module in iter_modules(__path__))


class Drawn(Protocol):
    """A module of this folder."""

    TITLE: str
    PLACE: int
    INPUTS: tuple[str, ...]

    def draw(self, given: Given) -> Figure | str:
        """The figure."""

    def caption(self, given: Given) -> str:
        """What it shows, in words with the results' own numbers."""


def figure(name: str) -> Drawn:
    """The figure of this name."""
    return cast(Drawn, import_module(f"{__name__}.{name}"))
