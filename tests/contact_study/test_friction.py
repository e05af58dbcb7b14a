"""How the gait answers to the ground: to friction's transition velocities, and parameters of ground that gives way."""

import dataclasses
import json
import math
from types import SimpleNamespace

import numpy as np
import pytest

from stages.analytic.gait.gait_search import find_gait
from stages.analytic.walk.sampling import walk_from_mid_stance
from stages.biped.question import WrongOption
from stages.contact_study import run as study
from stages.contact_study.questions.ground_sensitivity import HEADS, Options, ask, lines
from stages.contact_study.result import FrictionVariation, changes, crossing
from stages.contact_study.run import first_gait, laws_of, next_gait, row, vary_friction
from stages.penalty import step_map
from stages.penalty.model.changes import names_of
from stages.penalty.step_map import PenaltyStepper
from stages.penalty.walk import Settings, simulate
from stages.planar.limit_cycle import ENOUGH
from stages.planar.run import rolling_state
from stages.planar.sampling import find_events
from stages.planar.section import NoLimitCycle
from tests.asking import Asking


def variation(factor, period, length):
    return FrictionVariation("stiction_velocity", factor, period, length)


def test_the_factor_at_which_a_limit_is_crossed_is_interpolated():
    rows = (variation(0.5, 0.5, 0.1605), variation(1.0, 0.5, 0.16), variation(2.0, 0.5, 0.1592),
            variation(4.0, 0.51, 0.1568))  # fmt: skip
    below, above = crossing(rows, "stiction_velocity", 0.0075)
    assert np.isnan(below)  # 0.3 % at the half, and nothing computed beyond
    assert above == pytest.approx(2.0 * 2.0 ** ((0.0075 - 0.005) / (0.02 - 0.005)))
    assert crossing(rows, "stiction_velocity", 0.01)[1] > above
    assert crossing((*rows, variation(0.25, np.nan, np.nan)), "stiction_velocity", 0.0075)[1] == above


@pytest.fixture(scope="module")
def stepper(parameters, stand_in):
    def on(law):
        start = rolling_state(parameters.biped, law, stand_in.mid_stance, 9.4)
        return PenaltyStepper(parameters.biped, parameters.slope, law, start, Settings(1e-9))

    return on


@pytest.fixture(scope="module")
def rows(default, stepper):
    return vary_friction(default, stepper)


def test_halving_the_stiction_velocity_lengthens_the_step_and_doubling_shortens_it(rows, default):
    """From Adams' stiction velocity, by 0.9 % and 1.9 %; the other velocity hardly matters."""
    in_length = {(row.name, row.factor): length for row, _, length in changes(rows)}
    assert in_length["stiction_velocity", 0.5] == pytest.approx(0.009, abs=0.001)
    assert in_length["stiction_velocity", 2.0] == pytest.approx(-0.019, abs=0.001)
    assert abs(in_length["friction_velocity", 2.0]) < 1e-4
    below, above = crossing(rows, "stiction_velocity", 0.01)
    assert 0.25 < below < 0.5 and 1.0 < above < 2.0
    laws = laws_of(default, rows)
    assert len(laws) == len(rows) and laws[0].stiction_velocity == pytest.approx(0.25 * default.stiction_velocity)


@pytest.mark.parametrize("tolerance", [1e-8, 1e-7, 1e-6])
def test_a_looser_solver_finds_the_same_gaits(rows, parameters, default, tolerance):
    """A poor derivative led the search at 1e-7 to legs that stand side by side, and to a gait of 4e-11 s."""
    walker, point = find_gait(parameters.biped, parameters.slope, 1e-9)
    walk, upright = walk_from_mid_stance(walker, point.z, 1, 1e-9, 2000.0)

    def on(law):
        start = rolling_state(parameters.biped, law, upright, walk.standing_force)
        return PenaltyStepper(parameters.biped, parameters.slope, law, start, Settings(tolerance))

    found = vary_friction(default, on)
    # Nearly all are within 60 tolerances; what a search may leave was met at one in ten, on each processor at others.
    for name in ("period_s", "step_length_m"):
        exact = [getattr(one, name) for one in rows]
        np.testing.assert_allclose([getattr(one, name) for one in found], exact, rtol=ENOUGH[-1] * tolerance)


def test_legs_that_stand_side_by_side_take_no_step(default, stepper):
    numbers = np.array([0.3325, 0.0494, 0.3325, 0.3326, 0.956, -0.0441, -2.88, -3.374, -0.044, 0.05])
    with pytest.raises(NoLimitCycle, match="no leg swings"):
        stepper(default).step(numbers)


def test_a_gait_that_is_solved_for_is_where_a_long_walk_runs_into(rows, parameters, default, stepper):
    doubled = dataclasses.replace(default, stiction_velocity=2 * default.stiction_velocity)
    walker = stepper(doubled)
    run = simulate(
        parameters.biped, parameters.slope, doubled, walker.start, Settings(1e-9), steps=60, signals=())
    strikes = find_events(run.trajectory, parameters.biped.foot_radii).heel_strike_time
    solved = next(row for row in rows if (row.name, row.factor) == ("stiction_velocity", 2.0))
    assert 0.5 * (strikes[-1] - strikes[-3]) == pytest.approx(solved.period_s, rel=1e-6)  # steps alternate around it


