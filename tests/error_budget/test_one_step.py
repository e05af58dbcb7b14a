"""Effects in their limits, on the walker itself; the whole budget is a slow test."""

import dataclasses
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest

from pipeline.cache import artefact
from stages.drawing import style
from stages.error_budget.path import NotWalked, OneStep
from stages.error_budget.result import (
    CONTACT,
    EACH,
    EFFECTS,
    INTEGRATION_CONSTRAINT,
    INTEGRATION_PENALTY,
    POSITION,
    SLIP,
    Result,
)
from stages.error_budget.run import run
from stages.figures.drawn import model_difference
from tests.comparison.made_up import make_budget


def test_creep_is_proportional_to_the_stiction_velocity(parameters, scene):
    """Before heel strike, where nothing else depends on it: halving v_s halves what it moves the hip by."""
    before = scene.time < 0.9 * scene.constraint.heel_strikes[0]
    hips = [
        scene.penalty(dataclasses.replace(parameters.contact, stiction_velocity=v, friction_velocity=0.2), 1e-7)
        for v in (0.08, 0.04, 0.02)
    ]
    first, second = (np.ptp((b - a)[before, 0]) for a, b in pairwise(hips))
    assert first / second == pytest.approx(2.0, abs=0.04)


def test_integration_errors_shrink_with_the_tolerance(parameters, scene):
    law = parameters.contact
    exact, fine = scene.penalty(law, 1e-8), scene.coarse_or_fine(1e-13)
    for errors in (
        [np.abs(scene.penalty(law, tolerance) - exact)[:, 0].max() for tolerance in (1e-4, 1e-6)],
        [np.abs(scene.coarse_or_fine(tolerance) - fine)[:, 0].max() for tolerance in (1e-6, 1e-9)],
    ):
        assert errors[1] < errors[0] / 3, errors


def test_slip_of_the_trailing_foot_does_nothing_before_heel_strike(scene):
    slip = scene.coarse_or_fine(1e-12, coulomb=True) - scene.coarse_or_fine(1e-12)
    before = scene.time < scene.constraint.heel_strikes[0]
    assert np.abs(slip[before]).max() < 1e-11 < np.abs(slip[~before, 0]).max()


def test_a_walker_that_falls_is_a_result_with_its_reason(parameters, monkeypatch):
    def fall(*_):
        raise NotWalked("over one step: the walker fell")

    monkeypatch.setattr(OneStep, "penalty", fall)
    result = run(parameters)
    assert result.step is None and result.cycle is None and result.outcome != "completed"
    assert artefact.decode(artefact.encode(result, {}), Result, "error_budget.h5").outcome == result.outcome
    assert result.outcome in result.summary() and result.tables() == ()
    with style.drawing():
        for draw in (model_difference.draw_error_budget, model_difference.draw_error_bars):
            assert style.pictures("budget", draw(SimpleNamespace(error_budget=result)), 50)


@pytest.fixture(scope="module")
def budget(parameters):
    return run(parameters)


@pytest.mark.slow
def test_the_whole_difference_is_explained(budget, parameters, scene):
    """The parts add up to the difference of two walks made apart from the path; at most 2 % of it has no name."""
    assert budget.outcome == "completed", budget.outcome
    direct = scene.penalty(parameters.contact, parameters.penalty_tolerance) - scene.constraint.hip(scene.time)
    for parts in budget.step.split.orders:
        assert parts.sum(axis=0) == pytest.approx(direct, abs=1e-9)
    for _, found in budget.known():
        split = found.split
        assert min(split.explained(column) for column in EACH) >= 0.98, [split.explained(column) for column in EACH]
        for effect in (INTEGRATION_CONSTRAINT, INTEGRATION_PENALTY):
            assert split.rms(split.part(effect), POSITION) < 0.01 * split.rms(split.total, POSITION)


@pytest.mark.slow
def test_effects_are_alike_over_orders(budget):
    """Half the interval is below 8 % of an effect on the hip's end over a step, below 12 % on the period and length."""
    split, cycle = budget.step.split, budget.cycle
    rows = [EFFECTS.index(effect) for effect in CONTACT]
    assert abs(split.interaction[-1, 0]) < 0.08 * np.abs(split.parts[rows, -1, 0]).min()
    assert np.all(np.abs(cycle.scalar_interaction) < 0.12 * np.abs(cycle.scalars[rows]).min(axis=0))


@pytest.mark.slow
def test_the_last_share_is_foretold(budget):
    """To 5 % of the whole difference, and orders are those of effects that vanish with their share."""
    for _, found in budget.known():
        whole = [found.split.rms(found.split.total, column) for column in EACH]
        assert np.all(found.convergence.missed < 0.05 * np.array(whole))
        assert found.convergence.order[1] == pytest.approx(np.ones(4), abs=0.15)


@pytest.mark.slow
def test_figures_and_storage(budget):
    read = artefact.decode(artefact.encode(budget, {}), Result, "error_budget.h5")
    assert np.array_equal(read.cycle.scalars, budget.cycle.scalars)
    assert len(budget.tables()) == 4 and all(
        len(row) == len(columns) for _, columns, rows in budget.tables() for row in rows
    )
    with style.drawing():
        drawn = model_difference.draw_error_budget(SimpleNamespace(error_budget=budget))
    panel = drawn.axes[0]
    total = next(line for line in panel.lines if line.get_label() == "total")
    parts = [line for line in panel.lines if line.get_label() != "total"]
    missing = 1e3 * sum(budget.step.split.part(e)[:, 0] for e in EFFECTS if e.startswith("integration"))
    assert sum(line.get_ydata() for line in parts) + missing == pytest.approx(total.get_ydata(), abs=1e-9)
    assert SLIP in [line.get_label() for line in parts]


def test_bars_add_up_to_the_total():
    """In every panel; whiskers reach from one order to the other."""
    with style.drawing():
        drawn = model_difference.draw_error_bars(SimpleNamespace(error_budget=make_budget()))
    assert len(drawn.axes) == 5
    for panel, (_, ways) in zip(drawn.axes, model_difference.measures(make_budget())):
        widths = [bar.get_width() for bar in panel.patches]
        assert sum(widths[:-1]) == pytest.approx(widths[-1]) and widths[-1] == pytest.approx(ways.sum(axis=1).mean())
        assert ways.sum(axis=1) == pytest.approx(np.full(2, widths[-1]))
