"""The question how the gait on ground that gives way answers to parameters."""

import dataclasses
import json

import pytest

from stages.biped.question import WrongOption
from stages.contact_study.questions.ground_sensitivity import HEADS, Options, ask
from stages.penalty import step_map
from stages.penalty.model.changes import names_of


class Listener:
    jobs = 1

    def progress(self, fraction, what):
        assert 0.0 < fraction < 1.0 and what


def test_it_names_what_moves_the_gait_and_nothing_else(parameters):
    plain = set(names_of(parameters.biped, parameters.slope, parameters.contact))
    assert {"biped.damping", "ground.slope_deg", "ground.damping_depth", "ground.friction_velocity"} < plain
    assert not {"ground.restitution", "ground.impact_speed", "biped.frame_mass"} & plain
    other = dataclasses.replace(parameters.contact, normal_force="restitution", friction="coulomb")
    rigid = dataclasses.replace(parameters.biped, legs="rigid", frame_mass=0.05)
    names = set(names_of(rigid, parameters.slope, other))
    assert plain - names == {"biped.stiffness", "biped.damping", "ground.contact_damping", "ground.damping_depth",
                             "ground.dynamic_friction", "ground.friction_velocity"}  # fmt: skip
    assert names - plain == {"ground.restitution", "ground.impact_speed", "biped.frame_mass"}


def test_elasticities_of_legs_that_differ_in_words_and_numbers(parameters, default, monkeypatch):
    """Of the multipliers seven digits would do; how they are had to ten, `tests/penalty/test_response.py` says."""
    monkeypatch.setattr(step_map, "OF_MATRICES", 1e-10)
    design = dataclasses.replace(
        parameters.biped, frame_mass=0.03, frame_com=0.04, other_leg_length=parameters.biped.leg_length - 1e-4)
    names = ("biped.foot_mass", "biped.leg_length", "biped.leg_inertia")
    answer = ask(dataclasses.replace(parameters, biped=design, contact=default), Options(names), Listener())
    assert json.loads(json.dumps(answer.plain)) == answer.plain
    told = answer.plain["parameters"]
    assert tuple(told) == names and tuple(row["parameter"] for row in answer.rows) == names
    shares = told["biped.foot_mass"]["elasticities"]
    assert tuple(shares) == HEADS
    period = answer.plain["gait"]["period_s"]
    assert told["biped.foot_mass"]["period_s"] == pytest.approx(shares["period"] * period / design.foot_mass)
    assert told["biped.leg_inertia"]["elasticities"] is None
    assert any(line.startswith("biped.leg_inertia is 0") for line in answer.lines)
    assert told["biped.leg_length"]["elasticities"]["|mu1|"] is None  # of the first leg alone, by .4 %: it falls
    assert [word.split()[1] for word in answer.plain["refused"]] == ["biped.leg_length"]
    assert answer.plain["distance_to_exudyn_m"] < 1e-9 and answer.plain["left_by_extrapolation"] < 1e-5


def test_what_moves_nothing_is_refused_with_what_does(parameters):
    with pytest.raises(WrongOption, match=r"ground\.restitution: this gait depends on biped\.hip_mass, .*"):
        ask(parameters, Options(("ground.restitution",)), Listener())
