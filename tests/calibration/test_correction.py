"""The correction step: nothing where the simulator is the model, and the bias where it is not."""

import dataclasses

import numpy as np
import pytest

from stages.calibration.estimation import run_fit as fitting
from stages.calibration.estimation.held_out import corrected, explained, rms_of
from stages.calibration.estimation.least_squares import Rule, information_of, least_squares
from stages.calibration.estimation.run_fit import fit_near, fit_run
from stages.calibration.observation.measured_run import SIDES
from stages.calibration.observation.prediction import predict
from stages.calibration.recordings import first_steps
from tests.calibration import runs
from tests.calibration.runs import fitted


@pytest.fixture(scope="module")
def drawn():
    """One run of a robot that was drawn, cut to six steps."""
    campaign = runs.drawn(1001)
    return dataclasses.replace(campaign, runs=(first_steps(campaign.runs[0], 6),))


@pytest.fixture(scope="module")
def given(drawn):
    """What a fit is given: the drawing, the run, the model and what is known."""
    drawing, model = fitted()
    return drawing, drawn.runs[0], model, drawn.known


@pytest.fixture(scope="module")
def fit(given):
    return fit_run(*given)


@pytest.fixture(scope="module")
def sd(given, fit):
    """Standard deviations of the design, (d,): by what the run tells and by the scale, which tells of masses."""
    _, _, model, known = given
    d = len(model.shared)
    information = fit.equations.matrix.copy()
    information[:d, :d] += information_of(known, model.shared)
    return np.sqrt(np.diag(np.linalg.inv(information))[:d])


def corrected_by(given, fit, change):
    """The fit, corrected by a constraint model with a stiffness that is larger than it is told by some share."""
    drawing, measured, model, known = given

    def run(design, unknowns, like):
        stiffer = design.with_value("biped.stiffness", change * design.value("biped.stiffness"))
        found = predict(stiffer, (), unknowns, model.layout, like.sampling, 1e-9)
        return dataclasses.replace(like, samples={side: one[:, :, 0] for side, one in found.samples.items()})

    return corrected(drawing, fit, measured, model, known, run)


def test_a_simulator_that_is_the_model_corrects_nothing(given, fit, sd):
    assert np.abs(corrected_by(given, fit, 1.0)[0] / sd).max() < 0.3


def test_a_fit_begun_near_its_end_ends_there_sooner(given, fit, sd):
    drawing, *others = given
    near = drawing.with_values(dict(zip(others[1].shared, fit.design, strict=True)))
    again = fit_near(near, fit.unknowns, *others)
    assert np.abs((again.design - fit.design) / sd).max() < 0.1
    assert again.converged and again.evaluations < fit.evaluations


def fits_anew(given, fit, slower=1.0):
    """Whether a fit that was begun there, with so much of its rate, is left for that from a first guess."""
    begin = fit.unknowns.copy()
    begin[given[2].layout.place("start_theta_rate")] *= slower
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(fitting, "fit_run", lambda *other: fit if other == given else None)
        return fit_near(given[0], begin, *given[1:]) is fit


def test_a_fit_begun_where_none_walks_or_that_finds_no_rest_is_begun_anew(given, fit, monkeypatch):
    assert fits_anew(given, fit, 0.0)  # from there no walker gets to the first heel strike
    monkeypatch.setattr(fitting, "least_squares", lambda *begun: least_squares(*begun[:4], Rule(2)))
    assert fits_anew(given, fit)


@pytest.mark.slow
def test_a_fit_begun_far_from_its_end_is_begun_anew(given, fit):
    assert fits_anew(given, fit, 0.1)


def test_a_simulator_that_is_stiffer_than_it_is_told_takes_that_off(given, fit):
    bias, _ = corrected_by(given, fit, 1.02)
    shares = dict(zip(given[2].shared, bias / fit.design, strict=True))
    assert shares["biped.stiffness"] == pytest.approx(0.02, rel=0.1)
    assert abs(shares["biped.leg_length"]) < 1e-3


def test_a_run_of_the_model_is_explained_to_its_noise_and_foretold(given, drawn):
    """Fit within 1.2 times the sensors' noise; foretold, errors are larger, those of a walk that stays near."""
    _, run, model, _ = given
    tell = explained(drawn.design, run, model, 0.15)
    force, rate = model.noise[0], model.noise[2]
    assert tell.fit_force < 1.2 * force and tell.fit_rate < 1.2 * rate and tell.sigmas < 1.2
    assert force < tell.foretold_force < 1.0 and rate < tell.foretold_rate < 0.5


def test_errors_count_what_counts_after_a_time(given):
    _, run, model, _ = given
    residuals = {side: np.where(getattr(run.sampling, side) <= 1.0, 100.0, 2.0)[:, None] * np.ones(3) for side in SIDES}
    assert rms_of(residuals, run, model, 1.0) == pytest.approx((2 * model.noise[0], 2 * model.noise[2]))
    assert rms_of(residuals, run, model)[0] > 10 * model.noise[0]
