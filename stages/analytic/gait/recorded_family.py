"""Families of gaits over a parameter as they are kept and drawn: every step of every gait, and where they turn."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from stages.analytic.explored import RecordedFamily, Turn
from stages.analytic.gait.continuation import Branch, BranchPoint
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.poincare import poincare_map


def recorded(design: DesignPoint, branch: Branch, tolerance: float) -> RecordedFamily:
    """A family with every step of its gaits, which are walked once more; its turns are among the gaits."""
    points = _with_turns(branch)
    durations, angles, double = _steps(design, branch, points, tolerance)
    multipliers = np.array([point.floquet_multipliers for point in points])
    turns = tuple(
        Turn(special.kind, special.point.value, _nearest(special.kind, special.point),
             *(steps[0] for steps in _steps(design, branch, [special.point], tolerance)[:2]))
        for special in branch.special
    )  # fmt: skip
    return RecordedFamily(
        branch.cycle, branch.ended, np.array([point.value for point in points]), durations, angles, double,
        np.stack([multipliers.real, multipliers.imag], axis=-1), turns,
    )  # fmt: skip


def _with_turns(branch: Branch) -> list[BranchPoint]:
    """The gaits of a branch with its special points, each between the neighbours that it is nearest to."""
    points = list(branch.points)
    for special in branch.special:
        away = [float(np.abs(special.point.z - point.z).max()) for point in points]
        if len(points) > 1:
            before = min(range(len(points) - 1), key=lambda i: away[i] + away[i + 1])
            points.insert(before + 1, special.point)
    return points


def _nearest(kind: str, point: BranchPoint) -> float:
    wanted = -1.0 if kind == "period doubling" else 1.0
    return float(point.floquet_multipliers[np.abs(point.floquet_multipliers - wanted).argmin()].real)


def _steps(
    design: DesignPoint, branch: Branch, points: Iterable[BranchPoint], tolerance: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Duration of every step [s], stance angle at its begin [rad] and double stance [s] of gaits, each (n, steps)."""
    rows = []
    for point in points:
        walker, z, row = design.with_value(branch.name, point.value).walker(), point.z, []
        for _ in range(branch.cycle * walker.gait_steps):
            step = poincare_map(walker, z, tolerance)
            row.append((step.period * walker.time, -z[0], step.double_stance * walker.time))
            z, walker = step.z, walker.exchanged
        rows.append(row)
    found = np.array(rows)
    return found[..., 0], found[..., 1], found[..., 2]
