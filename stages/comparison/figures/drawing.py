"""Figures to be drawn, and their files: laying out and embedding fonts takes seconds, so all cores draw."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from matplotlib.figure import Figure

from stages.biped.processes import each_in_a_process
from stages.drawing import style


@dataclass(frozen=True)
class Drawing:
    """A figure to be drawn: its name, a function of a module, and what it is given."""

    name: str
    draw: Callable[..., Figure]
    arguments: tuple[Any, ...]


def pictures_of(drawings: Sequence[Drawing], dpi: int) -> dict[str, bytes]:
    """All figures as files, by path in the results folder, in the order of the drawings."""
    drawn = dict(each_in_a_process(partial(_pictures, dpi=dpi), drawings))
    return {path: content for number in sorted(drawn) for path, content in drawn[number].items()}


def _pictures(drawing: Drawing, dpi: int) -> dict[str, bytes]:
    with style.drawing():
        return style.pictures(drawing.name, drawing.draw(*drawing.arguments), dpi)
