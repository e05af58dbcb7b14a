"""`ask` and `map --within`: the cheapest rung that has the error, its parts, and requests that are refused."""

import copy
import dataclasses
import json
import math
from contextlib import nullcontext
from types import SimpleNamespace

import h5py
import numpy as np
import pytest

from pipeline.cache import artefact
from pipeline.errors import StudyError
from stages.analytic.gait.continuation import continue_gait
from stages.analytic.gait.gait_search import describe, find_gait
from stages.analytic.parameters import Correlation
from stages.biped.question import WrongOption
from stages.model_error.choice import MULTIPLIER, Ladder, below_one
from stages.model_error.measures import NAMES, Allowed, errors
from stages.model_error.miss import Learnt, Miss, covering
from stages.model_error.questions import map
from stages.model_error.questions.ask import Options, ask, stability_in_words
from stages.model_error.result import MODELS, PENALTY, TWIN, WIDTH, Result, Stability
from stages.model_error.run import further, further_draws, walked
from stages.model_error.rungs import RUNGS, Found, NoRung, TooLoose, design_of
from tests.asking import Asking


@pytest.fixture(scope="module")
def ladder(parameters, small):
    return Ladder(parameters, Learnt(small))


@pytest.fixture(scope="module")
def true(parameters):
    """What the twin says."""
    return RUNGS[TWIN].find(design_of(parameters), 1e-8)


@pytest.mark.parametrize("name", NAMES)
def test_what_is_asked_is_kept_against_the_twin_and_climbs_with_the_error(ladder, true, name):
    place, before = NAMES.index(name), 0
    for error in (0.2, 0.02, 5e-3):
        found = ladder.within(name, error, share=True)
        size = 1.0 if name == "multiplier" else true.values[place]
        assert found.met and found.solver + found.model <= error
        assert abs(found.value - true.values[place]) <= error * size + true.errors[place]
        assert MODELS.index(found.rung) >= before
        before = MODELS.index(found.rung)
        floors = [ladder.learnt.at(rung, place, ladder.numbers).error for rung in range(before)]
        assert all(floor + 1e-6 > error for floor in floors)  # no cheaper one would have done
        assert len(found.passed_over) >= before


@pytest.mark.parametrize("rung", range(PENALTY))
@pytest.mark.parametrize(("outside", "errors", "over", "refused"), [
    pytest.param([], 0.0, 1e-9, "not stable", id="inside, not below one"),
    pytest.param([], 0.0, -1e-9, "", id="inside, below one"),
    pytest.param(["slope"], 1.0, 1e-9, "may not be there", id="outside, not below one with its error"),
    pytest.param(["slope"], 1.0, -1e-9, "", id="outside, below one with its error"),
    pytest.param([], 1.0, 1e-9, "", id="inside, not below one with its error"),
])
def test_a_gait_has_a_known_error_whose_multiplier_with_its_known_bias_is_below_one(
    monkeypatch, ladder, rung, outside, errors, over, refused
):
    """Of 30 robots outside of the sampled designs that fall, the constraint model answered for 10 within 5 %."""
    miss = ladder.miss(rung, MULTIPLIER)
    values = np.where(np.arange(len(NAMES)) == MULTIPLIER, 1.0 - miss.bias - errors * miss.error + over, 0.5)
    monkeypatch.setattr(ladder, "find", lambda *_: Found(values, 0.0 * values))
    monkeypatch.setattr(ladder, "outside", lambda: outside)
    with pytest.raises(NoRung, match=refused) if refused else nullcontext():
        ladder.corrected(rung, NAMES.index("period"), 1e-6)
    assert abs(miss.bias) > 1e-6, "else the sign of the bias shows nothing"


def test_an_error_in_the_measures_unit_is_that_share_of_it(ladder):
    share = ladder.within("period", 0.01, share=True)
    number = ladder.within("period", 0.01 * share.value, share=False)
    assert (number.rung, number.value) == (share.rung, share.value)
    assert number.requested == pytest.approx(0.01)


def test_an_error_that_model_and_solver_have_only_together_is_passed_over(ladder):
    _, solver, model = ladder.corrected(PENALTY, NAMES.index("period"), 1e-6)
    error = max(solver, model) + 0.2 * min(solver, model)
    found = ladder.within("period", error, share=True)
    assert found.met and found.solver + found.model <= error < solver + model
    assert f"has an error of up to {100 * (solver + model):.2g} % at tolerance 1e-06" in "; ".join(found.passed_over)


