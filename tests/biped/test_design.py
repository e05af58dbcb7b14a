"""A detailed design: what it adds, its two legs, rubber under its feet, and what is refused."""

import dataclasses
import math
from importlib import import_module

import numpy as np
import pytest

from pipeline.errors import StudyError
from pipeline.parameters.value import LEVELS, broken_rules
from pipeline.study import locate
from stages.biped.accuracy.tolerances import CHECKED_FINEST, FINEST, scaled
from stages.biped.design import BeyondModel
from stages.biped.quantity import faults
from stages.biped.rubber import Rubber, ring_sector, soled
from tests.study import ROOT, TABLE_1, parameters_of


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


@pytest.mark.parametrize(("values", "key", "wanted"), [
    ({"other_leg_length": 0.05}, "other_leg_length", ("> foot_radius = 0.083 m and > foot_com = 0.1 m",)),
    ({"strike_time": 0.5}, "strike_time", ("none without feet_retract: true", "and none with compliant legs")),
])
def test_all_rules_of_a_key_are_one_sentence(values, key, wanted):
    ((named, sentence),) = broken_rules(with_values(**values))
    assert named == key and all(words in sentence for words in wanted)


@pytest.mark.parametrize("values", [
    {"hip_mass": 0.0, "frame_mass": 0.1}, {"hip_gravity_mass": -0.4}, {"frame_com": -0.02, "frame_mass": 0.1},
    {"other_leg_length": 0.34, "other_foot_radius": 0.3335}, {},
])
def test_what_a_machine_can_have_is_legal(values):
    assert list(faults(with_values(**values))) == []


class Anything:
    """Results that nobody looks at."""

    def __getattr__(self, name):
        return Anything()


TIMED = "biped.strike_time=0.5"
RETRACTING = ("biped.legs=rigid", "biped.feet_retract=true")


@pytest.mark.parametrize(("stages", "settings", "words"), [
    (("contact_study", "error_budget"), ("biped.frame_mass=0.05", TIMED, *RETRACTING), "does not know strike_time"),
    (("twin", "twin_pushes"), (*RETRACTING, TIMED), "the twin does not know strike_time"),
])
def test_stages_refuse_details_they_do_not_know_when_they_run(stages, settings, words):
    """In one sentence, which is an answer: the study's other stages run."""
    for stage in stages:
        with pytest.raises(BeyondModel, match=words):
            import_module(f"stages.{stage}.run").run(parameters_of(stage, *settings), Anything())


@pytest.mark.parametrize("stage", ["analytic", "multibody", "twin", "twin_pushes", "tradeoff", "extremes"])
def test_other_stages_take_them(stage):
    biped = parameters_of(stage, "biped.frame_mass=0.05", "biped.other_leg_length=0.34").biped
    assert (biped.frame_mass, biped.leg(1).leg_length) == (0.05, 0.34)


def test_what_no_design_can_have_is_said_where_it_is_tried():
    with pytest.raises(StudyError) as error:
        parameters_of("analytic", "biped.knee_height=0.1")
    assert "without knees" in " ".join(error.value.sentences)


# --- Rubber under the feet: its mass, and one leg made of a leg and its sole.


RUBBER = Rubber(foot_width=0.02, outsole_arc=0.112, outsole_density=1100.0)


def grains(outer, thickness, half_angle, count=400):
    """Place (n, 2) and area (n,) of the small pieces of a sector, by the midpoint rule."""
    radius = outer - thickness + thickness * (np.arange(count) + 0.5) / count
    angle = half_angle * (2.0 * (np.arange(count) + 0.5) / count - 1.0)
    radius, angle = (values.ravel() for values in np.meshgrid(radius, angle))
    area = radius * (thickness / count) * (2.0 * half_angle / count)
    return np.column_stack([radius * np.sin(angle), -radius * np.cos(angle)]), area


SECTORS = [(0.085, 0.002, 0.67), (1.0, 1.0, math.pi / 2), (2.0, 0.5, 3.0)]


@pytest.mark.parametrize(("outer", "thickness", "half"), SECTORS)
def test_a_sectors_moments_are_those_of_its_pieces(outer, thickness, half):
    place, area = grains(outer, thickness, half)
    found = ring_sector(outer, thickness, half)
    centre = area @ place / area.sum()
    assert found.area == pytest.approx(area.sum(), rel=1e-9)
    assert found.depth == pytest.approx(-centre[1], rel=1e-5)
    squares = area @ (place - centre) ** 2 / area.sum()
    assert (found.across, found.along) == pytest.approx(tuple(squares), rel=1e-4)


def test_an_arc_that_is_not_given_is_the_share_of_the_foot_that_it_is_of_table_1s():
    """112 mm stayed under a foot of any radius: a foot of 10 mm wore a whole ring."""
    own = Rubber(foot_width=0.02, outsole_arc=None, outsole_density=1100.0)
    assert own.mass(0.083, 0.002) == RUBBER.mass(0.083, 0.002) == pytest.approx(0.002 * 0.020 * 0.112 * 1100.0)
    assert RUBBER.mass(0.083, 0.0) == 0.0
    assert own.mass(0.83, 0.02) == pytest.approx(100.0 * own.mass(0.083, 0.002))
    assert own.mass(0.0, 0.002) == 0.0, "a point has no arc"


