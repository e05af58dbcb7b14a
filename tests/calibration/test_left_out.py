"""What a model leaves out is named by its score, where it explains what a fit leaves, and rarely where nothing is."""

import dataclasses
import json
import math
import re
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.special import ndtr

from stages.calibration import blind_score
from stages.calibration.estimation.campaign import Joint, fit_campaign, side_by_side
from stages.calibration.estimation.least_squares import TOTAL_MASS, Known
from stages.calibration.estimation.run_fit import Equations
from stages.calibration.information.identifiability import SLOPE, short
from stages.calibration.intervals import left_out
from stages.calibration.intervals.left_out import LEVEL, Cause, candidates, causes, in_words, limit, scores, widened
from stages.calibration.intervals.model_error import Judged
from stages.calibration.observation.measured_run import SIDES, MeasuredRun, usable
from stages.calibration.observation.prediction import predict
from stages.calibration.reports import parameters_left, sensor_report
from stages.calibration.result import HALF_WIDTH
from tests.calibration.runs import BIPED, DESIGN, PARAMETERS, SETTINGS, disturbed, drawn, fitted

KNOWN = (Known(TOTAL_MASS, BIPED.total_mass, 1e-3 * BIPED.total_mass),)
RADIUS, LENGTH = "biped.other_foot_radius", "biped.other_leg_length"


def made(changes, seed=1, bandwidth=0.0):
    """The fit of four steps of a robot that differs from the drawing, with its sensors' noise, from the truth on."""
    _, model = fitted()
    layout, unknowns, sampling = disturbed(seed, 4)
    unknowns[[layout.place("bandwidth"), layout.place("foot_place")]] = bandwidth, 0.0
    robot = DESIGN.with_values({name: DESIGN.value(name) * share for name, share in changes.items()})
    shown, rng = predict(robot, (), unknowns, layout, sampling, 1e-8), np.random.default_rng(seed)
    noise = np.asarray(model.noise)
    values = {side: one[:, :, 0] for side, one in shown.samples.items()}
    samples = {side: one + noise * rng.normal(size=one.shape) for side, one in values.items()}
    strikes = np.concatenate([[0.0], shown.strikes[:, 0]])
    used = {side: usable(sampling.of(side), strikes, 0.0, SETTINGS.before_strike_s, SETTINGS.after_strike_s)
            for side in SIDES}  # fmt: skip
    run = MeasuredRun("made", sampling, samples, used, strikes, {SLOPE: (2.0, 0.05)})
    start = np.array([DESIGN.value(name) for name in model.shared])
    fit = Joint(DESIGN, [run], model, KNOWN).from_point(start, np.array([[2.0]]), unknowns[None], {}, 0)
    assert fit.converged
    return model, fit


@pytest.fixture(autouse=True)
def few(request, monkeypatch):
    """Two of the parameters, as each costs a fit."""
    if not any(word in request.node.name for word in ("tried", "lost", "led_far")):
        monkeypatch.setattr(left_out, "candidates", lambda design, model: (RADIUS, "biped.other_stiffness"))


@pytest.fixture(scope="module")
def unlike():
    return made({RADIUS: 1.03})


@pytest.fixture(scope="module")
def narrow():
    """With a low pass that cuts off at half of what is declared."""
    return made({}, 2, bandwidth=math.log(0.5))


def test_a_foot_that_is_larger_than_the_other_is_named_with_its_radius(unlike):
    model, fit = unlike
    found = causes(DESIGN, fit, model, KNOWN)
    assert (found[0].name, found[0].explains) == (RADIUS, True)
    assert found[0].value == pytest.approx(1.03 * BIPED.foot_radius, abs=4 * found[0].sd)
    (words,) = in_words(found, DESIGN)
    assert "other_foot_radius" in words
    sd = np.sqrt(np.diag(fit.covariance))
    wide = widened(sd, found)
    truth = np.array([DESIGN.value(name) for name in model.shared])
    assert (np.abs(fit.design - truth) < 1.96 * wide).all()
    assert (np.abs(fit.design - truth) > 1.96 * sd).any()


