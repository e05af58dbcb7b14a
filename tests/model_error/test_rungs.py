"""The rungs: the twin of a design in detail, that penalty walker and twin are one machine, and robots of any size."""

import dataclasses

import numpy as np
import pytest

from stages.biped.design import BeyondModel
from stages.model_error.designs import NUMBERS, draws, kind, numbers
from stages.model_error.measures import NAMES
from stages.model_error.result import PENALTY, TWIN
from stages.model_error.run import design_of
from stages.model_error.rungs import RUNGS, NoRung
from stages.twin.machine.machine import build
from stages.twin.machine.projection import PLAIN, machine_of, project
from tests.similar import EXPONENT, similar

DETAILS = {
    "unequal legs": {"other_foot_mass": 0.338, "other_leg_length": 0.3331},
    "frames": {"hip_mass": 0.216, "frame_mass": 0.05, "frame_com": 0.04, "frame_inertia": 5e-5, "leg_inertia": 5e-4},
    "mass off the leg": {"foot_offset": -0.001},
    "spring at the hip": {"hip_stiffness": 0.05, "hip_rest_angle": 0.02, "hip_damping": 0.002},
    "friction at the hip": {"hip_friction": 0.002},
    "counterweight": {"hip_gravity_mass": 0.4},
}
#: Details that the quick tests try in Exudyn.
QUICK = "unequal legs", "spring at the hip"


def changed(parameters, **details):
    return dataclasses.replace(parameters, biped=dataclasses.replace(parameters.biped, **details))


@pytest.mark.parametrize("details", DETAILS.values(), ids=DETAILS)
def test_a_detail_changes_the_machine_by_itself(parameters, details):
    biped = dataclasses.replace(parameters.biped, **details)
    plain = project(build(dataclasses.replace(biped, **PLAIN), parameters.twin))
    found = project(machine_of(biped, parameters.twin))
    assert found.total_mass == pytest.approx(plain.total_mass + biped.total_mass
                                             - dataclasses.replace(biped, **PLAIN).total_mass, rel=1e-12)  # fmt: skip
    for key in ("foot_offset", "hip_stiffness", "hip_rest_angle", "hip_friction", "hip_damping"):
        assert getattr(found, key) == pytest.approx(getattr(plain, key) + getattr(biped, key), abs=1e-12)
    assert found.weighed_hip - found.hip_mass == pytest.approx(biped.weighed_hip - biped.hip_mass, abs=1e-12)
    for leg in (0, 1):
        for key in ("foot_mass", "leg_length", "foot_com", "stiffness"):
            more = getattr(biped.leg(leg), key) - getattr(biped.leg(0), key)
            assert getattr(found.leg(leg), key) == pytest.approx(getattr(plain.leg(leg), key) + more, rel=1e-9)
    moment = biped.frame_mass * biped.frame_com + plain.frame_mass * plain.frame_com
    assert found.frame_mass * found.frame_com == pytest.approx(moment, abs=1e-12)


@pytest.mark.parametrize("details", [
    pytest.param(details, id=name, marks=() if name in QUICK else pytest.mark.slow)
    for name, details in {"none": {}, **DETAILS}.items()])  # fmt: skip
def test_exudyns_twin_walks_as_the_penalty_walker_of_the_same_machine(parameters, details):
    """Exudyn's bodies, springs and friction in space against our own equations in the plane."""
    one = design_of(changed(parameters, **details))
    penalty, twin = (RUNGS[rung].find(one, 1e-7) for rung in (PENALTY, TWIN))
    apart = np.abs(twin.values / penalty.values - 1.0)
    assert apart[:4].max() < 3e-6
    assert apart[NAMES.index("peak_force")] < 2e-4  # of a spike of a tenth of a millisecond
    assert apart[-1] < 0.002  # by finite differences