def test_leg_and_sole_keep_mass_moment_and_inertia_about_the_hip():
    mass, thickness = 0.0099, 0.002
    whole = soled(TABLE_1, RUBBER, thickness, mass)
    place, area = grains(TABLE_1.foot_radius + thickness, thickness, 0.112 / (2 * 0.083 + 0.002))
    from_hip = place[:, 1] - (TABLE_1.leg_length - TABLE_1.foot_radius)  # the disc's centre stays where it was
    share = area / area.sum()
    moment = TABLE_1.foot_mass * (TABLE_1.leg_length - TABLE_1.foot_com) - mass * share @ from_hip
    second = TABLE_1.foot_mass * (TABLE_1.leg_length - TABLE_1.foot_com) ** 2
    second += mass * share @ (from_hip**2 + place[:, 0] ** 2)
    arm = whole.leg_length - whole.foot_com
    assert whole.foot_mass == TABLE_1.foot_mass + mass
    assert whole.foot_mass * arm == pytest.approx(moment, rel=1e-6)
    assert whole.foot_mass * arm**2 + whole.leg_inertia == pytest.approx(second, rel=1e-6)


def test_without_mass_it_only_lengthens_and_widens():
    grown = soled(TABLE_1, RUBBER, 0.002, 0.0)
    assert (grown.leg_length, grown.foot_radius, grown.foot_com) == pytest.approx((0.335, 0.085, 0.102))
    assert (grown.foot_mass, grown.leg_inertia) == (TABLE_1.foot_mass, 0.0)


# --- Settings that follow from others: at every level, and not where one is given by hand.


STAGES = ("analytic", "multibody", "contact_study", "error_budget", "twin", "campaign", "calibration", "twin_pushes")


def at(*settings, asked="paper"):
    study = dataclasses.replace(locate(settings=settings, start=ROOT), requested=(("accuracy", asked),))
    return study.parameters(STAGES)


@pytest.mark.parametrize("level", LEVELS)
def test_what_is_compared_is_as_accurate_as_what_it_is_compared_with(level):
    found = at(asked=level)
    constraint, penalty = (found[name].settings.tolerance for name in ("analytic", "multibody"))
    contact, budget = found["contact_study"], found["error_budget"]
    assert (contact.constraint_tolerance, contact.penalty_tolerance) == (constraint, penalty)
    assert budget.constraint_tolerance == constraint
    assert budget.penalty_tolerance == max(penalty, 10 * budget.settings.penalty_fine_tolerance)
    for each in (contact, budget):
        assert CHECKED_FINEST <= each.checked_tolerance <= each.penalty_tolerance
    twin, pushes, campaign = found["twin"].settings, found["twin_pushes"], found["campaign"]
    pushed = pushes.twin.with_tolerance(pushes.settings.tolerance).tolerance
    sensed = campaign.twin.with_tolerance(campaign.runs.solver_tolerance).tolerance
    # coarser, an accelerometer is off by gravity's degree, and pushes ten times looser than that are no walks
    assert pushed == sensed == min(scaled(twin.tolerance, 10), 1e-5)
    calibration = found["calibration"].settings
    assert calibration.corrected == calibration.fitted_runs
    assert campaign.bare_runs == (0 if level == "draft" else calibration.fitted_runs)


def test_a_setting_by_hand_reaches_all_that_follow_and_one_of_their_own_wins():
    found = at("multibody.tolerance=3e-9", "twin.tolerance=2e-7", "calibration.fitted_runs=3")
    assert found["contact_study"].penalty_tolerance == 3e-9
    assert found["contact_study"].checked_tolerance == CHECKED_FINEST
    assert found["campaign"].twin.with_tolerance(found["campaign"].runs.solver_tolerance).tolerance == 2e-6
    assert (found["campaign"].bare_runs, found["calibration"].settings.corrected) == (3, 3)
    found = at("multibody.tolerance=3e-9", "contact_study.tolerance=1e-5", "campaign.bare_runs=0",
               "calibration.corrected_runs=0")  # fmt: skip
    assert found["contact_study"].penalty_tolerance == 1e-5 and found["contact_study"].checked_tolerance == 1e-7
    assert (found["campaign"].bare_runs, found["calibration"].settings.corrected) == (0, 0)


def test_nothing_that_follows_leaves_what_is_allowed():
    found = at("analytic.tolerance=1e-14", "multibody.tolerance=1e-11", "twin.tolerance=1e-4")
    budget = found["error_budget"]
    assert FINEST < budget.settings.constraint_fine_tolerance < budget.constraint_tolerance
    assert budget.settings.penalty_fine_tolerance < budget.penalty_tolerance
    assert found["campaign"].twin.with_tolerance(None).tolerance == 1e-4


def test_fine_tolerances_are_finer_than_those_given():
    with pytest.raises(StudyError, match="penalty_fine_tolerance = 1e-10 is not allowed; allowed: < penalty_tolerance"):
        at("error_budget.penalty_tolerance=1e-10")
