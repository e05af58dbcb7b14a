"""Derivatives by parameters: against extrapolated differences, and against the rules that dimensions set."""

import dataclasses

import numpy as np
import pytest

from stages.analytic.derivatives.gait import gait_derivatives, step_tangents, walk_derivatives
from stages.analytic.derivatives.multipliers import APART, LEADING, along_the_gait, multiplier_derivatives
from stages.analytic.derivatives.numbers import changes_of, moved, sensitive_names
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.gait_search import describe
from stages.analytic.gait.poincare import fixed_point, poincare_derivative, poincare_map
from stages.analytic.model.kinds import directions
from stages.analytic.phases.impact import LIFTS, SLIPS, STICKS, heel_strike_reset, land, trailing_impulse
from stages.analytic.phases.motion import DOUBLE_STANCE, HOVERING, SLIDING_BACK, SLIDING_FORWARD
from stages.analytic.phases.section import section_state
from stages.analytic.walk.recording import record
from stages.ground.slope import Friction
from tests.analytic.designs import (
    FRICTION,
    HEAVY_LEGS,
    SLOPE,
    TABLE_1,
    TABLE_1_RIGID,
    changed,
    found_gait,
    gait_beside,
    stiff_gait,
    walker_of,
)
from tests.analytic.differences import extrapolated
from tests.analytic.test_detailed import LAME, LAME_RIGID
from tests.analytic.test_hip_friction import FREE
from tests.analytic.test_transitions import landing_states
from tests.similar import factor

DESIGNS = {
    "rolling": DesignPoint(TABLE_1, SLOPE),
    "rolling, heavy legs": DesignPoint(HEAVY_LEGS, SLOPE),
    "stiff": DesignPoint(changed(TABLE_1, damping=1e5), SLOPE),
    "rigid": DesignPoint(TABLE_1_RIGID, SLOPE),
    "rigid, heavy legs": DesignPoint(dataclasses.replace(HEAVY_LEGS, legs="rigid"), SLOPE),
    "friction of the paper": DesignPoint(TABLE_1, SLOPE, Friction(1.1, 1.0)),
    "one coefficient": DesignPoint(TABLE_1, SLOPE, Friction(0.5, 0.4, "coulomb")),
    "low friction": DesignPoint(TABLE_1, SLOPE, Friction(0.5, 0.4)),
    "ice": DesignPoint(TABLE_1, SLOPE, Friction(0.05, 0.05)),
}


def gait_of(kind):
    """(design, its gait)."""
    design = DESIGNS[kind]
    _, point = stiff_gait(design.biped, 1e-12) if kind == "stiff" else found_gait(design.biped, design.friction)
    return design, point


def share_of(name):
    """Steps of the differences, as shares: at given leg lengths, a longer natural length presses the stiff springs."""
    return 2e-5 if name == "biped.leg_length" else 1e-3


@pytest.mark.parametrize(
    "kind", [pytest.param(kind, marks=pytest.mark.slow) if kind == "stiff" else kind for kind in DESIGNS])
def test_step_map_and_period_answer_to_every_parameter_as_differences_say(kind):
    """To 1e-7 of the largest entry of the row, through flow, guards, impacts and sliding; to the start as well.
    Implicit steps of stiff legs carry them too."""
    design, point = gait_of(kind)
    walker = design.walker()
    changes = changes_of(design, sensitive_names(design))
    exact = step_tangents(walker, point.z, changes.along, 1e-12)
    columns = []
    for name, along in zip(changes.names, changes.along):

        def image(share, along=along):
            step = poincare_map(moved(walker, share * along), point.z, 1e-13)
            return np.append(step.z, step.period)

        columns.append(extrapolated(image, share_of(name), 3))
    found, given = np.column_stack(columns), np.vstack([exact.along, exact.time_along])
    largest = np.abs(given).max(axis=1, keepdims=True)
    assert (np.abs(found - given) <= 1e-7 * largest + 1e-14).all(), np.abs(found - given) / largest
    assert (largest[[0, -1]] > 0.1).all()
    _, plain = poincare_derivative(walker, point.z, 1e-12)
    assert np.abs(exact.by_start - plain).max() <= 1e-10 * np.abs(plain).max()
    e = np.eye(point.z.size)[0]
    found = extrapolated(lambda h: poincare_map(walker, point.z + h * e, 1e-13).period, 1e-3, 3)
    assert found == pytest.approx(exact.time_by_start[0], rel=1e-7)


def test_sliding_both_ways_hovering_and_rolling_are_all_walked_through():
    seen = set()
    for kind in DESIGNS:
        design, point = gait_of(kind)
        if design.friction:
            walker = design.walker()
            seen |= {segment.phase for segment in record(walker, section_state(point.z, walker.p), 1, 1e-10)}
    assert {DOUBLE_STANCE, SLIDING_FORWARD, HOVERING} <= seen
    assert SLIDING_BACK in seen


