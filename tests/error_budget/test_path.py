"""The path and its contributions, with made-up outcomes whose parts are known."""

import dataclasses
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest

from pipeline.cache import artefact
from stages.comparison.stride import NoEvidence
from stages.drawing import style
from stages.error_budget.path import Cycles, Limits, OneStep, contributions, switched
from stages.error_budget.result import (
    CONTACT,
    CREEP,
    EACH,
    EFFECTS,
    IMPACT,
    INTEGRATION_CONSTRAINT,
    INTEGRATION_PENALTY,
    ORDER,
    POSITION,
    SLIP,
    UNEXPLAINED,
    VELOCITY,
    Convergence,
    Result,
    Shares,
    Split,
    rms_of_columns,
    split_of,
    telescoped,
)
from stages.error_budget.run import run
from stages.figures.drawn import model_difference
from stages.ground.contact_law import ContactLaw
from stages.ground.friction import friction_coefficient, static_penetration
from stages.planar.section import NoLimitCycle
from tests.comparison.made_up import make_budget
from tests.study import parameters_of

LAW = ContactLaw(3e5, 2.2, 3e4, 1e-4, 1.1, 1.0, 0.03, 1.0)
CURVE = np.random.default_rng(1).normal(size=(20, 4))
EVERYWHERE = np.ones(len(CURVE), dtype=bool)


def limits(bend=0.0, interaction=0.0, cube=0.0):
    """Outcomes made of creep ~ v_s (with higher orders), impact ~ penetration, and both at once."""

    def outcome(law, tolerance):
        creep = law.stiction_velocity / LAW.stiction_velocity
        give = static_penetration(law, 10.0) / static_penetration(LAW, 10.0)
        powers = creep + bend * creep**2 + cube * creep**3
        return (5.0 + tolerance + powers + 2.0 * give + interaction * creep * give) * CURVE

    return Limits(LAW, 0.1, outcome, 1e-3, 1e-3)


def split(path):
    both = path.at(frozenset(CONTACT)) - 0.001 * CURVE
    return Split(*contributions(1.0 * CURVE, 1.1 * CURVE, 4.0 * CURVE, path, both), EVERYWHERE)


def test_contributions_add_up_to_the_difference_of_the_models():
    found = split(limits(bend=0.3, interaction=0.7, cube=0.2))
    expected = pytest.approx((5.001 + 1.5 + 2.0 + 0.7 - 1.0) * CURVE, rel=1e-12)
    assert found.total == expected and len(found.parts) == len(EFFECTS)
    assert all(parts.sum(axis=0) == expected for parts in found.orders)


def test_effects_that_do_not_act_on_each_other_are_told_apart_without_a_rest():
    found = split(limits(bend=0.3))
    expected = {
        INTEGRATION_CONSTRAINT: 0.1, SLIP: 2.9, UNEXPLAINED: 1.001, CREEP: 1.3 - 0.0005, IMPACT: 2.0 - 0.0005,
        INTEGRATION_PENALTY: 0.001,
    }  # fmt: skip
    for effect, size in expected.items():
        assert found.part(effect) == pytest.approx(size * CURVE, abs=1e-12), effect


def test_the_third_order_stays_in_the_rest():
    """(8 f(s) - 6 f(2 s) + f(4 s)) / 3 of s^3 is 8 s^3."""
    rest = split(limits(cube=0.3)).part(UNEXPLAINED) - split(limits()).part(UNEXPLAINED)
    assert rest == pytest.approx(8 * 0.1**3 * 0.3 * CURVE, rel=1e-9)


def test_an_interaction_is_halved_and_widens_the_interval():
    """Switched on in either order, one after the other, the effects come out at the interval's ends."""
    path, plain = limits(interaction=0.7), split(limits())
    found = split(path)
    for effect in CONTACT:
        assert found.part(effect) - plain.part(effect) == pytest.approx(0.35 * CURVE, abs=1e-12)
    neither, whole = path.at(frozenset()), path.at(frozenset(CONTACT)) - 0.001 * CURVE
    for parts, first in zip(found.orders, CONTACT):
        last = next(effect for effect in CONTACT if effect != first)
        steps = telescoped([neither, path.at(frozenset({first})), whole])
        for effect, step in zip((first, last), steps):
            assert parts[EFFECTS.index(effect)] == pytest.approx(step, abs=1e-12)
            low, high = found.interval(effect)
            assert np.all((low <= step + 1e-12) & (step <= high + 1e-12))
            assert high - low == pytest.approx((0.7 - 0.001) * np.abs(CURVE), rel=1e-9)


