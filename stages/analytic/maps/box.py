"""The designs of a map: a grid, or points that fill a box evenly, by their number."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from stages.analytic.gait.design_point import DesignPoint
from stages.biped.question import Place, WrongOption, number, only, place_of, refuse

KINDS = ("sobol", "grid")
KEYS = ("kind", "count", "seed", "vary")
MOST = 10_000_000


@dataclass(frozen=True)
class Axis:
    """A parameter and its range, evenly spread or evenly in the logarithm; `steps` values of it in a grid."""

    name: str
    unit: str
    low: float
    high: float
    log: bool
    steps: int

    def at(self, shares: np.ndarray) -> np.ndarray:
        """Values at shares (n,) of the way from low to high."""
        if self.log:
            return np.clip(self.low * (self.high / self.low) ** shares, self.low, self.high)
        return np.clip(self.low + (self.high - self.low) * shares, self.low, self.high)


@dataclass(frozen=True)
class Box:
    """So many designs: a grid, the last axis quickest, or with `seed` the points of a scrambled Sobol sequence."""

    axes: tuple[Axis, ...]
    size: int
    seed: int | None

    @property
    def shape(self) -> tuple[int, ...]:
        """Values of each axis of a grid."""
        return tuple(axis.steps for axis in self.axes)

    def in_words(self) -> str:
        """The box in a line for each axis."""
        how = "grid, the last axis quickest" if self.seed is None else f"sobol, {self.size} designs, seed {self.seed}"
        return "\n".join([how, *(
            f"{axis.name} = {axis.low:g} .. {axis.high:g} {axis.unit}" + (", log" if axis.log else "")
            + (f", {axis.steps} steps" if axis.steps else "") for axis in self.axes)])

    def values(self, first: int, end: int) -> np.ndarray:
        """Values of the designs from number `first` to before `end`, (n, axes)."""
        return self.at(self.shares(first, end))

    def shares(self, first: int, end: int) -> np.ndarray:
        """Where these designs lie, as shares of the ranges, (n, axes)."""
        if self.seed is None:
            places = np.array(np.unravel_index(np.arange(first, end), self.shape)).reshape(len(self.axes), -1).T
            return np.asarray(places / (np.array(self.shape) - 1))
        return evenly(len(self.axes), self.seed, first, end)

    def at(self, shares: np.ndarray) -> np.ndarray:
        """Values at shares (n, axes) of the ranges."""
        return np.column_stack([axis.at(share) for axis, share in zip(self.axes, shares.T, strict=True)])

    def spread(self, count: int) -> np.ndarray:
        """So many designs all over the box, none of which need be in the map, (count, axes)."""
        return self.at(evenly(len(self.axes), 0 if self.seed is None else self.seed + 1, 0, count))

    def design(self, base: DesignPoint, values: np.ndarray) -> DesignPoint:
        """The design with these values (axes,) of the varied parameters."""
        return base.with_values({axis.name: value for axis, value in zip(self.axes, values.tolist(), strict=True)})


def evenly(axes: int, seed: int, first: int, end: int) -> np.ndarray:
    """Points `first` to before `end` of a scrambled Sobol sequence in the unit cube, (n, axes)."""
    from scipy.stats import qmc

    sequence = qmc.Sobol(axes, seed=np.random.default_rng(seed))
    if first:
        sequence.fast_forward(int(first))
        return np.asarray(sequence.random(end - first))
    return np.asarray(sequence.random_base2(max(end - 1, 1).bit_length()))[:end]  # a first power of two: no warning


def read(given: Mapping[str, Any], base: DesignPoint) -> Box:
    """The map that a file describes. Raises WrongOption, a sentence with key, value and what is allowed."""
    at = place_of(given)
    only(given, KEYS, at, wrong="a map has no such key; its keys are")
    kind = given.get("kind", KINDS[0])
    vary: Any = given.get("vary")
    refuse((kind not in KINDS, f"{at('kind')}: {kind!r}, must be {' or '.join(KINDS)}"),
           (not isinstance(vary, Mapping) or not vary,
            f"{at('vary')}: must be names like ground.slope_deg, each with {{low: ..., high: ...}}"))
    axes = tuple(axis(str(name), about, base, kind, partial(at, "vary", name)) for name, about in vary.items())
    if kind == "grid":
        size = math.prod(each.steps for each in axes)
        refuse(*((key in given, f"{at(key)}: {given.get(key)!r}, must be left out of a grid") for key in KEYS[1:3]),
               (size > MOST, f"{at('vary')}: {size} designs, must be at most {MOST}"))
        return Box(axes, size, None)
    count = int(number(given.get("count"), at("count"), 1, MOST, whole=True))
    return Box(axes, count, int(number(given.get("seed", 1), at("seed"), 0, 2**31, whole=True)))


def axis(name: str, about: Any, base: DesignPoint, kind: str, at: Place) -> Axis:
    """One varied parameter; `at` says where an entry of it stands. Raises WrongOption."""
    try:
        bound, unit = base.bound(name), base.unit(name)
    except KeyError as error:
        raise WrongOption(f"{at()}: {error.args[0]}") from None
    refuse((not isinstance(about, Mapping), f"{at()}: {about!r}, must be {{low: ..., high: ...}}"))
    only(about, ("low", "high", "scale", "steps"), at)
    low, high = (number(about.get(key), at(key)) for key in ("low", "high"))
    scale = about.get("scale", "linear")
    refuse(
        *((not bound.holds(value), f"{at(key)}: {value:g}, must be {bound}")
          for key, value in (("low", low), ("high", high))),
        (not low < high, f"{at('high')}: {high:g}, must be > low = {low:g}"),
        (scale not in ("linear", "log"), f"{at('scale')}: {scale!r}, must be linear or log"),
        (scale == "log" and low <= 0, f"{at('low')}: {low:g}, must be > 0 where the scale is log"),
        (kind != "grid" and "steps" in about,
         f"{at('steps')}: {about.get('steps')!r}, must be left out: only a grid has steps"))
    steps = int(number(about.get("steps"), at("steps"), 2, MOST, whole=True)) if kind == "grid" else 0
    return Axis(name, unit, low, high, scale == "log", steps)
