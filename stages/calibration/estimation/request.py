"""What a lab says beside its recordings: known values with their errors, and what is looked for."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from types import MappingProxyType
from typing import Any

from stages.analytic.gait.design_point import DesignPoint, parameter_names
from stages.biped.design import Biped
from stages.biped.quantity import Bound
from stages.biped.question import Place, number, only, place_of, refuse
from stages.calibration.estimation.least_squares import SUMS, TOTAL_MASS, Known
from stages.calibration.information.identifiability import EACH_RUNS, KNOWN_EVERYWHERE, SLOPE, short
from stages.ground.slope import Slope

ENTRY = ("value", "uncertainty", "unit", "source")
KEYS = ("known", "free", "fixed", "also", "fitted", "held_out", "design")
#: A known value may differ from the design's by this factor.
FAR = 2.0
#: What a fit begins from: the design of biped.yaml, or the bill of parts seen from the side, as the study's own fits.
BIPED, PARTS = "biped", "parts"
#: Unit and bound of the design's parameters and of known sums.
DECLARED: dict[str, Mapping[str, Any]] = {
    TOTAL_MASS: {"unit": "kg", "bound": Bound(above=0)},
    **{f"{owner.FILE}.{field.name}": field.metadata
       for owner in (Biped, Slope) for field in fields(owner)}}  # fmt: skip


@dataclass(frozen=True)
class Request:
    """Known values; names of parameters that are looked for (all, if there are none) and that keep their value; names
    of runs that are held out, and of those that are fitted (all others, if there are none); the `design` to begin from;
    names that are looked for `also`, which the design need not have.
    """

    known: tuple[Known, ...] = ()
    free: tuple[str, ...] = ()
    fixed: tuple[str, ...] = ()
    held_out: tuple[str, ...] = ()
    fitted: tuple[str, ...] = ()
    design: str = BIPED
    also: tuple[str, ...] = ()

    def check(self, names: tuple[str, ...], design: DesignPoint) -> None:
        """Raise WrongOption where nothing, or what the `design` does not have, is looked for (`names` is what is), and
        for a known value that says nothing of that, or that no fit which begins with the design gets to."""
        absent = [name for name in self.free if name not in (*names, *self.fixed)]
        idle = [one.name for one in self.known if one.name in EACH_RUNS or one.name not in (*SUMS, *names)]
        drawn = {one: one.of(design) for one in self.known}
        refuse(
            *((True, f"free: {short(name)} is not looked for, as the design has none: give it a value in "
                     f"{name.partition('.')[0]}.yaml, or name it under also") for name in absent),
            (not names, "free, fixed: nothing is left that is looked for"),
            *((True, f"known.{short(name)}: {_why_idle(name)}") for name in idle),
            *((value != 0.0 and not 1.0 / FAR <= one.value / value <= FAR,
               f"known.{short(one.name)}: {one.value:g}, where the design that the fit begins with has {value:g}: "
               f"allowed is up to {FAR:g} times as much or as little; correct either") for one, value in drawn.items()))

    def looked_for(self, names: tuple[str, ...]) -> tuple[str, ...]:
        """Those of `names` that are looked for, and what is so only where its error is known: gravity."""
        return (*(name for name in names if (not self.free or name in self.free) and name not in self.fixed),
                *(one.name for one in self.known if one.name in KNOWN_EVERYWHERE))


def _why_idle(name: str) -> str:
    """Why what is known of a parameter says nothing of those that all runs share, and where to give it."""
    if name == SLOPE:
        return "each run has its own: give slope_deg of its experiment, and calibration.slope_reading_sd_deg"
    if name in EACH_RUNS:
        return "each run has its own: leave it out"
    return f"is not looked for, so that nothing follows from it: give it as the value in {name.partition('.')[0]}.yaml"


def request_of(about: Mapping[str, Any] | None) -> Request:
    """Read and check what the file says. Raises WrongOption with file, line, key, value and what is allowed."""
    if about is None:
        return Request()
    place = place_of(about)
    only(about, KEYS, place)
    entries, design = known_entries(about, place), about.get("design") or BIPED
    refuse((design not in (BIPED, PARTS), f"{place('design')}: {design}, must be {BIPED} (biped.yaml as it is) or "
                                          f"{PARTS} (the bill of parts in twin.yaml, with its frames)"))  # fmt: skip
    known = tuple(
        known_value(full_name(key, (*SUMS, *parameter_names()), place("known", key), "no such quantity"), entry, place,
                    key) for key, entry in entries.items())
    free, fixed, also = (
        tuple(full_name(name, parameter_names(), place(key, row), f"{name} is no parameter of the design")
              for row, name in enumerate(listed(about, key, "parameters", place)))
        for key in ("free", "fixed", "also"))
    held_out, fitted = (tuple(map(str, listed(about, key, "names of runs", place))) for key in ("held_out", "fitted"))
    return Request(known, free, fixed, held_out, fitted, str(design), also)


def known_entries(about: Mapping[str, Any], place: Place) -> Mapping[str, Any]:
    """What is known, by name. Raises WrongOption where it is no mapping."""
    entries: Mapping[str, Any] = about.get("known") or {}
    refuse((not isinstance(entries, Mapping), f"{place('known')}: expected names with {{{', '.join(ENTRY)}}}"))
    return entries


def listed(about: Mapping[str, Any], key: str, what: str, place: Place) -> Sequence[Any]:
    """The entries of a list of names or numbers. Raises WrongOption."""
    given = about.get(key) or []
    is_list = isinstance(given, list) and all(isinstance(one, (str, int)) for one in given)
    refuse((not is_list, f"{place(key)}: expected a list of {what}"))
    return list(given)


def full_name(name: Any, among: Iterable[str], where: str, wrong: str, known: str = "") -> str:
    """The one of the names `among` which this is, with or without its file.

    Raises WrongOption where it is none: what is `wrong`, and the names, or in words what is `known`.
    """
    every = tuple(among)
    found = next((one for one in every if name in (one, short(one))), "")
    refuse((not found, f"{where}: {wrong}; known are {known or ', '.join(every)}"))
    return found


def known_value(
    name: str, entry: Any, place: Place, key: str, units: Mapping[str, str] = MappingProxyType({})
) -> Known:
    """A known value from {value, uncertainty, unit, source}, which the file calls `key`; `units` beside the design's.

    Raises WrongOption.
    """
    is_entry = isinstance(entry, dict) and {*ENTRY[:3]} <= set(entry) <= set(ENTRY)
    refuse((not is_entry, f"{place('known', key)}: expected {{{', '.join(ENTRY)}}} (source may be left out)"))
    declared = DECLARED.get(name, {"unit": units.get(name), "bound": Bound()})
    value = value_of(entry, str(declared["unit"]), place, "known", key, most=1e9)
    sd = number(entry["uncertainty"], place("known", key, "uncertainty"), 0.0, 1e9)
    refuse((sd == 0.0, f"{place('known', key, 'uncertainty')}: 0, must be above 0"),
           (not declared["bound"].holds(value), f"{place('known', key, 'value')}: {value:g}, must be "
                                                f"{declared['bound']}"))  # fmt: skip
    return Known(name, value, sd, str(entry.get("source", "")))


def value_of(entry: Any, unit: str, place: Place, *keys: str, most: float = 1e6) -> float:
    """The value of {value, unit, source} at these keys, `most` in size. Raises WrongOption."""
    is_entry = isinstance(entry, Mapping) and {"value", "unit"} <= set(entry)
    refuse((not is_entry, f"{place(*keys)}: expected {{value, unit, source}}"))
    refuse((entry["unit"] != unit, f"{place(*keys, 'unit')}: {entry['unit']}, must be {unit}"))
    return number(entry["value"], place(*keys, "value"), -most, most)