@pytest.mark.parametrize("kind", ["rolling, heavy legs", "rigid, heavy legs", "friction of the paper"])
def test_gait_answers_to_every_parameter_as_gaits_of_changed_designs_say(kind):
    """Period, step length and speed [SI], each changed design scaled to its own units; to 1e-7 of the row."""
    design, point = gait_of(kind)
    names = names_with_shares(design)
    given = gait_derivatives(design, point, names, 1e-12).elasticities()
    walked = beside(design, names)

    def logarithms(share):
        gait = describe(*walked(share, point.z))
        return np.log([getattr(gait, name) for name in given])

    for (name, row), found in zip(given.items(), extrapolated(logarithms, 5e-4, 3), strict=True):
        assert abs(row @ signs(names) - found) <= 1e-7 * np.abs(row).max(), name


def signs(names):
    """A sign for each parameter: all of them are changed at once, by shares of one size."""
    return np.random.default_rng(3).choice([-1.0, 1.0], len(names))


def beside(design, names):
    """What finds the walker changed by so large shares, and its gait near `z`."""

    def walked(share, z):
        there = design
        for name, sign in zip(names, signs(names), strict=True):
            there = with_share(there, name, sign * share)
        walker = there.walker()
        return walker, fixed_point(walker, z, 1e-13)

    return walked


def names_with_shares(design):
    """The parameters that are not zero: a share of zero is none."""
    return tuple(name for name in sensitive_names(design) if with_share(design, name, 0.1) != design)


def with_share(design, parameter, share):
    """The design with one parameter changed by a share, friction too."""
    file, _, key = parameter.partition(".")
    if file == "ground" and key.endswith("friction"):
        value = getattr(design.friction, key) * (1 + share)
        return dataclasses.replace(design, friction=dataclasses.replace(design.friction, **{key: value}))
    return design.with_value(parameter, design.value(parameter) * (1 + share))


@pytest.mark.parametrize("kind", ["rolling", "rigid, heavy legs", "friction of the paper"])
def test_leading_multipliers_answer_as_those_of_changed_designs(kind):
    design, point = gait_of(kind)
    names = names_with_shares(design)
    found = multiplier_derivatives(gait_derivatives(design, point, names, 1e-12))
    assert found.refused == () and (np.abs(found.values) >= LEADING * np.abs(found.values[0])).all()
    assert len(found.values) >= 2
    walked = beside(design, names)

    def multipliers(share):
        every = walked(share, point.z)[1].floquet_multipliers
        return np.array([every[np.abs(every - value).argmin()] for value in found.values])

    off = np.abs(found.derivatives @ signs(names) - extrapolated(multipliers, 1e-3, 3))
    assert off.max() <= 1e-6


#: Designs of every kind by their parameters, the tolerance of their gaits, and what sums of elasticities may leave.
OF_DIMENSIONS = [
    *(((design.biped, design.friction), tolerance, left)
      for design in map(DESIGNS.get, ("rolling, heavy legs", "rigid, heavy legs", "friction of the paper"))
      for tolerance, left in ((1e-13, 1e-10), (1e-8, 1e-7))),
    *(((biped, friction), 1e-13, 1e-9) for biped, friction in (
        (LAME_RIGID, None), (LAME, None), (LAME, FRICTION), (changed(FREE["rigid"], hip_friction=1e-3), None))),
    ((changed(FREE["compliant"], hip_friction=1e-3), None), 1e-13, 1e-8),
    ((changed(FREE["rigid"], feet_retract=True, strike_time=0.499), None), 1e-13, 1e-8),
]  # fmt: skip


@pytest.mark.parametrize(("of", "tolerance", "left"), OF_DIMENSIONS)
def test_units_may_be_chosen(of, tolerance, left):
    """Masses, lengths and times in other units: the elasticities of all that has a unit add up accordingly."""
    biped, friction = of
    design = DesignPoint(biped, SLOPE, friction)
    point = gait_beside(biped, found_gait(biped, friction)[1].z, friction, tolerance)[1]
    gait = gait_derivatives(design, point, names_with_shares(design), tolerance)

    def exponents(unit):
        """Of mass, length and time, by the table of these tests."""
        return np.log([factor(unit, scale) for scale in np.exp(np.eye(3))])

    by_units = np.array([exponents(unit) for unit in gait.changes.units])
    for measure, unit in (("period_s", "s"), ("step_length_m", "m"), ("speed_m_s", "m/s"), ("step_frequency_hz", "Hz")):
        assert np.abs(gait.elasticities()[measure] @ by_units - exponents(unit)).max() <= left, measure
    if tolerance < 1e-12 and not gait.walker.alternates:
        assert np.abs(multiplier_derivatives(gait).elasticities() @ by_units).max() <= 1e-6


