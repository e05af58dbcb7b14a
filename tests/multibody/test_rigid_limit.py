"""The multibody model on hard ground tends to the constraint model, and answers to parameters as that does."""

import dataclasses

import numpy as np
import pytest

from stages.analytic.derivatives.gait import gait_derivatives
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.gait_search import find_gait
from stages.analytic.phases.motion import SINGLE_STANCE
from stages.analytic.walk.recording import crossing_state, record
from stages.analytic.walk.sampling import sample_walk
from stages.ground.contact_law import ContactLaw
from stages.ground.slope import Friction
from stages.multibody.walking.cycle import search
from stages.planar.limit_cycle import fixed_point, gait_near
from stages.planar.run import rolling_state
from stages.planar.section import NoLimitCycle

FRICTION, EXPONENT = 1.1, 2.2
#: Time around heel strike left out [s].
IMPACT = 5e-3


def walk_of(model, friction):
    """One step of the constraint model's gait from mid-stance to mid-stance, its period, and its state at the start."""
    walker, point = find_gait(model.biped, model.slope, 1e-11, friction)
    upright = crossing_state(walker, point.z, 1e-11)
    walk = sample_walk(walker, record(walker, upright, 2, 1e-11, SINGLE_STANCE), 5000.0)
    return walk, point.steps[0].period * walker.time, walker.stance_state(upright)


def differences(model, constraint, factor, stiction_velocity=1e-3):
    """Largest hip difference [mm] and velocity difference [mm/s] away from heel strike, stiffness times `factor`."""
    walk, period, upright = constraint
    scale = factor ** (1 / (EXPONENT + 1))
    law = ContactLaw(
        1e5 * factor, EXPONENT, 1e4 * scale, 1e-4 / scale, FRICTION, FRICTION, stiction_velocity, 2 * stiction_velocity)
    run = model.but(contact=law).walk(rolling_state(model.biped, law, upright, walk.standing_force), steps=1)
    assert run.completed
    away = (walk.time <= period) & (np.abs(walk.time - walk.heel_strike_time[0]) > IMPACT)
    found = zip(run.trajectory.at(walk.time[away]), (walk.hip_position, walk.hip_velocity), strict=True)
    return tuple(1e3 * np.abs(own[:, :2] - wanted[away]).max() for own, wanted in found)


#: About the twin's planar projection: frames that differ instead of a hip mass, and the lower legs' inertia.
FRAMES = {"hip_mass": 0.0, "leg_inertia": 8.576e-4, "frame_mass": 0.1582, "frame_com": 0.01547,
          "frame_inertia": 1.712e-4, "other_frame_mass": 0.1578, "other_frame_com": 0.0155}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("details", [{}, FRAMES], ids=["table 1", "frames"])
def test_penalty_contact_tends_to_coulomb_transitions(scene, details):
    """Hip within 0.03 mm and 0.5 mm/s away from the impact; the difference falls like the static penetration,
    k^(-1/e), while creep is smaller than it."""
    model = scene.but(**details)
    limited = walk_of(model, Friction(FRICTION, FRICTION))
    found = np.array([differences(model, limited, factor) for factor in (1.0, 10.0, 100.0)])
    orders = np.log10(found[:-1, 0] / found[1:, 0])
    assert orders == pytest.approx([1 / EXPONENT] * 2, abs=0.1), (found, orders)
    position, velocity = differences(model, limited, 1e4)
    assert position <= 0.03 and velocity <= 0.5, (position, velocity)


@pytest.mark.slow
def test_penalty_contact_does_not_tend_to_rolling_transitions(scene):
    """A trailing foot that rolls through the impact is told apart at the same stiffness."""
    position, velocity = differences(scene, walk_of(scene, None), 1e4)
    assert position > 0.1 and velocity > 0.5, (position, velocity)


def test_a_start_that_falls_is_refused(scene, start):
    pushed_back = dataclasses.replace(start, hip_velocity=(-0.6, 0.0), leg_rate=(2.0, 0.0))
    with pytest.raises(NoLimitCycle, match="fell"):
        gait_near(scene.but(tolerance=1e-6, largest_step=2e-3).walker(pushed_back, 1e-4), pushed_back)


# --- The multibody model answers to parameters as the constraint model does; what is said of its digits rests on
# that.


NAMES = ("biped.hip_mass", "biped.foot_mass", "biped.leg_length", "biped.foot_radius", "biped.foot_com",
         "biped.stiffness", "biped.damping", "ground.slope_deg")


@pytest.mark.slow
def test_elasticities_are_those_of_the_constraint_model(scene):
    """Period and step length, by differences of cycles on the ground of the study: to .01, the largest being .82."""
    study = scene.but(contact=ContactLaw(3e5, 2.2, 3e4, 1e-4, 1.1, 1.0, 0.03, 1.0), tolerance=1e-8)
    base, share = DesignPoint(scene.biped, scene.slope), 0.01

    def model_of(design):
        model = study.but(biped=design.biped, slope=design.slope)
        walker, point = find_gait(design.biped, design.slope, 1e-9)
        upright = walker.stance_state(crossing_state(walker, point.z, 1e-9))
        return model, rolling_state(design.biped, model.contact, upright, 9.4)

    gait = search(*model_of(base))

    def logarithms(design):
        model, state = model_of(design)
        found = fixed_point(model.walker(state), gait.section_state, gait.monodromy_matrix)
        return np.log([found.step.duration, found.step.length])

    _, point = find_gait(scene.biped, scene.slope, 1e-11)
    shares = gait_derivatives(base, point, NAMES, 1e-11).elasticities()
    for row, name in enumerate(NAMES):
        upper, lower = (logarithms(base.with_value(name, base.value(name) * (1 + sign * share))) for sign in (1, -1))
        expected = [shares["period_s"][row], shares["step_length_m"][row]]
        assert np.abs((upper - lower) / (2 * share) - expected).max() <= 0.01, name
