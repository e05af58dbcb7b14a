"""A run's start from the times of its heel strikes."""

import numpy as np
import pytest

from stages.calibration.estimation.first_guess import first_guess
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