def test_what_no_rung_has_is_refused_with_every_rungs_reason(parameters, small):
    answer = ask(parameters, Options(("multiplier", "stable"), ("1e-5",)), Asking(model_error=small))
    assert answer.no and answer.plain["multiplier"]["value"] is None and "NaN" not in json.dumps(answer.plain)
    text = "\n".join(answer.lines)
    assert all(name in text for name in MODELS)


def test_digits_leave_what_the_printed_values_leave(parameters, small):
    exact = dataclasses.replace(parameters, design_digits=type(parameters.design_digits)(),
                                slope_digits=type(parameters.slope_digits)())  # fmt: skip
    assert Ladder(exact, Learnt(small)).inputs("period", 0) == 0.0
    half = dataclasses.replace(exact, design_digits=type(parameters.design_digits)({"leg_length": 1e-4}))
    found = Ladder(half, Learnt(small)).inputs("period", 0)
    other = dataclasses.replace(half.biped, leg_length=half.biped.leg_length + 1e-5)
    pair = half, dataclasses.replace(half, biped=other)
    one, longer = (RUNGS[0].find(design_of(each), 1e-8).values[0] for each in pair)
    even = 1e-4 / math.sqrt(3.0) * 1.96
    assert found == pytest.approx(even * (longer / one - 1.0) / 1e-5, rel=0.02)


def test_what_the_ramp_leaves_open_is_what_gaits_on_other_slopes_have(parameters, small):
    """At 1.7 +- .5 degrees steps are most frequent: a derivative said .44 %, and at 1.2 they are 2.9 % less so."""
    there = dataclasses.replace(
        parameters, slope=dataclasses.replace(parameters.slope, slope_deg=1.7),
        design_digits=type(parameters.design_digits)(),
        slope_digits=type(parameters.slope_digits)({"slope_deg": 0.5}))  # fmt: skip
    names = ("step_frequency", "step_length", "peak_force")
    answer = ask(there, Options(names, ("20%",)), Asking(model_error=small))
    found = {name: answer.plain[name] for name in names}
    own, edge = (describe(*find_gait(there.biped, dataclasses.replace(there.slope, slope_deg=each), 1e-8))
                 for each in (1.7, 1.2))  # fmt: skip
    for name, value in (("step_frequency", "step_frequency_hz"), ("step_length", "step_length_m")):
        assert found[name]["ramp"] == pytest.approx(found[name]["inputs"])
        off = abs(getattr(edge, value) / getattr(own, value) - 1)
        assert off < found[name]["ramp"] < 1.4 * off, name
    assert found["peak_force"]["ramp"] is None, "its impulses are not in derivatives"
    said = [f"the ramp's slope alone {100 * found[name]['ramp']:.2g} %" in line
            for name, line in zip(names, (line for line in answer.lines if "beside it" in line), strict=False)]
    assert said == [True, True]


def test_errors_that_go_together_leave_what_they_leave_together(parameters, small):
    """Wholly so, two parts are added or taken off each other. Fitted ones are normal, printed ones have edges.

    Multipliers bend: over .1 mm by some hundred thousandths of what they change.
    """
    digits, widths = type(parameters.design_digits), {"leg_length": 1e-4, "foot_com": 1e-4}
    exact = dataclasses.replace(parameters, slope_digits=type(parameters.slope_digits)())

    def left(correlation, **some):
        rows = (Correlation("biped.foot_com", "biped.leg_length", correlation),)
        given = dataclasses.replace(exact, design_digits=digits(some or widths, rows))
        return [Ladder(given, Learnt(small)).inputs(name, 0) for name in ("period", "multiplier")]

    alone = np.array([left(0.5, **{key: width}) for key, width in widths.items()])
    assert left(0.0) == pytest.approx(np.sqrt((alone**2).sum(axis=0)), rel=1e-4)
    ends = np.sort([left(-1.0), left(1.0)], axis=0)
    assert ends == pytest.approx(np.array([abs(alone[0] - alone[1]), alone.sum(axis=0)]), rel=1e-4)
    printed = Ladder(dataclasses.replace(exact, design_digits=digits(widths)), Learnt(small))
    assert left(0.0) == pytest.approx([math.sqrt(3.0) / 1.96 * printed.inputs(name, 0)
                                       for name in ("period", "multiplier")], rel=1e-4)  # fmt: skip


