"""Errors that step times are given, against what strikes and toe-offs with such errors do to them."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from stages.imu.strikes.step_times import HeelStrikes, step_times
from tests.imu.stand_in import DRAWING

ONSET, STEP, COUNT = 2e-3, 0.48, 11


@pytest.fixture(scope="module")
def drawn() -> tuple[np.ndarray, list]:
    """Step times of 400 walks whose legs' impacts are each seen late or early by an error of the leg's own."""
    rng, leg = np.random.default_rng(6), (np.arange(COUNT) + 1) % 2
    drawing = dataclasses.replace(DRAWING, onset_error_s=ONSET, strike_scatter_s=0.0, toe_off_error_s=0.0)
    late = ONSET * rng.normal(size=(400, 2))
    found = [step_times(HeelStrikes(STEP * np.arange(COUNT) + one[leg], leg), 1e-6, drawing) for one in late]
    return late, found


def test_a_steps_error_is_that_of_two_strikes(drawn: tuple[np.ndarray, list]) -> None:
    off = np.array([(one.inner_step - STEP, one.outer_step - STEP) for one in drawn[1]])
    assert drawn[1][0].step_error == pytest.approx(np.sqrt(np.mean(off**2)), rel=0.08)
    asymmetry = np.array([one.asymmetry for one in drawn[1]])
    assert drawn[1][0].asymmetry_error == pytest.approx(np.sqrt(np.mean(asymmetry**2)), rel=0.08)


def test_the_error_of_stances_that_differ_holds_that_of_the_steps(drawn: tuple[np.ndarray, list]) -> None:
    """The stances differ as the steps do; of the double stance, which is not seen twice, an error is added."""
    asymmetry = np.array([one.stance_asymmetry for one in drawn[1]])
    said = drawn[1][0].stance_asymmetry_error
    assert np.sqrt(np.mean(asymmetry**2)) <= said < 1.3 * np.sqrt(np.mean(asymmetry**2))
