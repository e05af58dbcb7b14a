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
def drawing():
    return fitted()[0]


@pytest.fixture(scope="module")
def model():
    return fitted()[1]


@pytest.fixture(scope="module")
def drawn():
    """One run of a robot that was drawn, cut to six steps."""
    campaign = runs.drawn(1001)
    return dataclasses.replace(campaign, runs=(first_steps(campaign.runs[0], 6),))


@pytest.fixture(scope="module")
def fit(drawing, model, drawn):
    return fit_run(drawing, drawn.runs[0], model, drawn.known)


def sd_of(model, fit, known):
    """Standard deviations of the design, (d,): by what the run tells and by the scale, which tells of masses."""
    d = len(model.shared)
    information = fit.equations.matrix.copy()
    information[:d, :d] += information_of(known, model.shared)
    return np.sqrt(np.diag(np.linalg.inv(information))[:d])


def constraint(model, change=1.0):
    """A simulator that is the constraint model, with a stiffness that is larger than it is told by some share."""

    def run(design, unknowns, like):
        stiffer = design.with_value("biped.stiffness", change * design.value("biped.stiffness"))
        found = predict(stiffer, (), unknowns, model.layout, like.sampling, 1e-9)
        return dataclasses.replace(like, samples={side: one[:, :, 0] for side, one in found.samples.items()})

    return run


def test_a_simulator_that_is_the_model_corrects_nothing(drawing, model, drawn, fit):
    found = corrected(drawing, fit, drawn.runs[0], model, drawn.known, constraint(model))
    assert np.abs(found.bias / sd_of(model, fit, drawn.known)).max() < 0.3


def test_a_fit_begun_near_its_end_ends_there_sooner(drawing, model, drawn, fit):
    near = drawing.with_values(dict(zip(model.shared, fit.design, strict=True)))
    again = fit_near(near, fit.unknowns, drawn.runs[0], model, drawn.known)
    assert np.abs((again.design - fit.design) / sd_of(model, fit, drawn.known)).max() < 0.1
    assert again.converged and again.evaluations < fit.evaluations


def fits_anew(drawing, model, drawn, fit, begin):
    """Whether a fit that was begun there is left for that from a first guess."""
    given = drawing, drawn.runs[0], model, drawn.known
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(fitting, "fit_run", lambda *other: fit if other == given else None)
        return fit_near(drawing, begin, drawn.runs[0], model, drawn.known) is fit


def test_a_fit_begun_where_none_walks_or_that_finds_no_rest_is_begun_anew(drawing, model, drawn, fit, monkeypatch):
    lost = fit.unknowns.copy()
    lost[model.layout.place("start_theta_rate")] = 0.0  # from there no walker gets to the first heel strike
    assert fits_anew(drawing, model, drawn, fit, lost)
    monkeypatch.setattr(fitting, "least_squares", lambda *begun: least_squares(*begun[:4], Rule(2)))
    assert fits_anew(drawing, model, drawn, fit, fit.unknowns)


@pytest.mark.slow
def test_a_fit_begun_far_from_its_end_is_begun_anew(drawing, model, drawn, fit):
    lost = fit.unknowns.copy()
    lost[model.layout.place("start_theta_rate")] *= 0.1
    assert fits_anew(drawing, model, drawn, fit, lost)


def test_a_simulator_that_is_stiffer_than_it_is_told_takes_that_off(drawing, model, drawn, fit):
    found = corrected(drawing, fit, drawn.runs[0], model, drawn.known, constraint(model, 1.02))
    shares = dict(zip(model.shared, found.bias / fit.design, strict=True))
    assert shares["biped.stiffness"] == pytest.approx(0.02, rel=0.1)
    assert abs(shares["biped.leg_length"]) < 1e-3
    assert found.design == pytest.approx(fit.design - found.bias, rel=1e-14)


def test_a_run_of_the_model_is_explained_to_its_noise_and_foretold(model, drawn):
    """Fit within 1.2 times the sensors' noise; foretold, errors are larger, those of a walk that stays near."""
    robot = drawn.design
    tell = explained(robot, drawn.runs[0], model, 0.15)
    force, rate = model.noise[0], model.noise[2]
    assert tell.fit[0] < 1.2 * force
    assert tell.fit[1] < 1.2 * rate
    assert tell.sigmas < 1.2
    assert force < tell.foretold[0] < 1.0
    assert rate < tell.foretold[1] < 0.5


def test_errors_count_what_counts_after_a_time(model, drawn):
    run = drawn.runs[0]
    residuals = {side: np.full((len(getattr(run.sampling, side)), 3), 2.0) for side in SIDES}
    for side in SIDES:
        residuals[side][getattr(run.sampling, side) <= 1.0] = 100.0
    assert rms_of(residuals, run, model, 1.0) == pytest.approx((2 * model.noise[0], 2 * model.noise[2]))
    assert rms_of(residuals, run, model)[0] > 10 * model.noise[0]