def test_order_and_last_share_are_those_of_the_outcomes():
    """An effect of first order: order 1, the last share predicted; one that bends: not, by 2 s^2 of the bend."""
    for bend, missed in ((0.0, 0.0), (0.3, 0.3 * (0.1**2 - 1.5 * 0.2**2 + 0.5 * 0.4**2))):
        path = limits(bend=bend)
        split(path)
        found = path.convergence(lambda outcome: outcome, EVERYWHERE)
        expected = np.log2((0.2 + 0.12 * bend) / (0.1 + 0.03 * bend))
        assert found.order[2] == pytest.approx(np.full(4, expected)), "creep off"
        assert found.missed[2] == pytest.approx(missed * np.sqrt((CURVE**2).mean(axis=0)), abs=1e-12)
        assert found.order[1] == pytest.approx(np.ones(4)), "impact off"
        assert found.missed[1] == pytest.approx(np.zeros(4), abs=1e-12)


def test_shares_are_those_of_the_unexplained_rest():
    parts = np.zeros((len(EFFECTS), 3, 4))
    parts[EFFECTS.index(SLIP)] = [[3.0, 4.0, 0.0, 9.0], [3.0, 4.0, 0.0, 9.0], [3.0, 4.0, 99.0, 9.0]]
    parts[EFFECTS.index(UNEXPLAINED), :, 0] = 1.0
    found = split_of(parts, np.zeros((3, 4)), np.array([True, True, False]))
    assert np.isnan(found.parts[:, 2, 2:]).all() and (found.parts[:, 2, :2] == parts[:, 2, :2]).all()
    assert found.explained(POSITION) == pytest.approx(1 - 1 / np.hypot(4, 4))
    assert found.explained(VELOCITY) == 1.0 and found.peak(found.total, VELOCITY) == 9.0
    assert [found.explained(column) for column in EACH[:2]] == pytest.approx([0.75, 1.0])
    assert found.along(found.part(SLIP), POSITION) == pytest.approx((3 * 4 + 4 * 4) / np.hypot(4, 4))
    assert sum(found.along(part, POSITION) for part in parts) == pytest.approx(np.hypot(4, 4))


def test_all_effects_on_is_the_law_itself():
    assert switched(LAW, CONTACT, 0.1) == LAW
    assert switched(LAW, (CREEP,), 0.1).contact_stiffness > LAW.contact_stiffness
    assert switched(LAW, (IMPACT,), 0.1).stiction_velocity < LAW.stiction_velocity


@pytest.mark.parametrize("share", (0.2, 0.1, 0.01))
def test_an_effect_that_is_off_keeps_its_share(share):
    off, slip = switched(LAW, (), share), 1e-7
    assert static_penetration(off, 10.0) == pytest.approx(share * static_penetration(LAW, 10.0), rel=1e-9)
    assert friction_coefficient(off, share * slip) == pytest.approx(friction_coefficient(LAW, slip), rel=1e-4)
    assert off.friction_velocity == 2 * off.stiction_velocity


# --- The order in which effects vanish with their share, of the walker against its limit.


@pytest.fixture(scope="module")
def approach(parameters, scene):
    """The walker's hip over a step with both effects off, for shares that halve, and the limit that is expected."""
    law = parameters.contact
    hips = [scene.penalty(switched(law, (), share), 1e-7) for share in (0.4, 0.2, 0.1, 0.05)]
    return hips, scene.coarse_or_fine(1e-12, coulomb=True), scene.compared()


def test_the_walkers_order_and_its_last_share(approach):
    """The first three shares show the order and foretell the fourth, to 2 % of the way that three of them made."""
    hips, _, compared = approach
    found = Convergence.of(0.1, [Shares(*hips[:3])], compared)
    assert found.order[0, 1] == pytest.approx(ORDER, abs=0.1), found.order
    assert found.order[0, 3] == pytest.approx(ORDER, abs=0.15), found.order
    last = rms_of_columns(hips[3] - Shares(hips[1], hips[2], hips[3]).predicted, compared)
    way = rms_of_columns(hips[3] - hips[0], compared)
    assert np.all(last[[1, 3]] < 0.02 * way[[1, 3]]) and np.all(last < 0.2 * way), last / way


