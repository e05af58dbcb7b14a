"""The multibody model answers to parameters as the constraint model does; what is said of its digits rests on that."""

import numpy as np
import pytest

from stages.analytic.derivatives.gait import gait_derivatives
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.gait_search import find_gait
from stages.analytic.walk.recording import crossing_state
from stages.ground.contact_law import ContactLaw
from stages.multibody.walking.cycle import search
from stages.planar.limit_cycle import fixed_point
from stages.planar.run import rolling_state

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
