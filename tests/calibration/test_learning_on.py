"""A robot that goes on learning: runs one after another against all of them at once."""

import dataclasses
from functools import cache

import numpy as np
import pytest

from stages.calibration.blind_score import draw, model_of
from stages.calibration.estimation.campaign import fit_campaign
from stages.calibration.estimation.least_squares import information_of
from stages.calibration.following.fitted import Spread, earlier_runs, fitted_robot, judged_again, widened_again
from stages.calibration.information.identifiability import first_model
from stages.calibration.intervals.model_error import Judged, widening
from tests.calibration.runs import SHORT


def fitted(runs, known, before=None):
    """The robot of runs, after one that was fitted before."""
    design, model = model_of(SHORT)
    given = known
    if before is not None:
        design, model = before.design, first_model(before.design, (*before.names, *before.own), SHORT)
        given = (*known, *earlier_runs(before))
    fit = fit_campaign(design, runs, model, given)
    assert fit.converged and not fit.left_out, (fit.why, fit.left_out)
    sigmas, wider = widening(fit.equations)
    if before is None:
        told = Judged(fit.design, wider * np.sqrt(np.diag(fit.covariance)), "")
    else:
        sigmas, wider = widened_again(sigmas, wider, len(runs), before)
        told = judged_again(fit, before, wider)
    return fitted_robot(design, model, fit, told, (sigmas, wider), tuple(known), False, before)


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
    """A campaign of three short runs, and its robot after two and after the third."""
    campaign = draw(11, 3, dataclasses.replace(SHORT, settings=dataclasses.replace(SHORT.settings, planned_steps=6)))
    return campaign, list(one_by_one(campaign, 2))


def test_a_run_after_two_others_tells_what_all_do_at_once():
    campaign, (_, last) = learned()
    both = fitted(campaign.runs, campaign.known)
    assert np.abs(off(last, both)).max() < 0.1
    alone, other = (np.sqrt(np.diag(one.covariance)) / one.wider for one in (last, both))
    np.testing.assert_allclose(alone, other, rtol=0.1)
    np.testing.assert_allclose(last.own_sd, both.own_sd, rtol=0.05)
    np.testing.assert_allclose(last.mounting, both.mounting, rtol=0.25, atol=1e-5)
    assert (last.runs, last.sigmas, last.late_sd) == pytest.approx((3, both.sigmas, both.late_sd), rel=0.05)


def test_what_runs_told_is_what_a_fit_that_goes_on_is_given():
    _, (robot, _) = learned()
    told = earlier_runs(robot)
    at = robot.design.with_values(dict(zip(robot.names, map(float, robot.estimate), strict=True)))
    np.testing.assert_allclose(information_of(told, robot.names, at), robot.information, rtol=1e-6,
                               atol=1e-9 * robot.information.max())  # fmt: skip
    assert [one.of(at) for one in told] == pytest.approx([one.value for one in told], abs=0.05)


def test_another_unit_of_mass_is_as_far_from_what_runs_told_as_it_was():
    """No sensor shows it."""
    _, (robot, _) = learned()
    shorter = ("biped.leg_length", "biped.foot_radius", "biped.foot_com")
    there, heavier = (robot.design.with_values({name: share * robot.design.value(name) for name in robot.names
                                                if name not in shorter}) for share in (1.0, 1.1))  # fmt: skip
    for one in earlier_runs(robot):
        assert one.of(heavier) == pytest.approx(one.of(there), abs=0.01)


def test_spreads_of_two_samples_are_that_of_both():
    values = np.random.default_rng(1).normal(size=(7, 3))
    whole, first = Spread.of(values), Spread.of(values[:1])
    both = first.and_of(6, values[1:].mean(axis=0), values[1:].std(axis=0, ddof=1))
    np.testing.assert_allclose(both.mean, whole.mean)
    np.testing.assert_allclose(both.sd, whole.sd)
    assert both.count == 7 and not first.sd.any()


@pytest.mark.slow
@pytest.mark.xfail(reason="what nine runs tell worst is off by 0.4 standard errors of thirty: valleys of the cost are "
                          "curved, and earlier runs are a quadratic")
def test_runs_one_by_one_after_nine_are_within_a_tenth_of_a_standard_error_of_all_at_once():
    campaign = draw(12, 30, SHORT)
    *_, last = one_by_one(campaign, 9)
    assert np.abs(off(last, fitted(campaign.runs, campaign.known))).max() < 0.1