def test_of_gaits_that_lie_on_a_line_the_next_is_where_its_search_starts(monkeypatch):
    monkeypatch.setattr(study, "fixed_point", lambda _, numbers, *__: numbers)
    line = [(at, SimpleNamespace(numbers=np.array([0.3 + at, 2.0 - 3.0 * at]), derivative=None)) for at in (0.7, 1.1)]
    np.testing.assert_allclose(next_gait(None, line, 1.6), [0.3 + 1.6, 2.0 - 3.0 * 1.6])


def test_of_legs_that_differ_what_is_kept_is_of_a_step(rows, parameters, default, stepper):
    """Their cycle has two: legs as good as alike walk the gait of alike ones."""
    biped = dataclasses.replace(parameters.biped, other_foot_mass=parameters.biped.foot_mass * (1.0 + 1e-9))
    walker = PenaltyStepper(biped, parameters.slope, default, stepper(default).start, Settings(1e-9))
    alike = next(each for each in rows if each.factor == 1.0)
    found = row(alike.name, 1.0, first_gait(walker))
    assert walker.steps_a_cycle == 2
    assert found.period_s == pytest.approx(alike.period_s, rel=1e-6)
    assert found.step_length_m == pytest.approx(alike.step_length_m, rel=1e-6)


def test_ground_on_which_no_gait_is_found_has_empty_rows(default, stepper):
    slippery = dataclasses.replace(default, static_friction=1e-3, dynamic_friction=1e-3)
    rows = vary_friction(slippery, stepper)
    assert rows and all(math.isnan(row.period_s) for row in rows) and laws_of(slippery, rows) == []


# --- The question how the gait on ground that gives way answers to parameters.


def test_it_names_what_moves_the_gait_and_nothing_else(parameters):
    plain = set(names_of(parameters.biped, parameters.slope, parameters.contact))
    assert {"biped.damping", "ground.slope_deg", "ground.damping_depth", "ground.friction_velocity"} < plain
    assert not {"ground.restitution", "ground.impact_speed", "biped.frame_mass"} & plain
    other = dataclasses.replace(parameters.contact, normal_force="restitution", friction="coulomb")
    rigid = dataclasses.replace(parameters.biped, legs="rigid", frame_mass=0.05)
    names = set(names_of(rigid, parameters.slope, other))
    assert plain - names == {"biped.stiffness", "biped.damping", "ground.contact_damping", "ground.damping_depth",
                             "ground.dynamic_friction", "ground.friction_velocity"}  # fmt: skip
    assert names - plain == {"ground.restitution", "ground.impact_speed", "biped.frame_mass"}


@pytest.mark.slow
def test_elasticities_of_legs_that_differ_in_words_and_numbers(parameters, default, monkeypatch):
    """Of the multipliers seven digits would do; how they are had to ten, `tests/penalty/test_walk.py` says."""
    monkeypatch.setattr(step_map, "OF_MATRICES", 1e-10)
    design = dataclasses.replace(
        parameters.biped, frame_mass=0.03, frame_com=0.04, other_leg_length=parameters.biped.leg_length - 1e-4)
    names = ("biped.foot_mass", "biped.leg_length", "biped.leg_inertia")
    answer = ask(dataclasses.replace(parameters, biped=design, contact=default), Options(names), Asking())
    assert json.loads(json.dumps(answer.plain)) == answer.plain
    told = answer.plain["parameters"]
    assert tuple(told) == names and tuple(row["parameter"] for row in answer.rows) == names
    shares = told["biped.foot_mass"]["elasticities"]
    assert tuple(shares) == HEADS
    period = answer.plain["gait"]["period_s"]
    assert told["biped.foot_mass"]["period_s"] == pytest.approx(shares["period"] * period / design.foot_mass)
    assert told["biped.leg_inertia"]["elasticities"] is None
    assert any(line.startswith("biped.leg_inertia is 0") for line in answer.lines)
    assert told["biped.leg_length"]["elasticities"]["|mu1|"] is None  # of the first leg alone, by .4 %: it falls
    assert [word.split()[1] for word in answer.plain["refused"]] == ["biped.leg_length"]
    assert answer.plain["distance_to_exudyn_m"] < 1e-9 and answer.plain["left_by_extrapolation"] < 1e-5


@pytest.mark.parametrize(("largest", "unstable"), [((-1.2, 0.0), True), ((0.6, 0.7), False), ((0.8, 0.7), True)])
def test_an_unstable_gait_is_said_to_be(largest, unstable):
    plain = {"gait": {"period_s": 0.5, "step_length_m": 0.2}, "multipliers": [largest, (0.1, 0.0)], "parameters": {},
             "left_by_extrapolation": None, "refused": [], "distance_to_exudyn_m": 1e-11}  # fmt: skip
    said = "\n".join(lines(plain, 1e-9, np.zeros((0, 4)), np.zeros(0)))
    assert ("the gait is unstable" in said) == unstable


def test_what_moves_nothing_is_refused_with_what_does(parameters):
    with pytest.raises(WrongOption, match=r"ground\.restitution: this gait depends on biped\.hip_mass, .*"):
        ask(parameters, Options(("ground.restitution",)), Asking())
