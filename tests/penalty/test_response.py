"""Derivatives of steps and gaits by parameters: against differences, what dimensions demand, gaits solved anew."""

import dataclasses
from itertools import pairwise

import numpy as np
import pytest

from stages.analytic.derivatives.gait import gait_derivatives
from stages.analytic.derivatives.multipliers import SURE
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.gait_search import find_gait
from stages.ground.contact_law import family_member
from stages.penalty.model.changes import changes_of
from stages.penalty.step_map import PenaltyStepper, changed, of_multipliers, responses
from stages.penalty.walk import Settings
from stages.planar.limit_cycle import fixed_point, gait_near
from stages.planar.run import rolling_state
from stages.planar.section import section_numbers
from tests.analytic.differences import together
from tests.penalty.drawn import drawn_designs, drawn_sets
from tests.planar_start import SCALES

DESIGN = ("biped.hip_mass", "biped.foot_mass", "biped.leg_length", "biped.foot_radius", "biped.foot_com",
          "biped.leg_inertia", "biped.stiffness", "biped.damping")  # fmt: skip
SLOPE = ("ground.slope_deg", "ground.gravity")
FRICTION = ("ground.static_friction", "ground.dynamic_friction", "ground.stiction_velocity", "ground.friction_velocity")
SPRING = ("ground.contact_stiffness", "ground.contact_exponent")
OF_LAW = {"impact": ("ground.contact_damping", "ground.damping_depth"),
          "restitution": ("ground.restitution", "ground.impact_speed")}  # fmt: skip
#: How the steps are walked whose differences are taken, and the largest of these: rigid legs bounce.
FINE = {"compliant": (Settings(1e-12), 8e-4), "rigid": (Settings(1e-13), 8e-5)}
#: Numbers whose derivatives are held against one rerun.
TOGETHER = 6
#: What sums may leave: of period and length, and of multipliers, whose derivatives are differences of matrices.
LEFT, LEFT_OF_MULTIPLIERS = 1e-8, 4e-7


@pytest.fixture(scope="module")
def found(biped, slope, contact, start, gait):
    return responses(biped, slope, contact, start, gait, (*DESIGN, *SLOPE, *SPRING, *FRICTION, *OF_LAW["impact"]))


def total(table, names, weights):
    return sum(power * table[names.index(name)] for name, power in weights.items())


def differences(parts, state, along, lift):
    """Central differences of a step along a change of its numbers, extrapolated (12,), and how far those of half the
    size are from them: their truncation, and twice their round-off.

    `along`: how much of each number goes into the change; `lift` (10,): changes of the start's section numbers that go
    along.
    """
    numbers = section_numbers(state)
    settings, first = FINE[parts[0].legs]

    def slope(share):
        ends = []
        for by in (share, -share):
            there = parts
            for name, size in along.items():
                there = changed(*there, name, by * size)
            step = PenaltyStepper(*there, state, settings).step(numbers + by * lift)
            ends.append(np.array([*(step.numbers / SCALES), step.duration, step.length]))
        return (ends[0] - ends[1]) / (2 * share)

    slopes = [slope(share) for share in (first, first / 2, first / 4)]
    once = [(4 * fine - coarse) / 3 for coarse, fine in pairwise(slopes)]
    return once[0], np.abs(once[1] - once[0]).max()


def assert_derivatives_are_those_of_reruns(parts, state, names):
    """By every name, each with a weight of its own and along with others whose derivatives are about as large."""
    changes = changes_of(*parts, names)
    step = PenaltyStepper(*parts, state, FINE[parts[0].legs][0]).step_tangents(section_numbers(state), changes)
    columns = np.vstack([step.numbers / SCALES[:, None], step.duration, step.length])
    for rows, weights in together(np.abs(columns[:, 10:]).max(axis=0), TOGETHER):
        along = {names[row]: weight * changes.scales[row] for row, weight in zip(rows, weights, strict=True)}
        lift = np.zeros(10)
        if parts[0].legs == "rigid":  # a longer rigid leg stands as deep in the ground
            lift[0] = along.get("biped.leg_length", 0.0)
        own = columns[:, 10 + rows] @ weights + columns[:, :10] @ lift
        expected, left = differences(parts, state, along, lift)
        assert own == pytest.approx(expected, abs=1e-6 + 10 * left), (along, parts)
        assert left < 1e-3 * max(np.abs(expected).max(), 1.0), along


@pytest.mark.parametrize("legs", ["compliant", "rigid"])
@pytest.mark.parametrize(("law", "others"), [
    ("impact", True), ("restitution", False), pytest.param("restitution", True, marks=pytest.mark.slow)])
def test_a_steps_derivatives_are_those_of_reruns(biped, slope, contact, rough, law, others, legs):
    """By every number of the normal force, from a start that is no gait, on ground drawn by a seed; of one law by every
    other number too, of design, slope and friction.
    """
    names = (*SPRING, *OF_LAW[law])
    if others:
        names = (*(DESIGN if legs == "compliant" else DESIGN[:6]), *SLOPE, *FRICTION, *names)
    length = biped.leg_length
    stance = rough if legs == "compliant" else dataclasses.replace(rough, stance_length=length, swing_length=length)
    for ground in drawn_sets(contact, 4, 1, law):
        parts = dataclasses.replace(biped, legs=legs, leg_inertia=2e-4), slope, ground
        assert_derivatives_are_those_of_reruns(parts, rolling_state(parts[0], ground, stance, 9.4), names)


