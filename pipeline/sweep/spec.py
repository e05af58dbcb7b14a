"""The file a sweep is described in: stage, varied parameters, points, outputs, and how long a point may take.

The same spec gives the same points. A varied parameter is a map from a share between 0 and 1 to a value. Fields have
unit, bound and choices, as stages declare parameters.
"""

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import MISSING, dataclass, field
from functools import cached_property
from pathlib import Path
from statistics import NormalDist
from typing import Any, NamedTuple

import numpy as np

from pipeline.errors import StudyError, nearest
from pipeline.parameters import yaml_text
from pipeline.parameters.value import allowed, declared, shown, values_of
from pipeline.study import shown as shown_path


class Between(NamedTuple):
    """Limits of a number, both allowed."""

    least: float = -math.inf
    most: float = math.inf

    def holds(self, value: float) -> bool:
        """Whether `value` is finite and keeps to the limits."""
        return math.isfinite(value) and self.least <= value <= self.most

    def __str__(self) -> str:
        limits = ((">=", self.least), ("<=", self.most))
        return " and ".join(f"{sign} {limit:g}" for sign, limit in limits if math.isfinite(limit)) or "any number"


class Broken(NamedTuple):
    """A rule between several values that does not hold: the key to blame, and what is allowed."""

    key: str
    allowed: str


_ANY = Between()


def entry(
    description: str, *, unit: str = "1", bound: Between | str = _ANY, choices: tuple[str, ...] = (),
    default: Any = MISSING,
) -> Any:  # fmt: skip
    """A field of a dataclass that is read from a file. `bound` limits a number, or says in words what is allowed."""
    metadata = {"unit": unit, "description": description, "bound": bound, "choices": choices}
    return field(metadata=metadata, default=default)


@dataclass(frozen=True)
class Range:
    """Values from `low` to `high`, evenly spread, or evenly in the logarithm; `steps` of them in a grid."""

    low: float = entry("least value")
    high: float = entry("largest value")
    steps: int | None = entry("values in a grid, both ends among them", bound=Between(2), default=None)
    scale: str = entry("how they are spread", choices=("linear", "log"), default="linear")

    def broken_rules(self) -> Iterator[Broken]:
        """Rules between the values that do not hold."""
        if self.high <= self.low:
            yield Broken("high", f"> low = {self.low:g}")
        if self.scale == "log" and self.low <= 0:
            yield Broken("low", "> 0 where the scale is log")

    def at(self, share: float) -> float:
        """The value at `share` of the way, in [low, high]."""
        if self.scale == "log":
            value = math.exp(math.log(self.low) + share * (math.log(self.high) - math.log(self.low)))
        else:
            value = self.low + share * (self.high - self.low)
        return min(max(value, self.low), self.high)

    def values(self) -> list[Any]:
        """The values of a grid, both ends included."""
        spread = np.geomspace if self.scale == "log" else np.linspace  # decades and ends come out as they are written
        return list(spread(self.low, self.high, self.steps or 1).tolist())


@dataclass(frozen=True)
class Normal:
    """Normally distributed values."""

    mean: float = entry("mean")
    deviation: float = entry("standard deviation")

    def broken_rules(self) -> Iterator[Broken]:
        """Rules that do not hold."""
        if self.deviation <= 0:
            yield Broken("deviation", "> 0")

    def at(self, share: float) -> float:
        """The quantile of `share`; the ends of the interval stay finite."""
        return NormalDist(self.mean, self.deviation).inv_cdf(min(max(share, 1e-16), 1 - 1e-16))

    def values(self) -> list[Any]:
        """The mean, which must be legal; a distribution has no grid."""
        return [self.mean]


@dataclass(frozen=True)
class Choice:
    """Given values, each as likely as the others."""

    options: tuple[Any, ...]

    def at(self, share: float) -> Any:
        """The option whose equal part of the interval holds `share`."""
        return self.options[min(int(share * len(self.options)), len(self.options) - 1)]

    def values(self) -> list[Any]:
        """All options in order."""
        return list(self.options)


Axis = Range | Normal | Choice


Point = dict[str, Any]
_MOST_POINTS = 10_000_000
_DRAWN = ("count", "seed", "vary")
#: Kinds of sweeps, and the keys that make their points.
KINDS = {"grid": ("vary",), "list": ("points",), "latin_hypercube": _DRAWN, "monte_carlo": _DRAWN}


