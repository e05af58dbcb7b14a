"""The designs of a map: a grid, or points that fill a box evenly, by their number."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from functools import partial
from typing import Any

import numpy as np

from stages.analytic.gait.design_point import DesignPoint
from stages.biped.question import WrongOption, refuse

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
    at = partial(line, given)
    known(given, KEYS, "a map", at)
    kind = given.get("kind", KINDS[0])
    vary: Any = given.get("vary")
    refuse((kind not in KINDS, f"{at('kind')}kind = {kind!r} is not allowed; allowed: {' or '.join(KINDS)}"),
           (not isinstance(vary, Mapping) or not vary,
            f"{at('vary')}vary: allowed are names like ground.slope_deg, each with {{low: ..., high: ...}}"))
    axes = tuple(axis(str(name), about, base, kind, partial(at, "vary", name)) for name, about in vary.items())
    if kind == "grid":
        size = math.prod(each.steps for each in axes)
        refuse(*((key in given, f"{at(key)}{key} = {given.get(key)!r} is not allowed; a grid has none")
                 for key in KEYS[1:3]),
               (size > MOST, f"{at('vary')}vary: {size} designs; at most {MOST} are allowed"))
        return Box(axes, size, None)
    count = whole(given.get("count"), f"{at('count')}count", 1, MOST)
    return Box(axes, count, whole(given.get("seed", 1), f"{at('seed')}seed", 0, 2**31))


def line(given: Mapping[str, Any], *keys: str) -> str:
    """File and line of an entry, before what is said of it; of what was not read from a file nothing."""
    place = getattr(given, "place", None)
    return "" if place is None else place(*keys).removesuffix(": " + ".".join(map(str, keys))) + ": "


def axis(name: str, about: Any, base: DesignPoint, kind: str, at: Callable[..., str]) -> Axis:
    """One varied parameter; `at` says where an entry of it stands. Raises WrongOption."""
    try:
        bound, unit = base.bound(name), base.unit(name)
    except KeyError as error:
        raise WrongOption(f"{at()}vary: {error.args[0]}") from None
    whole_axis = f"vary: {name}"
    refuse((not isinstance(about, Mapping),
            f"{at()}{whole_axis} = {about!r} is not allowed; allowed: {{low: ..., high: ...}}"))
    known(about, ("low", "high", "scale", "steps"), whole_axis, at)
    where = {key: f"{at(key)}{whole_axis}: {key}" for key in ("low", "high", "scale", "steps")}
    low, high = (number(about.get(key), where[key]) for key in ("low", "high"))
    scale = about.get("scale", "linear")
    refuse(
        *((not bound.holds(value), f"{where[key]} = {value:g} is not allowed; allowed: {bound}")
          for key, value in (("low", low), ("high", high))),
        (not low < high, f"{where['high']} = {high:g} is not allowed; allowed: > low = {low:g}"),
        (scale not in ("linear", "log"), f"{where['scale']} = {scale!r} is not allowed; allowed: linear or log"),
        (scale == "log" and low <= 0, f"{where['low']} = {low:g} is not allowed; allowed: > 0 where the scale is log"),
        (kind != "grid" and "steps" in about,
         f"{where['steps']} = {about.get('steps')!r} is not allowed; only a grid has steps"))
    steps = whole(about.get("steps"), where["steps"], 2, MOST) if kind == "grid" else 0
    return Axis(name, unit, low, high, scale == "log", steps)


def known(given: Mapping[str, Any], keys: tuple[str, ...], where: str, at: Callable[..., str]) -> None:
    """Refuse a key that is none of `keys`."""
    for key in given:
        if key not in keys:
            near = get_close_matches(str(key), keys, 1)
            raise WrongOption(f"{at(key)}there is no key {key!r} in {where} (keys: {', '.join(keys)})"
                              + (f"; did you mean {near[0]}?" if near else ""))  # fmt: skip


def number(value: Any, where: str) -> float:
    """A finite number. Raises WrongOption."""
    try:
        if isinstance(value, bool) or value is None or not math.isfinite(float(value)):
            raise ValueError
        return float(value)
    except (TypeError, ValueError):
        raise WrongOption(f"{where} = {value!r} is not allowed; allowed: a number") from None


def whole(value: Any, where: str, least: int, most: int) -> int:
    """A whole number within limits. Raises WrongOption."""
    is_whole = isinstance(value, int | float) and not isinstance(value, bool) and not value % 1
    refuse((not is_whole or not least <= value <= most,
            f"{where} = {value!r} is not allowed; allowed: a whole number from {least} to {most}"))
    return int(value)
