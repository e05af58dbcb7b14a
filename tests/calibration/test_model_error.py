"""Intervals where the model is not the robot's: residual structure, the sandwich, and the discrepancy."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.special import ndtr

from benchmarks.sandwich import noise_covariance, sandwich_covariance
from stages.calibration.estimation import run_fit as fitting
from stages.calibration.estimation.held_out import corrected, explained, rms_of
from stages.calibration.estimation.least_squares import Rule, information_of, least_squares
from stages.calibration.estimation.run_fit import WHOLE, Equations, fit_from, fit_near, fit_run, run_equations
from stages.calibration.information.identifiability import SLOPE
from stages.calibration.intervals.model_error import (
    PARTS,
    Discrepancy,
    step_parts,
    structure,
    structure_in_words,
    whiteness,
    widening,
)
from stages.calibration.observation.measured_run import SIDES
from stages.calibration.observation.prediction import predict
from stages.calibration.recordings import first_steps, measured
from stages.calibration.result import HALF_WIDTH
from stages.imu.parameters import filter_delay
from tests.calibration import runs
from tests.calibration.runs import PARAMETERS, SETTINGS, fitted

STEPS = 7


def half_widths(term, scales, pull):
    """Half of 95 % intervals about one more run's estimate less what it misses on average."""
    return HALF_WIDTH * np.sqrt(np.diag(term.spread(scales, pull)))


@pytest.fixture(scope="module")
def planned():
    """A robot on its ramp, the model, and a run of it whose samples are the prediction and noise."""
    campaign = runs.drawn(1001)
    return campaign.design.with_value(SLOPE, float(campaign.slopes[0])), fitted()[1], campaign.runs[0]


def test_a_run_counts_from_its_first_heel_strike_wherever_its_clock_stands(planned):
    """Of times that binary numbers hold exactly."""
    design, model, _ = planned
    values = np.random.default_rng(4).normal(size=(2, 384, 3))

    def sensor(time, cut_off):
        device = SimpleNamespace(bandwidth_hz=cut_off)
        trace = SimpleNamespace(rate_hz=128.0, indexed=SimpleNamespace(recording=SimpleNamespace(device=device)),
                                clock=SimpleNamespace(clock_error_s=np.nan))  # fmt: skip
        return SimpleNamespace(time=time, force=values[0], rate=values[1], trace=trace)

    def run(later):
        time = later + np.arange(384) / 128
        sensors = {side: sensor(time, cut_off) for side, cut_off in zip(SIDES, (PARAMETERS.sensor.bandwidth_hz, None))}
        strikes = later + 0.25 + 31 / 64 * np.arange(STEPS - 2)
        return measured("run", sensors, strikes, np.arange(STEPS - 2) % 2, 2.0, design, model.layout, SETTINGS, None)

    here, there = run(0.0), run(16.0)
    assert here.sampling.hip.size == there.sampling.hip.size > 150 and 0.0 < here.sampling.hip[0] < 31 / 64
    np.testing.assert_array_equal(here.strikes, there.strikes)
    cut_off = PARAMETERS.sensor.bandwidth_hz
    assert here.sampling.bandwidth_hz == {"hip": cut_off, "foot": 0.4 * 128.0} and not here.sampling.declared
    assert here.sampling.rate_sd == dict.fromkeys(SIDES, SETTINGS.own_clock_sd)
    assert here.sampling.late == {"hip": filter_delay(cut_off), "foot": 0.0}
    for side in SIDES:
        np.testing.assert_array_equal(here.sampling.of(side), there.sampling.of(side))
        np.testing.assert_array_equal(here.samples[side], there.samples[side])
        np.testing.assert_array_equal(here.used[side], there.used[side])


def equations_of(planned):
    design, model, run = planned
    return run_equations(design, np.array([design.value(SLOPE)]), runs.drawn(1001).unknowns[0], run, model)


def test_noise_is_told_for_noise_and_a_lack_at_one_phase_for_what_it_is(planned):
    design, model, run = planned
    found = structure(run, equations_of(planned))
    assert [one.is_noise for one in found] == [True] * 6
    assert structure_in_words([run], [equations_of(planned)]) == []
    part = step_parts(run.sampling.foot, run.strikes)
    foot = run.samples["foot"] + np.where(part == 2, 1.5 * model.noise[1], 0.0)[:, None] * np.array([0.0, 1.0, 0.0])
    changed = dataclasses.replace(run, samples={**run.samples, "foot": foot})
    equations = equations_of((design, model, changed))
    (wrong,) = (one for one in structure(changed, equations) if not one.is_noise)
    assert (wrong.side, wrong.axis, wrong.means.argmax()) == ("foot", "up", 2) and wrong.by_phase < 1e-6
    alone = {"white": 1.0}, {"by_phase": 1.0, "white": 0.0}
    assert not any(dataclasses.replace(wrong, **one).is_noise for one in alone)
    (told,) = structure_in_words([changed], [equations])
    assert f"part 3 of {PARTS}" in told


