"""The stage as a whole, with a stand-in for the analytic result, and the study's own choice."""

import dataclasses

import numpy as np
import pytest

from pipeline.cache import artefact
from stages.contact_study.result import Result
from stages.contact_study.run import Inputs, run, same_set


@pytest.fixture(scope="module")
def result(small, stand_in):
    return run(small, Inputs(stand_in))


def test_rows_and_curves_belong_together(result):
    assert result.variations.key == ("contact_stiffness", "stiction_velocity")
    assert result.variations.value.tolist() == [1e6, 0.02]
    assert result.variations.outcome == ("completed", "completed")
    assert result.variations.force.shape == (2, len(result.time), 2)
    assert result.default_force.shape == result.chosen_force.shape == (len(result.time), 2)
    assert len(result.candidates.outcome) == 2


def test_the_choice_is_among_the_candidates_and_keeps_the_starting_sets_rest(result, default):
    assert result.chosen.law == default, "the stand-in is a walk with that set"
    assert result.chosen.hip_position.max() < 1e-6


def test_it_says_whether_the_ground_is_its_choice(result, small, stand_in, default):
    assert not result.ground_is_choice and "ground.yaml holds another" in result.summary()
    other = run(dataclasses.replace(small, contact=default), Inputs(stand_in))
    assert other.ground_is_choice and "ground.yaml holds it" in other.summary()


def test_runs_give_the_same_bytes_and_survive_storage(result, small, stand_in):
    content = artefact.encode(result, {})
    assert artefact.encode(run(small, Inputs(stand_in)), {}) == content
    read = artefact.decode(content, Result, "contact_study.h5")
    assert read.chosen.law == result.chosen.law and np.array_equal(read.variations.force, result.variations.force)


def test_tables_show_all_variations_and_the_best_sets(result):
    (_, columns, varied), (_, searched, tried) = result.tables()
    assert len(varied) == 1 + 2 + 2 and all(len(row) == len(columns) for row in varied)
    assert len(tried) == 2 and all(len(row) == len(searched) for row in tried)
    assert tried[0][-2] <= tried[1][-2]


@pytest.mark.slow
def test_ground_yaml_holds_the_choice_of_the_study(parameters, repository):
    """The whole study from the analytic gait: is the set that every stage uses still the one the criterion chooses?"""
    from pipeline.study import locate
    from stages.analytic import run as analytic

    own = locate(start=repository).parameters(["analytic"])["analytic"]
    result = run(parameters, Inputs(analytic.run(own)))
    assert same_set(parameters.contact, result.chosen.law), result.summary()
    assert result.chosen.hip_position.max() <= 3e-4 and result.chosen.hip_velocity.max() <= 5e-3