def test_digits_of_what_a_gait_does_not_depend_on_leave_nothing(parameters, small):
    """Rigid legs have no stiffness: with its digits alone `ask stable` ended with StopIteration."""
    rigid = dataclasses.replace(
        parameters, biped=dataclasses.replace(parameters.biped, legs="rigid"),
        design_digits=type(parameters.design_digits)({"stiffness": 5e-3}),
        slope_digits=type(parameters.slope_digits)())  # fmt: skip
    ladder = Ladder(rigid, Learnt(small))
    assert ladder.inputs("multiplier", 0) == ladder.inputs("period", 0) == 0.0


def test_stable_is_a_probability_that_falls_where_the_gait_loses_stability(parameters, small):
    told = []
    for slope in (2.0, 2.5, 3.0):
        ground = dataclasses.replace(parameters.slope, slope_deg=slope)
        told.append(Ladder(dataclasses.replace(parameters, slope=ground), Learnt(small)).stable())
    assert told[0].probability > 0.99 and all(0.0 <= one.probability <= 1.0 for one in told)
    assert [one.multiplier for one in told] == sorted(one.multiplier for one in told)
    assert told[-1].probability < told[0].probability


def test_the_stage_leaves_the_stability_of_its_own_design_as_it_is_answered(parameters, small):
    assert small.stability == Ladder(parameters, Learnt(small)).stable()


@pytest.mark.parametrize(("probability", "words"), [(8.6e-23, "below 0.001"), (1.0, "above 0.999"), (0.98, "of 0.98")])
def test_a_probability_is_no_more_certain_than_its_errors(probability, words):
    found = Stability(probability, 1.09, 1e-3, 1e-3, 0.018, "twin")
    assert stability_in_words(found)[0] == f"stable: with a probability {words}"


def test_a_robot_unlike_the_drawn_ones_is_said_to_be_and_its_error_widened(parameters, small, ladder):
    softer = dataclasses.replace(parameters, biped=dataclasses.replace(parameters.biped, stiffness=500.0))
    other = Ladder(softer, Learnt(small))
    assert other.outside() and not ladder.outside()
    assert other.learnt.at(1, 0, other.numbers).error > 2.0 * ladder.learnt.at(1, 0, ladder.numbers).error
    assert other.learnt.at(PENALTY, 0, other.numbers).error > ladder.learnt.at(PENALTY, 0, ladder.numbers).error


BOX = {"count": 6, "seed": 2, "vary": {"biped.stiffness": {"low": 1800, "high": 2400},
                                       "ground.slope_deg": {"low": 1.8, "high": 2.4}}}  # fmt: skip


@pytest.mark.parametrize(("what", "within", "said"), [
    (BOX, ("1%",), "names the measure"), (BOX, ("hop=1%",), "hop is no measure"),
    (BOX, ("multiplier=1%",), "can be 0"), (BOX, ("speed=0",), "not a positive error"),
    (("speed",), (), "no error is given for speed"),
    (("speed",), ("0",), "not a positive error"),
    (("speed",), ("-1%",), "not a positive error"),
    (("speed",), ("nan",), "not a positive error"),
    (("speed",), ("inf",), "not a positive error"),
    (("speed",), ("one",), "not a positive error"),
    (("speed",), ("hop=1%",), "hop is no measure"),
    (("speed",), ("1%", "2%"), "already"),
    (("multiplier",), ("1%",), "can be 0"),
    (("multiplier",), ("multiplier=1%",), "can be 0"),
])  # fmt: skip
def test_a_bad_request_is_one_sentence(parameters, small, what, within, said):
    with pytest.raises(WrongOption, match=said):
        requested(parameters, what, within, Asking(model_error=small))


def requested(parameters, what, within, asking):
    """The answer of `ask` on these measures, or of `map` over this box."""
    if what is BOX:
        return map.ask(parameters, map.Options(what, within=within), asking)
    return ask(parameters, Options(what, within), asking)


@pytest.mark.parametrize("what", [("speed",), BOX])
def test_without_what_was_learnt_the_command_that_learns_is_named(parameters, what):
    with pytest.raises(WrongOption, match="bipedstudy run model_error"):
        requested(parameters, what, ("speed=1%",), Asking())


