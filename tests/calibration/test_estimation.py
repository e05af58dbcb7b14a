"""Runs drawn blind and fitted: what comes back, how well, and what is refused."""

import dataclasses

import numpy as np
import pytest

from pipeline.parameters import yaml_text
from pipeline.questions.command import Described
from stages.analytic.errors import StepFailed
from stages.biped.question import WrongOption
from stages.calibration.blind_score import draw, scored, summary
from stages.calibration.estimation.campaign import JOINT, Joint, as_plain, fit_campaign, from_plain
from stages.calibration.estimation.request import request_of
from stages.calibration.estimation.run_fit import fit_near, horizons, run_equations
from stages.calibration.information.identifiability import free_names
from tests.calibration.runs import DESIGN, SHORT, fitted

#: As many fits are made of them.
SHORTER = dataclasses.replace(SHORT, settings=dataclasses.replace(SHORT.settings, planned_steps=4))


@pytest.fixture(scope="module", params=[1, pytest.param(3, marks=pytest.mark.slow)])
def blind(request):
    return scored(request.param, 1, SHORTER)


def test_a_blind_run_comes_to_rest_at_the_noise(blind):
    assert blind.converged and 0.9 < blind.chi2 < 1.1
    assert np.abs((blind.estimate - blind.truth) / blind.sd).max() < 4.5
    np.testing.assert_allclose(blind.sd, blind.bound, rtol=0.1)


def test_a_summary_counts_what_holds_and_what_found_no_rest(blind):
    far = np.where(np.arange(len(blind.sd)) % 3, 3.0, 0.0)
    off = dataclasses.replace(blind, seed=3, estimate=blind.truth + far * blind.sd)
    restless = dataclasses.replace(blind, seed=4, converged=False, why="too few steps")
    told = summary([blind, off, restless])
    assert told["not_converged"] == {4: "too few steps"}
    assert told["coverage_together"] == pytest.approx(np.mean([one.holds for one in (blind, off)]))
    assert np.mean(off.holds) < 0.5 < np.mean(blind.holds)


@pytest.fixture(scope="module")
def campaign():
    """Three runs of one robot; every third sample of the second is off by .2, m/s^2 or rad/s."""
    drawn = draw(5, 3, SHORTER)
    odd = drawn.runs[1]
    samples = {side: one + 0.2 * (np.arange(len(one))[:, None] % 3 == 0) for side, one in odd.samples.items()}
    return dataclasses.replace(drawn, runs=(drawn.runs[0], dataclasses.replace(odd, samples=samples), drawn.runs[2]))


@pytest.fixture(scope="module")
def own_fits(campaign):
    """By their places; they begin at the truth, as that of the odd one is found by many attempts else."""
    _, model = fitted()
    return {number: fit_near(campaign.design, begin, run, model, campaign.known)
            for number, (begin, run) in enumerate(zip(campaign.unknowns, campaign.runs))}  # fmt: skip


@pytest.fixture(scope="module")
def fit_of_two(campaign, own_fits):
    """All three together, of which one is odd."""
    drawing, model = fitted()
    return fit_campaign(drawing, campaign.runs, model, campaign.known, own_fits.items())


def test_two_runs_tell_more_than_one(campaign, own_fits, fit_of_two):
    drawing, model = fitted()
    one = fit_campaign(drawing, campaign.runs[:1], model, campaign.known, [(0, own_fits[0])])
    assert fit_of_two.converged and one.converged
    assert (np.diag(fit_of_two.covariance) < np.diag(one.covariance)).all()
    truth = np.array([campaign.design.value(name) for name in model.shared])
    assert np.abs((fit_of_two.design - truth) / np.sqrt(np.diag(fit_of_two.covariance))).max() < 4.5


def test_an_odd_run_is_left_out_and_said(campaign, fit_of_two):
    odd = campaign.runs[1]
    assert [run.name for run in fit_of_two.runs] == [campaign.runs[0].name, campaign.runs[2].name]
    assert list(fit_of_two.left_out) == [odd.name]
    assert "times the usual residuals" in fit_of_two.left_out[odd.name]


def test_together_the_runs_begin_where_their_own_unknowns_go_along(campaign, own_fits, monkeypatch):
    """With a design that is not their own, each run's start and sensors are those that fit it best there."""
    drawing, model = fitted()
    begun = []

    def begin(self, design, own, unknowns, *_):
        begun.append((design, own, unknowns))
        raise StepFailed("seen enough")

    monkeypatch.setattr(Joint, "from_point", begin)
    fits = [own_fits[0], own_fits[2]]
    with pytest.raises(StepFailed, match="in common"):
        Joint(drawing, [campaign.runs[0], campaign.runs[2]], model, campaign.known).fitted(fits, {}, 0)
    assert len(begun) == 3  # what they agree on, then each one's own
    for number, fit in enumerate(fits):
        design, own, unknowns = begun[0]
        moved = np.concatenate([design - fit.design, own[number] - fit.own, unknowns[number] - fit.unknowns])
        left = fit.equations.right - fit.equations.matrix @ moved
        scale = np.sqrt(np.diag(fit.equations.matrix))
        assert np.abs(left / scale)[len(design) :].max() < 1e-3
        np.testing.assert_allclose(begun[1 + number][2][number], fit.unknowns, atol=1e-3)


