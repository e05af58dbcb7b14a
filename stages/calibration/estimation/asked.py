"""What a lab says beside its recordings: known values with their errors, and what is looked for."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from stages.analytic.gait.design_point import parameter_names
from stages.biped.design import Biped
from stages.biped.question import WrongOption
from stages.calibration.estimation.known import SUMS, TOTAL_MASS, Known
from stages.ground.slope import Slope

ENTRY = ("value", "uncertainty", "unit", "source")
KEYS = ("known", "free", "fixed", "fitted", "held_out", "design")
#: What a fit begins from: the design of biped.yaml, or the bill of parts seen from the side, as the study's own fits.
BIPED, PARTS = "biped", "parts"


@dataclass(frozen=True)
class Asked:
    """Known values; names of parameters that are looked for (all, if there are none) and that keep their value; names
    of runs that are held out, and of those that are fitted (all others, if there are none); the `design` to begin from.
    """

    known: tuple[Known, ...] = ()
    free: tuple[str, ...] = ()
    fixed: tuple[str, ...] = ()
    held_out: tuple[str, ...] = ()
    fitted: tuple[str, ...] = ()
    design: str = BIPED

    def looked_for(self, names: tuple[str, ...]) -> tuple[str, ...]:
        """Those of `names` that are looked for."""
        return tuple(name for name in names if (not self.free or name in self.free) and name not in self.fixed)


def asked_of(about: Mapping[str, Any] | None) -> Asked:
    """Read and check what the file says. Raises WrongOption with file, line, key, value and what is allowed."""
    if about is None:
        return Asked()
    place = about.place  # type: ignore[attr-defined]
    for key in about:
        if key not in KEYS:
            raise WrongOption(f"{place(key)}: there is no such entry; known are {', '.join(KEYS)}")
    known = []
    entries = about.get("known") or {}
    if not isinstance(entries, dict):
        raise WrongOption(f"{place('known')}: expected names with {{{', '.join(ENTRY)}}}")
    for name, entry in entries.items():
        known.append(_known(name, entry, lambda *keys, name=name: place("known", name, *keys)))
    free, fixed = (_names(about.get(key), key, place) for key in ("free", "fixed"))
    of_runs = {key: about.get(key) or [] for key in ("held_out", "fitted")}
    for key, runs in of_runs.items():
        if not isinstance(runs, list) or not all(isinstance(one, (str, int)) for one in runs):
            raise WrongOption(f"{place(key)}: expected a list of names of runs")
    design = about.get("design") or BIPED
    if design not in (BIPED, PARTS):
        raise WrongOption(f"{place('design')}: {design}, must be {BIPED} (biped.yaml as it is) or {PARTS} (the bill of "
                          "parts in twin.yaml, with its frames)")
    held_out, fitted = (tuple(map(str, runs)) for runs in of_runs.values())
    return Asked(tuple(known), free, fixed, held_out, fitted, str(design))


def full_name(name: str) -> str | None:
    """The parameter's name with its file; None if there is no such parameter."""
    return next((one for one in parameter_names() if name in (one, one.partition(".")[2])), None)


def _names(given: Any, key: str, place: Any) -> tuple[str, ...]:
    if given is not None and not isinstance(given, list):
        raise WrongOption(f"{place(key)}: expected a list of parameters")
    found = []
    for number, name in enumerate(given or []):
        whole = full_name(str(name))
        if whole is None:
            raise WrongOption(f"{place(key, number)}: {name} is no parameter of the design; known are "
                              f"{', '.join(parameter_names())}")  # fmt: skip
        found.append(whole)
    return tuple(found)


def _known(name: str, entry: Any, place: Any) -> Known:
    """One known value of the design. Raises WrongOption."""
    whole = name if name in SUMS else full_name(name)
    if whole is None:
        raise WrongOption(f"{place()}: no such quantity; known are {', '.join([*SUMS, *parameter_names()])}")
    return known_value(whole, entry, unit_of, place)


def known_value(name: str, entry: Any, unit_of_name: Callable[[str], str], place: Any) -> Known:
    """A known value from {value, uncertainty, unit, source}. Raises WrongOption."""
    if not isinstance(entry, dict) or set(entry) - set(ENTRY) or not {"value", "uncertainty", "unit"} <= set(entry):
        raise WrongOption(f"{place()}: expected {{{', '.join(ENTRY)}}} (source may be left out)")
    unit = unit_of_name(name)
    if entry["unit"] != unit:
        raise WrongOption(f"{place('unit')}: {entry['unit']}, must be {unit}")
    value = number(entry["value"], place("value"), -1e9, 1e9)
    sd = number(entry["uncertainty"], place("uncertainty"), 0.0, 1e9)
    if sd == 0.0:
        raise WrongOption(f"{place('uncertainty')}: 0, must be above 0")
    return Known(name, value, sd, str(entry.get("source", "")))


def number(given: Any, where: str, least: float, most: float) -> float:
    """A number within limits. Raises WrongOption that says where it stands."""
    is_number = isinstance(given, (int, float)) and not isinstance(given, bool) and math.isfinite(given)
    if not is_number or not least <= given <= most:
        raise WrongOption(f"{where}: {given}, must be a number from {least:g} to {most:g}")
    return float(given)


def unit_of(name: str) -> str:
    """Unit of a parameter or of a known sum."""
    if name == TOTAL_MASS:
        return "kg"
    owner, key = (Biped if name.startswith("biped.") else Slope), name.partition(".")[2]
    return str(owner.__dataclass_fields__[key].metadata["unit"])