def test_a_result_of_other_measures_is_refused(parameters, small):
    earlier = copy.copy(small)
    object.__setattr__(earlier, "values", small.values[..., 1:])
    with pytest.raises(StudyError, match="of other measures") as refused:  # by every command that reads it
        artefact.decode(artefact.encode(earlier, {}), Result, "results/model_error.h5")
    asking = Asking()
    asking.result = lambda stage="": (None, str(refused.value))
    with pytest.raises(WrongOption, match=r"of other measures\); bipedstudy run model_error"):
        ask(parameters, Options(("speed",), ("1%",)), asking)


def test_a_result_of_other_numbers_is_refused(parameters, small):
    earlier = dataclasses.replace(small, numbers=small.numbers[:, 1:])
    with pytest.raises(WrongOption, match=r"of other numbers of a design; bipedstudy run model_error"):
        ask(parameters, Options(("speed",), ("1%",)), Asking(model_error=earlier))


def test_who_asks_for_a_peak_force_is_told_what_the_constraint_model_lacks(parameters, small):
    answer = ask(parameters, Options(("peak_force",), ("1%",)), Asking(model_error=small))
    assert answer.plain["peak_force"]["rung"] == MODELS[PENALTY] and answer.plain["peak_force"]["inputs"] is None
    assert "heel strikes are impulses" in answer.lines[3] and "is not known" in answer.lines[1]


def test_one_error_serves_all_measures_but_those_with_their_own():
    found = errors(("1%", "speed=0.02"))
    assert found[""] == Allowed(0.01, True) and found["speed"] == Allowed(0.02, False)
    assert Options(("period",), ("1%", "speed=0.02")).allowed("period").share


def test_what_the_twin_misses_of_the_robot_is_a_calibrations_or_not_known(parameters, small):
    for others, late, said in (({}, None, "nothing is known of how the twin differs"),
                               ({"calibrated_twin": SimpleNamespace(strikes_off=None)}, None, "nothing is known"),
                               ({"calibrated_twin": SimpleNamespace(strikes_off=0.0051)}, 0.0051,
                                "off by up to 5.1 ms")):  # fmt: skip
        answer = ask(parameters, Options(("period",), ("1%",)), Asking(model_error=small, **others))
        assert answer.plain["twin_strikes_off_s"] == late and said in answer.lines[-1]


def test_the_probability_is_students_where_draws_are_few():
    """At one spread beyond one, two draws tell .211 (t = 1 with 2 degrees), and .159 where other errors are the sum."""
    miss = Miss(0.0, 1e-3 * covering(2.0), 2.0)
    assert miss.spread == pytest.approx(1e-3)
    assert below_one(1.001, miss, 0.0) == pytest.approx(0.2113, abs=1e-4)
    assert below_one(1.0 + 0.1, miss, 0.1 * WIDTH) == pytest.approx(0.1587, abs=1e-3)
    assert below_one(0.9, Miss(0.0, 0.0), 0.0) == 1.0 - below_one(1.1, Miss(0.0, 0.0), 0.0) == 1.0


@pytest.mark.parametrize(("lost", "share"), [(2.0, 8 / 9), (0.6, 6 / 9)])
def test_slopes_that_may_be_count_by_what_the_multiplier_is_on_them(parameters, small, monkeypatch, lost, share):
    """It rises to 1 within a quarter of the slope's half width, and turns back in a limp at a half: eight of the nine
    slopes are stable, six where two have no gait."""
    width, own = parameters.half_widths["ground.slope_deg"], parameters.slope.slope_deg

    def find(ladder, rung, tolerance):
        off = (ladder.parameters.slope.slope_deg - own) / width
        if off > lost:
            raise NoRung("it falls")
        return Found(np.array([0.5, 2.0, 0.2, 0.4, 9.0, 0.9 + (0.4 * off if off < 0.5 else -0.2)]), np.zeros(6))

    monkeypatch.setattr(Ladder, "find", find)
    monkeypatch.setattr(Ladder, "miss", lambda ladder, rung, measure: Miss(0.0, 0.0))
    monkeypatch.setattr(Ladder, "multipliers_over_values", np.zeros(1))
    found = Ladder(parameters, Learnt(small)).stable()
    assert found.probability == pytest.approx(share) and found.rung == MODELS[PENALTY]
    changes = np.append(0.4 * np.linspace(-8 / 9, 4 / 9, 7), [-0.2, -0.2] if lost > 1.0 else [math.inf, math.inf])
    assert found.inputs == pytest.approx(WIDTH * np.sqrt(np.mean(changes**2)))


