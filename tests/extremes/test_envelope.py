"""The warnings outside the kept map: quiet inside, one sentence outside, and never at odds with a point of the map."""

import csv
import dataclasses
import json
import math
from collections import Counter

import pytest
from click.testing import CliRunner

from pipeline.cli import cli
from pipeline.study import locate
from stages.extremes import warnings as warned
from stages.extremes.parameters import (
    COULOMB,
    GAIT,
    INACCURATE,
    JOINTS,
    REFUSED,
    RIGHT,
    STEP,
    TREE,
    TWIN,
    USUAL,
    Parameters,
)
from stages.extremes.points import points
from stages.extremes.run import evaluate, in_words
from tests.study import parameters_of

STAGES = ("analytic", "multibody", "twin")


def said(repository, *settings, accuracy="", stages=STAGES):
    """The sentences for the study with `settings`, and its checked parameters."""
    study = dataclasses.replace(locate(settings=settings, start=repository), requested=(("accuracy", accuracy),))
    values = study.parameters(stages)
    return study.warnings(values), values


@pytest.fixture(scope="module")
def kept(repository):
    with open(repository / "docs/extremes.csv", newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_the_study_s_own_parameters_bring_no_warning(repository):
    sentences, values = said(repository, stages=(*STAGES, "campaign", "contact_study"))
    assert [warned.engine_of(stage, own) for stage, own in values.items()] == [GAIT, TREE, TWIN, None, None]
    assert sentences == [] and not any(said(repository, accuracy=word)[0] for word in ("draft", "paper", "reference"))


def test_similar_bipeds_have_one_place(repository):
    """Scaled in mass, length and gravity, every dimensionless number stays, and so does its place."""
    own = said(repository)[1]["analytic"]
    mass, length, gravity = 7.0, 30.0, 0.2
    time = math.sqrt(length / gravity)
    powers = {"hip_mass": mass, "foot_mass": mass, "leg_length": length, "foot_radius": length, "foot_com": length,
              "stiffness": mass / time**2, "damping": mass / time, "leg_inertia": mass * length**2}  # fmt: skip
    other = dataclasses.replace(own.biped, **{key: getattr(own.biped, key) * by for key, by in powers.items()})
    slope = dataclasses.replace(own.slope, gravity=own.slope.gravity * gravity)
    here, there = (warned.place_of(GAIT, *model, own.friction, own.settings)
                   for model in ((own.biped, own.slope), (other, slope)))  # fmt: skip
    assert warned.distance(here, there) == pytest.approx(0.0, abs=1e-12) and other != own.biped


def test_a_hip_whose_mass_is_in_its_frames_has_the_place_of_its_mass(repository):
    framed = "biped.hip_mass=0", "biped.frame_mass=0.158", "biped.frame_com=0.03", "biped.frame_inertia=1e-4"
    sentences, values = said(repository, *framed)
    places = [warned.place_of(GAIT, own.biped, own.slope, own.friction, own.settings)
              for own in (values["analytic"], said(repository)[1]["analytic"])]  # fmt: skip
    assert sentences == [] and warned.distance(*places) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(
    ("settings", "stage", "words"),
    [
        (("biped.stiffness=120", "biped.damping=1"), "analytic", ("found right", "refused", "no periodic gait")),
        (("ground.slope_deg=85",), "analytic", ("ground.slope_deg 80", "refused", "no periodic gait")),
        (("biped.stiffness=1e8", "biped.damping=5e4", "biped.hip_mass=30", "biped.leg_inertia=0.05"), "analytic",
         ("a factor", "came out as right")),
        (("ground.contact_stiffness=1e-8",), "multibody", ("ground.contact_stiffness 1,", "failed")),
        (("ground.friction=coulomb",), "multibody", ("no point", "ground.friction = coulomb")),
        (("ground.stiction_velocity=1e-6",), "twin", ("ground.stiction_velocity 1e-06", "failed")),
    ],
)
def test_outside_one_sentence_names_the_nearest_point_and_its_end(repository, settings, stage, words):
    (sentence,) = said(repository, *settings, stages=(stage,))[0]
    assert sentence.startswith(f"stage {stage}: ") and all(word in sentence for word in words), sentence
    assert "\n" not in sentence


def test_whoever_asks_for_an_accuracy_is_not_told_of_it():
    here = warned.Place({}, {"tolerance": -1.0})
    rough = [warned.Tried(here, "tolerance 0.01", INACCURATE, 3e-3, "within 100 times the tolerance")]
    assert "inaccurate by 3.0e-03 leg lengths" in warned.warning(GAIT, here, rough, False)
    assert warned.warning(GAIT, here, rough, True) is None


def test_a_kind_of_robot_that_the_map_lacks_is_told_what_finds_its_errors():
    here = warned.Place({"biped.legs": "rigid"}, {})
    sentence = warned.warning(GAIT, here, [warned.Tried(warned.Place({}, {}), "none", RIGHT, None, "")], False)
    assert "no point" in sentence and sentence.endswith("requested (--accuracy hip_position_m=1e-5)")
    assert warned.warning(GAIT, here, [], True) is None


@pytest.mark.parametrize("engine", [GAIT, COULOMB, TREE, JOINTS, TWIN])
def test_at_a_point_of_the_map_the_warning_says_what_came_of_it(engine):
    tried = warned.tried(engine)
    assert {point.status for point in tried} >= {RIGHT, REFUSED} or engine == JOINTS
    for point in tried:
        sentence = warned.warning(engine, point.place, tried, False)
        twins = [other for other in tried if warned.distance(point.place, other.place) < 1e-9]
        if len({other.status for other in twins}) == 1:
            assert (sentence is None) == (point.status == RIGHT), point
        assert sentence is None or any(other.what in sentence and other.status in sentence for other in twins)


def test_warnings_leave_json_alone(repository):
    command = ["run", "multibody", "twin", "--dry-run", "--json", "--set", "ground.friction=none"]
    done = CliRunner().invoke(cli, command, catch_exceptions=False)
    assert done.exit_code == 0 and isinstance(json.loads(done.stdout), list)
    said = [line.split(": ")[:2] for line in done.stderr.splitlines()]
    assert said == [["warning", "stage multibody"], ["warning", "stage twin"]]


def test_the_kept_table_holds_the_kept_map(kept):
    assert len(kept) >= 1500 and not {row["status"] for row in kept} & {"wrong", "crashed", "hung"}
    assert all(row["reason"] for row in kept if row["status"] != RIGHT)
    for engine in (GAIT, COULOMB, TREE, JOINTS, TWIN):
        rows = [row for row in kept if row["engine"] == engine and "is not allowed" not in row["reason"]]
        assert Counter(point.status for point in warned.tried(engine)) == Counter(r["status"] for r in rows)


def contradictions(kept, wanted):
    """Points of the coarse map that `wanted` picks, computed anew, whose answer is not the kept one."""
    parameters = parameters_of("extremes")
    known = {(row["engine"], row["axis"], row["value"]): row for row in kept}
    found = []
    for point in filter(wanted, points(parameters)):
        row, finding = known[point.engine, point.axis, f"{point.value:g}"], evaluate(parameters, point)
        assert isinstance(parameters, Parameters) and in_words(point) == row["changes"]
        if finding.status != row["status"] or finding.error > 10 * max(float(row["error"] or 0.0), 1e-9):
            found.append((point, finding, row))
    return found


def test_a_coarse_rerun_does_not_contradict_the_kept_map(kept):
    def quick(point):
        return (point.engine == STEP and point.value < 3) or (point.axis == USUAL and point.engine == GAIT)

    assert contradictions(kept, quick) == []


@pytest.mark.slow
def test_the_whole_coarse_rerun_does_not_contradict_the_kept_map(kept):
    assert contradictions(kept, lambda point: True) == []