def test_what_no_run_shows_stays_where_it_is_known_in_what_the_runs_agree_on(campaign, own_fits, monkeypatch):
    """No sensor shows the scale of mass; that designs differ by it a little looks as if each run told something."""
    drawing, model = fitted()
    begun = []
    monkeypatch.setattr(Joint, "from_point", lambda self, *start: begun.append(start[0]))
    lighter = dataclasses.replace(own_fits[2], design=own_fits[2].design * (1.0 + 0.1 * np.array(
        [name.endswith("_radius") for name in model.shared])))  # fmt: skip
    joint = Joint(drawing, [campaign.runs[0], campaign.runs[2]], model, campaign.known)
    joint.fitted([own_fits[0], lighter], {}, 0)
    (weighed,) = campaign.known
    assert model.robot(drawing, begun[0]).biped.total_mass == pytest.approx(weighed.value, abs=3.0 * weighed.sd)


@pytest.mark.parametrize("off", [-0.6, 0.6])
def test_a_runs_own_unknowns_settle_at_a_design_where_a_whole_step_leads_past(campaign, own_fits, off):
    """A bandwidth off by a factor of 1.8, as a whole step of Gauss and Newton had it and took it back by turns."""
    drawing, model = fitted()
    fit, run = own_fits[0], campaign.runs[0]
    moved = fit.unknowns.copy()
    moved[model.layout.place("bandwidth")] += off
    begun = Joint(drawing, [run], model, campaign.known).from_point(
        fit.design, fit.own[None], moved[None], {}, 0, dataclasses.replace(JOINT, most=0))
    assert begun.equations[0].cost < fit.equations.cost + 1.0 and begun.evaluations > 1


def test_a_run_that_is_not_at_rest_begins_where_its_own_fit_ended(campaign, own_fits, monkeypatch):
    """A whole step of its own unknowns may lead farther off than it was: it is from_point's to try."""
    drawing, model = fitted()
    run, fit = campaign.runs[0], own_fits[0]
    unknowns = fit.unknowns + 0.3 * model.layout.sizes
    equations = run_equations(drawing.with_values(dict(zip(model.shared, fit.design, strict=True))), fit.own, unknowns,
                              run, model)  # fmt: skip
    begun = []
    monkeypatch.setattr(Joint, "from_point", lambda self, *start: begun.append(start))
    restless = dataclasses.replace(fit, unknowns=unknowns, equations=equations, converged=False)
    Joint(drawing, [run], model, campaign.known).fitted([restless], {}, 0)
    np.testing.assert_allclose(begun[0][2][0], unknowns, atol=1e-9)
    np.testing.assert_allclose(begun[0][1][0], fit.own, atol=1e-9)


def test_horizons_rise_to_the_whole_run(campaign):
    run = campaign.runs[0]
    ends = [end for end, _ in horizons(run)]
    assert ends == sorted(ends) and horizons(run)[-1] == (run.duration, 1.0)


def test_a_run_is_the_same_in_plain_values(campaign):
    run = campaign.runs[0]
    again = from_plain(as_plain(run))
    np.testing.assert_array_equal(again.samples["foot"], run.samples["foot"])
    np.testing.assert_array_equal(again.used["hip"], run.used["hip"])
    assert (again.own, again.sampling.first_leg) == (run.own, run.sampling.first_leg)


@pytest.mark.parametrize(("text", "message"), [
    ("weight: 1", "known.yaml:1: weight: there is no such entry"),
    ("known:\n  mass: {value: 1, uncertainty: 1, unit: kg}", "known.yaml:2: known.mass: no such quantity"),
    ("known:\n  total_mass: {value: 1, uncertainty: 1, unit: g}", "known.yaml:2: known.total_mass.unit: g, must be kg"),
    ("known:\n  leg_length: {value: long, uncertainty: 1, unit: m}", "known.yaml:2: known.leg_length.value: long"),
    ("known:\n  leg_length: {value: 0.3, uncertainty: 0, unit: m}", "known.yaml:2: known.leg_length.uncertainty: 0"),
    ("fixed: [damping, colour]", "known.yaml:1: fixed.1: colour is no parameter of the design"),
    ("held_out: all", "known.yaml:1: held_out: expected a list"),
])
def test_a_wrong_file_is_refused_with_line_and_key(text, message):
    with pytest.raises(WrongOption) as refused:
        request_of(Described(yaml_text.parse(text, "known.yaml"), "known.yaml"))
    assert str(refused.value).startswith(message)


@pytest.mark.parametrize(("text", "words"), [
    ("known: {leg_length: {value: -0.3, uncertainty: 0.1, unit: m}}", "known.leg_length.value: -0.3, must be > 0"),
    ("known: {total_mass: {value: 0, uncertainty: 0.1, unit: kg}}", "known.total_mass.value: 0, must be > 0"),
    ("known: {leg_length: {value: 33.3, uncertainty: 0.1, unit: m}}", "33.3, where the design .* has 0.333"),
    ("free: [hip_stiffness]", "hip_stiffness is not looked for"),
    ("free: [leg_length]\nfixed: [leg_length]", "nothing is left"),
    ("design: drawing", "must be biped .* or parts"),
])
def test_what_cannot_be_fitted_is_refused_before_anything_is(text, words):
    with pytest.raises(WrongOption, match=words):
        request = request_of(Described(yaml_text.parse(text, "known.yaml"), "known.yaml"))
        request.check(request.looked_for(free_names(DESIGN)), DESIGN)
