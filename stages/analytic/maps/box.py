"""The designs of a map: a grid, or points that fill a box evenly, by their number."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Any

import numpy as np

from stages.analytic.gait.design_point import DesignPoint
from stages.biped.question import WrongOption

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
        if self.seed is None:
            places = np.array(np.unravel_index(np.arange(first, end), self.shape)).reshape(len(self.axes), -1).T
            return self.at(places / (np.array(self.shape) - 1))
        return self.at(evenly(len(self.axes), self.seed, first, end))

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
    known(given, KEYS, "a map")
    kind = given.get("kind", KINDS[0])
    if kind not in KINDS:
        raise WrongOption(f"kind = {kind!r} is not allowed; allowed: {' or '.join(KINDS)}")
    vary = given.get("vary")
    if not isinstance(vary, Mapping) or not vary:
        raise WrongOption("vary: allowed are names like ground.slope_deg, each with {low: ..., high: ...}")
    axes = tuple(axis(str(name), about, base, kind) for name, about in vary.items())
    if kind == "grid":
        for key in ("count", "seed"):
            if key in given:
                raise WrongOption(f"{key} = {given[key]!r} is not allowed; a grid has none")
        size = math.prod(each.steps for each in axes)
        if size > MOST:
            raise WrongOption(f"vary: {size} designs; at most {MOST} are allowed")
        return Box(axes, size, None)
    count = whole(given.get("count"), "count", 1, MOST)
    return Box(axes, count, whole(given.get("seed", 1), "seed", 0, 2**31))


def axis(name: str, about: Any, base: DesignPoint, kind: str) -> Axis:
    """One varied parameter. Raises WrongOption."""
    try:
        bound, unit = base.bound(name), base.unit(name)
    except KeyError as error:
        raise WrongOption(f"vary: {error.args[0]}") from None
    where = f"vary: {name}"
    if not isinstance(about, Mapping):
        raise WrongOption(f"{where} = {about!r} is not allowed; allowed: {{low: ..., high: ...}}")
    known(about, ("low", "high", "scale", "steps"), where)
    low, high = (number(about.get(key), f"{where}: {key}") for key in ("low", "high"))
    for key, value in (("low", low), ("high", high)):
        if not bound.holds(value):
            raise WrongOption(f"{where}: {key} = {value:g} is not allowed; allowed: {bound}")
    if not low < high:
        raise WrongOption(f"{where}: high = {high:g} is not allowed; allowed: > low = {low:g}")
    scale = about.get("scale", "linear")
    if scale not in ("linear", "log"):
        raise WrongOption(f"{where}: scale = {scale!r} is not allowed; allowed: linear or log")
    if scale == "log" and low <= 0:
        raise WrongOption(f"{where}: low = {low:g} is not allowed; allowed: > 0 where the scale is log")
    if kind != "grid" and "steps" in about:
        raise WrongOption(f"{where}: steps = {about['steps']!r} is not allowed; only a grid has steps")
    steps = whole(about.get("steps"), f"{where}: steps", 2, MOST) if kind == "grid" else 0
    return Axis(name, unit, low, high, scale == "log", steps)


def known(given: Mapping[str, Any], keys: tuple[str, ...], where: str) -> None:
    """Refuse a key that is none of `keys`."""
    for key in given:
        if key not in keys:
            near = get_close_matches(str(key), keys, 1)
            raise WrongOption(f"there is no key {key!r} in {where} (keys: {', '.join(keys)})"
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
    if isinstance(value, bool) or not isinstance(value, int | float) or value % 1 or not least <= value <= most:
        raise WrongOption(f"{where} = {value!r} is not allowed; allowed: a whole number from {least} to {most}")
    return int(value)