def test_runs_that_are_fitted_anew_name_the_same(unlike, monkeypatch):
    """As those of a lost fit are: from the drawing and what the score says."""
    model, fit = unlike
    near = causes(DESIGN, fit, model, KNOWN)[0]
    monkeypatch.setattr(left_out, "GOOD", 0.5)
    assert fit.chi2 > left_out.GOOD * fit.count
    (anew,) = causes(DESIGN, fit, model, KNOWN)
    assert (anew.name, anew.value, anew.sigmas) == (
        near.name, pytest.approx(near.value, abs=0.1 * near.sd), pytest.approx(near.sigmas, rel=1e-2))


def test_runs_that_are_fitted_anew_start_no_process(monkeypatch):
    """Each process ran the whole script of a user again that asks this."""
    monkeypatch.setattr("stages.biped.processes.ProcessPoolExecutor", None)
    campaign, (design, model) = drawn(1001), fitted()
    (_, first), (_, other) = side_by_side(design, campaign.runs * 2, model, campaign.known)
    np.testing.assert_array_equal(first.design, other.design)


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "name", "change", "lost"), [
    (21, "biped.hip_friction", lambda drawing, _: drawing.with_value("biped.hip_friction", 0.003), True),
    (21, "biped.other_foot_mass", lambda drawing, _: drawing.with_value("biped.other_foot_mass", 0.345), True),
    (21006, RADIUS, lambda _, drawn: (robot := drawn()).with_value(RADIUS, 1.05 * robot.value(RADIUS)), False)])
def test_the_cause_is_found_of_a_fit_that_is_lost_or_led_far_off(seed, name, change, lost, monkeypatch):
    """A run of another robot than the drawing's, fitted from the drawing, tried with all that may be left out. Of a
    foot of 1.05 times the radius no fit finds back from where the one without it ended: it is made anew.
    """
    drawn = blind_score.drawn_robot
    monkeypatch.setattr(blind_score, "drawn_robot", lambda *of: change(of[0], lambda: drawn(*of)))
    campaign, (design, model) = blind_score.draw(seed, 1, PARAMETERS), blind_score.model_of(PARAMETERS)
    fit = fit_campaign(design, campaign.runs, model, campaign.known)
    assert (fit.chi2 > left_out.GOOD * fit.count) == lost
    (best,) = causes(design, fit, model, campaign.known)
    assert (best.name, best.explains) == (name, True)
    assert best.value == pytest.approx(campaign.design.value(name), abs=3 * best.sd)


def test_of_two_fits_of_a_parameter_the_better_names_it(unlike, monkeypatch):
    """Each is fitted from where the fit is and anew: one of other_damping; other_damping; frame_mass, said a lab's. The
    latter takes minutes of many runs, and nothing told so."""
    (model, fit), reported = unlike, []
    names = RADIUS, "biped.other_stiffness"
    monkeypatch.setattr(left_out, "scores", lambda *given: [Cause(name, 9.0) for name in names])
    monkeypatch.setattr(left_out, "_fitted", lambda score, *given: Cause(score.name, 9.0 + given[-1]))
    found = causes(DESIGN, fit, model, KNOWN, lambda share, what: reported.append((round(share, 9), what)))
    assert [(one.name, one.sigmas) for one in found] == [(name, 10.0) for name in names]
    assert reported == [(share, f"all runs once more, with {short(name)} looked for too")
                        for share, name in zip((0.9, 0.95), names, strict=True)]  # fmt: skip


def test_nothing_is_named_where_the_model_is_right():
    model, fit = made({}, 2)
    assert causes(DESIGN, fit, model, KNOWN) == []
    assert in_words([], DESIGN) == []
    assert widened(np.ones(3), []) == pytest.approx(np.ones(3))