@dataclass(frozen=True)
class Spec:
    """A sweep: what its file says, and the file's name."""

    stage: str = entry("any stage; what it reads is computed as well", bound="a stage of dvc.yaml")
    kind: str = entry("how points are made", choices=tuple(KINDS))
    count: int | None = entry("points to draw", bound=Between(1, _MOST_POINTS), default=None)
    seed: int | None = entry("the same seed draws the same points", bound=Between(0, 2**63), default=None)
    vary: Mapping[str, tuple[Any, ...] | Range | Normal] | None = entry(
        "what each varied parameter runs over", default=None,
        bound="names like ground.gravity, each with [a, b, ...], {low, high} or {mean, deviation}")  # fmt: skip
    points: tuple[Mapping[str, Any], ...] = entry(
        "the points themselves", bound="a list of rows like {ground.gravity: 9.8}", default=())  # fmt: skip
    set: Mapping[str, Any] | None = entry(
        "fixed changes, as --set takes them", bound="names like ground.gravity with values", default=None)  # fmt: skip
    outputs: tuple[str, ...] = entry("columns to keep", bound="names or patterns such as energy.*", default=("*",))
    time_limit_s: float = entry("for a point", unit="s", bound=Between(0.01, 1e6), default=60.0)
    start_limit_s: float = entry(
        "more for the first point of a process, which may have to compile", unit="s", bound=Between(0, 1e6),
        default=600.0)  # fmt: skip
    file: str = ""

    @cached_property
    def axes(self) -> dict[str, Axis]:
        """The varied parameters with what they run over; none in a list."""
        return {name: Choice(over) if isinstance(over, tuple) else over for name, over in (self.vary or {}).items()}

    @cached_property
    def _grids(self) -> dict[str, list[Any]]:
        return {name: axis.values() for name, axis in self.axes.items()}

    @property
    def names(self) -> tuple[str, ...]:
        """The varied parameters."""
        return tuple(dict.fromkeys([*(self.vary or {}), *(name for point in self.points for name in point)]))

    @property
    def settings(self) -> tuple[str, ...]:
        """The fixed changes as texts for `--set`."""
        return tuple(f"{name}={json.dumps(value)}" for name, value in (self.set or {}).items())  # JSON is YAML

    @cached_property
    def size(self) -> int:
        """How many points there are."""
        if self.kind == "grid":
            return math.prod(map(len, self._grids.values()))
        return self.count or len(self.points)

    @cached_property
    def _shares(self) -> np.ndarray | None:
        """Shares between 0 and 1 of each drawn point, shape (count, parameters); None where points are not drawn."""
        if self.kind not in ("latin_hypercube", "monte_carlo"):
            return None
        random = np.random.default_rng(self.seed)
        if self.kind == "monte_carlo":
            return random.random((self.size, len(self.axes)))
        from scipy.stats import qmc

        return np.asarray(qmc.LatinHypercube(d=len(self.axes), seed=random).random(self.size))

    def point(self, index: int) -> Point:
        """The point of this number, made when it is requested, so that a million of them need little memory."""
        if self.kind == "list":
            return dict(self.points[index])
        if self._shares is not None:
            return {name: axis.at(float(share)) for (name, axis), share in zip(self.axes.items(), self._shares[index])}
        point: Point = {}
        for name, values in reversed(self._grids.items()):  # the last parameter changes fastest
            index, place = divmod(index, len(values))
            point[name] = values[place]
        return {name: point[name] for name in self.axes}

    def problems(self) -> Iterator[tuple[str, str]]:
        """What does not fit together: the key to blame, and a sentence."""
        for key in (*_DRAWN, "points"):
            value, needed = getattr(self, key), key in KINDS[self.kind]
            missing = value in (None, {}, ())
            if missing and needed:
                yield key, f"{key} is missing; allowed: {allowed(*declared(Spec)[key])}"
            elif needed == missing:
                yield key, f"{key} = {shown(value)} is not allowed; a sweep of kind {self.kind} has none"
        for name, over in (self.vary or {}).items():
            if isinstance(over, Normal) and self.kind == "grid":
                yield "vary", f"vary: {name}: a distribution has no grid; allowed: [a, b, ...] or {{low, high, steps}}"
            if isinstance(over, Range) and (over.steps is None) == (self.kind == "grid"):
                yield "vary", f"vary: {name}: steps, a whole number from 2, is given in a grid and only there"
            if over == ():
                yield "vary", f"vary: {name} = [] is not allowed; allowed: at least one value"
        if any(not point for point in self.points):
            yield "points", "points: a row without values"
        if self.size > _MOST_POINTS:
            yield "vary", f"{self.size} points; at most {_MOST_POINTS} are allowed"


def read(path: Path) -> Spec:
    """Read a sweep's file. Raises `StudyError` with a sentence for each thing that is wrong with it."""
    where = shown_path(path)
    tree = yaml_text.read(path, where)
    entries: dict[str, yaml_text.Node] = tree.value if isinstance(tree.value, dict) else {}
    known = {key: about for key, about in declared(Spec).items() if about[0].metadata}
    problems = [
        f'{where}:{node.line}: there is no key "{key}" in a sweep (keys: {", ".join(known)}){nearest(key, known)}'
        for key, node in entries.items()
        if key not in known
    ]
    values, wrong = values_of(Spec, {key: node for key, node in entries.items() if key in known})
    problems += [f"{where}{f':{line}' if key in entries else ''}: {sentence}" for key, line, sentence in wrong]
    if not problems:
        spec = Spec(**values, file=where)
        for key, text in spec.problems():
            problems.append(f"{where}:{entries[key].line}: {text}" if key in entries else f"{where}: {text}")
    if problems:
        raise StudyError(problems)
    return spec
