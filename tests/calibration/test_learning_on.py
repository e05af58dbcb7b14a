"""A robot that goes on learning: runs one after another against all of them at once."""

import dataclasses
from functools import cache

import numpy as np
import pytest

from stages.calibration.blind_score import draw, model_of
from stages.calibration.estimation.campaign import fit_campaign
from stages.calibration.estimation.run_fit import RunFit, begun, fit_near, run_equations
from stages.calibration.following import robot_file
from stages.calibration.following.fitted import earlier_fits, earlier_runs, fitted_robot
from stages.calibration.intervals.model_error import Judged, widening
from tests.calibration.runs import SHORT

#: Two steps less.
SHORTER = dataclasses.replace(SHORT, settings=dataclasses.replace(SHORT.settings, planned_steps=5))


def fitted(runs, known, before=None, fits=None, parameters=SHORT):
    """The robot of runs, after one that was fitted before; of `fits` where the runs' own are known."""
    design, model = model_of(parameters)
    had = [one.run for one in before.learned] if before else []
    if before:
        there, told = before.uncorrected, (*known, *earlier_runs(before))
        fits = fits or [fit_near(there, begun(there, run, model), run, model, told) for run in runs]
        fits = [*earlier_fits(before, model), *fits]
    fit = fit_campaign(design, [*had, *runs], model, known, fits and enumerate(fits))
    assert fit.converged and not fit.left_out, (fit.why, fit.left_out)
    sigmas, wider = widening(fit.equations)
    told = Judged(fit.design, wider * np.sqrt(np.diag(fit.covariance)), "")
    return fitted_robot(design, model, fit, told, (sigmas, wider), tuple(known), False)


def one_by_one(campaign, first):
    """After the first runs at once, and each of the others."""
    robot = fitted(campaign.runs[:first], campaign.known)
    yield robot
    for run in campaign.runs[first:]:
        robot = fitted([run], campaign.known, robot)
        yield robot


def off(one, other):
    """What two robots differ by, in the standard errors of the second."""
    return (one.estimate - other.estimate) / np.sqrt(np.diag(other.covariance))


@cache
def learned():
    """The robot of three runs one after another, and of all at once; the truth stands for the runs' own fits."""
    campaign = draw(11, 3, SHORTER)
    _, model = model_of(SHORTER)
    values = np.array([campaign.design.value(name) for name in model.shared])
    fits = [RunFit(values, own, unknowns, run_equations(campaign.design, own, unknowns, run, model), 0, True, "")
            for run, own, unknowns in zip(campaign.runs, campaign.slopes[:, None], campaign.unknowns, strict=True)]
    robot = None
    for run, fit in zip(campaign.runs, fits, strict=True):
        robot = fitted([run], campaign.known, robot, [fit], SHORTER)
    return robot, fitted(campaign.runs, campaign.known, None, fits, SHORTER)


def test_runs_one_after_another_tell_what_all_do_at_once():
    last, both = learned()
    assert np.abs(off(last, both)).max() < 0.1
    np.testing.assert_allclose(np.diag(last.covariance), np.diag(both.covariance), rtol=0.02)
    np.testing.assert_allclose(last.own_sd, both.own_sd, rtol=0.02)
    np.testing.assert_allclose(last.mounting, both.mounting, rtol=0.02, atol=1e-5)
    assert (last.runs, last.sigmas) == pytest.approx((3, both.sigmas), rel=0.01)


def test_a_robots_file_has_its_runs_and_how_far_they_were_fitted(tmp_path):
    robot, _ = learned()
    (tmp_path / robot_file.NAME).write_bytes(robot.content())
    again = robot_file.read(tmp_path)
    assert again.content() == robot.content()
    _, model = model_of(SHORTER)
    for one, other, fit in zip(robot.learned, again.learned, earlier_fits(again, model), strict=True):
        np.testing.assert_array_equal(one.run.samples["hip"], other.run.samples["hip"])
        assert fit.equations.chi2 / fit.equations.count == pytest.approx(1.0, abs=0.15)


@pytest.mark.slow
def test_runs_one_by_one_after_nine_are_within_a_tenth_of_a_standard_error_of_all_at_once():
    campaign = draw(12, 30, SHORT)
    *_, last = one_by_one(campaign, 9)
    assert np.abs(off(last, fitted(campaign.runs, campaign.known))).max() < 0.1
