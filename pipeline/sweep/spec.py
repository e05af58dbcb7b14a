"""The file a sweep is described in: stage, varied parameters, points, outputs, and how long a point may take."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pipeline.errors import StudyError, nearest
from pipeline.parameters import yaml_text
from pipeline.parameters.yaml_text import Node
from pipeline.study import shown
from pipeline.sweep.axes import Axis, Choice, Normal, Range

KINDS = ("grid", "list", "latin_hypercube", "monte_carlo")
_KEYS = ("stage", "kind", "count", "seed", "set", "vary", "points", "outputs", "time_limit_s", "start_limit_s")
_AXIS_KEYS = ("low", "high", "steps", "scale", "mean", "deviation", "values")
_MOST_POINTS = 10_000_000


@dataclass(frozen=True)
class Spec:
    """A sweep. `axes` maps names like biped.hip_mass to what they run over; a list has `points` instead.

    `settings` are fixed changes as `--set` takes them; `outputs` are patterns of column names; `start_limit_s` is
    what the first point in a fresh process may take longer, because it may have to compile.
    """

    name: str
    stage: str
    kind: str
    axes: Mapping[str, Axis]
    points: tuple[Mapping[str, Any], ...]
    count: int
    seed: int
    settings: tuple[str, ...]
    outputs: tuple[str, ...]
    time_limit_s: float
    start_limit_s: float

    @property
    def names(self) -> tuple[str, ...]:
        """The varied parameters."""
        if self.kind == "list":
            return tuple(dict.fromkeys(name for point in self.points for name in point))
        return tuple(self.axes)


def read(path: Path) -> Spec:
    """Read a sweep's file. Raises `StudyError` with a sentence for each thing that is wrong with it."""
    return _Reading(shown(path)).read(path)