def test_a_score_foretells_the_fit_with_the_parameter():
    """Its value, and what it takes off the sum of squares; without any other parameter beside it or with some."""
    model, fit = made({"biped.other_stiffness": 1.01})
    (score,) = scores(DESIGN, fit, model, KNOWN, ["biped.other_stiffness"])
    close = dataclasses.replace(model, tolerance=1e-10)  # a walk with more derivatives takes other steps
    alone, beside = (scores(DESIGN, fit, close, KNOWN, names) for names in (
        ["biped.other_stiffness"], ["biped.other_foot_mass", "biped.other_stiffness"]))
    beside = [one for one in beside if one.name == score.name]
    assert [one.sigmas for one in beside] == pytest.approx([one.sigmas for one in alone], rel=1e-6)
    best = causes(DESIGN, fit, model, KNOWN)[0]
    assert best.name == score.name
    assert best.value - fit.design[5] == pytest.approx(score.value, abs=3 * best.sd)
    assert score.sigmas == pytest.approx(best.sigmas, rel=0.02)


def test_all_scores_together_name_a_cause_in_so_many_of_right_campaigns():
    assert [count * 2 * ndtr(-limit(count)) for count in (1, 8, 12)] == pytest.approx([LEVEL] * 3)


def test_only_what_is_not_there_is_tried():
    _, model = fitted()
    assert RADIUS in candidates(DESIGN, model)
    assert "biped.hip_friction" in candidates(DESIGN, model)
    has = dataclasses.replace(model, own=(*model.own, "biped.other_leg_length"))
    assert "biped.other_leg_length" not in candidates(DESIGN, has)
    assert candidates(DESIGN.with_values({"biped.hip_friction": 1e-3}), model)[-1] == "biped.frame_mass"


def test_a_low_pass_that_is_not_the_declared_one_is_found_by_the_fit(narrow):
    model, fit = narrow
    assert causes(DESIGN, fit, model, KNOWN) == []
    assert fit.unknowns[0, model.layout.place("bandwidth")] == pytest.approx(math.log(0.5), abs=0.02)


def answered(model, fit, design=DESIGN, known=()):
    """The answer to a calibration by sensors that ended so, whose runs miss nothing that others' tell."""
    told = Judged(fit.design, np.sqrt(np.diag(fit.covariance)), "as it is")
    return sensor_report.answered(sensor_report.Calibrated(design, model, fit, told, PARAMETERS, known=known))


@pytest.mark.parametrize("converged", [True, False])
def test_a_fit_of_sensors_that_is_not_at_rest_has_no_intervals_and_ends_with_3(unlike, converged):
    model, fit = unlike
    answer = answered(model, dataclasses.replace(fit, converged=converged, why="lost"))
    assert answer.no is not converged
    assert bool(answer.tables) is bool(answer.parameters) is converged
    assert all((row["sd"] is not None) is converged for row in answer.plain["parameters"].values())
    assert ("not at rest" in answer.lines[0]) is not converged
    assert answer.lines[0].startswith("1 run fitted,") and not any(" apart" in line for line in answer.lines)


@pytest.mark.parametrize(("off", "said"), [(2.5, []), (14.0, ["14.0 standard errors"])])
def test_a_known_value_that_the_runs_contradict_is_named(unlike, off, said):
    """A caliper's leg length that left the rubber out came out 14 standard errors off, in silence."""
    model, fit = unlike
    length = float(fit.design[model.shared.index("biped.leg_length")])
    known = (Known("biped.leg_length", length - off * 1e-4, 1e-4), Known("total_mass", 1.0, 1e-9))
    lines = [line for line in answered(model, fit, known=known).lines if "these runs contradict that" in line]
    assert [re.search(r"by (.*) \(found", line)[1] for line in lines] == said
    assert all(line.startswith("leg_length is known as ") for line in lines)


@pytest.mark.parametrize(("off", "said"), [(0.1, 0), (0.5, 1)])
def test_a_ramp_that_was_read_off_wrongly_is_said_and_runs_that_do_not_go_together(unlike, off, said):
    """Half a degree, ten standard errors, was taken in silence."""
    model, fit = unlike
    run = dataclasses.replace(fit.runs[0], own={SLOPE: (float(fit.own[0, 0]) + off, 0.05)})
    alone = fit.chi2 / fit.count / (1.0 + 10.0 * off)
    lines = answered(model, dataclasses.replace(fit, runs=(run,), alone=alone)).lines
    assert sum(line.startswith("slope_deg is known as ") and "10.0 standard errors" in line for line in lines) == said
    assert sum("they are not of one robot" in line for line in lines) == said


