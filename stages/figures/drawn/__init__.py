"""The register of figures: every module of this folder holds those of a subject as FIGURES, by name."""

import re
from collections.abc import Mapping
from html import escape
from importlib import import_module
from pkgutil import iter_modules
from types import SimpleNamespace
from typing import Any

from stages.biped.accuracy.tolerances import PAPER
from stages.drawing import style
from stages.figures.entry import Entry
from stages.figures.parameters import Parameters

_ENTRIES: dict[str, Entry] = {}
for _module in iter_modules(__path__):
    _ENTRIES |= import_module(f"{__name__}.{_module.name}").FIGURES
NAMES = tuple(sorted(_ENTRIES))


def figure(name: str) -> Entry:
    """The figure of a name."""
    return _ENTRIES[name]


def given_to(name: str, parameters: Parameters, results: Mapping[str, Any]) -> Any:
    """What a figure is given: the parameters, and of the `results` by stage those that it names."""
    return SimpleNamespace(parameters=parameters, **{key: results.get(key) for key in figure(name).inputs})


def at_level(shown: Any, level: str) -> Any:
    """A figure that says how accurate its study is, where that is not as usual."""
    if level == PAPER:
        return shown
    said = f"accuracy: {level}"
    if isinstance(shown, str):
        return with_note(shown, said)
    band = 0.13 / shown.get_figheight()  # below all else: there are labels of axes
    shown.get_layout_engine().set(rect=(0.0, band, 1.0, 1.0 - band))
    shown.text(0.998, 0.002, said, ha="right", va="bottom", fontsize=7, color=style.MULTIBODY, in_layout=False)
    return shown


def with_note(fragment: str, said: str) -> str:
    """A fragment of a page with a note below."""
    return f'{fragment}\n<p class="note">{escape(said)}</p>'


def draw(name: str, parameters: Parameters, results: Mapping[str, Any], said: str = "") -> tuple[dict[str, bytes], str]:
    """A figure's files, by path in the results folder, and its caption; what is `said` of its results stands in it."""
    given = given_to(name, parameters, results)
    with style.drawing():
        shown = at_level(figure(name).draw(given), parameters.level.level)
        files = (
            {f"figures/{name}.html": (with_note(shown, said) if said else shown).encode()}
            if isinstance(shown, str)
            else style.pictures(name, shown, parameters.settings.resolution_dpi, pdf=parameters.settings.pdf, said=said)
        )
    return files, re.sub(r"[-+]?\b(nan|inf)\b", "?", figure(name).caption(given))  # a number that is not known
