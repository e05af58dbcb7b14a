"""A step is measured right: no difference from itself, creep as the friction law says, failures as rows."""

import dataclasses

import numpy as np
import pytest

from stages.contact_study.one_step import NO_HEEL_STRIKE, cost, landing_force, measure, take_step
from stages.contact_study.run import curve_times
from stages.planar.run import STEP_FLOOR


def test_a_step_does_not_differ_from_itself(scene, default):
    run = take_step(scene, default)
    step = measure(scene, default, run)
    assert step.completed and abs(step.heel_strike_lead) < 1e-7
    # not exactly none: the stand-in stood on its own static penetration, under a force 1e-6 different
    assert step.hip_position.max() < 1e-7 and step.hip_velocity.max() < 1e-5
    assert step.normal_force < 1e-2
    dense = dataclasses.replace(scene, solver=dataclasses.replace(scene.solver, between=60))
    sampled = take_step(dense, default).trajectory.ground_reaction[:, 1, 1].max()
    assert step.peak_force == pytest.approx(sampled, rel=2e-5), "between the solver's steps"
    assert step.peak_force > 1.0001 * run.trajectory.ground_reaction[:, 1, 1].max()


def measured(scene, law):
    return measure(scene, law, take_step(scene, law))


def test_a_known_difference_is_found(scene, default):
    moved = dataclasses.replace(scene.walk, hip_position=scene.walk.hip_position - np.array([2e-3, 1e-3]))
    step = measured(dataclasses.replace(scene, walk=moved), default)
    for found in (step.hip_position, step.end_position):
        assert found == pytest.approx([2e-3, 1e-3], abs=1e-6)


def test_creep_is_what_the_slope_of_the_friction_law_asks_for(scene, default):
    """v = (F_T / F_N) v_s / (1.5 mu_s) while the friction used is small: halving v_s halves the creep."""
    fast, slow = (measured(scene, dataclasses.replace(default, stiction_velocity=share * default.stiction_velocity))
                  for share in (1.0, 0.5))  # fmt: skip
    assert fast.creep_velocity / slow.creep_velocity == pytest.approx(2.0, rel=0.03)
    alone = scene.walk.time < scene.heel_strike - 0.005
    time, force = scene.walk.time[alone], scene.walk.ground_reaction[alone, 0]
    used = np.trapezoid(np.abs(force[:, 0] / force[:, 1]), time) / time[-1]
    expected = used * default.stiction_velocity / (1.5 * default.static_friction)
    assert fast.creep_velocity == pytest.approx(expected, rel=0.05)


def test_a_cost_at_the_tolerance_of_the_walk_is_the_walks_own(scene, default):
    walked = take_step(scene, default, signals=())
    for tolerance in (1e-4, scene.solver.tolerance):
        coarse = dataclasses.replace(scene, cost_tolerance=tolerance)
        assert cost(coarse, default, walked) == cost(coarse, default)
        assert (cost(coarse, default) == walked.evaluations) == (tolerance == scene.solver.tolerance)
        assert cost(coarse, default) <= walked.evaluations


def test_the_force_curve_is_the_recorded_force(scene, default):
    run, time = take_step(scene, default), curve_times(0.184)
    curve = landing_force(scene, run, time)
    assert np.all(np.diff(time) > 0.0) and curve.shape == (len(time), 2)
    assert np.all(curve[time < -1e-3] == 0.0), "in the air"
    peak = run.trajectory.ground_reaction[:, 1, 1].max()
    assert curve[:, 1].max() == pytest.approx(peak, rel=0.05), "50 us show a peak of half a millisecond"


def test_a_solver_that_gets_nowhere_is_a_row_with_its_reason(scene, default):
    """Hard and sharply damped ground drives the step size down; the run is given up, not waited for."""
    hopeless = dataclasses.replace(default, contact_stiffness=1e9, contact_damping=1e7, damping_depth=1e-8)
    hurried = dataclasses.replace(scene, solver=dataclasses.replace(scene.solver, most_solver_steps=1000))
    run = take_step(hurried, hopeless)
    step = measure(hurried, hopeless, run)
    assert step.outcome == STEP_FLOOR and "gets nowhere after 1000 steps" in step.message
    assert np.isnan([step.normal_force, step.penetration, *step.hip_position, *step.end_position]).all()
    assert np.isnan(landing_force(hurried, run, curve_times(0.184))[-1]).all()
    assert np.isfinite(run.trajectory.position).all()


def test_a_step_without_a_heel_strike_is_told(scene, default):
    assert measured(dataclasses.replace(scene, period=0.05), default).outcome == NO_HEEL_STRIKE
