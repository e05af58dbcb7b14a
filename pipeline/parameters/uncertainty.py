"""How far a value in a parameter file may be off: a half-width given with it, or half of the last digit of a print.

`{value: 0.1, uncertainty: 0.002, ...}` lets the value lie within 0.002 of 0.1; `{value: 0.1, printed: "0.100", ...}`
says how a source prints it, and so within 0.0005. A value without either is exact, and so is one that is set anew or
edited: it is not the printed one any more.
"""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Collection, Mapping
from decimal import Decimal
from functools import cache
from typing import Any

#: Parts of an entry that say so.
PARTS = ("uncertainty", "printed")
#: The metadata of a field of a parameter class that is filled with the half-widths of its file's values.
DERIVED = "half_widths"
#: What follows on a key where a half-width stands among plain parameters.
SUFFIX = " half-width"
_DIGITS = re.compile(r"[-+]?[0-9]+(\.[0-9]*)?$")


@cache
def derived(cls: type) -> tuple[str, ...]:
    """The fields of a parameter class that are filled with half-widths, key -> half-width, and are no parameters."""
    return tuple(field.name for field in dataclasses.fields(cls) if field.metadata.get(DERIVED))


def half_width(parts: Mapping[str, Any]) -> float | None:
    """The half-width that the parts of an entry (plain) give its value; None for an exact one.

    Raises ValueError with the reason, to follow on the key.
    """
    given = [part for part in PARTS if part in parts]
    if not given:
        return None
    value = parts.get("value")
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise ValueError(f'has a part "{given[0]}", which only a number can have')
    if len(given) > 1:
        raise ValueError("has both an uncertainty and digits as printed; give one of them")
    said = parts[given[0]]
    if given[0] == "uncertainty":
        if isinstance(said, bool) or not isinstance(said, (int, float)) or not 0 <= said < math.inf:
            raise ValueError(f"has the uncertainty {said!r}; allowed: a number >= 0, in the unit of the value")
        return float(said)
    if not isinstance(said, str) or not _DIGITS.match(said):
        raise ValueError(f'is printed as {said!r}; write the digits as text, as in printed: "0.100"')
    if float(said) != value:  # somebody's own value now
        return None
    return 0.5 * 10.0 ** int(Decimal(said).as_tuple().exponent)


def without(section: Any, keys: Collection[str]) -> Any:
    """A section of parameters in which the values of `keys` are exact."""
    kind: type = type(section)
    exact = {
        name: {key: width for key, width in getattr(section, name).items() if key not in keys}
        for name in derived(kind)
    }
    return dataclasses.replace(section, **exact) if exact else section
