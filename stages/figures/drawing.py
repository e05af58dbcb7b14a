"""One figure drawn: its files and its caption, from the results that it names."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, cast

from stages.drawing import style
from stages.figures.drawn import NAMES, figure
from stages.figures.result import Caption

if TYPE_CHECKING:
    from stages.figures.inputs import Given
    from stages.figures.parameters import Parameters

__all__ = ["NAMES", "Drawing", "draw", "inputs_of"]


@dataclass(frozen=True)
class Drawing:
    """A figure's place in the report, its caption, and its files by path in the results folder."""

    place: int
    caption: Caption
    files: dict[str, bytes]


def inputs_of(name: str) -> tuple[str, ...]:
    """Stages whose results a figure shows."""
    return figure(name).INPUTS


def given_to(name: str, parameters: Parameters, results: Mapping[str, Any]) -> Given:
    """What a figure is given: the parameters, and of the `results` by stage those that it names, no other."""
    return cast("Given", SimpleNamespace(parameters=parameters, **{key: results[key] for key in inputs_of(name)}))


def draw(name: str, parameters: Parameters, results: Mapping[str, Any]) -> Drawing:
    """Draw a figure from what it names of the `results`."""
    one, given = figure(name), given_to(name, parameters, results)
    with style.drawing():
        shown = one.draw(given)
        files = (
            {f"figures/{name}.html": shown.encode()}
            if isinstance(shown, str)
            else style.pictures(name, shown, parameters.settings.resolution_dpi)
        )
    return Drawing(one.PLACE, Caption(name, one.TITLE, one.caption(given)), files)
