"""Captions: every figure has one, its numbers are the results', and what is synthetic is called so."""

import dataclasses
import itertools
import math
import re
from types import SimpleNamespace

import matplotlib.pyplot as plt
import numpy as np
import pytest
import yaml

from stages.analytic.result import Uncertainty, Validity
from stages.biped import processes
from stages.biped.quantity import mm, written_out
from stages.biped.walk import Limp
from stages.calibrated_twin.result import Number, Result as CalibratedTwin
from stages.calibration.result import Result as Calibration
from stages.campaign.result import Result as Campaign, SetSpike
from stages.comparison.claims.judge import STATEMENTS
from stages.comparison.stride import NoEvidence
from stages.comparison.tables import as_yaml
from stages.error_budget.result import CREEP
from stages.figures import drawn, run
from stages.figures.drawn import NAMES, figure
from stages.figures.drawn.calibration import draw_robot
from stages.figures.entry import Inputs
from stages.figures.first_screen import Measure, answers, measure, stable, title
from stages.figures.result import Caption
from stages.figures.run import synthetic
from stages.ground.blocks import Blocks
from stages.model_error.result import EVEN, WIDTH, Stability
from stages.multibody.result import in_newtons
from stages.twin.result import Settling
from tests.comparison.made_up import DEFAULTS, make_agreement, make_budget, make_study, make_walk
from tests.figures.made_up_results import (
    analytic,
    calibrated_twin,
    calibration,
    comparison,
    drawn as made_up_figure,
    given,
    ladder,
    misses,
    parameters,
    pushes,
    results,
    rough_ground,
    stability,
)


def folded():
    """A family that turns back at 1 degree and has double stance but for its unstable gaits beyond 3 degrees."""
    family = stability().families[0]
    slope = np.array([4.0, 3.2, 2.0, 1.0, 1.6, 2.6, 3.6])
    double = np.where(np.arange(7) < 2, 0.0, 1e-3)[:, None]
    return SimpleNamespace(slope_deg=2.0, basin=None, families=(dataclasses.replace(
        family, value=slope, step_duration=0.5 + double, stance_angle=0.3 + double, double_stance=double,
        floquet_multipliers=family.floquet_multipliers[:7], turns=()),))  # fmt: skip


def text(name, **other):
    return figure(name).caption(given(name, **other))


@pytest.mark.parametrize("name", NAMES)
def test_every_figure_has_a_title_and_a_caption_from_the_results_that_it_names(name):
    assert figure(name).title and isinstance(figure(name).place, int) and text(name).endswith(".")
    assert set(figure(name).inputs) <= {field.name for field in dataclasses.fields(Inputs)}


@pytest.mark.parametrize(("name", "other", "words"), [
    ("gait_animation", {}, ["2.0718 Hz"]),
    ("gait_animation", {"analytic": analytic(frequency=1.9999)}, ["1.9999 Hz"]),
    ("gait_animation", {"multibody": SimpleNamespace(**{**vars(results()["multibody"]), "unsettled": "unstable"})},
     ["161.0 mm (unstable) with penalty"]),
    ("figure_02_ground_reaction", {}, ["768 N with 31 µm"]),
    ("figure_08_hip_motion", {}, ["0.19 mm in x and 0.04 mm in y", "the paper states 0.3 mm and 5 mm/s"]),
    ("figure_05_contact_parameters", {}, ["2.00 mm", "0.20 mm"]),
    ("bifurcation", {}, [
        "known from 1° to 4°; stable ones lie between 1° and 3.333°.",
        "At 3.3333° the cycle of 1 doubles (multiplier -1.000000). At 1.0000° the cycle of 1 turns back",
        "loses its double stance: the cycle of 2 at 3.4°."]),
    ("bifurcation", {"stability": folded()}, ["loses its double stance: the cycle of 1 at 2.6°."]),
    ("bifurcation", {"stability": SimpleNamespace(slope_deg=2.0, basin=None, families=(
        dataclasses.replace(stability().families[1], cycle=1),))},  # of legs that differ
     ["repeats after two steps, or", "The gait of two steps is known"]),
    ("basin", {}, ["from 42 starts", "14.3 % come within 0.001", "after 1 to 5 steps",
                   "others: walks on, elsewhere 14.3 %", "In 14.3 % the trailing leg"]),
    ("rough_ground", {}, ["of 0.5 mm, where the design makes 60 steps", "Within 25 % it makes more than 300;",
                          "bounds reached: speed, biped.hip_mass lower.", "with biped.foot_radius times 1.25: 57.6"]),
    ("rough_ground", {"rough_ground": dataclasses.replace(rough_ground(), norms=rough_ground().norms[:2])},
     ["72 s/m for the design, is least with it as it is."]),
    ("bifurcation", {"stability": SimpleNamespace(slope_deg=2.0, families=(), basin=None)},
     ["No gait could be followed."]),
    ("basin", {"stability": SimpleNamespace(slope_deg=2.0, families=(), basin=None)}, ["unstable"]),
])
def test_captions_state_the_numbers_of_the_results(name, other, words):
    said = text(name, **other)
    assert all(each in said for each in words), said
    if "stability" in other:
        plt.close(made_up_figure(name, **other))


