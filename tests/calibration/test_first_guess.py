"""A run's start from the times of its heel strikes."""

from types import SimpleNamespace

import numpy as np
import pytest

from stages.analytic.errors import StepFailed
from stages.analytic.model.walker import build_walker
from stages.calibration.estimation import first_guess as first_guess_module
from stages.calibration.estimation import run_fit
from stages.calibration.estimation.first_guess import first_guess, other_guesses
from tests.calibration.runs import drawn, fitted


@pytest.mark.parametrize("seed", [1054, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (1060, 1099))])
def test_a_push_is_told_from_the_strikes_alone(seed):
    """Of robots not the drawing's, pushed so that mid-stance is .05 to .15 s off the gait's, strikes wrong by 2 ms."""
    run = drawn(seed)
    drawing, model = fitted()
    layout, truth = model.layout, run.unknowns[0]
    guess = first_guess(drawing, run.runs[0].strikes, run.runs[0].sampling.first_leg, layout)
    place = layout.place("mid_stance")
    assert abs(layout.middle[place] - truth[place]) > 0.045
    assert guess[place] == pytest.approx(truth[place], abs=0.02)
    at = layout.place("start_psi")
    assert abs(guess[at] - truth[at]) < 0.6 * abs(layout.middle[at] - truth[at])


def test_a_guess_without_strikes_is_the_gaits_own():
    drawing, model = fitted()
    np.testing.assert_array_equal(first_guess(drawing, np.array([0.0, 0.5]), 0, model.layout), model.layout.middle)


def test_where_a_guess_leads_nowhere_one_parameter_is_changed_until_steps_last_as_long_as_measured(monkeypatch):
    """A leg 30 % too short: what comes first has a longer one, of both legs; and the fit goes on from there."""
    drawing, model = fitted()
    short = drawing.with_values({"biped.leg_length": 0.7 * 0.333, "biped.other_leg_length": 0.7 * 0.333})

    def gait(biped, slope, tolerance):  # steps of all robots last as many pendulum times
        return build_walker(biped, slope), SimpleNamespace(steps=[SimpleNamespace(period=2.6)])

    monkeypatch.setattr(first_guess_module, "find_gait", gait)
    found = other_guesses(short, ("biped.leg_length",), 0.48 * np.arange(6))
    assert found[0].value("biped.leg_length") == pytest.approx(1.25 * 0.7 * 0.333)
    assert found[0].value("biped.other_leg_length") == found[0].value("biped.leg_length")
    tried = []

    def attempt(design, run, *_):
        tried.append(design.value("biped.leg_length"))
        if len(tried) < 2:
            raise StepFailed("the first guess does not walk")
        return run_fit.RunFit(np.zeros(1), np.zeros(1), np.zeros(1), SimpleNamespace(chi2=1.0, count=1), 7, True, "")

    monkeypatch.setattr(run_fit, "_from_guess", attempt)
    run = drawn(1054).runs[0]
    assert run_fit.fit_run(short, run, model, ()).evaluations == 7
    assert tried[0] == short.value("biped.leg_length") < tried[1]
