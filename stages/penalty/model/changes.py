"""How a penalty walker's numbers change with parameters of its design, its slope and its contact law.

By complex steps through what makes the numbers of the parameters, so that no rule for a single parameter is written a
second time; only a slope's derivative stands here.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from stages.analytic.derivatives.numbers import sizes
from stages.biped.accuracy.scales import Scales, scales_of
from stages.biped.design import DETAILS, Biped
from stages.ground.contact_law import ContactLaw
from stages.ground.slope import Slope
from stages.penalty.model.walker import LENGTH, RATES, SIZE, Directions, build_penalty, natural_lengths
from stages.penalty.motion.feet import STEP


@dataclass(frozen=True)
class Changes:
    """Parameters, named as in their files, and what a whole share of each does to a walker's numbers.

    `scales` (n,): the share, a parameter's value, or where that is zero a size it could have. `along` (n, numbers
    before the law), `laws` (n, numbers of the law), complex as in `Directions`. `at_start` (n, 12): the change of
    the state at the start of a step, which holds the length of rigid legs.
    """

    names: tuple[str, ...]
    scales: np.ndarray
    along: np.ndarray
    laws: np.ndarray
    at_start: np.ndarray

    def directions(self, columns: int) -> Directions:
        """These changes as directions of the last n of so many variations."""
        return Directions(self.along, self.laws, (self.laws.imag != 0.0).any(axis=1), np.zeros(columns))


def changes_of(
    biped: Biped, slope: Slope, contact: ContactLaw, names: Sequence[str], scales: Scales | None = None
) -> Changes:
    """What whole shares of the parameters do to numbers in `scales`, None: the design's own, which stay as they are.

    Raises KeyError for a name of no number.
    """
    own, (g_x, g_y) = scales or scales_of(biped, slope.gravity), slope.gravity_vector
    fresh = np.array(flat(own.measure(contact).numbers), dtype=complex)
    turned = {"slope_deg": (-math.radians(g_y), math.radians(g_x)),
              "gravity": (g_x / slope.gravity, g_y / slope.gravity)}  # fmt: skip
    along: list[np.ndarray] = []
    gravity: tuple[Any, Any]
    laws: list[np.ndarray] = []
    shares: list[float] = []
    lengths: list[np.ndarray] = []
    for name in names:
        section: Any = owner(name, (biped, slope, contact))
        key = name.partition(".")[2]
        shares.append(getattr(section, key) or sizes(biped, slope)[unit_of(section, key)])
        machine, law, gravity = biped, fresh, slope.gravity_vector
        if section is slope:
            gravity = complex(g_x, STEP * turned[key][0]), complex(g_y, STEP * turned[key][1])
        else:
            moved = replace(section, **{key: complex(getattr(section, key), STEP)})
            machine = moved if section is biped else biped
            if section is contact:
                law = np.array(flat(own.measure(moved).numbers), dtype=complex)
        walker = build_penalty(machine, gravity, contact, 1.0, own)
        along.append(shares[-1] * np.array(flat(walker[:-1]), dtype=complex).imag / STEP)
        laws.append(law.real + 1j * shares[-1] * law.imag)
        lengths.append(shares[-1] * np.array(natural_lengths(walker), dtype=complex).imag / STEP)
    count = len(flat(build_penalty(biped, (g_x, g_y), contact, 1.0)[:-1]))
    rows = np.array(along).reshape(-1, count)
    at_start = np.zeros((len(rows), SIZE))
    if biped.legs == "rigid" and lengths:
        at_start[:, LENGTH:RATES] = lengths
    return Changes(tuple(names), np.array(shares), rows, np.array(laws).reshape(-1, len(fresh)), at_start)


def names_of(biped: Biped, slope: Slope, contact: ContactLaw) -> tuple[str, ...]:
    """Every parameter that moves the numbers of this walker; of the details those that the design has."""
    every = [f"{section.FILE}.{field.name}" for section in (biped, slope, contact)
             for field in fields(section) if isinstance(getattr(section, field.name), float)
             and (section is not biped or getattr(section, field.name) != field.default)]
    changes = changes_of(biped, slope, contact, every)
    moves = (changes.along != 0.0).any(axis=1) | (changes.laws.imag != 0.0).any(axis=1)
    return tuple(name for name, moved in zip(every, moves, strict=True) if moved)


def owner(name: str, sections: tuple[Biped, Slope, ContactLaw]) -> Biped | Slope | ContactLaw:
    """Which of the three holds a number of this name. Raises KeyError."""
    file, _, key = name.partition(".")
    for section in sections:
        if file == section.FILE and isinstance(getattr(section, key, None), float | int):
            if key in DETAILS and not sections[0].detailed:
                raise KeyError(f"{name}: a detail, of which the walker of this design knows nothing")
            return section
    raise KeyError(f"{name}: no number of the design, its slope or its ground")


def unit_of(section: Biped | Slope | ContactLaw, key: str) -> str:
    """The unit of a parameter."""
    return str(next(field for field in fields(section) if field.name == key).metadata["unit"])


def flat(law: Sequence[Any]) -> list[Any]:
    """The numbers of nested tuples, in their order."""
    return [number for part in law for number in (flat(part) if isinstance(part, tuple) else [part])]