def test_without_a_statement_that_applies_the_paper_is_not_named():
    assert "paper" not in text("figure_08_hip_motion", comparison=comparison(verdict="does not apply"))


def test_the_law_of_the_normal_force_is_that_of_ground_yaml():
    law = dataclasses.replace(DEFAULTS, normal_force="restitution", restitution=0.12, impact_speed=0.2)
    said = figure("figure_04_normal_force").caption(SimpleNamespace(parameters=SimpleNamespace(contact=law)))
    assert "a damping that returns 0.12 of an impact at 0.2 m/s" in said and "c_max" not in said
    assert "c_max = 10 N s/mm, complete at d = 0.1 mm" in text("figure_04_normal_force")


def test_walks_that_end_before_have_no_frequency():
    multibody, nothing = given("gait_animation").multibody, np.zeros(0)
    cycle = SimpleNamespace(**vars(multibody.cycle) | {"period_s": math.nan})
    fell = SimpleNamespace(walk=multibody.walk, cycle=cycle, unsettled="it fell")
    twin = SimpleNamespace(settling=Settling(nothing, nothing, -1))
    said = figure("gait_animation").caption(SimpleNamespace(analytic=analytic(), multibody=fell, twin=twin))
    assert "no whole step with penalty contact. The twin's last four steps: there are fewer." in said


def test_unstable_gaits_among_the_stable_ones_are_named():
    family = stability().families[0]
    weights = np.where(np.arange(len(family.value)) == 2, 1.5, 0.5)[:, None, None]
    mixed = dataclasses.replace(family, turns=(), floquet_multipliers=weights * np.ones((1, 5, 2)) / np.sqrt(2.0))
    said = text("bifurcation", stability=SimpleNamespace(slope_deg=2.0, families=(mixed,), basin=None))
    assert re.search(r"stable ones lie between \S+° and \S+°, unstable ones too\.", said)


def test_claims_that_figures_name_are_judged_and_one_figure_opens_the_report_and_one_the_parameters():
    named = {claim for name in NAMES for claim in figure(name).claims}
    assert named <= set(STATEMENTS) and len(named) > 10
    assert [name for name in NAMES if figure(name).opens] == ["robot_in_space"]
    assert [name for name in NAMES if figure(name).beside_parameters] == ["robot_symbols"]


@pytest.mark.parametrize(("origin", "said"), [("synthetic", True), ("mixed", True), ("measured", False)])
def test_what_is_synthetic_is_called_so(origin, said):
    assert ("cannot confirm" in synthetic(make_agreement(origin))) == said
    assert ("cannot confirm" in text("figure_16_measurement", comparison=comparison(origin))) == said


def test_without_a_fit_there_is_the_reason_and_no_picture():
    nothing = {"fits": (), "held_out": (), "followed": (), "failed": (SimpleNamespace(name="run 01", why="it fell"),)}
    empty = {"robots": (), "reasons": ("run 01: it fell",), "summary": lambda: "no run could be fitted"}
    for name in ("calibration_fit", "calibration_held_out", "calibration_followed", "calibrated_robot"):
        with pytest.raises(NoEvidence, match=r"^no run .*; run 01: it fell$"):
            made_up_figure(name, calibration=SimpleNamespace(**nothing), calibrated_twin=SimpleNamespace(**empty))


def test_a_number_below_zero_is_drawn_with_its_interval_and_with_what_is_larger_on_the_right():
    """A foot's mass 4 mm behind the leg's line that was found to be 3 mm behind it."""
    behind = Number("biped.foot_offset", "m", -4e-3, -3e-3, -3e-3, -3e-3, 2e-4, -3.5e-3)
    axes = plt.figure().add_subplot()
    draw_robot(axes, SimpleNamespace(numbers=(behind,), kind="lab"), "black", 0.0)
    found, corrected, true = (line.get_xdata() for line in axes.lines)
    plt.close("all")
    assert [found, corrected, true] == [pytest.approx(each) for each in ([25.0], [25.0], [12.5])]


@pytest.mark.parametrize("count", [7, 12])
def test_numbers_of_a_calibrated_robot_have_room_for_their_two_lines(count):
    made_up = calibrated_twin()
    [robot, *_] = made_up.robots
    made_up.robots = (dataclasses.replace(
        robot, numbers=tuple(robot.numbers[row % 3] for row in range(count)), correlations=np.eye(count)),)
    with drawn.style.drawing():
        shown = made_up_figure("calibrated_robot", calibrated_twin=made_up)
        shown.canvas.draw()
        rows = [label.get_window_extent() for label in shown.axes[0].get_yticklabels()]
    plt.close("all")
    assert len(rows) == count and all(one.y0 >= other.y1 for one, other in itertools.pairwise(rows))


