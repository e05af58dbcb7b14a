"""Combinations of parameters that measurements do not see, in words, with what would help."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stages.analytic.model.walker import Vector
from stages.biped.accuracy.scales import powers
from stages.calibration.information.identifiability import BELONGS

#: Entries of a combination that differ by less are the same.
EQUAL = 0.01


def short(name: str) -> str:
    """A parameter's name without its file."""
    return name.partition(".")[2] or name


def listed(words: Sequence[str]) -> str:
    """a, b and c."""
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"


def is_scale_of_mass(combination: Vector, units: Sequence[str], values: Vector) -> bool:
    """Whether a combination of shares is that of another unit of mass, in which what is zero stays zero."""
    masses = np.array([powers(unit)[0] for unit in units], dtype=float) * (np.asarray(values) != 0.0)
    norm = float(np.linalg.norm(masses) * np.linalg.norm(combination))
    return norm > 0 and abs(float(masses @ combination)) > (1 - EQUAL) * norm


def described(combination: Vector, names: Sequence[str], units: Sequence[str], values: Vector) -> str:
    """A sentence on a combination (n,) of shares of `values` that no measurement tells of."""
    largest = float(combination[np.argmax(np.abs(combination))])
    parts = combination / largest
    rows = [row for row in np.argsort(-np.abs(parts)) if abs(parts[row]) > max(BELONGS, EQUAL)]
    rows = sorted(rows) if all(abs(parts[row] - 1) < EQUAL for row in rows) else rows
    words = [short(names[row]) for row in rows]
    if len(rows) == 1:
        moves = f"{words[0]} may have any value"
    elif all(abs(parts[row] - 1) < EQUAL for row in rows):
        moves = f"{listed(words)} may all change by one and the same share"
    else:
        shares = [f"{word} by {100 * parts[row]:+.0f} %" for word, row in zip(words, rows, strict=True)]
        moves = f"{listed(shares)} may change together"
    if is_scale_of_mass(combination, units, values):
        return (f"not seen: {moves}. That is the scale of mass, which leaves every acceleration and every rate as it "
                "is: weigh the robot (known: total_mass)")
    return f"not seen: {moves}, and the sensors show the same: measure one of them by other means"
