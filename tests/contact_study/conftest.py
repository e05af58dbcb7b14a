"""Scenes for the contact study: one in which the penalty model stands in for the constraint model, and the limit's."""

import dataclasses
from types import SimpleNamespace

import pytest

from stages.analytic.gait.gait_search import find_gait
from stages.analytic.walk.recording import crossing_state
from stages.contact_study.one_step import Scene, constraint_model
from stages.contact_study.rigid_limit import Ruler
from stages.penalty.walk import Settings, simulate
from stages.planar.run import rolling_state
from stages.planar.sampling import sample
from tests.changed import changed
from tests.planar_start import ROUGH
from tests.study import parameters_of

PERIOD = 0.48
STANDING_FORCE = 9.4


@pytest.fixture(scope="session")
def parameters():
    return parameters_of("contact_study")


@pytest.fixture(scope="session")
def default(parameters):
    return parameters.default_set.law(parameters.contact)


@pytest.fixture(scope="session")
def solver(parameters):
    settings = parameters.settings
    return Settings(parameters.penalty_tolerance, settings.between, most_solver_steps=settings.most_solver_steps)


@pytest.fixture(scope="session")
def stand_in(parameters, default, solver):
    """What the stage reads of an analytic result: a walk of the penalty model with the starting set."""
    start = rolling_state(parameters.biped, default, ROUGH, STANDING_FORCE)
    run = simulate(parameters.biped, parameters.slope, default, start, solver, duration=PERIOD)
    walk = sample(run.trajectory, parameters.biped, parameters.slope, 2000.0)
    return SimpleNamespace(walk=walk, mid_stance=ROUGH, gait=SimpleNamespace(period_s=PERIOD))


@pytest.fixture(scope="session")
def scene_of(parameters, solver):
    """A scene beside this walk from a mid-stance."""

    def beside(walk, mid_stance, period):
        settings = parameters.settings
        return Scene(parameters.biped, parameters.slope, solver, settings.cost_tolerance, walk, mid_stance, period,
                     settings.impact_window)  # fmt: skip

    return beside


@pytest.fixture(scope="session")
def scene(scene_of, stand_in):
    return scene_of(stand_in.walk, stand_in.mid_stance, PERIOD)


@pytest.fixture(scope="session")
def small(parameters):
    """A study of a few sets."""
    return changed(
        parameters,
        stiffness_values=(3e5,),
        exponent_values=(),
        damping_values=(),
        depth_values=(),
        stiction_velocity_values=(0.05,),
        friction_velocity_values=(),
        searched_stiffness=(1e5,),
        searched_damping=(1e4,),
        searched_depth=(1e-4, 3e-4),
        searched_stiction_velocity=(0.03,),
        finalists=1,
        family_shares=(1.0, 0.5),
        checked=2,
        checked_tolerance=3e-9,
    )


@pytest.fixture(scope="session")
def constraints(parameters):
    """The constraint models with rolling feet and with Coulomb's transition, from the first one's mid-stance."""
    walker, point = find_gait(parameters.biped, parameters.slope, parameters.constraint_tolerance)
    start = walker.stance_state(crossing_state(walker, point.z, parameters.constraint_tolerance))
    rate = parameters.settings.sampling_rate_hz
    return tuple(
        constraint_model(parameters.biped, parameters.slope, friction, start, 1e-10, rate)
        for friction in (None, parameters.contact.coefficients)
    )


@pytest.fixture(scope="session")
def beside_rolling(constraints, scene_of):
    """The scene of the study, in which sets are walked beside rolling feet."""
    rolling, _ = constraints
    return scene_of(rolling.walk, rolling.mid_stance, rolling.period)


@pytest.fixture(scope="session")
def ruler(parameters, constraints, beside_rolling):
    """Measures sets from the rigid limit."""
    _, coulomb = constraints
    return Ruler(dataclasses.replace(beside_rolling, walk=coulomb.walk, model=coulomb), coulomb, parameters.settings)
