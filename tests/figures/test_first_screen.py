"""What a report says first: answers with errors from the results, a title that names the biped."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest

from stages.analytic.result import Uncertainty, Validity
from stages.figures.first_screen import Measure, answers, measure, title
from stages.model_error.result import EVEN, WIDTH
from tests.figures.made_up_results import misses, results

GOOD = Validity(5.0, 1.0, 0.2, 0.4, 1.1, 0.0, 0.0, 0.3, 0.5, 0.01, 2e-3, 0.0, True)


def analytic(multiplier=0.6, validity=GOOD):
    gait = SimpleNamespace(period_s=0.5, step_frequency_hz=2.0, step_length_m=0.16, speed_m_s=0.32,
                           stable=multiplier < 1.0, floquet_multipliers=np.array([[multiplier, 0.0]]))
    nothing = float("nan")
    digits = tuple(Uncertainty(name, unit, 1.0, 0.03, width, "biped.hip_mass", 0.01, nothing, nothing)
                   for name, unit, width in (("step_frequency_hz", "Hz", 0.02), ("speed_m_s", "m/s", 0.003)))
    return SimpleNamespace(gait=gait, validity=validity, uncertainties=digits)


def inputs(**other):
    found = {**results(), "analytic": analytic(), **other}
    found["twin"] = SimpleNamespace(outcome="completed", steps=8)
    return SimpleNamespace(missing={}, **found)


def test_a_number_is_corrected_by_the_bias_and_has_three_errors():
    found = measure(analytic(), misses(), "step_frequency")
    assert found.value == pytest.approx(2.0 * 0.99) and found.model == pytest.approx(2.0 * 0.04)
    assert found.inputs == pytest.approx(EVEN * WIDTH * 0.02) and found.solver == pytest.approx(2e-8)
    assert found.error == pytest.approx(2e-8 + np.hypot(0.08, EVEN * WIDTH * 0.02))
    assert found.text() == "1.98 ± 0.09"
    assert found.parts() == "solver < 0.001 %, model 4 %, inputs 1 %"


def test_the_digits_of_the_slope_are_inputs_too():
    found = analytic()
    digits = dataclasses.replace(found.uncertainties[0], slope_least=1.9, slope_most=2.1)
    found.uncertainties = (digits,)
    assert measure(found, misses(), "step_frequency").inputs == pytest.approx(EVEN * WIDTH * np.hypot(0.02, 0.1))


def test_what_was_learnt_of_stable_gaits_corrects_no_other():
    found = measure(analytic(1.2), misses(), "multiplier")
    assert found.value == 1.2 and np.isnan(found.model) and "model not known" in found.parts(share=False)


def test_the_first_screen_answers_three_questions_and_a_fourth_of_own_recordings():
    walks, fast, stable = answers(inputs())
    assert walks.answer == "Yes, on conditions." and "2 mm below ground" in walks.means and "8 steps" in walks.errors
    assert fast.answer.startswith("0.32 ± 0.02 m/s: 1.98 ± 0.09 steps a second") and "fewer than 1.9 " in fast.means
    assert stable.answer.startswith("A step leaves 0.59 ± 0.05") and "above 0.999" in stable.answer
    assert "after 5 steps; of the starts tried, 14 %" in stable.means
    report = SimpleNamespace(step_frequency=2.0, step_frequency_error=0.01, step_length=0.16, step_length_error=1e-3)
    own = SimpleNamespace(origin="measured", runs=(SimpleNamespace(report=report),))
    said = answers(inputs(imu=own))[3]
    assert said.answer == "2.00 ± 0.02 steps a second (model: 1.98 ± 0.09); 160 ± 2 mm a step (model: 158 ± 7)."
    assert "1 % faster than the model, within their errors" in said.means
    faster = SimpleNamespace(origin="measured", runs=(SimpleNamespace(
        report=SimpleNamespace(**{**vars(report), "step_frequency": 2.5, "step_length": float("nan")})),))
    said = answers(inputs(imu=faster))[3]
    assert "26 % faster than the model, more than their errors" in said.means and "mm" not in said.answer
    _, fast, stable, said = answers(inputs(imu=faster, model_error=None))
    assert "How far the twin differs from this model is not known." in fast.means and "fewer" not in fast.means
    assert stable.answer.endswith("of a small disturbance: stable, as far as its errors are known.")
    assert said.means.endswith("more than the errors that are known; what the model misses is not.")


@pytest.mark.parametrize(("found", "answer", "means"), [
    (analytic(validity=dataclasses.replace(GOOD, deepest_scuff=0.0)), "Yes, on a plain ramp.", "neither"),
    (analytic(1.3), "Not on a plain ramp.", "a step enlarges what disturbs it"),
])
def test_it_says_whether_the_biped_walks(found, answer, means):
    walks, _, stable = answers(inputs(analytic=found))
    assert walks.answer == answer and means in walks.means
    assert ("unstable" in stable.answer) == (not found.gait.stable)


def test_without_a_gait_the_reason_is_the_answer():
    one, = answers(SimpleNamespace(analytic=None, missing={"analytic": "it falls"}))
    assert one.answer == "No gait is known." and one.means == "it falls"


def test_the_title_names_the_papers_biped_or_the_study():
    papers = title(SimpleNamespace(another=()))
    assert "Vasileiou" in papers["title"] and "Mechanism and Machine Theory, 2021" in papers["about"]
    assert papers["claims_first"]
    own = title(SimpleNamespace(another=("one", "two", "three")))
    assert own["title"].startswith("{study}") and own["about"] == "Not the paper's biped: one; two; and 1 more."
    assert not own["claims_first"]


def test_an_error_that_is_round_off_is_not_shown():
    assert Measure(2.0, 1e-12, 0.0, 0.0).text() == "2"