@pytest.mark.parametrize(("until", "said"), [(1.4, ""), (0.4, " After 0.4 s it is lost; the run goes on to 1.5 s.")])
def test_a_run_that_is_lost_while_it_is_followed_is_called_so(until, said):
    whole = calibration().followed[0]
    some = whole.time <= until + 1e-9
    fields = ("time", "angle", "angle_sd", "next_strike", "next_strike_sd", "step_length")
    part = dataclasses.replace(whole, **{name: getattr(whole, name)[some] for name in fields})
    caption = text("calibration_followed", calibration=SimpleNamespace(followed=(part,)))
    assert caption.partition("by the heel strikes.")[2] == said


def test_a_fit_that_did_not_come_to_rest_is_called_so():
    made_up = calibration()
    moving = dataclasses.replace(made_up.fits[0], converged=False, why="60 evaluations were not enough")
    assert "come to rest" not in text("calibration_fit", calibration=made_up)
    made_up.fits = (moving,)
    assert "It did not come to rest: 60 evaluations were not enough." in text("calibration_fit", calibration=made_up)
    row = SimpleNamespace(value=1.0, sd=0.01)
    result = SimpleNamespace(told=(row,), not_seen=(), fits=(moving, calibration().fits[0]), runs=2)
    assert Calibration.summary(result).endswith("; 2 fitted, 1 of them not to rest")


def test_where_no_model_walked_there_is_the_reason_and_no_picture():
    nothing = SimpleNamespace(known=lambda: [], step=None, cycle=None, outcome="no gait")
    for name in ("error_budget", "error_budget_bars"):
        with pytest.raises(NoEvidence, match=r"^no gait$"):
            made_up_figure(name, error_budget=nothing)
    with pytest.raises(NoEvidence, match=r"has a gait$"):
        made_up_figure("price_and_error", model_error=SimpleNamespace(at_the_design=np.full((4, 6, 3), np.nan)))


@pytest.mark.parametrize(("name", "words"), [
    ("figure_02_ground_reaction", "walk ends before"), ("figure_07_snapshots", "fell after 1 steps"),
    ("figure_05_contact_parameters", "no set of contact"), ("figure_06_friction", "no set of contact"),
    ("contact_sets", "no set of contact"), ("figure_13_steps", "no whole step: it slipped"),
])
def test_a_robot_that_falls_at_once_leaves_no_figure_and_no_traceback(name, words):
    fallen = SimpleNamespace(walk=make_walk(steps=1), summary=lambda: "fell after 1 steps", reason="it slipped")
    files, said = run._draw(parameters(), results(multibody=fallen, twin=fallen, contact_study=nothing_walks()), name)
    assert not files and said.startswith("Not drawn: ") and words in said and "unexpected" not in said


def test_multipliers_are_drawn_without_a_ladder_and_other_figures_are_not():
    missing = results(twin_ladder=None, missing={"twin_ladder": "no ladder"})
    files, said = run._draw(parameters(), missing, "multipliers")
    assert files and "(constraint model)" in said and "twin" not in said
    assert run._draw(parameters(), missing, "twin_ladder")[1] == "Not drawn: no ladder."


def nothing_walks():
    study = make_study()
    nan = {"hip_position": np.full(2, math.nan), "outcome": "fell"}
    variations = dataclasses.replace(study.variations, hip_position=math.nan * study.variations.hip_position)
    return dataclasses.replace(study, default=dataclasses.replace(study.default, **nan), variations=variations,
                               chosen=dataclasses.replace(study.chosen, **nan))  # fmt: skip


def test_a_number_that_is_not_known_is_a_question_mark_in_captions():
    cycle = SimpleNamespace(**vars(results()["multibody"].cycle) | {"step_frequency_hz": math.nan})
    unknown = SimpleNamespace(walk=make_walk(), cycle=cycle, unsettled="")
    assert "? Hz and" in drawn.draw("gait_animation", parameters(), results(multibody=unknown))[1]


@pytest.mark.parametrize(("length", "said"), [(0.046, False), (0.044, True)])
def test_a_block_shorter_than_a_foot_rolls_is_said_to_be(length, said):
    """Steps of 160 mm of which the feet are 115 mm apart: what is left a foot rolls."""
    asked = given("figure_12_ramp")
    asked.parameters.blocks = Blocks(block_length=length)
    assert ("rolls over 45 mm, farther than a block" in figure("figure_12_ramp").caption(asked)) == said