def test_spikes_hardly_widen_intervals(planned):
    """A hundredth of the samples 50 sigmas off: the width is that of Huber's estimate, below 1.3 of the clean one."""
    design, model, run = planned
    robust = dataclasses.replace(model, robust=4.0)
    rng = np.random.default_rng(8)
    samples = {side: one + np.where(rng.random(one.shape) < 0.01, 50.0, 0.0) * np.asarray(model.noise)
               for side, one in run.samples.items()}
    clean, spoiled = (equations_of((design, robust, one)) for one in (run, dataclasses.replace(run, samples=samples)))
    (_, plain), (size, wider) = widening([clean]), widening([spoiled])
    assert plain < 1.1 and 1.0 < size < 1.15 and 1.02 * plain < wider < 1.3 * plain
    assert all(one.is_noise for one in structure(run, spoiled))


def test_the_width_of_a_robust_fit_is_the_scatter_of_its_estimates():
    """Of a mean of noise with spikes: what is printed of each, and how much they differ."""
    rng, k, n = np.random.default_rng(3), 4.0, 400
    centres, widths = [], []
    for _ in range(300):
        left = rng.normal(size=n) + np.where(rng.random(n) < 0.05, 30.0 * rng.choice([-1, 1], n), 0.0)
        centre = 0.0
        for _ in range(20):
            weight = np.minimum(1.0, k / np.abs(left - centre))
            centre = float((weight * left).sum() / weight.sum())
        residuals = {side: np.full((n, 3), np.nan) for side in SIDES}
        residuals["hip"][:, 0] = left - centre
        chi2 = float((np.clip(left - centre, -k, k) ** 2).sum())
        of_one = Equations(np.eye(1), np.zeros(1), 0.0, chi2, n, residuals, None, k)
        centres.append(centre)
        widths.append(widening([of_one])[1] / np.sqrt(weight.sum()))
    assert np.std(centres) == pytest.approx(np.mean(widths), rel=0.15)


def test_whiteness_is_uniform_for_noise_and_nothing_for_a_wave():
    rng = np.random.default_rng(1)
    shares = np.array([whiteness(np.where(rng.random(400) < 0.1, np.nan, rng.normal(size=400))) for _ in range(400)])
    assert 0.02 < (shares < 0.05).mean() < 0.08
    assert 0.4 < shares.mean() < 0.6
    assert whiteness(np.sin(np.arange(400.0) / 5.0)) < 1e-12


def test_parts_of_a_step_begin_at_its_strike():
    strikes = np.array([0.0, 0.6, 1.2])
    found = step_parts(np.array([-0.1, 0.0, 0.09, 0.11, 0.59, 0.61, 1.19, 1.21]), strikes)
    assert found.tolist() == [-1, 0, 0, 1, PARTS - 1, 0, PARTS - 1, -1]


def test_the_sandwich_is_the_noises_own_where_residuals_are_noise(planned):
    """Over noises: its mean is the inverse of the information, which no residual enters."""
    _, model, run = planned
    d = len(model.shared)
    found = equations_of(planned)
    noise = np.diag(noise_covariance(found, model, ()))[1:d]  # without the mass' scale, which nothing tells of
    rng = np.random.default_rng(5)
    ratios = []
    for _ in range(40):
        left = {side: np.where(run.used[side], rng.normal(size=run.used[side].shape), np.nan) for side in SIDES}
        one = sandwich_covariance(run, dataclasses.replace(found, residuals=left), model, ())
        ratios.append(np.diag(one)[1:d] / noise)
    assert np.mean(ratios, axis=0) == pytest.approx(np.ones(d - 1), abs=0.35)


#: Pulls of further fits, and how often each comes, as Gaussian ones would (Gauss and Hermite's rule).
FURTHER, OFTEN = np.polynomial.hermite_e.hermegauss(12)
OFTEN = OFTEN / OFTEN.sum()


@pytest.mark.parametrize("pulled", [False, True])
@pytest.mark.parametrize("count", [5, pytest.param(8, marks=pytest.mark.slow), 24])
def test_a_discrepancy_holds_what_it_says(count, pulled):
    """Of studies with a scatter from few runs, 90 % have intervals that hold 95 % of what further runs miss."""
    rng = np.random.default_rng(2)
    scales, slope = np.array([3.0, -0.5]), np.array([2.0, 0.0])
    mean, sd = np.array([0.2, -1.0]), np.array([0.05, 0.4])
    contents = []
    for _ in range(400):
        pulls = rng.normal(size=count)
        misses = mean + sd * rng.normal(size=(count, 2)) + pulled * np.outer(pulls, slope)
        term = Discrepancy.of(misses, pulls if pulled else None)
        off = np.array([(mean + pulled * slope * pull) * scales - term.expected(scales, pull) for pull in FURTHER])
        half = np.array([half_widths(term, scales, pull) for pull in FURTHER])
        scatter = sd * np.abs(scales)
        contents.append(OFTEN @ (ndtr((half - off) / scatter) - ndtr((-half - off) / scatter)))
    assert (np.array(contents) >= 0.95).mean() == pytest.approx(0.9, abs=0.04)