def test_values_beyond_the_ends_of_the_family_are_not_stable(parameters, small):
    """One leg .1 mm longer, the other known to 1 mm: linear, a multiplier of .61 told a probability above .999."""
    digits, length = type(parameters.design_digits), parameters.biped.leg_length
    limped = dataclasses.replace(
        parameters, biped=dataclasses.replace(parameters.biped, other_leg_length=length + 1e-4),
        design_digits=digits({"leg_length": 1e-3}), slope_digits=type(parameters.slope_digits)())  # fmt: skip
    ladder = Ladder(limped, Learnt(small))
    design, point = ladder.design_point, ladder.design.as_it_stands[1]
    ends = [continue_gait(design, "biped.leg_length", (length - 1e-3, length + 1e-3), point.z, 1e-8, upward=upward,
                          until_fold=True).points[-1] for upward in (False, True)]  # fmt: skip
    assert all(0.5e-3 < abs(end.value - length) < 0.8e-3 for end in ends), "else the family does not end within 1 mm"
    share = (ends[1].value - ends[0].value) / 2e-3
    found = ladder.stable()
    assert found.probability == pytest.approx(share, abs=0.02) and not math.isfinite(found.inputs)


def test_where_the_solver_leaves_more_open_than_the_model_stability_takes_a_closer_walk(parameters, small, monkeypatch):
    """An error of a tenth told .46 of a multiplier of 1.002 that one of 1e-5 shows to be above one."""
    errors = {1e-6: 0.1, 1e-7: 1e-5, 1e-8: 0.0}

    def find(ladder, rung, tolerance):
        walked.append(tolerance)
        return Found(np.array([0.5, 2.0, 0.2, 0.4, 9.0, 1.002]), np.full(6, errors[tolerance]))

    exact = dataclasses.replace(parameters, design_digits=type(parameters.design_digits)(),
                                slope_digits=type(parameters.slope_digits)())  # fmt: skip
    monkeypatch.setattr(Ladder, "find", find)
    monkeypatch.setattr(Ladder, "miss", lambda ladder, rung, measure: Miss(0.0, 1e-4 if rung == PENALTY else math.inf))
    walked = []
    assert Ladder(exact, Learnt(small)).stable().probability < 1e-6
    assert set(walked) == {1e-6, 1e-7}


@pytest.mark.parametrize(("lost", "model", "answer"), [
    (False, 1e-2, (MODELS[TWIN], 0.998, 1.0)), (True, 1e-2, (MODELS[PENALTY], 0.99998, 0.5016)),
    (False, 1e-4, (MODELS[PENALTY], 0.99998, 0.652))])  # fmt: skip
def test_what_closes_by_chance_is_walked_closer_and_the_twin_decides(
    parameters, small, monkeypatch, lost, model, answer
):
    """Of rubbing legs .854 at 1e-6 was taken for .978, and the penalty walker answered for the best rung: it does where
    the twin's differences leave as much as it misses."""

    def find(ladder, rung, tolerance):
        if tolerance > 1e-7:
            raise TooLoose("beside it")
        if lost and rung == TWIN:
            raise NoRung("it falls")
        return Found(np.array([0.5, 2.0, 0.2, 0.4, 9.0, 0.998 if rung == TWIN else 0.99998]), np.zeros(6))

    def miss(ladder, rung, measure):
        return Miss(0.0, (math.inf, math.inf, model, 0.0)[rung])

    monkeypatch.setattr(Ladder, "find", find)
    monkeypatch.setattr(Ladder, "miss", miss)
    monkeypatch.setattr(Ladder, "multipliers_over_values", np.zeros(1))
    found, period = (each(Ladder(parameters, Learnt(small))) for each in (
        Ladder.stable, lambda ladder: ladder.within("period", 0.02, share=True)))
    assert (found.rung, found.multiplier, found.probability) == pytest.approx(answer, abs=1e-3)
    assert period.rung == MODELS[PENALTY] and period.tolerance == 1e-7 and "beside it" in period.passed_over


def test_the_answer_has_no_clock_in_it(parameters, small):
    options = Options(("period", "stable"), ("1%",))
    one, other = (ask(parameters, options, Asking(model_error=small)).plain for _ in range(2))
    assert one == other


def test_designs_of_another_kind_are_the_twins_alone_and_it_is_said(parameters, small):
    rigid = dataclasses.replace(parameters, biped=dataclasses.replace(parameters.biped, legs="rigid"))
    answer = ask(rigid, Options(("period",), ("5%",)), Asking(model_error=small))
    assert answer.plain["period"]["rung"] == MODELS[TWIN] and "rigid legs" in answer.plain["unlike_the_drawn"]
    assert any("another kind" in line and "compliant legs" in line for line in answer.lines)


