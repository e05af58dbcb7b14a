"""Every figure of the study, drawn from made-up results: nothing in it changes when the models do."""

from __future__ import annotations

import numpy as np
from made_up import DEFAULTS, make_agreement, make_budget, make_study, make_walk, scaled

from stages.comparison.figures import (
    error_budget,
    extremes,
    figure_02,
    figure_04,
    figure_05,
    figure_06,
    figure_07,
    figure_08,
    figure_10,
    figure_16,
    tradeoff,
    twin_ladder,
    twin_pushes,
)
from stages.comparison.stride import last_stride
from stages.extremes.result import Result as Extremes
from stages.tradeoff.result import Errors, Reference, Row
from stages.tradeoff.result import Result as Tradeoff
from stages.twin.walking.snapshots import Snapshots
from stages.twin_ladder.result import COMPLETED, RungGait
from stages.twin_ladder.result import Result as Ladder
from stages.twin_pushes.result import PushedWalk
from stages.twin_pushes.result import Result as Pushes


def poses(walk):
    """Three upright poses with feet side by side."""
    count = 3
    lanes = np.array([-0.04, 0.04, -0.09, 0.09])
    top = np.zeros((count, 4, 3))
    top[:, :, 0], top[:, :, 1], top[:, :, 2] = np.arange(count)[:, None] * 0.08, 0.333, lanes
    up = np.broadcast_to([0.0, 1.0, 0.0], (count, 4, 3))
    axis = np.broadcast_to([0.0, 0.0, 1.0], (count, 3))
    return Snapshots(walk.time[:count], top[:, 0], axis, top, up, top - 0.25 * up, np.full(4, 0.083), 0.02)


def ladder():
    """Three made-up rungs, the second without a gait, the first without motion out of the plane."""
    multipliers, none, unknown = np.array([[-0.7, 0.0], [0.5, 0.1]]), np.zeros((0, 2)), float("nan")
    return Ladder(
        0.48,
        0.16,
        (
            RungGait("first", "more", COMPLETED, False, 0.49, 0.161, 0.0, multipliers, none, 1e-6, 800.0, 20),
            RungGait("second", "more", "fell", False, unknown, unknown, unknown, none, none, unknown, unknown, 0),
            RungGait("third", "more", COMPLETED, True, 0.47, 0.165, 0.0, multipliers, multipliers, 1e-6, 800.0, 20),
        ),
        0.47,
        0.165,
    )


def pushes():
    """A push that is walked off, one that is not, and one of another kind."""
    time = np.linspace(0.0, 2.0, 50)

    def walk(kind, size, outcome):
        reason = "" if outcome == "completed" else "fell in step 2"
        return PushedWalk(kind, "m/s", size, outcome, reason, 4, time, np.sin(time), size * time, time, 0.1, 0.2)

    return Pushes((walk("side", 0.1, "completed"), walk("side", 0.2, "fell"), walk("spin", 1.0, "fell")))


def ways():
    """Two made-up ways of one model: errors fall with cost; one has no multiplier and one does not walk."""
    nan = float("nan")

    def row(way, mark, error, cost, outcome="completed"):
        errors = Errors(error, error, nan if way == "coarse" else error, 1e3 * error)
        return Row("model", way, f"cost {cost}", mark, outcome, errors, cost, nan, nan)

    small = Errors(1e-12, 1e-12, 1e-12, 1e-12)
    reference = Reference("model", "fine", 0.48, 0.64, 500.0, "second", small, "other", small)
    fine = [row("fine", "", error, cost) for error, cost in ((3e-4, 120.0), (1e-5, 160.0), (1e-6, 200.0),
                                                             (1e-7, 300.0), (1e-8, 350.0))]  # fmt: skip
    coarse = [row("coarse", "", error, cost) for error, cost in ((1e-3, 100.0), (1e-4, 300.0), (4e-5, 600.0))]
    rows = (row("fine", "default", 1e-9, 400.0), *fine, row("coarse", "paper", 1e-5, 900.0), *coarse,
            row("coarse", "", nan, nan, "fell"))  # fmt: skip
    return Tradeoff(4, (reference,), rows)


def extreme_points():
    """Every status once, on two made-up axes, one of them with a zero, and two draws."""
    status = ("right", "inaccurate", "refused", "failed", "unconfirmed", "wrong", "crashed", "hung", "right", "failed")
    count, none = len(status), ("",) * len(status)
    axis = ("ground.gravity",) * 4 + ("biped.damping",) * 4 + ("all together",) * 2
    value, number = np.array([1.0, 2.0, 3.0, 4.0, 0.0, 1.0, 10.0, 1e5, 0.0, 1.0]), np.full(count, 1e-6)
    return Extremes("full", ("tree",) * count, axis, value, none, status, number, number, none, none)


def figures(factor=1.0):
    """How to draw each figure, by name; all data times a factor."""

    def times(value):
        return scaled(value, factor)

    analytic, other = times(make_walk()), times(make_walk(period=0.51))
    stride = last_stride(analytic, 101)
    strides = np.stack([stride.signals * (1 + 0.01 * i) for i in range(-3, 4)])
    return {
        figure_02.NAME: lambda: figure_02.draw(analytic, other),
        figure_04.NAME: lambda: figure_04.draw(times(DEFAULTS)),
        figure_05.NAME: lambda: figure_05.draw(times(make_study()), analytic),
        figure_06.NAME: lambda: figure_06.draw(times(make_study()), analytic),
        figure_07.NAME: lambda: figure_07.draw(other, 0.083, np.radians(2)),
        figure_08.NAME: lambda: figure_08.draw(analytic, other, 1.0, (3e-4, 5e-3)),
        figure_10.NAME: lambda: figure_10.draw(other, times(poses(other))),
        figure_16.NAME: lambda: figure_16.draw(strides, make_agreement("synthetic"), stride, last_stride(other, 101)),
        error_budget.NAME: lambda: error_budget.draw(times(make_budget())),
        extremes.NAME: lambda: extremes.draw(times(extreme_points())),
        tradeoff.NAME: lambda: tradeoff.draw(times(ways())),
        twin_ladder.NAME: lambda: twin_ladder.draw(times(ladder())),
        twin_pushes.NAME: lambda: twin_pushes.draw(times(pushes())),
    }