@pytest.mark.parametrize("kind", ["rolling, heavy legs", "friction of the paper"])
def test_a_walk_off_the_gait_answers_to_start_and_parameters(kind):
    """Coordinates and time after five steps."""
    design, point = gait_of(kind)
    walker, z, steps = design.walker(), point.z.copy(), 5
    z[0] *= 1.01
    changes = changes_of(design, ["biped.foot_com", "ground.slope_deg"])
    walk = walk_derivatives(walker, z, changes.along, steps, 1e-12)

    def end(walker, z):
        time = 0.0
        for _ in range(steps):
            step = poincare_map(walker, z, 1e-13)
            z, time = step.z, time + step.period
        return np.append(z, time)

    for row, along in enumerate(changes.along):

        def ended(share, along=along):
            return end(moved(walker, share * along), z)

        given = np.append(walk[-1].along[:, row], walk[-1].time_along[row])
        assert np.abs(given - extrapolated(ended, 1e-3, 3)).max() <= 1e-6 * np.abs(given).max()
    e = np.eye(z.size)[0]
    given = np.append(walk[-1].by_start[:, 0], walk[-1].time_by_start[0])
    assert np.abs(given - extrapolated(lambda h: end(walker, z + h * e), 1e-3, 3)).max() <= 1e-6 * np.abs(given).max()


@pytest.mark.parametrize("kind", [LIFTS, SLIPS, STICKS])
def test_impact_with_limited_friction_answers_to_the_numbers(kind):
    """Variations through the impact equal its differences, whatever the trailing foot does, for random changes."""
    design = DesignPoint(HEAVY_LEGS, SLOPE, Friction(8.0, 6.0))
    walker, rng, seen = design.walker(), np.random.default_rng(5), 0
    numbers = np.array(walker.p)
    for y in landing_states(walker_of(HEAVY_LEGS), 150):
        along, direction = rng.normal(size=(1, numbers.size)) * numbers, rng.normal(size=8)

        kinds: list[int] = []

        def reset(share, y=y, along=along, direction=direction, kinds=kinds):
            p = walker.p._make(numbers + share * along[0])
            state = y + share * direction
            landed = state.copy()
            land(landed, p)
            kinds.append(trailing_impulse(landed, p)[0])
            heel_strike_reset(state, p)
            return state

        found = extrapolated(reset, 1e-4, 3)
        if set(kinds) != {kind}:
            continue
        seen += 1
        carried = np.concatenate([y, direction])
        assert heel_strike_reset(carried, walker.p, directions(along, 1))
        assert np.abs(carried[8:] - found).max() <= 1e-7 * max(1.0, np.abs(found).max())
        landed = np.concatenate([y, direction])
        land(landed, walker.p, directions(along, 1))
        assert kind == LIFTS or np.abs(landed[8:] - carried[8:]).max() > 1e-6
    assert seen >= 5


def test_parameters_without_influence_are_refused():
    with pytest.raises(KeyError, match=r"biped\.stiffness.*no such parameter; it has biped\.hip_mass"):
        changes_of(DESIGNS["rigid"], ["biped.stiffness"])
    with pytest.raises(KeyError, match=r"ground\.static_friction"):
        changes_of(DESIGNS["rolling"], ["ground.static_friction"])
    assert "ground.dynamic_friction" in sensitive_names(DESIGNS["ice"])


def test_multipliers_that_meet_have_no_derivatives_and_a_sentence_says_so():
    """Two leading multipliers are brought together by hand, in the matrix of a true gait."""
    design, point = gait_of("rigid")
    gait = gait_derivatives(design, point, ("ground.slope_deg",), 1e-12)
    values, vectors = np.linalg.eig(gait.by_state)
    order = np.argsort(-np.abs(values))
    values[order[1]] = values[order[0]] + 0.5 * APART
    matrix = np.real(vectors @ np.diag(values) @ np.linalg.inv(vectors))
    near = dataclasses.replace(gait, by_state=matrix)
    found = multiplier_derivatives(near)
    assert len(found.refused) == 2 and "has no derivative of its own" in found.refused[0]
    assert np.isnan(found.derivatives[:2]).all() and np.isfinite(found.derivatives[2:]).all()


@pytest.mark.parametrize("power", [1, 2, 6], ids=["bend", "smooth", "smoother"])
def test_what_is_left_of_a_multipliers_derivative_holds_beside_a_bend(power):
    """There differences fall by two where the step is halved, and extrapolation gains nothing."""
    one = np.ones((1, 1))
    found, left = along_the_gait(lambda share: one + 1e3 * abs(share) ** power, one, one)
    assert abs(found[0] - 1.0) < left + 1e-12 < 0.2