@pytest.mark.slow
def test_where_no_miss_is_known_the_twin_tells_what_is_stable(parameters, small):
    nothing = dataclasses.replace(small, values=np.where(np.arange(len(MODELS))[:, None, None] == TWIN, np.nan,
                                                         small.values))  # fmt: skip
    found = Ladder(parameters, Learnt(nothing)).stable()
    assert found.rung == MODELS[TWIN] and found.probability > 0.99


def test_where_nothing_tells_what_is_stable_the_other_answers_stay(parameters, small, monkeypatch):
    def lost(ladder):
        raise NoRung("no gait of the twin was found: the walker fell")

    monkeypatch.setattr(Ladder, "stable", lost)
    answer = ask(parameters, Options(("period", "stable"), ("5%",)), Asking(model_error=small))
    assert answer.no and answer.plain["period"]["met"] and answer.plain["stable"]["probability"] is None
    assert [row["measure"] for row in answer.rows] == ["period", "stable"]
    assert "stable: not known, as no gait of the twin was found: the walker fell" in answer.lines


def test_design_of_takes_the_studys_settings(parameters):
    drawn = design_of(parameters)
    assert drawn.twin is parameters.twin and drawn.biped is parameters.biped


@pytest.mark.slow
def test_further_draws_join_those_of_the_stage(parameters, small):
    asking = Asking(parameters, model_error=small)
    answer = ask(parameters, Options(("period",), ("0.4%",), learn=6), asking)
    more = further(small, parameters, [[*walked(one, twin=False)[:2]] for one in further_draws(parameters, 6)])
    assert len(more.numbers) == len(small.numbers) + 6 and more.solver_errors.shape == more.values.shape
    found = Ladder(parameters, Learnt(more)).within("period", 4e-3, share=True)
    assert answer.plain["period"]["value"] == found.value and answer.plain["period"]["model"] == found.model
    alone = Learnt(small)
    assert not np.array_equal(alone.fits[0, 0].coefficients, Learnt(more).fits[0, 0].coefficients)


# --- `map --within`: each design by the cheapest rung, as `ask` answers it alone, whatever the blocks.


@pytest.mark.slow
def test_each_design_is_answered_as_if_it_were_asked_alone(parameters, small, tmp_path):
    options = map.Options(BOX, out=tmp_path / "map.h5", within=("step_frequency=3%", "period=1e-4"))
    answer = map.ask(parameters, options, Asking(parameters, model_error=small))
    with h5py.File(options.out) as file:
        found = {name: column[()] for name, column in file["table"].items()}
        words = {value: word for word, value in h5py.check_enum_dtype(file["table/period_model"].dtype).items()}
    assert sum(answer.plain["answered_by"]["period"].values()) == 6
    for row in range(6):
        biped = dataclasses.replace(parameters.biped, stiffness=found["biped.stiffness"][row])
        slope = dataclasses.replace(parameters.slope, slope_deg=found["ground.slope_deg"][row])
        alone = Ladder(dataclasses.replace(parameters, biped=biped, slope=slope), Learnt(small))
        one, other = alone.within("step_frequency", 0.03, True), alone.within("period", 1e-4, False)
        assert found["step_frequency"][row] == pytest.approx(one.value, rel=1e-6)
        assert found["step_frequency_error"][row] == pytest.approx((one.solver + one.model) * one.value, rel=1e-3)
        assert found["step_frequency_error"][row] <= 0.03 * one.value and found["period_error"][row] <= 1e-4
        assert words[found["period_model"][row]] == other.rung == MODELS[2]


def test_a_design_that_breaks_a_rule_or_that_no_model_has_is_no_number(parameters, small, tmp_path):
    wide = {"kind": "grid", "vary": {"biped.foot_radius": {"low": 0.05, "high": 0.5, "steps": 2}}}
    options = map.Options(wide, out=tmp_path / "map.h5", within=("multiplier=1e-5",))
    plain = map.ask(parameters, options, Asking(parameters, model_error=small)).plain["answered_by"]["multiplier"]
    assert plain == {"no model": 1, "not allowed": 1}
    with h5py.File(options.out) as file:
        assert np.isnan(file["table/multiplier"][()]).all()
