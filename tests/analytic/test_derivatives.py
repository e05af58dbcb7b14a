"""Derivatives by parameters, against differences and the rules that dimensions set; and of the step map."""

import dataclasses

import numpy as np
import pytest

from benchmarks.round_off import eliminate, orders_of_summation, precisions, similarity, step, system
from stages.analytic.derivatives.gait import gait_derivatives, step_tangents, walk_derivatives
from stages.analytic.derivatives.multipliers import APART, LEADING, along_the_gait, multiplier_derivatives
from stages.analytic.derivatives.numbers import changes_of, moved, sensitive_names
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.gait_report import audit
from stages.analytic.gait.gait_search import describe, find_gaits, step_length
from stages.analytic.gait.poincare import fixed_point, poincare_derivative, poincare_map
from stages.analytic.integration.readable import accelerations
from stages.analytic.model import terms as eq
from stages.analytic.model.kinds import directions
from stages.analytic.phases.impact import LIFTS, SLIPS, STICKS, heel_strike_reset, land, trailing_impulse
from stages.analytic.phases.motion import DOUBLE_STANCE, HOVERING, RIGID, SLIDING_BACK, SLIDING_FORWARD
from stages.analytic.phases.section import section_state
from stages.analytic.walk.recording import record
from stages.analytic.walk.validity import dense_states
from stages.ground.slope import Friction
from tests.analytic.designs import (
    FRICTION,
    HEAVY_LEGS,
    SLOPE,
    TABLE_1,
    TABLE_1_RIGID,
    changed,
    double_stance_states,
    found_gait,
    gait_beside,
    stiff_gait,
    walker_of,
)
from tests.analytic.differences import extrapolated, map_slope
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


# --- The step map: its fixed point and its derivative, however they are computed, up to the edges of what is legal.


#: Walkers, and sizes of differences: stiff springs make the map curved on the scale of their deflection.
KINDS = [(TABLE_1, None, (4e-4, 8e-6, 8e-6, 4e-4, 4e-4)), (TABLE_1_RIGID, None, (4e-4,) * 3),
         *((TABLE_1, Friction(*pair), (2e-4, 4e-6, 4e-6, 2e-4, 2e-4, 2e-5, 2e-4))
           for pair in ((1.1, 1.0), (1.1, 1.1), (0.0, 0.0), (0.5, 0.4)))]  # fmt: skip
#: Walkers with the paper's friction, or none: design, friction.
WALKERS = pytest.mark.parametrize("biped, friction", [(TABLE_1, None), (TABLE_1_RIGID, None), (TABLE_1, FRICTION)])


def test_gait_of_table_1(table_1_gait):
    """Step frequency within 1% of the paper's 2.08 Hz at 2 degrees, nothing fitted; stable, as the paper says."""
    walker, point = table_1_gait
    assert 1 / (point.steps[0].period * walker.time) == pytest.approx(2.08, rel=0.01)
    assert np.abs(point.floquet_multipliers).max() < 1


@pytest.mark.parametrize(("biped", "friction", "sizes"), KINDS)
def test_a_fixed_point_closes_and_its_derivative_is_that_of_central_differences(biped, friction, sizes):
    """Through all events, of feet that slip too."""
    walker, point = found_gait(biped, friction)
    _, exact = poincare_derivative(walker, point.z, 1e-13)
    assert point.residual <= 1e-11
    assert np.abs(exact - map_slope(walker, point.z, sizes)).max() <= 1e-7 * np.abs(exact).max()


@WALKERS
def test_period_and_multipliers_do_not_depend_on_the_tolerance(biped, friction):
    """Trap 3: an event located to 1e-6 would show here at every tolerance."""
    walker, start = found_gait(biped, friction)
    coarse, alike, less = (1e-10, 1e-10, 3e-10) if friction is None else (1e-9, 1e-9, 1e-8)
    loose, tight = fixed_point(walker, start.z, coarse), fixed_point(walker, start.z, 1e-13)
    assert loose.steps[0].period == pytest.approx(tight.steps[0].period, rel=alike)
    largest = [np.sort(np.abs(point.floquet_multipliers))[::-1][:2] for point in (loose, tight)]
    assert np.abs(largest[0] / largest[1] - 1).max() <= less