def test_a_small_robot_has_its_peak_force_in_digits():
    assert [in_newtons(force) for force in (2.3456, 99.94, 768.2, 11138.0)] == ["2.35 N", "99.9 N", "768 N", "11138 N"]
    assert [written_out(steps) for steps in (71.432, 1002.0, 54321.0)] == ["71.4", "1000", "54300"]
    assert [mm(length) for length in (0.0, 3.9e-8, -2.53e-6, 3.456e-5, 2.5e-4)] == [
        "0.00 mm", "3.9e-05 mm", "-0.0025 mm", "0.035 mm", "0.25 mm"]


def test_a_push_that_topples_at_its_smallest_is_not_said_to_be_survived_at_nought():
    said = given("twin_pushes").twin_pushes.summary()
    assert "side 0.1 m/s survived, 0.2 not" in said and "spin 1 m/s not survived" in said
    most = max(walk.steps for walk in given("twin_pushes").twin_pushes.walks if walk.survived)
    assert f"pushes, walked off for {most} steps: " in said, "a twin that falls by itself may fall after these"


def test_a_run_that_cannot_be_foretold_is_shown_as_it_is_fitted():
    usual = given("calibration_held_out").calibration
    falls = dataclasses.replace(usual.held_out[0], name="run 03", foretold_force=math.nan)
    for runs, words in (((falls,), "run 03, with outsole, was not fitted: .* fitted to all of it, .* off by 0.020 m"),
                        ((falls, *usual.held_out), "run 02, with outsole, was not fitted: .* those of its first")):
        shown = SimpleNamespace(**vars(usual) | {"held_out": runs})
        assert re.match(words, text("calibration_held_out", calibration=shown))


@pytest.mark.parametrize("unforeseen", [False, True])
def test_a_figure_that_fails_leaves_its_reason_and_the_account_of_what_was_not_foreseen(monkeypatch, unforeseen):
    def draw(*_):
        raise ZeroDivisionError("by\nnought") if unforeseen else NoEvidence("it fell")

    monkeypatch.setattr(run, "draw", draw)
    files, words = run._draw(parameters(), results(), "extremes")
    if unforeseen:
        assert words.startswith("Not drawn: unexpected ZeroDivisionError in test_captions.py:")
        assert words.endswith(": by nought.") and b"Traceback" in files["figures/extremes.log"]
    else:
        assert (files, words) == ({}, "Not drawn: it fell.")
    assert run._caption("rough_ground", words).claims == () != run._caption("rough_ground", "Drawn.").claims


def test_captions_survive_yaml():
    one = Caption("a", 'quotes " and: colons', "µ ≤ 3 # no comment", ("b",), True, False, ("twin",))
    first = {"title": "a title: one", "synthetic": "line\nbreak", "answers": [{"answer": "ä # no comment"}]}
    read = yaml.safe_load(as_yaml("a test", {**first, "figures": [vars(one)]}))
    assert read == {
        **first,
        "figures": [
            {"name": "a", "title": 'quotes " and: colons', "text": "µ ≤ 3 # no comment", "claims": ["b"], "opens": True,
             "beside_parameters": False, "shows": ["twin"]}
        ],
    }


def test_unequal_legs_are_both_in_the_caption_of_the_simple_model():
    biped = dataclasses.replace(parameters().biped, other_foot_mass=0.31, other_foot_radius=0.09)
    said = figure("figure_03_simple_model").caption(SimpleNamespace(parameters=SimpleNamespace(biped=biped)))
    assert "0.3 and 0.31 kg below them and feet of 83 and 90 mm" in said


def test_the_stage_draws_all_in_their_places_with_captions_beside(monkeypatch):
    monkeypatch.setattr(run, "NAMES", ("extremes", "figure_04_normal_force", "gait_animation"))
    monkeypatch.setattr(processes.os, "cpu_count", lambda: 1)
    monkeypatch.setattr(run, "answers", lambda inputs: ())
    monkeypatch.setattr(run, "title", lambda parameters: {"title": "a title"})
    said = []
    made = run.run(parameters(), SimpleNamespace(**results()), lambda share, what: said.append(share))
    assert [caption.name for caption in made.captions] == ["gait_animation", "figure_04_normal_force", "extremes"]
    assert yaml.safe_load(made.files["captions.yaml"])["figures"] == [
        vars(caption) | {"claims": list(caption.claims), "shows": list(caption.shows)} for caption in made.captions
    ]
    assert set(made.files) == {
        "captions.yaml", "figures/gait_animation.html",
        *(f"figures/{name}.{kind}" for name in ("figure_04_normal_force", "extremes")
          for kind in ("png", "pdf", "csv")),
    }  # fmt: skip
    assert said[-1] == 1.0