def test_the_limit_is_the_constraint_model_with_coulomb_friction(approach, scene):
    """The difference falls with every share, and three shares foretell the limit better than the last of them is."""
    hips, coulomb, compared = approach
    away = [rms_of_columns(hip - coulomb, compared) for hip in hips]
    assert all(np.all(near < far) for far, near in pairwise(away))
    limit = rms_of_columns(Shares(*hips[1:]).limit - coulomb, compared)
    assert np.all(limit < 0.5 * away[-1]), limit / away[-1]
    rolling = rms_of_columns(scene.coarse_or_fine(1e-12) - coulomb, compared)
    assert limit[0] < 0.03 * rolling[0] and limit[2] < 0.03 * rolling[2]


# --- Effects in their limits, on the walker itself; the whole budget is a slow test.


def test_creep_is_proportional_to_the_stiction_velocity(parameters, scene):
    """Before heel strike, where nothing else depends on it: halving v_s halves what it moves the hip by."""
    before = scene.time < 0.9 * scene.constraint.heel_strikes[0]
    hips = [
        scene.penalty(dataclasses.replace(parameters.contact, stiction_velocity=v, friction_velocity=0.2), 1e-7)
        for v in (0.08, 0.04, 0.02)
    ]
    first, second = (np.ptp((b - a)[before, 0]) for a, b in pairwise(hips))
    assert first / second == pytest.approx(2.0, abs=0.04)


@pytest.mark.parametrize("other_foot_mass", [None, 0.338])
def test_a_cycle_is_a_stride_of_steps_that_limp_where_the_legs_differ(parameters, other_foot_mass):
    """After two steps the hip is as high as it was, and twice the step's length away, without a jump between."""
    biped = dataclasses.replace(parameters.biped, other_foot_mass=other_foot_mass)
    cycles = Cycles(dataclasses.replace(parameters, biped=biped))
    for found in (cycles.constraint(cycles.rolling), cycles.penalty(parameters.contact, 1e-8)):
        hip, length = found[:-2].reshape(-1, 4), found[-1]
        assert hip[-1, :2] == pytest.approx([2.0 * length, hip[0, 1]], abs=1e-6) and hip[0, 0] == 0.0
        assert np.diff(hip[:, 0]).min() > 0.0 and np.diff(hip[:, 0]).max() < 3.0 * 2.0 * length / len(hip)
    constraint, penalty = cycles.middle
    point = cycles.rolling.point  # a mid-stance of the first leg leads to a step on the other
    assert constraint == pytest.approx(0.5 * point.steps[-1].period / point.period)
    assert penalty == pytest.approx(constraint, abs=2e-3) and (abs(constraint - 0.5) > 5e-3) == bool(other_foot_mass)
    cycles.phase = np.array(cycles.middle) + 1e-4
    assert not cycles.compared().any(), "velocities right after a strike"


def test_integration_errors_shrink_with_the_tolerance(parameters, scene):
    law = parameters.contact
    exact, fine = scene.penalty(law, 1e-8), scene.coarse_or_fine(1e-13)
    for errors in (
        [np.abs(scene.penalty(law, tolerance) - exact)[:, 0].max() for tolerance in (1e-4, 1e-6)],
        [np.abs(scene.coarse_or_fine(tolerance) - fine)[:, 0].max() for tolerance in (1e-6, 1e-9)],
    ):
        assert errors[1] < errors[0] / 3, errors


def test_slip_of_the_trailing_foot_does_nothing_before_heel_strike(scene):
    slip = scene.coarse_or_fine(1e-12, coulomb=True) - scene.coarse_or_fine(1e-12)
    before = scene.time < scene.constraint.heel_strikes[0]
    assert np.abs(slip[before]).max() < 1e-11 < np.abs(slip[~before, 0]).max()


def test_a_walker_that_falls_is_a_result_with_its_reason(parameters, monkeypatch):
    def fall(*_):
        raise NoLimitCycle("over one step: the walker fell")

    monkeypatch.setattr(OneStep, "penalty", fall)
    result = run(parameters)
    assert result.step is None and result.cycle is None and result.outcome != "completed"
    assert artefact.decode(artefact.encode(result, {}), Result, "error_budget.h5").outcome == result.outcome
    assert result.outcome in result.summary() and result.tables() == ()
    for draw in (model_difference.draw_error_budget, model_difference.draw_error_bars):
        with pytest.raises(NoEvidence) as refused:
            draw(SimpleNamespace(error_budget=result))
        assert str(refused.value) == result.outcome


@pytest.fixture(scope="module")
def budget(parameters):
    return run(parameters)