def test_a_similar_robot_has_the_same_numbers_and_misses(parameters):
    scale = 4.0, 0.25, 0.5
    contact = dataclasses.replace(parameters.contact, contact_exponent=EXPONENT)
    parameters = dataclasses.replace(parameters, contact=contact)
    other = similar(parameters, scale)
    known = [numbers(design_of(each)) for each in (parameters, other)]
    assert known[0] == pytest.approx(known[1], rel=1e-12)
    drawn = [draws(design_of(each), 6, 1) for each in (parameters, other)]
    for one, another in zip(*drawn, strict=True):
        assert numbers(one) == pytest.approx(numbers(another), rel=1e-12, abs=1e-15)
        assert similar(one.biped, scale).foot_offset == pytest.approx(another.biped.foot_offset, rel=1e-12)


def test_drawn_designs_fill_the_box_and_every_other_one_has_details(parameters):
    drawn = draws(design_of(parameters), 32, 1)
    assert [one.biped.detailed for one in drawn] == [False, True] * 16
    shares = np.array([one.biped.stiffness / parameters.biped.stiffness for one in drawn])
    assert shares.min() < 0.8 and shares.max() > 1.2 and abs(shares.mean() - 1.0) < 0.02


def test_a_foot_that_is_put_down_at_a_time_is_known_to_one_rung_only(parameters):
    timed = {"legs": "rigid", "feet_retract": True, "strike_time": 0.45}
    one = design_of(changed(parameters, **timed))
    for rung in RUNGS[1:]:
        with pytest.raises(NoRung, match="strike_time"):
            rung.find(one, rung.tolerances[0])
    with pytest.raises(BeyondModel):
        _ = one.machine


def test_a_tenth_of_the_tolerance_brings_a_smaller_error_that_holds(parameters):
    one = design_of(parameters)
    found = [RUNGS[PENALTY].find(one, tolerance) for tolerance in (1e-6, 1e-7, 1e-8, 1e-9)]
    for coarse in found[:-1]:
        apart = np.abs(coarse.values - found[-1].values)
        assert (apart <= coarse.errors + found[-1].errors)[:4].all()  # the finest has an error too
    speed = NAMES.index("speed")
    assert found[-1].errors[speed] < 0.1 * found[0].errors[speed]


def test_legs_that_differ_are_drawn_as_unlike_as_they_are(parameters):
    longer = changed(parameters, other_leg_length=1.001 * parameters.biped.leg_length)
    for one in draws(design_of(longer), 16, 1):
        assert one.biped.other_leg_length / one.biped.leg_length == pytest.approx(1.001, rel=1e-12)


@pytest.mark.parametrize(("file", "key", "value"), [
    ("biped", "legs", "rigid"), ("biped", "feet_retract", True), ("contact", "normal_force", "restitution"),
    ("contact", "friction", "coulomb"), ("twin", "inertia", "planar"), ("analytic", "transition", "coulomb"),
])  # fmt: skip
def test_each_choice_is_a_kind_of_its_own(parameters, file, key, value):
    other = dataclasses.replace(parameters, **{file: dataclasses.replace(getattr(parameters, file), **{key: value})})
    assert kind(design_of(other)) != kind(design_of(parameters))


@pytest.mark.parametrize(("file", "key", "value", "name"), [
    ("biped", "hip_stiffness", 0.05, "hip's stiffness"), ("biped", "hip_friction", 0.002, "hip's friction"),
    ("contact", "dynamic_friction", 0.1, "dynamic friction"), ("contact", "damping_depth", 1e-3, "damping depth"),
    ("twin", "outsole", 0.002, "outsole"), ("biped", "frame_mass", 0.05, "frame's mass"),
])  # fmt: skip
def test_each_number_of_a_design_is_one_that_the_drawn_ones_have(parameters, file, key, value, name):
    other = dataclasses.replace(parameters, **{file: dataclasses.replace(getattr(parameters, file), **{key: value})})
    same = numbers(design_of(other)) == pytest.approx(numbers(design_of(parameters)), rel=1e-12)
    changed_ones = np.array(NUMBERS)[np.abs(numbers(design_of(other)) - numbers(design_of(parameters))) > 1e-12]
    assert not same and name in changed_ones
