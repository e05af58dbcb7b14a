"""Elasticities of the penalty walker's gait: what dimensions demand, gaits solved anew, the constraint model's."""

import dataclasses

import numpy as np
import pytest

from stages.analytic.derivatives.gait import gait_derivatives
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.gait_search import find_gait
from stages.ground.hardening import family_member
from stages.penalty.response import responses
from stages.penalty.settings import Settings
from stages.penalty.step_map import PenaltyStepper
from stages.planar.limit_cycle import fixed_point, gait_near
from stages.planar.state import rolling_state

DESIGN = ("biped.hip_mass", "biped.foot_mass", "biped.leg_length", "biped.foot_radius", "biped.foot_com",
          "biped.stiffness", "biped.damping")  # fmt: skip
GROUND = ("ground.gravity", "ground.contact_stiffness", "ground.contact_damping", "ground.damping_depth",
          "ground.stiction_velocity", "ground.friction_velocity")  # fmt: skip


@pytest.fixture(scope="module")
def found(biped, slope, contact, start, gait):
    return {one.name: one for one in responses(biped, slope, contact, start, gait, (*DESIGN, *GROUND))}


def total(found, weights):
    return sum(power * found[name].elasticities for name, power in weights.items())


def test_dimensions_demand_sums(found, contact):
    """Similar walkers: T in times, s in lengths; k_c in N/m^e, the multipliers without unit."""
    exponent = contact.contact_exponent
    mass = dict.fromkeys(("biped.hip_mass", "biped.foot_mass", "biped.stiffness", "biped.damping",
                          "ground.contact_stiffness", "ground.contact_damping"), 1.0)  # fmt: skip
    assert total(found, mass) == pytest.approx(np.zeros(4), abs=3e-6)
    sizes = ("biped.leg_length", "biped.foot_radius", "biped.foot_com", "ground.gravity", "ground.damping_depth")
    length = dict.fromkeys((*sizes, "ground.stiction_velocity", "ground.friction_velocity"), 1.0)
    length["ground.contact_stiffness"] = 1.0 - exponent
    assert total(found, length) == pytest.approx([0.0, 1.0, 0.0, 0.0], abs=3e-6)
    time = {"ground.gravity": -2.0, "ground.stiction_velocity": -1.0, "ground.friction_velocity": -1.0,
            "biped.stiffness": -2.0, "biped.damping": -1.0, "ground.contact_stiffness": -2.0,
            "ground.contact_damping": -1.0}  # fmt: skip
    assert total(found, time) == pytest.approx([1.0, 0.0, 0.0, 0.0], abs=3e-6)
    assert max(one.errors.max() for one in found.values()) < 1e-5


@pytest.mark.parametrize("name", ["biped.foot_mass", "ground.stiction_velocity"])
def test_a_gait_solved_anew_is_where_they_say(found, biped, slope, contact, start, gait, name):
    ends = []
    for share in (1e-3, -1e-3):
        key = name.partition(".")[2]
        section = biped if name.startswith("biped") else contact
        new = dataclasses.replace(section, **{key: (1 + share) * getattr(section, key)})
        parts = (new, slope, contact) if section is biped else (biped, slope, new)
        stepper = PenaltyStepper(*parts, start, Settings(1e-12))
        step = fixed_point(stepper, gait.section_state, 1e-9, gait.monodromy_matrix).step
        ends.append(np.log([step.duration, step.length]))
    assert (ends[0] - ends[1]) / 2e-3 == pytest.approx(found[name].elasticities[:2], abs=2e-5)


def test_on_hard_ground_they_are_the_constraint_models(biped, slope, contact, rough):
    """With an eighth of what the study's ground gives way and lets creep; the largest elasticity is .82."""
    ground = family_member(dataclasses.replace(contact, stiction_velocity=0.03), 0.25)
    start = rolling_state(biped, ground, rough, 9.4)
    gait = gait_near(PenaltyStepper(biped, slope, ground, start, Settings(1e-12)), start, 1e-9)
    _, point = find_gait(biped, slope, 1e-11)
    names = DESIGN[:-1]
    exact = gait_derivatives(DesignPoint(biped, slope), point, names, 1e-11).elasticities()
    own = np.array([one.elasticities[:2] for one in responses(biped, slope, ground, start, gait, names)])
    assert own[:, 0] == pytest.approx(exact["period_s"], abs=0.02)
    assert own[:, 1] == pytest.approx(exact["step_length_m"], abs=0.02)


def test_a_name_that_nothing_has_is_refused(biped, slope, contact, start, gait):
    with pytest.raises(KeyError, match="nothing"):
        responses(biped, slope, contact, start, gait, ["ground.nothing"])