def test_constraints_hold_through_double_stance(table_1_step, table_1_gait):
    """Height of the trailing foot, its rolled distance against its turning, and both rates stay within 1e-10."""
    walker, _ = table_1_gait
    states, radius = dense_states(walker, table_1_step[0]), walker.p.r
    theta, stance, psi, swing = states[:, :4].T
    height = (stance - radius) * np.cos(theta) - (swing - radius) * np.cos(psi)
    travel = radius * (theta + psi) + (stance - radius) * np.sin(theta) + (swing - radius) * np.sin(psi)
    assert np.abs(height).max() <= 1e-10
    assert np.abs(travel - travel[0]).max() <= 1e-10
    for y in states:
        c = np.array(eq.contact_terms(*y, walker.p))
        assert abs(c[0:4] @ y[4:]) <= 1e-10 and abs(c[4:8] @ y[4:]) <= 1e-10


# --- Rigid legs at the edges of what is legal: no hip mass, point feet, mass at the foot's bottom, leg inertia.


EDGES = {
    "no hip mass": {"hip_mass": 0.0},
    "point feet": {"foot_radius": 0.0},
    "mass at the foot's bottom": {"foot_com": 0.0},
    "no hip mass, point feet, inertia": {"hip_mass": 0.0, "foot_radius": 0.0, "leg_inertia": 1e-3},
    "high mass centre, inertia": {"foot_com": 0.2, "leg_inertia": 3e-3},
}


@pytest.mark.parametrize("name", EDGES)
def test_gait_closes_and_keeps_its_books(name):
    """A gait is found; its energy audit closes; its exact derivative is that of differences."""
    walker = walker_of(changed(TABLE_1_RIGID, **EDGES[name]))
    point = find_gaits(walker, 1e-12, unstable=True)[0]
    assert point.residual <= 1e-11
    segments = record(walker, section_state(point.z, walker.p), 1, 1e-12, RIGID)
    assert abs(audit(walker, segments, step_length(walker, point)).residual) <= 1e-9
    _, exact = poincare_derivative(walker, point.z, 1e-13)
    found = map_slope(walker, point.z, (1e-5,) * 3)
    assert np.abs(found - exact).max() <= 1e-5 * max(1.0, np.abs(exact).max())


def test_all_of_it_at_once_is_refused_with_a_reason():
    """No hip mass, point feet and all mass at the foot's bottom: two loose masses, no gait at 1 degree."""
    from stages.analytic.gait.gait_search import why_no_gait

    walker = walker_of(changed(TABLE_1_RIGID, hip_mass=0.0, foot_radius=0.0, foot_com=0.0), slope_deg=1.0)
    assert find_gaits(walker, 1e-11, unstable=True) == []
    assert "no periodic gait in the range searched" in why_no_gait(walker)


# --- Round-off of one step: similar bipeds, three precisions, orders of summation.


EXTENDED = pytest.mark.skipif(np.finfo(np.longdouble).nmant < 60, reason="longdouble is double on this machine")


@pytest.mark.parametrize("factors", [(1e-3, 1e-2, 0.165), (1e6, 30.0, 2.53)])
def test_similar_bipeds_walk_alike(factors):
    """Scaled in mass, length and gravity, the dimensionless gait is the same."""
    assert similarity(factors) < 1e-10


def test_elimination_solves(table_1_gait):
    """Against numpy's solver through the readable accelerations."""
    walker = table_1_gait[0]
    for y in double_stance_states(walker, 10):
        qdd, force = accelerations(walker, y, True)
        found = eliminate(*system(walker, y, True, np.float64))
        assert found == pytest.approx(np.concatenate([qdd, force]), rel=1e-10, abs=1e-12)


def test_fixed_steps_follow_the_gait(table_1_gait):
    """The scheme that measures round-off integrates the gait: its end is the compiled step's, to its truncation."""
    walker, point = table_1_gait
    taken = point.steps[0]
    start = section_state(point.z, walker.p)
    end = step(walker, start, (taken.double_stance, taken.period - taken.double_stance), np.float64)
    clearance = (end[1] - walker.p.r) * np.cos(end[0]) - (end[3] - walker.p.r) * np.cos(end[2])
    assert abs(clearance) < 1e-6, "the step ends at heel strike"
    assert -end[2] == pytest.approx(taken.state[0], abs=1e-6), "whose new stance leg is the compiled step's"


@EXTENDED
def test_double_precision_is_enough_and_single_is_not(table_1_gait):
    """Round-off scales with the precision: 2^29 lies between single and double."""
    found = precisions(*table_1_gait)
    assert found["double"] < 1e-12
    assert 1e-6 < found["single"] < 1e-2
    assert 1e7 < found["single"] / found["double"] < 1e10


def test_order_of_summation_does_not_matter(table_1_gait):
    assert orders_of_summation(table_1_gait[0], double_stance_states(table_1_gait[0], 20)) < 1e-12
