"""A detailed design: what it adds, its two legs, and what is refused."""

from __future__ import annotations

import dataclasses
from importlib import import_module
from pathlib import Path

import pytest

from pipeline.errors import StudyError
from pipeline.study import Study
from stages.biped.design import BeyondModel, Biped, require_plain
from stages.biped.quantity import faults

ROOT = Path(__file__).resolve().parents[2]
TABLE_1 = Biped("compliant", 0.316, 0.335, 0.333, 0.083, 0.1, 2800.0, 58.35, 0.0)


def with_values(**values):
    return dataclasses.replace(TABLE_1, **values)


def test_table_1_has_no_details_and_two_equal_legs():
    assert not TABLE_1.detailed and TABLE_1.alike and TABLE_1.exchanged == TABLE_1
    assert TABLE_1.leg(0) == TABLE_1.leg(1) and TABLE_1.total_mass == 0.316 + 2 * 0.335


def test_the_other_leg_has_what_is_given_and_else_the_first_legs_numbers():
    lame = with_values(other_leg_length=0.34, frame_mass=0.05)
    other = lame.leg(1)
    assert (other.leg_length, other.frame_mass, other.stiffness, lame.leg(0).leg_length) == (0.34, 0.05, 2800.0, 0.333)
    assert lame.details == ("frame_mass", "other_leg_length") and not lame.alike
    assert lame.total_mass == pytest.approx(0.316 + 2 * 0.335 + 2 * 0.05, abs=1e-15)


def test_frames_alone_leave_the_legs_alike_and_a_resting_angle_does_not():
    assert with_values(frame_mass=0.05, frame_com=0.03, hip_stiffness=1.0).alike
    assert not with_values(hip_stiffness=1.0, hip_rest_angle=0.1).alike


def test_exchanging_the_legs_twice_changes_nothing():
    lame = with_values(other_leg_length=0.34, other_foot_mass=0.3, hip_stiffness=1.0, hip_rest_angle=0.1)
    once = lame.exchanged
    assert once.leg(0) == lame.leg(1) and once.leg(1) == lame.leg(0) and once.hip_rest_angle == -0.1
    assert once.exchanged == lame and once.total_mass == pytest.approx(lame.total_mass, abs=1e-15)


@pytest.mark.parametrize(("values", "key"), [
    ({"other_leg_length": 0.08}, "other_leg_length"),
    ({"other_foot_radius": 0.4}, "other_foot_radius"),
    ({"other_foot_com": 0.35, "other_leg_length": 0.34}, "other_foot_com"),
    ({"frame_com": 0.1}, "frame_com"),
    ({"frame_mass": 0.1, "other_frame_mass": 0.0, "other_frame_offset": 0.1}, "other_frame_offset"),
    ({"hip_rest_angle": 0.1}, "hip_rest_angle"),
    ({"frame_mass": -0.1}, "frame_mass"),
    ({"hip_friction": -0.1}, "hip_friction"),
])
def test_rules_name_the_value_to_change(values, key):
    assert key in {broken.key for broken in faults(with_values(**values))}


@pytest.mark.parametrize("values", [
    {"hip_mass": 0.0, "frame_mass": 0.1}, {"hip_gravity_mass": -0.4}, {"frame_com": -0.02, "frame_mass": 0.1},
    {"other_leg_length": 0.34, "other_foot_radius": 0.3335}, {},
])
def test_what_a_machine_can_have_is_legal(values):
    assert list(faults(with_values(**values))) == []


def test_a_model_that_does_not_know_a_detail_says_so():
    with pytest.raises(BeyondModel, match="frame_mass"):
        require_plain(with_values(frame_mass=0.05), "the model")
    require_plain(TABLE_1, "the model")


class Anything:
    """Results that nobody looks at."""

    def __getattr__(self, name):
        return Anything()


def given(stage, *settings):
    """The parameters of a stage."""
    return Study(ROOT, ROOT / "params", ROOT / "results", settings).parameters((stage,))[stage]


@pytest.mark.parametrize("stage", ["twin_ladder", "campaign"])
def test_stages_refuse_details_they_do_not_know_when_they_run(stage):
    """In one sentence, which is an answer: the study's other stages run."""
    parameters = given(stage, "biped.frame_mass=0.05", "biped.other_leg_length=0.34")
    said = "does not know frame_mass, other_leg_length; only the planar models and stage twin do"
    with pytest.raises(BeyondModel, match=said):
        import_module(f"stages.{stage}.run").run(parameters, Anything())


@pytest.mark.parametrize("stage", ["contact_study", "error_budget"])
@pytest.mark.parametrize(("setting", "words"), [
    ("biped.other_leg_length=0.34", "repeat after one step, and with other_leg_length they"),
    ("biped.strike_time=0.5", "does not know strike_time")])
def test_stages_of_one_step_refuse_legs_that_differ_and_timed_strikes(stage, setting, words):
    parameters = given(stage, "biped.frame_mass=0.05", setting, "biped.legs=rigid", "biped.feet_retract=true")
    with pytest.raises(BeyondModel, match=words):
        import_module(f"stages.{stage}.run").run(parameters, Anything())


@pytest.mark.parametrize("stage", ["twin", "twin_pushes"])
def test_the_twin_refuses_timed_strikes(stage):
    timed = given(stage, "biped.legs=rigid", "biped.feet_retract=true", "biped.strike_time=0.5")
    with pytest.raises(BeyondModel, match="the twin does not know strike_time"):
        import_module(f"stages.{stage}.run").run(timed, Anything())


@pytest.mark.parametrize("stage", ["analytic", "multibody", "twin", "twin_pushes", "tradeoff", "extremes"])
def test_other_stages_take_them(stage):
    biped = given(stage, "biped.frame_mass=0.05", "biped.other_leg_length=0.34").biped
    assert (biped.frame_mass, biped.leg(1).leg_length) == (0.05, 0.34)


def test_what_no_design_can_have_is_said_where_it_is_tried():
    with pytest.raises(StudyError) as error:
        given("analytic", "biped.knee_height=0.1")
    assert "without knees" in " ".join(error.value.sentences)
