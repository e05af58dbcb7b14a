"""What a lab says beside its recordings: known values with their errors, and what is looked for."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from typing import Any, TypeVar

from stages.analytic.gait.design_point import DesignPoint, parameter_names
from stages.biped.design import Biped
from stages.biped.quantity import Bound
from stages.biped.question import WrongOption
from stages.calibration.estimation.least_squares import SUMS, TOTAL_MASS, Known
from stages.calibration.information.identifiability import short
from stages.ground.slope import Slope

Given = TypeVar("Given", bound=Collection[str])
#: Where an entry stands in the file, by its keys.
Place = Callable[..., str]
ENTRY = ("value", "uncertainty", "unit", "source")
KEYS = ("known", "free", "fixed", "fitted", "held_out", "design")
#: A known value may differ from the design's by this factor.
FAR = 2.0
#: What a fit begins from: the design of biped.yaml, or the bill of parts seen from the side, as the study's own fits.
BIPED, PARTS = "biped", "parts"
#: Unit and bound of the design's parameters and of known sums.
DECLARED: dict[str, Mapping[str, Any]] = {
    TOTAL_MASS: {"unit": "kg", "bound": Bound(above=0)},
    **{f"{owner.FILE}.{field.name}": field.metadata
       for owner in (Biped, Slope) for field in dataclasses.fields(owner)}}  # fmt: skip


@dataclass(frozen=True)
class Request:
    """Known values; names of parameters that are looked for (all, if there are none) and that keep their value; names
    of runs that are held out, and of those that are fitted (all others, if there are none); the `design` to begin from.
    """

    known: tuple[Known, ...] = ()
    free: tuple[str, ...] = ()
    fixed: tuple[str, ...] = ()
    held_out: tuple[str, ...] = ()
    fitted: tuple[str, ...] = ()
    design: str = BIPED

    def check(self, names: tuple[str, ...], design: DesignPoint) -> None:
        """Raise WrongOption where nothing, or what the `design` does not have, is looked for (`names` is what is), and
        for a known value that no fit which begins with the design gets to."""
        for name in self.free:
            if name not in (*names, *self.fixed):
                raise WrongOption(f"free: {short(name)} is not looked for, as the design has none: give it a value in "
                                  f"{name.partition('.')[0]}.yaml")  # fmt: skip
        if not names:
            raise WrongOption("free, fixed: nothing is left that is looked for")
        for one in self.known:
            drawn = one.of(design)
            if drawn and not 1.0 / FAR <= one.value / drawn <= FAR:
                raise WrongOption(f"known.{short(one.name)}: {one.value:g}, where the design that the fit begins with "
                                  f"has {drawn:g}: allowed is up to {FAR:g} times as much or as little; correct either")

    def looked_for(self, names: tuple[str, ...]) -> tuple[str, ...]:
        """Those of `names` that are looked for."""
        return tuple(name for name in names if (not self.free or name in self.free) and name not in self.fixed)


def request_of(about: Mapping[str, Any] | None) -> Request:
    """Read and check what the file says. Raises WrongOption with file, line, key, value and what is allowed."""
    if about is None:
        return Request()
    place: Place = about.place  # type: ignore[attr-defined]
    only(about, KEYS, place)
    entries = about.get("known") or {}
    if not isinstance(entries, dict):
        raise WrongOption(f"{place('known')}: expected names with {{{', '.join(ENTRY)}}}")
    known = tuple(_known(name, entry, place) for name, entry in entries.items())
    free, fixed = (_names(about.get(key), key, place) for key in ("free", "fixed"))
    held_out, fitted = (_runs(about.get(key) or [], key, place) for key in ("held_out", "fitted"))
    design = about.get("design") or BIPED
    if design not in (BIPED, PARTS):
        raise WrongOption(f"{place('design')}: {design}, must be {BIPED} (biped.yaml as it is) or {PARTS} (the bill of "
                          "parts in twin.yaml, with its frames)")
    return Request(known, free, fixed, held_out, fitted, str(design))


def only(
    given: Given, allowed: Collection[str], place: Place, *keys: str, wrong: str = "there is no such entry; known are"
) -> Given:
    """What is `given` at some keys. Raises WrongOption where it has entries that are not `allowed`."""
    for key in given:
        if key not in allowed:
            raise WrongOption(f"{place(*keys, key)}: {wrong} {', '.join(allowed)}")
    return given


def _runs(given: Any, key: str, place: Place) -> tuple[str, ...]:
    if not isinstance(given, list) or not all(isinstance(one, (str, int)) for one in given):
        raise WrongOption(f"{place(key)}: expected a list of names of runs")
    return tuple(map(str, given))


def _full_name(name: str) -> str | None:
    """The parameter's name with its file; None if there is no such parameter."""
    return next((one for one in parameter_names() if name in (one, one.partition(".")[2])), None)


def _names(given: Any, key: str, place: Place) -> tuple[str, ...]:
    if given is not None and not isinstance(given, list):
        raise WrongOption(f"{place(key)}: expected a list of parameters")
    found = []
    for row, name in enumerate(given or []):
        whole = _full_name(str(name))
        if whole is None:
            raise WrongOption(f"{place(key, row)}: {name} is no parameter of the design; known are "
                              f"{', '.join(parameter_names())}")  # fmt: skip
        found.append(whole)
    return tuple(found)


def _known(name: str, entry: Any, place: Place) -> Known:
    """One known value of the design. Raises WrongOption."""
    whole = name if name in SUMS else _full_name(name)
    if whole is None:
        raise WrongOption(f"{place('known', name)}: no such quantity; known are "
                          f"{', '.join([*SUMS, *parameter_names()])}")  # fmt: skip
    return known_value(whole, entry, str(DECLARED[whole]["unit"]), place, name)


def known_value(name: str, entry: Any, unit: str, place: Place, key: str) -> Known:
    """A known value from {value, uncertainty, unit, source}, which the file calls `key`. Raises WrongOption."""
    if not isinstance(entry, dict) or set(entry) - set(ENTRY) or not {"value", "uncertainty", "unit"} <= set(entry):
        raise WrongOption(f"{place('known', key)}: expected {{{', '.join(ENTRY)}}} (source may be left out)")
    if entry["unit"] != unit:
        raise WrongOption(f"{place('known', key, 'unit')}: {entry['unit']}, must be {unit}")
    value = number(entry["value"], place("known", key, "value"), -1e9, 1e9)
    sd = number(entry["uncertainty"], place("known", key, "uncertainty"), 0.0, 1e9)
    if sd == 0.0:
        raise WrongOption(f"{place('known', key, 'uncertainty')}: 0, must be above 0")
    bound: Bound | None = DECLARED[name]["bound"] if name in DECLARED else None
    if bound is not None and not bound.holds(value):
        raise WrongOption(f"{place('known', key, 'value')}: {value:g}, must be {bound}")
    return Known(name, value, sd, str(entry.get("source", "")))


def number(given: Any, where: str, least: float, most: float) -> float:
    """A number within limits. Raises WrongOption that says where it stands."""
    is_number = isinstance(given, (int, float)) and not isinstance(given, bool) and math.isfinite(given)
    if not is_number or not least <= given <= most:
        raise WrongOption(f"{where}: {given}, must be a number from {least:g} to {most:g}")
    return float(given)
