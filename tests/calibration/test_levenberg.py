"""Least squares rest where what is left to gain is a small part of what the residuals say that they do not know."""

import dataclasses

import numpy as np
import pytest

from stages.analytic.errors import StepFailed
from stages.calibration.estimation import run_fit
from stages.calibration.estimation.campaign import JOINT
from stages.calibration.estimation.least_squares import ENOUGH, WHOLE_RUN, Point, Rule, least_squares
from stages.calibration.estimation.run_fit import horizons
from tests.calibration.runs import drawn, fitted


def valley(spread, rule=WHOLE_RUN):
    """Half the squares of Rosenbrock's residuals, `spread` times a noise of which each is one."""

    def evaluate(x, *_):
        residuals = np.array([10.0 * (x[1] - x[0] ** 2), 1.0 - x[0]])
        jacobian = np.array([[-20.0 * x[0], 10.0], [-1.0, 0.0]])
        cost, matrix, right = 0.5 * float(residuals @ residuals), jacobian.T @ jacobian, -jacobian.T @ residuals
        return Point(x, cost, matrix, right, None, spread)

    return least_squares(evaluate, np.array([-1.2, 1.0]), np.ones(2), np.full(2, -np.inf), rule)


def test_a_fit_whose_residuals_are_larger_rests_where_as_small_a_part_is_left():
    exact, coarse = valley(1.0), valley(1e3)
    assert exact.converged and exact.point.cost < ENOUGH
    assert coarse.converged and coarse.evaluations < exact.evaluations and coarse.point.cost > exact.point.cost
    assert valley(0.01).evaluations == exact.evaluations  # no more is asked of residuals that are small


def test_of_halved_steps_those_that_do_not_help_do_not_count():
    def within(**most):
        return valley(1.0, dataclasses.replace(JOINT, rests=1e-9, **most))

    free = within()
    assert free.converged and free.point.cost < 1e-9
    bound, few = within(most=free.evaluations // 2), within(most=2)
    assert bound.converged and bound.evaluations == free.evaluations
    assert (few.converged, few.why) == (False, "2 joint steps were not enough")


def bowl(lowest, low):
    """Half the squares of two residuals that hang together, with the first unknown bounded below by `low`."""
    jacobian = np.array([[1.0, 0.5], [0.0, 1.0]])

    def evaluate(x, *_):
        assert x[0] >= low
        residuals = jacobian @ (lowest - x)
        return Point(x, 0.5 * float(residuals @ residuals), jacobian.T @ jacobian, jacobian.T @ residuals, None)

    return least_squares(evaluate, np.array([1.0, 1.0]), np.ones(2), np.array([low, -np.inf]), Rule(enough=1e-9))


def test_an_unknown_at_its_bound_stays_there_and_the_others_come_to_rest():
    ended = bowl(np.array([-2.0, 3.0]), 0.0)
    assert ended.converged
    assert ended.point.x == pytest.approx([0.0, 3.0 - 0.5 * 2.0 / 1.25], abs=1e-3)  # by hand, for the first at zero
    assert bowl(np.array([2.0, 3.0]), 0.0).point.x == pytest.approx([2.0, 3.0], abs=1e-3)


def test_no_step_is_taken_that_brings_the_residuals_up():
    """Not by a millionth: the slack is for round-off alone."""
    def evaluate(x, *_):
        return Point(x, 100.0 + 1e-4 * (x[0] != 0.0), np.eye(1), np.array([1.0]), None)

    ended = least_squares(evaluate, np.zeros(1), np.ones(1), np.full(1, -np.inf), Rule(enough=1e-12))
    assert (ended.converged, ended.point.x[0]) == (False, 0.0) and "no step" in ended.why


def test_one_step_from_beside_a_fit_leads_back_to_it():
    """All but a fifth of the way: the step lacks the curvature of what the residuals leave."""
    campaign, (design, model) = drawn(1054), fitted()
    run = campaign.runs[0]
    fit = run_fit.fit_run(design, run, model, campaign.known)
    found = np.concatenate([fit.design, fit.own, fit.unknowns])
    sizes = np.concatenate([run_fit.design_sizes(design, model.of_design), model.layout.sizes])
    d, o = len(model.shared), len(model.of_design)

    def after(x):
        again = run_fit.one_step(design, (x[:d], x[d:o], x[o:]), run, model, campaign.known)
        assert again.converged
        return np.concatenate([again.design, again.own, again.unknowns])

    rest, away = after(found), 1e-3 * sizes * np.random.default_rng(1).normal(size=len(found))
    assert np.linalg.norm((after(found + away) - rest) / sizes) < 0.2 * np.linalg.norm(away / sizes)


def test_on_the_way_the_design_is_held_by_the_first_guess_with_its_usual_change(monkeypatch):
    """Three hundredths of each parameter for a standard deviation, thirty of an inertia."""
    model = fitted()[1]
    begun = []

    def first_horizon(evaluate, begin, *rest):
        begun.append((evaluate, begin))
        raise StepFailed("seen enough")

    monkeypatch.setattr(run_fit, "least_squares", first_horizon)
    campaign = drawn(1054)
    run, drawing = campaign.runs[0], campaign.design
    with pytest.raises(StepFailed):
        start = run_fit._as_drawn(drawing, campaign.unknowns[0], run, model)
        run_fit._fit(drawing, start, horizons(run), run, model, ())
    ((evaluate, begin),) = begun
    held, free = evaluate(begin, held=True), evaluate(begin, held=False)
    d = len(model.shared)
    values = np.array([drawing.value(name) for name in model.shared])
    shares = np.where([name.endswith("inertia") for name in model.shared], 0.3, 0.03)
    np.testing.assert_allclose(np.diag(held.matrix - free.matrix)[:d], 1.0 / (shares * values) ** 2, rtol=1e-3)
    moved = begin.copy()
    moved[0] += shares[0] * values[0]
    assert evaluate(moved, held=True).cost - evaluate(moved, held=False).cost == pytest.approx(0.5)