def test_what_each_run_has_of_its_own_is_said_with_its_scatter(unlike):
    model, fit = unlike
    own = dataclasses.replace(model, own=(*model.own, "biped.other_leg_length"))
    twice = {"runs": 2 * fit.runs, "equations": 2 * fit.equations, "unknowns": np.vstack([fit.unknowns] * 2)}
    two = dataclasses.replace(fit, **twice, own=np.array([[2.0, 0.333], [2.1, 0.335]]))
    assert answered(own, two).lines[-2:] == [
        "ramp: 2.050 deg on average, 0.050 deg apart",
        "other_leg_length, for each run: 0.334 m on average, 0.001 m apart"]


@pytest.mark.parametrize(("drawn", "found", "left"), [(0.0, 1e-5, False), (0.0, 2e-3, True), (3e-4, 1e-5, True)])
def test_a_robot_is_left_with_the_other_legs_length_of_its_runs(unlike, drawn, found, left):
    """None where legs that were drawn alike are alike; never the drawing's, beside a leg whose length was found."""
    model, fit = unlike
    length = fit.design[model.shared.index("biped.leg_length")] + found
    own = dataclasses.replace(model, own=(*model.own, LENGTH))
    design = DESIGN.with_value(LENGTH, BIPED.leg_length + drawn)
    entry = answered(own, dataclasses.replace(fit, own=np.array([[2.0, length]])), design).parameters[LENGTH]
    assert entry["unit"] == "m" and entry["value"] == (pytest.approx(length) if left else None)
    assert ("uncertainty" in entry) is left


def test_a_robot_is_left_with_the_ramp_of_its_runs(unlike):
    """It was left with the study's, and the half degree of its last digit."""
    model, fit = unlike
    twice = {"runs": 2 * fit.runs, "equations": 2 * fit.equations, "unknowns": np.vstack([fit.unknowns] * 2)}
    left = answered(model, dataclasses.replace(fit, **twice, own=np.array([[2.0], [2.3]]))).parameters[SLOPE]
    half = pytest.approx(HALF_WIDTH * 0.3 / 2**0.5)
    assert left == {"value": pytest.approx(2.15), "uncertainty": half, "unit": "deg"}


def test_a_robot_is_left_with_how_its_errors_go_together(unlike):
    answer = answered(*unlike)
    names, left = unlike[1].names, answer.parameters
    assert [left[name]["unit"] for name in names] == [answer.plain["parameters"][name]["unit"] for name in names]
    half = np.array([left[name]["uncertainty"] for name in names])
    shares = np.eye(len(names))
    for row in left["biped.correlations"]["rows"]:
        one, other = names.index(row["one"]), names.index(row["other"])
        shares[one, other] = shares[other, one] = row["correlation"]
    covariance = np.array(json.loads(answer.files["robot.json"])["covariance"])
    assert shares * np.outer(half, half) == pytest.approx(HALF_WIDTH**2 * covariance, rel=1e-9)


def test_the_other_legs_length_goes_along_with_what_each_run_shows_with_it():
    """It is as long as the first leg in each run here, whose ramp shows nothing of either."""
    equations = Equations(np.array([[2.0, 0.0, -1.0], [0.0, 4.0, 0.0], [-1.0, 0.0, 1.0]]), np.zeros(3), 0.0, 0.0, 1,
                          {}, None)  # fmt: skip
    robot = SimpleNamespace(names=("biped.leg_length",), own=(SLOPE, LENGTH), own_sd=np.array([0.05, 3.0]),
                            covariance=np.array([[16.0]]))  # fmt: skip
    found = parameters_left.with_other_length(SimpleNamespace(equations=[equations] * 2), robot)
    assert found == pytest.approx(np.array([[16.0, 16.0], [16.0, 16.0 + 9.0]]))