@pytest.mark.parametrize("level", ["draft", "paper"])
@pytest.mark.parametrize("name", ["extremes", "gait_animation"])
def test_a_figure_of_another_accuracy_than_the_usual_says_so(name, level, monkeypatch):
    pictures = []
    monkeypatch.setattr(drawn.style, "pictures", lambda name, figure, *_, **__: pictures.append(figure) or {})
    files, _ = drawn.draw(name, parameters(level), results())
    said = " ".join([content.decode() for content in files.values()]
                    + [text.get_text() for picture in pictures for text in picture.texts])  # fmt: skip
    assert ("accuracy: draft" in said, "accuracy:" in said) == (level == "draft", level == "draft")


def test_that_mark_stands_on_no_label():
    with drawn.style.drawing():
        picture, axes = plt.subplots(figsize=(3.0, 1.5))
        axes.set_xlabel("as wide as the axes are, and some more of it")
        drawn.at_level(picture, "draft")
        with drawn.style.laid_out(picture, 80):
            marks = [text.get_window_extent() for text in (*picture.texts, axes.xaxis.label)]
    assert not marks[0].overlaps(marks[1])


# --- What a report says first: answers with errors from the results, a title that names the biped.


GOOD = Validity(5.0, 1.0, 0.2, 0.4, 1.1, 0.0, 0.0, 0.3, 0.5, 0.01, 2e-3, 0.0, True)


def gaits(multiplier=0.6, validity=GOOD):
    gait = SimpleNamespace(period_s=0.5, step_frequency_hz=2.0, step_length_m=0.16, speed_m_s=0.32,
                           stable=multiplier < 1.0, largest_multiplier=multiplier, steps=1)
    digits = tuple(Uncertainty(name, unit, value, 0.03, width, "biped.hip_mass", 0.01, value, value)
                   for name, unit, value, width in (("step_frequency_hz", "Hz", 2.0, 0.02),
                                                    ("speed_m_s", "m/s", 0.32, 0.003)))  # fmt: skip
    return SimpleNamespace(gait=gait, validity=validity, uncertainties=digits)


def inputs(**other):
    return SimpleNamespace(missing={}, **{**results(), "analytic": gaits(), **other})


def test_a_number_is_corrected_by_the_bias_and_has_three_errors():
    found = measure(gaits(), misses(), "step_frequency")
    assert found.value == pytest.approx(2.0 * 0.99) and found.model == pytest.approx(2.0 * 0.04)
    assert found.inputs == pytest.approx(EVEN * WIDTH * 0.02) and found.solver == pytest.approx(2e-8)
    assert found.error == pytest.approx(2e-8 + np.hypot(0.08, EVEN * WIDTH * 0.02))
    assert found.text() == "1.98 ± 0.09"
    assert found.parts() == "solver < 0.001 %, model 4 %, inputs 1 %"
    exact = dataclasses.replace(found, inputs=0.0)
    assert exact.parts() == "solver < 0.001 %, model 4 %, inputs taken as exact"


def test_the_digits_of_the_slope_are_inputs_too():
    found = gaits()
    digits = dataclasses.replace(found.uncertainties[0], slope_least=1.9, slope_most=2.1)
    found.uncertainties = (digits,)
    assert measure(found, misses(), "step_frequency").inputs == pytest.approx(EVEN * WIDTH * np.hypot(0.02, 0.1))


def test_near_its_highest_a_frequency_is_off_to_one_side_and_where_the_gait_is_lost_it_is_not_known():
    """Half of the range left 1.6 % open of a frequency 2.9 % lower at an edge; a gait lost on some slopes, nothing."""
    found = gaits()
    digits = found.uncertainties[0]
    found.uncertainties = (dataclasses.replace(digits, slope_least=1.9),)
    assert measure(found, misses(), "step_frequency").inputs == pytest.approx(EVEN * WIDTH * np.hypot(0.02, 0.1))
    found.uncertainties = (dataclasses.replace(digits, slope_least=np.nan, slope_most=np.nan),)
    lost = measure(found, misses(), "step_frequency")
    assert "inputs not known" in lost.parts() and not lost.known


def test_a_multipliers_digits_are_those_of_one_step():
    """Of legs that differ it is known over two steps: the root of .36 moves by half of what that does, over .6."""
    found = gaits()
    found.gait.steps = 2
    found.uncertainties = (Uncertainty("multiplier_1", "1", 0.36, 0.03, 0.012, "biped.hip_mass", 0.01, 0.25, 0.49),)
    of_a_step = np.hypot(0.5 * 0.012 / 0.6, 0.5 * (0.7 - 0.5))
    assert measure(found, misses(), "multiplier").inputs == pytest.approx(EVEN * WIDTH * of_a_step)