class _Reading:
    """One reading: how the file is called, and the problems found so far."""

    def __init__(self, where: str) -> None:
        self.where = where
        self.problems: list[str] = []

    def read(self, path: Path) -> Spec:
        tree = yaml_text.read(path, self.where)
        entries: dict[str, Node] = tree.value if isinstance(tree.value, dict) else {}
        for key, node in entries.items():
            if key not in _KEYS:
                self._wrong(node, f'there is no key "{key}" in a sweep (keys: {", ".join(_KEYS)}){nearest(key, _KEYS)}')
        missing = [key for key in ("stage", "kind") if key not in entries]
        if missing:
            raise StudyError([*self.problems, f"{self.where}: {missing[0]} is missing"])
        kind = entries["kind"].value
        if kind not in KINDS:
            self._wrong(entries["kind"], f"kind = {kind} is not allowed; allowed: {', '.join(KINDS)}")
        axes, points = self._axes(entries, kind), self._points(entries, kind)
        count = self._count(entries, kind, axes, points)
        spec = Spec(
            name=path.stem,
            stage=str(entries["stage"].value),
            kind=str(kind),
            axes=axes,
            points=points,
            count=count,
            seed=int(self._number(entries, "seed", 0, 0, 2**63, whole=True)),
            settings=self._settings(entries),
            outputs=self._outputs(entries),
            time_limit_s=self._number(entries, "time_limit_s", 60.0, 0.01, 1e6),
            start_limit_s=self._number(entries, "start_limit_s", 600.0, 0.0, 1e6),
        )
        if self.problems:
            raise StudyError(self.problems)
        return spec

    def _wrong(self, node: Node, text: str) -> None:
        self.problems.append(f"{self.where}:{node.line}: {text}")

    def _number(
        self, entries: dict[str, Node], key: str, default: float, low: float, high: float, whole: bool = False
    ) -> float:
        node = entries.get(key)
        if node is None:
            return default
        value = node.value
        legal = isinstance(value, (int, float)) and not isinstance(value, bool) and low <= value <= high
        if not legal or (whole and value != int(value)):
            noun = "a whole number" if whole else "a number"
            self._wrong(node, f"{key} = {value} is not allowed; allowed: {noun} from {low:g} to {high:g}")
            return default
        return float(value) if not whole else int(value)

    def _axes(self, entries: dict[str, Node], kind: Any) -> dict[str, Axis]:
        if kind == "list":
            return {}
        node = entries.get("vary")
        if node is None or not isinstance(node.value, dict) or not node.value:
            self.problems.append(f"{self.where}: vary is missing; it maps names like biped.hip_mass to ranges")
            return {}
        axes = {name: self._axis(name, item, kind) for name, item in node.value.items()}
        return {name: axis for name, axis in axes.items() if axis is not None}

    def _axis(self, name: str, node: Node, kind: Any) -> Axis | None:
        plain = node.plain()
        if isinstance(plain, list):
            plain = {"values": plain}
        parts: dict[str, Any] = plain if isinstance(plain, dict) else {}
        unknown = [key for key in parts if key not in _AXIS_KEYS]
        numbers = all(_is_number(parts[key]) for key in ("low", "high", "mean", "deviation") if key in parts)
        if unknown or not numbers:
            self._wrong(node, f"{name}: " + (f'there is no "{unknown[0]}" here' if unknown else "expected numbers"))
        elif set(parts) == {"values"} and isinstance(parts["values"], list) and parts["values"]:
            return Choice(tuple(parts["values"]))
        elif set(parts) == {"mean", "deviation"} and kind != "grid" and parts["deviation"] > 0:
            return Normal(float(parts["mean"]), float(parts["deviation"]))
        elif {"low", "high"} <= set(parts) <= {"low", "high", "steps", "scale"} and parts["low"] < parts["high"]:
            return self._range(name, node, parts, kind)
        else:
            self._wrong(node, f"{name}: expected [a, b, ...], {{low, high}} with low < high (and steps in a grid, "
                              "scale: log where wanted), or, where points are drawn, {mean, deviation}")  # fmt: skip
        return None

    def _range(self, name: str, node: Node, parts: dict[str, Any], kind: Any) -> Axis | None:
        steps, logarithmic = parts.get("steps"), parts.get("scale") == "log"
        if parts.get("scale", "log") != "log" or (logarithmic and parts["low"] <= 0):
            self._wrong(node, f"{name}: the only scale besides the plain one is log, and it needs low > 0")
        elif (kind == "grid") != isinstance(steps, int) or (isinstance(steps, int) and steps < 2):
            self._wrong(node, f"{name}: steps, a whole number from 2, is given in a grid and only there")
        else:
            return Range(float(parts["low"]), float(parts["high"]), logarithmic, steps)
        return None

    def _points(self, entries: dict[str, Node], kind: Any) -> tuple[Mapping[str, Any], ...]:
        if kind != "list":
            return ()
        node = entries.get("points")
        rows = node.plain() if node is not None else None
        if not isinstance(rows, list) or not rows or not all(isinstance(row, dict) and row for row in rows):
            self.problems.append(f"{self.where}: points is missing; it is a list of rows like {{biped.hip_mass: 0.3}}")
            return ()
        return tuple(rows)

    def _count(
        self, entries: dict[str, Node], kind: Any, axes: Mapping[str, Axis], points: tuple[Mapping[str, Any], ...]
    ) -> int:
        if kind in ("grid", "list"):
            for key in ("count", "seed"):
                if key in entries:
                    self._wrong(entries[key], f"a {kind} has no {key}")
            count = len(points)
            if kind == "grid":
                count = 1
                for axis in axes.values():
                    count *= len(axis.values())
            if count > _MOST_POINTS:
                self.problems.append(f"{self.where}: {count} points; at most {_MOST_POINTS} are allowed")
            return count
        for key in ("count", "seed"):
            if key not in entries:
                self.problems.append(f"{self.where}: {key} is missing; kind {kind} draws count points with a seed")
        return int(self._number(entries, "count", 1, 1, _MOST_POINTS, whole=True))

    def _settings(self, entries: dict[str, Node]) -> tuple[str, ...]:
        node = entries.get("set")
        plain = node.plain() if node is not None else {}
        if not isinstance(plain, dict):
            self._wrong(entries["set"], "set must map names like analytic.steps to values")
            return ()
        return tuple(f"{name}={_as_yaml(value)}" for name, value in plain.items())

    def _outputs(self, entries: dict[str, Node]) -> tuple[str, ...]:
        node = entries.get("outputs")
        plain = node.plain() if node is not None else ["*"]
        if not isinstance(plain, list) or not plain or not all(isinstance(item, str) for item in plain):
            self._wrong(entries["outputs"], "outputs must be a list of names or patterns such as gait.*")
            return ("*",)
        return tuple(plain)


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < float("inf")


def _as_yaml(value: Any) -> str:
    import json

    return json.dumps(value)  # JSON is YAML