def test_a_detailed_steps_derivatives_are_those_of_reruns(biped, slope, contact, rough):
    """By every number of frames, legs that differ and hip, over the two steps of a cycle."""
    design = next(drawn_designs(biped, 12, 1))
    parts = design, slope, contact
    names = [f"biped.{field.name}" for field in dataclasses.fields(design)
             if isinstance(getattr(design, field.name), float)]  # fmt: skip
    assert_derivatives_are_those_of_reruns(parts, rolling_state(design, contact, rough, 9.4), names)


@pytest.mark.parametrize("of_multipliers_too", [
    slice(1), pytest.param(slice(3), marks=pytest.mark.slow)], ids=["mass", "all"])
def test_dimensions_demand_sums(contact, biped, slope, start, gait, of_multipliers_too):
    """Similar walkers: T in times, s in lengths; k_c in N/m^e, the multipliers without unit."""
    mass = dict.fromkeys(("biped.hip_mass", "biped.foot_mass", "biped.stiffness", "biped.damping",
                          "ground.contact_stiffness", "ground.contact_damping"), 1.0)  # fmt: skip
    sizes = ("biped.leg_length", "biped.foot_radius", "biped.foot_com", "ground.gravity", "ground.damping_depth")
    length = dict.fromkeys((*sizes, "ground.stiction_velocity", "ground.friction_velocity"), 1.0)
    length["ground.contact_stiffness"] = 1.0 - contact.contact_exponent
    time = {"ground.gravity": -2.0, "ground.stiction_velocity": -1.0, "ground.friction_velocity": -1.0,
            "biped.stiffness": -2.0, "biped.damping": -1.0, "ground.contact_stiffness": -2.0,
            "ground.contact_damping": -1.0}  # fmt: skip
    names = sorted({*mass, *length, *time})
    table = responses(biped, slope, contact, start, gait, names).elasticities()
    for powers, wanted in ((mass, [0.0, 0.0]), (length, [0.0, 1.0]), (time, [1.0, 0.0])):
        assert (np.abs(total(table, names, powers) - wanted) < LEFT).all()
    for powers in (mass, length, time)[of_multipliers_too]:
        answers = responses(biped, slope, contact, start, gait, [*powers])
        multipliers = of_multipliers(biped, slope, contact, start, answers)
        assert multipliers.errors.max() < SURE and not multipliers.refused
        assert (np.abs(total(multipliers.elasticities, [*powers], powers)) < LEFT_OF_MULTIPLIERS).all()


def test_tighter_steps_come_nearer(found, biped, slope, contact, start, gait):
    """Through touch-down, lift-off and the corners of friction: nothing of order one is left at any of them.

    A step over a corner now and then passes for a good one; where, the last bits of the start decide. So the errors are
    counted in tolerances, and their geometric mean over four of them is bounded.
    """
    names, errors = (*DESIGN[1:7:2], SLOPE[0], SPRING[0], *FRICTION[1:3]), []
    exact = found.elasticities()[[found.changes.names.index(name) for name in names]]
    for tolerance in (1e-7, 1e-8, 1e-9, 1e-10):
        other = responses(biped, slope, contact, start, gait, names, tolerance)
        errors.append(np.abs(other.elasticities() - exact).max() / tolerance)
    assert np.exp(np.log(errors).mean()) < 150, errors


@pytest.mark.parametrize("name", ["biped.foot_mass", "ground.stiction_velocity", "ground.slope_deg"])
def test_a_gait_solved_anew_is_where_they_say(found, biped, slope, contact, start, gait, name):
    row, ends = found.changes.names.index(name), []
    for share in (1e-3, -1e-3):
        parts = changed(biped, slope, contact, name, share * found.changes.scales[row])
        anew = fixed_point(PenaltyStepper(*parts, start, Settings(1e-12)), gait.section_state, found.matrix)
        ends.append(np.array([*(anew.numbers / SCALES), np.log(anew.step.duration), np.log(anew.step.length)]))
    own = [*(found.section[:, row] / SCALES), *found.elasticities()[row]]
    assert own == pytest.approx((ends[0] - ends[1]) / 2e-3, abs=1e-4)


def test_on_hard_ground_they_are_the_constraint_models(biped, slope, contact, rough):
    """With an eighth of what the study's ground gives way and lets creep; the largest elasticity is .82."""
    ground = family_member(dataclasses.replace(contact, stiction_velocity=0.03), 0.25)
    start = rolling_state(biped, ground, rough, 9.4)
    gait = gait_near(PenaltyStepper(biped, slope, ground, start, Settings(1e-9)), start)
    _, point = find_gait(biped, slope, 1e-9)
    exact = gait_derivatives(DesignPoint(biped, slope), point, (*DESIGN, *SLOPE), 1e-9).elasticities()
    own = responses(biped, slope, ground, start, gait, (*DESIGN, *SLOPE), 1e-9).elasticities()
    assert own[:, 0] == pytest.approx(exact["period_s"], abs=0.02)
    assert own[:, 1] == pytest.approx(exact["step_length_m"], abs=0.02)


@pytest.mark.parametrize(
    "name", ["ground.nothing", "ground.friction", "biped.legs", "twin.hip_mass", "biped.frame_mass"])
def test_a_name_of_no_number_is_refused(biped, slope, contact, start, gait, name):
    with pytest.raises(KeyError, match=name):
        responses(biped, slope, contact, start, gait, [name])