def test_a_robot_is_left_with_the_mass_that_was_weighed(unlike):
    """Or a study of it fits its recordings anew without a scale: masses were off by a half."""
    assert not any("weighed" in name for name in answered(*unlike).parameters)
    left = answered(*unlike, known=KNOWN).parameters
    assert left["calibration.weighed_mass"] == BIPED.total_mass
    assert left["calibration.weighed_sd"] == pytest.approx(1e-3)


def test_a_robot_is_left_with_its_sole_in_its_legs_and_its_foot_sensor_in_its_place(unlike):
    """A study of it added a second sole, and sought the sensor at the mass centre that was found."""
    left = {name: one["value"] for name, one in answered(*unlike).parameters.items() if "value" in one}
    assert left["biped.leg_length"] - left["biped.foot_com"] != pytest.approx(left["imu.lever_arm"], rel=1e-6)
    assert left["imu.lever_arm"] == BIPED.leg_length - BIPED.foot_com
    assert left["twin.foot_socket"] == [0.0, -left["imu.lever_arm"], PARAMETERS.twin.inner_lane]
    assert left["campaign.outsole"] == 0.0


def test_a_change_from_nothing_has_no_share(unlike):
    answer = answered(*unlike, DESIGN.with_values({"biped.damping": 0.0}))
    changes = {row[0]: row[4] for row in answer.tables[0][2]}
    assert changes.pop("damping") == "from 0" and all(change.endswith(" %") for change in changes.values())


def test_what_the_runs_say_of_the_sensors_is_said(narrow):
    model, fit = narrow
    late = fit.runs[0].sampling.late | {"foot": 0.0}
    silent = dataclasses.replace(fit.runs[0], sampling=dataclasses.replace(fit.runs[0].sampling, late=late))
    wider = dataclasses.replace(
        silent, sampling=dataclasses.replace(fit.runs[0].sampling, bandwidth_hz={"hip": 40.0, "foot": 60.0}))
    as_said, moved = np.zeros_like(fit.unknowns), np.zeros_like(fit.unknowns)
    moved[0, model.layout.place("foot_place")] = 0.02
    for changed, parts in (({}, ("the sensors' low pass cuts off at 20.", "40.0 Hz is declared, or stiff legs")),
                           ({"runs": (silent,)}, ("bandwidth is not declared",)),
                           ({"runs": (wider,)}, ("at the hip and 30.", "40.0 Hz at the hip and 60.0 Hz")),
                           ({"unknowns": moved}, ("lever arm", "20.0 mm higher")),
                           ({"unknowns": -moved}, ("lever arm", "20.0 mm lower"))):  # fmt: skip
        (words,) = sensor_report._of_sensors(dataclasses.replace(fit, **changed), model)
        assert all(part in words for part in parts)
    assert sensor_report._of_sensors(dataclasses.replace(fit, unknowns=as_said), model) == []
    quick = dataclasses.replace(
        fit.runs[0], sampling=dataclasses.replace(fit.runs[0].sampling, bandwidth_hz=dict.fromkeys(SIDES, 160.0)))
    both = dataclasses.replace(fit, runs=(fit.runs[0], quick), unknowns=np.vstack([fit.unknowns, as_said]))
    (words,) = sensor_report._of_sensors(both, model)  # and not 100 Hz, which no sensor has
    assert "cuts off at 20." in words and "40.0 Hz is declared" in words


def test_causes_that_cannot_be_parted_are_one_of_a_few():
    two = [Cause(RADIUS, 5.0, 0.085, 1e-4, np.zeros(1), 25.0, True), Cause("biped.hip_friction", 4.8, 1e-3, 1e-4)]
    (words,) = in_words(two, DESIGN)
    assert "one of: other_foot_radius" in words and "hip_friction" in words
    assert PARAMETERS.settings.lever_arm_sd == pytest.approx(0.01 * BIPED.leg_length)