def test_of_a_limping_gait_both_steps_are_told_beside_their_means():
    found = gaits()
    assert "limps" not in answers(inputs(analytic=found))[1].means
    found.gait.steps = 2
    found.limp = Limp(np.array([0.48, 0.52]), np.array([0.158, 0.162]), np.array([0.12, 0.121]), 0.08)
    told = answers(inputs(analytic=found))[1].means
    assert told.endswith("These are means: it limps, and its step on the first leg takes 0.4848 s and 156.4 mm, "
                         "the other 0.5253 s and 160.4 mm.")  # fmt: skip
    mean = 0.5 * (0.4848 + 0.5253), 0.5 * (156.4 + 160.4)
    shown = measure(found, misses(), "step_frequency").value, measure(found, misses(), "step_length").value
    assert mean == pytest.approx((1.0 / shown[0], 1e3 * shown[1]), rel=1e-3), "what the twin has is in both steps too"


def test_what_was_learnt_of_stable_gaits_corrects_no_other():
    found = measure(gaits(1.2), misses(), "multiplier")
    assert found.value == 1.2 and np.isnan(found.model) and "model not known" in found.parts(share=False)
    assert found.solver == measure(gaits(1.2 - 1.0), misses(), "multiplier").solver, "a solver's error is of any gait"


def test_the_first_screen_answers_three_questions_and_a_fourth_of_own_recordings():
    walks, fast, steady = answers(inputs())
    assert walks.answer == "Yes, on conditions." and "2 mm below ground" in walks.means and "8 steps" in walks.errors
    assert fast.answer.startswith("0.317 ± 0.014 m/s: 1.98 ± 0.09 steps a second") and "fewer than 1.9 " in fast.means
    assert steady.answer.startswith("A step leaves 0.59 ± 0.05") and "above 0.999" in steady.answer
    assert "after 5 steps; of the starts tried, 14 %" in steady.means
    report = SimpleNamespace(step_frequency=2.0, step_frequency_error=0.01, step_length=0.16, step_length_error=1e-3,
                             not_trusted=(), evidence=SimpleNamespace(alternating=1.0, spacing=0.1))
    own = SimpleNamespace(origin="measured", runs=(SimpleNamespace(report=report),))
    said = answers(inputs(imu=own))[3]
    assert said.answer == "2.00 ± 0.02 steps a second (model: 1.98 ± 0.09); 160 ± 2 mm a step (model: 158 ± 7)."
    assert "1 % faster than the model, within their errors" in said.means
    faster = SimpleNamespace(origin="measured", runs=(SimpleNamespace(
        report=SimpleNamespace(**{**vars(report), "step_frequency": 2.5, "step_length": float("nan")})),))
    said = answers(inputs(imu=faster))[3]
    assert "26 % faster than the model, more than their errors" in said.means and "mm" not in said.answer
    _, fast, steady, said = answers(inputs(imu=faster, model_error=None))
    assert "The twin's last four steps: 2.0400 ± 0.0005 Hz and 159 mm (what" in fast.means and "than" not in fast.means
    assert steady.answer.endswith(": stable, with a probability above 0.999 by the errors that are known.")
    assert said.means.endswith("more than the errors that are known; others are not.")


def test_a_run_in_which_a_leg_lands_twice_is_not_held_against_the_model():
    """A leg that lands twice is two steps: the first screen advised a calibration, by 30 %."""
    report = SimpleNamespace(
        step_frequency=3.7, step_frequency_error=0.1, step_length=0.1, step_length_error=0.01, name="run 1",
        not_trusted=("heel strikes", "step frequency"), remarks=("a leg lands twice",),
        evidence=SimpleNamespace(alternating=1.0, spacing=0.97))  # fmt: skip
    twice = SimpleNamespace(report=report)
    said = answers(inputs(imu=SimpleNamespace(origin="measured", runs=(twice,))))[3]
    assert (said.answer, said.means) == ("No step frequency that can be trusted.", "run 1: a leg lands twice.")
    good = SimpleNamespace(report=SimpleNamespace(**{**vars(report), "step_frequency": 2.0, "not_trusted": (),
                                                 "evidence": SimpleNamespace(alternating=1.0, spacing=0.1)}))
    said = answers(inputs(imu=SimpleNamespace(origin="measured", runs=(twice, good))))[3]
    assert said.answer.startswith("2.0 ± 0.2 steps a second") and said.errors.endswith("from the scatter of 1 run.")
    own = SimpleNamespace(report=SimpleNamespace(**{
        **vars(good.report), "not_trusted": ("clock", "step frequency"), "remarks": ("a clock of its own",)}))
    said = answers(inputs(imu=SimpleNamespace(origin="measured", runs=(own,))))[3]
    assert said.errors.endswith("A remark speaks against them: run 1: a clock of its own.")


def test_where_known_errors_leave_stability_open_no_sentence_says_it_is_stable():
    """It said: stable, as far as its errors are known. Its errors leave open whether it is stable."""
    said = stable(inputs(), Measure(0.99, 0.0, np.nan, 0.02))
    assert said.answer.endswith("stable, with a probability of 0.84 by the errors that are known.")
    assert said.means.startswith("Its errors leave open whether it is stable")
    assert "with a probability of 0.997" in stable(inputs(), Measure(0.5, 0.0, 0.36, 0.0)).answer, "it was: of 1"