@pytest.mark.slow
def test_the_whole_difference_is_explained(budget, parameters, scene):
    """The parts add up to the difference of two walks made apart from the path; at most 2 % of it has no name."""
    assert budget.outcome == "completed", budget.outcome
    direct = scene.penalty(parameters.contact, parameters.penalty_tolerance) - scene.constraint.hip(scene.time)
    direct[~budget.step.split.compared, VELOCITY] = np.nan
    for parts in budget.step.split.orders:
        assert parts.sum(axis=0) == pytest.approx(direct, abs=1e-9, nan_ok=True)
    for _, found in budget.known():
        split = found.split
        assert min(split.explained(column) for column in EACH) >= 0.98, [split.explained(column) for column in EACH]
        for effect in (INTEGRATION_CONSTRAINT, INTEGRATION_PENALTY):
            assert split.rms(split.part(effect), POSITION) < 0.01 * split.rms(split.total, POSITION)


@pytest.mark.slow
def test_effects_are_alike_over_orders(budget):
    """Half the interval is below 8 % of an effect on the hip's end over a step, below 12 % on the period and length."""
    split, cycle = budget.step.split, budget.cycle
    rows = [EFFECTS.index(effect) for effect in CONTACT]
    assert abs(split.interaction[-1, 0]) < 0.08 * np.abs(split.parts[rows, -1, 0]).min()
    assert np.all(np.abs(cycle.scalar_interaction) < 0.12 * np.abs(cycle.scalars[rows]).min(axis=0))


@pytest.mark.slow
def test_the_last_share_is_predicted(budget):
    """To 5 % of the whole difference, and orders are those of effects that vanish with their share."""
    for _, found in budget.known():
        whole = [found.split.rms(found.split.total, column) for column in EACH]
        assert np.all(found.convergence.missed < 0.05 * np.array(whole))
        assert found.convergence.order[1] == pytest.approx(np.ones(4), abs=0.15)


@pytest.mark.slow
def test_figures_and_storage(budget):
    read = artefact.decode(artefact.encode(budget, {}), Result, "error_budget.h5")
    assert np.array_equal(read.cycle.scalars, budget.cycle.scalars)
    assert len(budget.tables()) == 4 and all(
        len(row) == len(columns) for _, columns, rows in budget.tables() for row in rows
    )
    with style.drawing():
        drawn = model_difference.draw_error_budget(SimpleNamespace(error_budget=budget))
    panel = drawn.axes[0]
    total = next(line for line in panel.lines if line.get_label() == "total")
    parts = [line for line in panel.lines if line.get_label() != "total"]
    missing = 1e3 * sum(budget.step.split.part(e)[:, 0] for e in EFFECTS if e.startswith("integration"))
    assert sum(line.get_ydata() for line in parts) + missing == pytest.approx(total.get_ydata(), abs=1e-9)
    assert SLIP in [line.get_label() for line in parts]


def test_bars_add_up_to_the_total():
    """In every panel; whiskers reach from one order to the other."""
    with style.drawing():
        drawn = model_difference.draw_error_bars(SimpleNamespace(error_budget=make_budget()))
    assert len(drawn.axes) == 5
    for panel, (_, ways) in zip(drawn.axes, model_difference.measures(make_budget())):
        widths = [bar.get_width() for bar in panel.patches]
        assert sum(widths[:-1]) == pytest.approx(widths[-1]) and widths[-1] == pytest.approx(ways.sum(axis=1).mean())
        assert ways.sum(axis=1) == pytest.approx(np.full(2, widths[-1]))


# --- The study's own parameters, and a step in a scene that is walked once.


@pytest.fixture(scope="session")
def parameters():
    return parameters_of("error_budget")


@pytest.fixture(scope="session")
def scene(parameters):
    return OneStep(parameters)


def test_the_window_of_an_impact_follows_the_robot(parameters):
    """An impact of a robot four times as long lasts twice as long; one that is given stays."""
    assert parameters.settings.impact_window == pytest.approx(1e-3, rel=1e-12)
    settings = dataclasses.replace(parameters.settings, impact_window=None)
    longer = dataclasses.replace(parameters.biped, leg_length=4.0 * parameters.biped.leg_length)
    other = dataclasses.replace(parameters, biped=longer, settings=settings)
    assert other.settings.impact_window == pytest.approx(2e-3, rel=1e-12)
    assert dataclasses.replace(parameters, biped=longer).settings.impact_window == parameters.settings.impact_window
