"""Similar robots: all lengths, times and masses of a study times three numbers, every value by its unit."""

import dataclasses
import re

import numpy as np

#: Powers of mass, length and time.
PARTS = {
    "kg": (1, 0, 0), "m": (0, 1, 0), "mm": (0, 1, 0), "s": (0, 0, 1), "Hz": (0, 0, -1), "N": (1, 1, -2),
    "J": (1, 2, -2), "W": (1, 2, -3), "g": (0, 1, -2),
    **dict.fromkeys(("deg", "rad", "1", "-", "ppm", "B", "inch"), (0, 0, 0)),
}  # fmt: skip
#: Exponent of the ground: with this one, no power of four leaves anything to round-off.
EXPONENT = 2.5


def factor(unit, scale, exponent=EXPONENT):
    """By what a value in this unit grows where masses, lengths and times grow by `scale` (3,); KeyError for no unit."""
    total = 1.0
    for place, part in enumerate(unit.split("/")):
        for name, power in re.findall(r"([a-zA-Z1-]+)(?:\^(\S+))?", part):
            times = exponent if power == "e" else float(power or 1)
            sizes = np.array(PARTS[name]) * (times if place == 0 else -times)
            total *= float(np.prod(np.array(scale, dtype=float) ** sizes))
    return total


def similar(section, scale):
    """A section of parameters, or all of a stage's, for the similar robot."""
    changes = {}
    for field in dataclasses.fields(section):
        value, unit = getattr(section, field.name), field.metadata.get("unit")
        if dataclasses.is_dataclass(value) and not unit:
            changes[field.name] = similar(value, scale)
        elif isinstance(value, float | int) and not isinstance(value, bool) and factor(unit, scale) != 1.0:
            changes[field.name] = value * factor(unit, scale)
        elif isinstance(value, tuple) and value and all(isinstance(one, float | int) for one in value):
            changes[field.name] = tuple(one * factor(unit, scale) for one in value)
    return dataclasses.replace(section, **changes)


def differences(one, other, scale, where=""):
    """Largest relative difference of each number of two results, by its path, once the first is scaled by its unit."""
    found = {}
    for field in dataclasses.fields(one):
        first, second, unit = getattr(one, field.name), getattr(other, field.name), field.metadata.get("unit", "-")
        name = f"{where}{field.name}"
        if dataclasses.is_dataclass(first):
            found |= differences(first, second, scale, f"{name}.")
        elif isinstance(first, tuple) and first and dataclasses.is_dataclass(first[0]):
            assert len(first) == len(second), name
            for number, (left, right) in enumerate(zip(first, second, strict=True)):
                found |= differences(left, right, scale, f"{name}.{number}.")
        elif isinstance(first, float | int | np.ndarray) and unit != "-" and np.size(first):
            left, right = np.asarray(first, dtype=float) * factor(unit, scale), np.asarray(second, dtype=float)
            assert left.shape == right.shape and (np.isfinite(left) == np.isfinite(right)).all(), name
            known = np.isfinite(left)
            size = np.abs(left[known]).max(initial=0.0)
            found[name] = float(np.abs(left[known] - right[known]).max(initial=0.0) / (size or 1.0))
    return found