@pytest.mark.parametrize(("twins", "limps", "error", "words"), [
    (1.09, False, 0.0, " The twin's gait is unstable: it leaves 1.09 in the plane."), (0.5, False, 0.0, ""),
    (np.nan, False, 0.1, ""), (0.5, False, 0.1, " The twin's gait is stable: it leaves 0.5 in the plane."),
    (0.5, True, 0.0, " The twin's gait, which limps, is stable: it leaves 0.5 in the plane.")])
def test_the_first_screen_says_where_the_twins_stability_is_another_or_decides(twins, limps, error, words):
    ladder = SimpleNamespace(twin=SimpleNamespace(limps=limps), largest_multipliers=(twins, 0.1))
    said = stable(inputs(twin_ladder=ladder), Measure(0.97, 0.0, error, 0.0)).means
    assert said.endswith(f"end in this gait.{words}")


def test_stability_is_that_of_the_model_that_decides_it():
    """It followed the constraint model over the slope's digit: .7 +- .4 where the twin's machine has .783 +- .03."""
    decided = dataclasses.replace(misses(), stability=Stability(0.93, 0.97, 1e-4, 3e-3, 0.04, "penalty walker"))
    found = gaits(1.3)
    said = stable(inputs(analytic=found, model_error=decided), measure(found, misses(), "multiplier"))
    assert said.answer.startswith("A step leaves 0.97 ± 0.05 of a small disturbance: ")
    assert "stable, with a probability of 0.93." in said.answer
    assert said.errors == "Errors of this multiplier, by the penalty walker: solver 0.0001, model 0.003, inputs 0.04."
    assert said.means.endswith(" The constraint model's gait leaves 1.3.")


@pytest.mark.parametrize(("likely", "value", "left", "answer"), [
    (0.9999, 0.98, 0.11, "0.98 of a small disturbance, or up to 0.11 less: stable, with a probability above 0.999."),
    (0.0001, 1.03, 0.11, "1.03 of a small disturbance, or up to 0.11 more: unstable, with a probability above 0.999."),
    (0.9999, 0.82, 0.11, "0.82 ± 0.11 of a small disturbance: stable, with a probability above 0.999."),
    (0.84, 0.98, 0.11, "0.98 ± 0.11 of a small disturbance: stable, with a probability of 0.84."),
    (0.72, 0.56, np.inf, "0.56 of a small disturbance: stable, with a probability of 0.72 by the errors that are "
                         "known.")])
def test_errors_that_reach_beyond_one_although_it_is_stable_are_told_by_their_side(likely, value, left, answer):
    """It said: leaves 0.98 ± 0.11, stable with a probability above 0.999, as beyond a doubling it limps."""
    decided = dataclasses.replace(misses(), stability=Stability(likely, value, 0.0, 0.0, left, "penalty walker"))
    said = stable(inputs(model_error=decided), Measure(0.5, 0.0, 0.0, 0.0))
    assert said.answer == f"A step leaves {answer}"


@pytest.mark.parametrize(("outcome", "survived", "words"), [
    ("completed", (False, False), " That is in the plane: in space the twin falls after every push to the side that "
                                  "was tried."),
    ("fell", (True, True), " That is in the plane: in space the twin falls after 8 steps."),
    ("completed", (False, True), ""), ("completed", (), "")])
def test_a_gait_that_is_stable_in_the_plane_alone_is_not_called_stable_without_that(outcome, survived, words):
    given = inputs(twin=SimpleNamespace(outcome=outcome, steps=8),
                   twin_pushes=SimpleNamespace(walks=[SimpleNamespace(survived=one) for one in survived]))  # fmt: skip
    assert stable(given, Measure(0.5, 0.0, 0.0, 0.0)).answer.endswith(f"stable, with a probability above 0.999.{words}")
    assert stable(given, Measure(1.5, 0.0, 0.0, 0.0)).answer.endswith(" unstable, with a probability above 0.999.")


@pytest.mark.parametrize(("slope", "cycle"), [(2.0, 0), (3.6, 2), (5.0, 0)])
def test_it_says_where_a_cycle_beside_an_unstable_gait_is_stable(slope, cycle):
    beside = dataclasses.replace(stability(), slope_deg=slope)
    walks = answers(inputs(analytic=gaits(1.3), stability=beside))[0]
    assert beside.cycle == cycle and (walks.answer == "Not so on a plain ramp.") == bool(cycle)
    assert ("there is a stable cycle of 2 steps" in walks.means) == bool(cycle)


