"""The stage as a whole beside the constraint model, and the study's own choice."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest

from pipeline.cache import artefact
from pipeline.study import locate
from stages.analytic.errors import NoGait
from stages.analytic.gait.gait_search import gaits_kept
from stages.contact_study import rigid_limit
from stages.contact_study import run as stage
from stages.contact_study.result import Result
from stages.contact_study.rigid_limit import same_set
from stages.contact_study.run import Inputs, checked, run
from stages.studies.result import EnginesDisagree
from stages.studies.walks import Machine


@pytest.fixture(scope="module")
def analytic(constraints):
    """What the stage reads of an analytic result."""
    rolling, _ = constraints
    return SimpleNamespace(
        walk=rolling.walk, mid_stance=rolling.mid_stance, gait=SimpleNamespace(period_s=rolling.period))


@pytest.fixture(scope="module")
def result(small, analytic):
    return run(small, Inputs(analytic))


@pytest.fixture
def unchecked(result, monkeypatch):
    """The check against Exudyn takes most of a run: this one leaves it out and takes what that of `result` found."""

    def known(scene, laws, cycles, count, tolerance):
        assert laws and cycles and count == 2 and tolerance > 0.0
        return result.engines

    monkeypatch.setattr(stage, "checked", known)


def test_rows_and_curves_belong_together(result):
    rows = result.variations
    assert (rows.key, rows.value.tolist()) == (("contact_stiffness", "stiction_velocity"), [3e5, 0.05])
    assert rows.outcome == ("completed", "completed") and len(result.candidates.outcome) == 2
    assert rows.force.shape == (2, len(result.time), 2)
    assert result.default_force.shape == result.chosen_force.shape == (len(result.time), 2)


def test_the_choice_is_among_the_candidates_and_at_the_head_of_its_family(result, default):
    limit, depth = result.limit, result.chosen.law.damping_depth
    chosen = dataclasses.replace(default, stiction_velocity=0.03, damping_depth=depth)
    assert result.chosen.law == limit.chosen.law == chosen and limit.finalists == (limit.chosen,)
    assert [one.law.stiction_velocity for one in limit.family] == [0.03, 0.015]
    assert limit.family[1].position_parts.sum() < limit.family[0].position_parts.sum()
    assert limit.chosen.evaluations <= limit.most_evaluations


def test_it_says_whether_the_ground_is_its_choice(result, small, analytic, unchecked):
    assert not result.ground_is_choice and "ground.yaml holds another" in result.summary()
    assert result.limit.ground.law == small.contact != result.limit.chosen.law
    other = run(dataclasses.replace(small, contact=result.chosen.law), Inputs(analytic))
    assert other.ground_is_choice and "ground.yaml holds it" in other.summary()
    assert other.limit.ground.score == other.limit.chosen.score == pytest.approx(result.limit.chosen.score)


def test_runs_give_the_same_bytes_and_survive_storage(result, small, analytic, unchecked):
    content = artefact.encode(result, {})
    gaits_kept.cache_clear()  # this run searches as well
    assert artefact.encode(run(small, Inputs(analytic)), {}) == content
    read = artefact.decode(content, Result, "contact_study.h5")
    assert read.chosen.law == result.chosen.law and np.array_equal(read.variations.force, result.variations.force)
    assert read.limit.finalists[0].law == result.limit.finalists[0].law


def test_tables_show_all_variations_the_family_and_the_best_sets(result):
    tables = result.tables()
    assert all(len(row) == len(columns) for _, columns, rows in tables for row in rows)
    varied, measured, tried, *friction, checks = (rows for *_, rows in tables)
    assert [len(rows) for rows in (varied, measured, tried, checks)] == [1 + 2 + 2, 1 + 3 + 1 + 2, 2, 3]
    assert all(len(rows) == 14 for rows in friction) and tried[0][-1] <= tried[1][-1]


def test_the_study_is_within_a_nanometre_of_exudyn_and_fails_if_it_is_not(
    result, small, default, beside_rolling, monkeypatch
):
    step, _, cycle = result.engines.distances
    assert step.allowed == pytest.approx(3e-9 * 0.333) and "step with" in step.what and "cycle with" in cycle.what
    assert result.engines.largest < 1e-9 and "of Exudyn at 3 sampled points" in result.summary()
    assert {one.outcome for one in result.engines.distances} == {"completed"}

    def other(machine, state, tolerance, steps, duration):
        """In Exudyn's place the compiled walker, on ground that is stiffer by a hundred-thousandth."""
        stiffer = dataclasses.replace(machine.contact, contact_stiffness=(1 + 1e-5) * machine.contact.contact_stiffness)
        return dataclasses.replace(machine, contact=stiffer).compiled(state, 1e-12, steps, duration)

    monkeypatch.setattr(Machine, "exudyn", other)
    with pytest.raises(EnginesDisagree, match="disagree on a step with contact_stiffness"):
        checked(beside_rolling, [(default, 1)], (), 1, small.checked_tolerance)


def test_without_a_gait_with_slipping_feet_there_is_no_choice_but_a_result(
    small, analytic, default, unchecked, monkeypatch
):
    def none(*given):
        raise NoGait("the trailing foot slips away")

    monkeypatch.setattr(rigid_limit, "constraint_model", none)
    found = run(small, Inputs(analytic))
    assert found.limit is None and found.candidates is None and not found.ground_is_choice
    assert found.chosen.law == default and found.variations.outcome == ("completed", "completed")
    assert "the trailing foot slips away" in found.summary() and len(found.tables()) == 4
    assert artefact.decode(artefact.encode(found, {}), Result, "contact_study.h5").limit is None


@pytest.mark.slow
def test_ground_yaml_holds_the_choice_of_the_study(parameters, repository):
    """The whole study from the analytic gait: is the set that every stage uses still the one the criterion chooses?"""
    from stages.analytic import run as analytic

    own = locate(start=repository).parameters(["analytic"])["analytic"]
    result = run(parameters, Inputs(analytic.run(own)))
    assert result.ground_is_choice and same_set(parameters.contact, result.chosen.law), result.summary()
    best, second = result.limit.finalists[:2]
    assert best.score < 0.9 * second.score, "by more than a tenth"
    assert best.evaluations <= result.limit.most_evaluations
    assert result.limit.family[-1].position_parts.sum() < 0.1 * best.position_parts.sum(), "an eighth of both effects"
