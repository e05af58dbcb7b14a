"""Settings that follow from others: at every level, and not where one is given by hand."""

import dataclasses

import pytest

from pipeline.errors import StudyError
from pipeline.parameters.value import LEVELS
from pipeline.study import locate
from stages.biped.accuracy.tolerances import CHECKED_FINEST, FINEST, scaled
from tests.pipeline.toy import HOME

STAGES = ("analytic", "multibody", "contact_study", "error_budget", "twin", "campaign", "calibration", "twin_pushes")


def at(*settings, asked="paper"):
    study = dataclasses.replace(locate(settings=settings, start=HOME), requested=(("accuracy", asked),))
    return study.parameters(STAGES)


@pytest.mark.parametrize("level", LEVELS)
def test_what_is_compared_is_as_accurate_as_what_it_is_compared_with(level):
    found = at(asked=level)
    constraint, penalty = (found[name].settings.tolerance for name in ("analytic", "multibody"))
    contact, budget = found["contact_study"], found["error_budget"]
    assert (contact.constraint_tolerance, contact.penalty_tolerance) == (constraint, penalty)
    assert budget.constraint_tolerance == constraint
    assert budget.penalty_tolerance == max(penalty, 10 * budget.settings.penalty_fine_tolerance)
    for each in (contact, budget):
        assert CHECKED_FINEST <= each.checked_tolerance <= each.penalty_tolerance
    twin, pushes, campaign = found["twin"].settings, found["twin_pushes"], found["campaign"]
    pushed = pushes.twin.with_tolerance(pushes.settings.tolerance).tolerance
    sensed = campaign.twin.with_tolerance(campaign.runs.solver_tolerance).tolerance
    # coarser, an accelerometer is off by gravity's degree, and pushes ten times looser than that are no walks
    assert pushed == sensed == min(scaled(twin.tolerance, 10), 1e-5)
    calibration = found["calibration"].settings
    assert calibration.corrected == calibration.fitted_runs
    assert campaign.bare_runs == (0 if level == "draft" else calibration.fitted_runs)


def test_a_setting_by_hand_reaches_all_that_follow_and_one_of_their_own_wins():
    found = at("multibody.tolerance=3e-9", "twin.tolerance=2e-7", "calibration.fitted_runs=3")
    assert found["contact_study"].penalty_tolerance == 3e-9
    assert found["contact_study"].checked_tolerance == CHECKED_FINEST
    assert found["campaign"].twin.with_tolerance(found["campaign"].runs.solver_tolerance).tolerance == 2e-6
    assert (found["campaign"].bare_runs, found["calibration"].settings.corrected) == (3, 3)
    found = at("multibody.tolerance=3e-9", "contact_study.tolerance=1e-5", "campaign.bare_runs=0",
               "calibration.corrected_runs=0")  # fmt: skip
    assert found["contact_study"].penalty_tolerance == 1e-5 and found["contact_study"].checked_tolerance == 1e-7
    assert (found["campaign"].bare_runs, found["calibration"].settings.corrected) == (0, 0)


def test_nothing_that_follows_leaves_what_is_allowed():
    found = at("analytic.tolerance=1e-14", "multibody.tolerance=1e-11", "twin.tolerance=1e-4")
    budget = found["error_budget"]
    assert FINEST < budget.settings.constraint_fine_tolerance < budget.constraint_tolerance
    assert budget.settings.penalty_fine_tolerance < budget.penalty_tolerance
    assert found["campaign"].twin.with_tolerance(None).tolerance == 1e-4


def test_fine_tolerances_are_finer_than_those_given():
    with pytest.raises(StudyError, match="penalty_fine_tolerance = 1e-10 is not allowed; allowed: < penalty_tolerance"):
        at("error_budget.penalty_tolerance=1e-10")