def test_a_discrepancy_takes_off_what_goes_along_with_a_pull():
    pulls = np.array([-1.0, 0.0, 2.0, 3.0])
    misses = np.column_stack([0.1 + 0.5 * pulls, np.full(4, -0.2)])
    term = Discrepancy.of(misses, pulls)
    scales = np.array([10.0, 2.0])
    assert term.expected(scales, 5.0) == pytest.approx([10 * 2.6, -0.4])
    assert half_widths(term, scales, 5.0) == pytest.approx([0.0, 0.0], abs=1e-12)
    alone = Discrepancy.of(misses)
    assert alone.expected(scales) == pytest.approx(scales * misses.mean(axis=0))
    np.testing.assert_allclose(alone.covariance, np.cov(misses, rowvar=False), atol=1e-15)
    for few, needed in (((misses[:3], pulls[:3]), "4 runs"), ((misses[:2],), "3 runs")):
        with pytest.raises(ValueError, match=needed):
            Discrepancy.of(*few)


# --- The correction step: nothing where the simulator is the model, and the bias where it is not.


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
    assert fits_anew(given, fit, -1.0)  # from there no walker gets to the first heel strike
    monkeypatch.setattr(fitting, "least_squares", lambda *begun: least_squares(*begun[:4], Rule(2)))
    assert fits_anew(given, fit)


@pytest.mark.slow
def test_a_fit_begun_far_from_its_end_ends_there(given, fit, sd):
    """By a damping that rose and fell tenfold it had not come to rest after 60 evaluations."""
    begin = fit.unknowns.copy()
    begin[given[2].layout.place("start_theta_rate")] *= 0.1
    again = fit_from(given[0], begin, *given[1:], WHOLE)
    assert again.converged and np.abs((again.design - fit.design) / sd).max() < 0.1


def test_a_simulator_that_is_stiffer_than_it_is_told_takes_that_off(given, fit):
    bias, _ = corrected_by(given, fit, 1.02)
    shares = dict(zip(given[2].shared, bias / fit.design, strict=True))
    assert shares["biped.stiffness"] == pytest.approx(0.02, rel=0.1)
    assert abs(shares["biped.leg_length"]) < 1e-3


def test_noise_grows_with_the_root_of_a_sensors_bandwidth(planned):
    """A foot sensor of four times the bandwidth is twice as noisy: residuals are as large as they are said to be."""
    design, model, run = planned
    hip = run.sampling.bandwidth_hz["hip"]
    run = dataclasses.replace(run, sampling=dataclasses.replace(
        run.sampling, bandwidth_hz={"hip": hip, "foot": 4 * hip}))  # fmt: skip

    def equations(one):
        return run_equations(design, np.array([design.value(SLOPE)]), model.layout.middle, one, model)

    rng, shown = np.random.default_rng(2), equations(run).predicted.samples
    samples = {side: shown[side][:, :, 0] + times * np.array(model.noise) * rng.normal(size=shown[side].shape[:2])
               for side, times in (("hip", 1.0), ("foot", 2.0))}  # fmt: skip
    left = equations(dataclasses.replace(run, samples=samples)).residuals
    for side in SIDES:
        assert np.nanstd(left[side]) == pytest.approx(1.0, abs=0.05)


def test_a_run_of_the_model_is_explained_to_its_noise_and_predicted(given, drawn):
    """Fit within 1.2 times the sensors' noise; predicted, errors are larger, those of a walk that stays near."""
    _, run, model, _ = given
    tell = explained(drawn.design, run, model, 0.15)
    force, rate = model.noise[0], model.noise[2]
    assert tell.fit_force < 1.2 * force and tell.fit_rate < 1.2 * rate and tell.sigmas < 1.2
    assert force < tell.foretold_force < 1.0 and rate < tell.foretold_rate < 0.5
    for one in (tell.hip, tell.foot):
        counts = np.isfinite(one.residual)
        assert np.allclose((one.measured - one.fitted)[counts], one.residual[counts], rtol=1e-9, atol=1e-9)


def test_errors_count_what_counts_after_a_time(given):
    _, run, model, _ = given
    residuals = {side: np.where(getattr(run.sampling, side) <= 1.0, 100.0, 2.0)[:, None] * np.ones(3) for side in SIDES}
    assert rms_of(residuals, run, model, 1.0) == pytest.approx((2 * model.noise[0], 2 * model.noise[2]))
    assert rms_of(residuals, run, model)[0] > 10 * model.noise[0]