@pytest.mark.parametrize(("found", "answer", "means"), [
    (gaits(validity=dataclasses.replace(GOOD, deepest_scuff=0.0)), "Yes, on a plain ramp.", "neither"),
    (gaits(1.3), "Not on a plain ramp.", "a step enlarges what disturbs it"),
])
def test_it_says_whether_the_biped_walks(found, answer, means):
    walks, _, steady = answers(inputs(analytic=found))
    assert walks.answer == answer and means in walks.means
    assert ("unstable" in steady.answer) == (not found.gait.stable)


def test_without_a_gait_the_reason_is_the_answer():
    one, = answers(SimpleNamespace(analytic=None, missing={"analytic": "there is no analytic: it falls"}))
    assert one.answer == "No gait is known." and one.means == "It falls."
    assert title(None)["about"] == "Not compared with the paper's biped."


def test_the_title_names_the_papers_biped_or_the_study():
    papers = title(SimpleNamespace(another=()))
    assert "Vasileiou" in papers["title"] and "Mechanism and Machine Theory, 2021" in papers["about"]
    assert papers["claims_first"]
    own = title(SimpleNamespace(another=("one", "two", "three")))
    assert own["title"].startswith("{study}") and own["about"] == "Not the paper's biped: one; two; and 1 more."
    assert not own["claims_first"]


def test_an_error_that_is_round_off_is_not_shown():
    assert Measure(2.0, 1e-12, 0.0, 0.0).text() == "2"


# --- Tables of results stand on the page beside the figures.


def of_a_calibrated_twin():
    made = calibrated_twin()
    return CalibratedTwin(made.robots, made.pairs, made.checks, (), None)


def of_a_calibration():
    misses = SimpleNamespace(shares=np.array([[0.01, -0.02], [0.03, -0.02]]))
    made = SimpleNamespace(runs=1, fits=(), held_out=(), told=(), names=("hip", "foot"), misses=misses)
    return SimpleNamespace(tables=lambda: Calibration.tables(made))


def of_a_campaign():
    sensor = SimpleNamespace(peak=200.0, peak_filtered=60.0, peak_sampled=40.0)
    made = SimpleNamespace(runs=(SimpleNamespace(hip=sensor, foot=sensor),),
                           spikes=(SetSpike(0.5, 2e5, 40.0, 160.0, 1.5e-3),))  # fmt: skip
    return SimpleNamespace(tables=lambda: Campaign.tables(made))


@pytest.mark.parametrize(("result", "title", "row", "cells"), [
    (make_study, "One parameter at a time", "starting set", ("", 2.0, 10.0, 0.1, 40.0, 600, "completed")),
    (make_study, "Distance from the rigid limit", "limit - rolling feet",
     ("", "", "", "", 0.25, 0.005, 2.5, 0.05, -0.8, 0.2, "", "")),
    (make_study, "The 2 best", 2e5, (2e4, 2e-4, 0.2, 1.0, 5.0, 2.0, 1.0, 0.1, 10.0, 5.0, 1.0, 700, 10.0)),
    (make_budget, "Penalty minus constraint model, one step", CREEP,
     (0.14, 0.24, 0.632, 0.74, -0.24, "-0.264 to -0.216")),
    (make_budget, "Penalty minus constraint model, cycles", CREEP,
     (0.14, 0.24, 0.632, 0.74, -0.24, "-0.264 to -0.216", -0.024, "-0.0264 to -0.0216")),
    (make_budget, "What is explained", "one step: share 0.1 not predicted, %, both off", (3.53, 35.3, 0.785, 4.89)),
    (ladder, "From the simple model", "third = the twin", (
        "0.47000", "-20.00", "165.00", "+4.00", "-0.700, +0.500+0.100i", "-0.70000", "0.0e+00", "800", "20")),
    (pushes, "Pushes", "side", ("0.1 m/s", "4", "completed", "57.28", "5.7e+00", "+11.459", "+2000.0")),
    (of_a_calibrated_twin, "What the outsole does", "run 01", (
        "2.10", "0.20", "2.00", "9.0", "-0.80", "0.10", "-0.85")),
    (of_a_calibrated_twin, "Runs held out", "run 02", ("corrected by the twin", "2.0", "0.100", "0.0200")),
    (of_a_calibration, "Errors of such fits", "hip", ("+2.00", "1.41")),
    (of_a_campaign, "Spike at heel strike", "foot", ("200.0", "60.0", "40.0")),
    (of_a_campaign, "The twin's spike", "0.5", ("2e+05", "40", "160", "1.50")),
])
def test_cells_of_tables_are_in_the_units_of_their_columns(result, title, row, cells):
    """Of results of round sizes, worked out by hand: mm of m, degrees of rad, per cent of shares."""
    columns, rows = next((columns, rows) for named, columns, rows in result().tables() if named.startswith(title))
    found = next(tuple(each) for each in rows if each[0] == row)
    assert len(found) == len(columns) and found[1:] == cells
