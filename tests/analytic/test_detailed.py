"""The detailed design: what it shares with Table 1, legs exchanged, gaits that alternate, derivatives."""

import numpy as np
import pytest

from stages.analytic.derivatives.gait import gait_derivatives
from stages.analytic.derivatives.numbers import sensitive_names
from stages.analytic.gait.continuation import CLOSED, TURNING_POINT, continue_gait, follow_family
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.gait_report import limp_of
from stages.analytic.gait.gait_search import step_length, step_lengths
from stages.analytic.gait.poincare import fixed_point, iterate, poincare_derivative, poincare_map
from stages.analytic.model import terms as eq
from stages.analytic.model.kinds import DetailedCompliant, DetailedRigid, with_legs_exchanged
from stages.analytic.model.walker import build_walker
from stages.analytic.phases.motion import RIGID, flow
from stages.analytic.phases.section import section_state
from stages.analytic.walk.recording import record
from stages.analytic.walk.sampling import sample_walk
from tests.analytic.designs import (
    FRICTION,
    HEAVY_LEGS,
    SLOPE,
    TABLE_1,
    changed,
    found_gait,
    gait_beside,
    random_states,
)
from tests.analytic.differences import extrapolated, gait_slope, together

#: Every detail at work, and a gait with it.
LAME = changed(
    TABLE_1, leg_inertia=2e-4, foot_offset=3e-4, frame_mass=0.01, frame_com=0.02, frame_offset=1e-3, frame_inertia=2e-5,
    hip_stiffness=0.05, hip_damping=5e-4, hip_rest_angle=0.02, hip_gravity_mass=0.31, other_leg_length=0.3331,
    other_foot_mass=0.334, other_foot_radius=0.0825, other_foot_com=0.101, other_stiffness=2900.0, other_damping=60.0,
    other_leg_inertia=2.5e-4, other_foot_offset=2e-4, other_frame_mass=0.012, other_frame_com=0.018,
    other_frame_offset=8e-4, other_frame_inertia=2.3e-5)  # fmt: skip
LAME_RIGID = changed(LAME, legs="rigid")
#: The kinds of walkers there are with details.
KINDS = pytest.mark.parametrize(("legs", "friction", "kind"), [
    ("rigid", None, DetailedRigid), ("compliant", None, DetailedCompliant), ("compliant", FRICTION, DetailedCompliant)])


@pytest.fixture(scope="module")
def lame():
    return found_gait(LAME)


# --- Table 1 through the detailed kind -----------------------------------------------------------------------------

@KINDS
def test_without_details_the_detailed_equations_are_table_1s(legs, friction, kind):
    """Step, derivative and gait differ by round-off, so a plain design may be walked as either."""
    biped = changed(HEAVY_LEGS, legs=legs)
    plain, point = found_gait(biped, friction)
    detailed = build_walker(biped, SLOPE, friction, detailed=True)
    assert type(detailed.p) is kind and not detailed.alternates
    (step, derivative), (own, own_derivative) = (poincare_derivative(w, point.z, 1e-12) for w in (plain, detailed))
    assert np.abs(step.z - own.z).max() < 1e-13 and abs(step.period - own.period) < 1e-13
    assert np.abs(derivative - own_derivative).max() < 1e-9
    again = fixed_point(detailed, point.z, 1e-12)
    assert step_length(detailed, again) == pytest.approx(step_length(plain, point), abs=1e-13)


# --- parts that are the same in other words ------------------------------------------------------------------------

@pytest.mark.parametrize("legs", ["rigid", "compliant"])
def test_a_frame_whose_mass_is_at_the_hip_is_hip_mass(legs):
    whole = changed(TABLE_1, legs=legs)
    parted = changed(whole, hip_mass=0.216, frame_mass=0.05)
    (a, one), (b, other) = found_gait(whole), found_gait(parted)
    assert other.z == pytest.approx(one.z, abs=1e-12)
    assert other.period * b.time == pytest.approx(one.period * a.time, abs=1e-12)


def test_masses_of_a_rigid_leg_may_be_parted_at_will():
    """A frame and a foot mass on a rigid leg are one body: their joint centre and inertia make the same walker."""
    frame, com, offset, turn = 0.06, 0.09, 0.002, 3e-5
    parted = changed(TABLE_1, legs="rigid", frame_mass=frame, frame_com=com, frame_offset=offset, frame_inertia=turn)
    whole, below = 0.335 + frame, 0.333 - 0.1
    down, forward = (0.335 * below + frame * com) / whole, frame * offset / whole
    inertia = turn + frame * ((com - down) ** 2 + (offset - forward) ** 2) + 0.335 * (
        (below - down) ** 2 + forward**2)  # fmt: skip
    joined = changed(TABLE_1, legs="rigid", foot_mass=whole, foot_com=0.333 - down, foot_offset=forward,
                     leg_inertia=inertia)  # fmt: skip
    walkers = [build_walker(biped, SLOPE) for biped in (parted, joined)]
    for y in random_states(walkers[0], 10):
        rates = [np.empty(4), np.empty(4)]
        for walker, found in zip(walkers, rates, strict=True):
            flow(RIGID, y, walker.p, found)
        assert rates[0] == pytest.approx(rates[1], abs=1e-13)


@KINDS
def test_exchanged_in_code_is_exchanged_in_design(legs, friction, kind):
    walker = build_walker(changed(LAME, legs=legs), SLOPE, friction)
    assert eq.exchanged(walker.p) == with_legs_exchanged(walker.p) == walker.exchanged.p
    assert walker.exchanged.exchanged == walker and walker.alternates
    other = build_walker(changed(LAME, legs=legs).exchanged, SLOPE, friction)
    scale = np.array(other.p)  # in units of the other leg
    assert scale[0] * other.mass == pytest.approx(walker.p.M * walker.mass)
    assert other.p.m * other.mass == pytest.approx(walker.exchanged.p.m * walker.mass)
    assert other.p.phi_h == walker.exchanged.p.phi_h


@pytest.mark.parametrize("friction", [None, FRICTION])
def test_the_same_machine_with_its_legs_exchanged_has_the_same_gait(friction):
    walker, point = found_gait(LAME, friction)
    other, mirrored = found_gait(LAME.exchanged, friction)
    near = [step.period * walker.time for step in point.steps]
    assert [step.period * other.time for step in mirrored.steps] == pytest.approx(near[::-1], abs=1e-12)
    assert mirrored.floquet_multipliers[:3] == pytest.approx(point.floquet_multipliers[:3], abs=1e-9)
    lengths = np.array(step_lengths(walker, point)) * walker.length
    assert np.array(step_lengths(other, mirrored))[::-1] * other.length == pytest.approx(lengths, abs=1e-12)


# --- gaits that alternate ------------------------------------------------------------------------------------------

@KINDS
def test_a_stride_closes_and_its_derivative_is_that_of_differences(legs, friction, kind):
    walker, point = found_gait(changed(LAME, legs=legs), friction)
    assert len(point.steps) == 2 and point.residual < 1e-11 and type(walker.p) is kind
    wanted = np.zeros_like(point.monodromy_matrix)

    def stride(z):
        first = poincare_map(walker, z, 1e-13)
        return poincare_map(walker.exchanged, first.z, 1e-13).z

    free = point.z.size if friction is None else 5  # a foot at rest has no neighbours that slip
    for column in range(free):
        unit = np.eye(point.z.size)[column]
        wanted[:, column] = extrapolated(lambda h: stride(point.z + h * unit), 2e-5)  # noqa: B023
    assert np.abs(point.monodromy_matrix - wanted)[:, :free].max() < 2e-7


def test_a_gait_of_alike_legs_is_a_stride_of_two_equal_steps():
    """Legs a hair apart: the stride's multipliers are the squares of the step's, and it hardly limps."""
    walker, point = found_gait(changed(TABLE_1, frame_mass=0.01, frame_com=0.02))
    near = changed(TABLE_1, frame_mass=0.01, frame_com=0.02, other_frame_com=0.02 + 1e-9)
    apart, stride = found_gait(near)
    assert apart.alternates and len(stride.steps) == 2 and limp_of(walker, point).limp == 0.0
    squares = np.sort(point.floquet_multipliers.real[:2] ** 2)
    assert np.sort(stride.floquet_multipliers.real[:2]) == pytest.approx(squares, abs=1e-6)
    assert 0 < limp_of(apart, stride).limp < 1e-6


def test_the_longer_leg_makes_the_longer_double_step(lame):
    """Lengths of the two steps add up to the hip's way over a stride, as the recorded walk has it."""
    walker, point = lame
    walk = sample_walk(walker, record(walker, section_state(point.z, walker.p), 4, 1e-12), 1000.0)
    strikes = np.searchsorted(walk.time, walk.heel_strike_time[:3])
    stride = point.period * 2 * walker.time
    assert walk.heel_strike_time[2] - walk.heel_strike_time[0] == pytest.approx(stride, abs=1e-9)
    way = np.interp(walk.heel_strike_time[[0, 2]], walk.time, walk.hip_position[:, 0])
    assert way[1] - way[0] == pytest.approx(sum(step_lengths(walker, point)) * walker.length, abs=1e-5)
    assert walk.leg_length[strikes[0] - 1, 0] != walk.leg_length[strikes[1] - 1, 1]


def test_a_walk_of_rigid_legs_keeps_their_lengths_and_stands_on_the_ground():
    walker, point = found_gait(LAME_RIGID)
    walk = sample_walk(walker, record(walker, section_state(point.z, walker.p), 4, 1e-12), 1000.0)
    lengths, radii = np.array(LAME_RIGID.leg_lengths), np.array(LAME_RIGID.foot_radii)
    assert walk.leg_length == pytest.approx(np.tile(lengths, (len(walk.time), 1)))
    height = walk.hip_position[:, 1, None] - (lengths - radii) * np.cos(walk.leg_angle) - radii
    assert np.abs(height).min(axis=1) == pytest.approx(np.zeros(len(walk.time)), abs=1e-12)
    for leg in (0, 1):
        state = walker.on(leg).stance_state(section_state(point.z, walker.p))
        assert (state.stance_length, state.swing_length) == pytest.approx(np.roll(lengths, leg), rel=1e-15)


def test_a_stride_can_be_iterated_from_either_leg(lame):
    walker, point = lame
    steps, _ = iterate(walker.exchanged, point.steps[0].z, 2, 1e-12)
    assert steps[1].z == pytest.approx(point.steps[0].z, abs=1e-11)


def test_a_design_stays_detailed_where_a_detail_passes_zero():
    design = DesignPoint(TABLE_1, SLOPE)
    assert not isinstance(design.walker().p, DetailedCompliant)
    assert isinstance(design.with_value("biped.frame_mass", 0.0).walker().p, DetailedCompliant)
    assert design.value("biped.other_leg_length") == 0.333 and design.value("biped.hip_gravity_mass") == 0.316


def test_gaits_by_the_difference_of_the_legs_are_a_closed_family():
    """Table 1 with one leg longer or shorter: two folds, alike on both sides, where stable and unstable gaits meet."""
    walker, point = found_gait(TABLE_1)
    design = DesignPoint(TABLE_1, SLOPE).with_value("biped.other_leg_length", 0.333)
    branch = continue_gait(design, "biped.other_leg_length", (0.328, 0.338), point.z, 1e-8)
    assert branch.ended == CLOSED and branch.points[0].period == pytest.approx(
        2 * point.period * walker.time, abs=1e-9)  # fmt: skip
    folds = [point.value for kind, point in branch.special if kind == TURNING_POINT]
    shorter, longer = 0.333 - min(folds), max(folds) - 0.333
    assert len(folds) == 2 and shorter == pytest.approx(longer, rel=5e-3) and 6e-4 < longer < 7e-4
    (family,) = follow_family(design, "biped.other_leg_length", (0.328, 0.338), point.z, 1e-8, doublings=0)
    assert family.ended == CLOSED and len(family.special) == 2, "once round, not once each way"


# --- Derivatives of gaits of detailed designs by all their numbers, against extrapolated differences and
# dimensions.


DESIGNS = pytest.mark.parametrize(("legs", "friction"), [
    ("rigid", None), ("compliant", None), ("compliant", FRICTION)])


def varied(biped, friction, names=None):
    design = DesignPoint(biped, SLOPE, friction)
    _, point = gait_beside(biped, found_gait(biped, friction)[1].z, friction, 1e-13)
    names = sensitive_names(design) if names is None else names
    return design, point, gait_derivatives(design, point, names, 1e-13)


@DESIGNS
def test_derivatives_by_all_numbers_are_those_of_differences(legs, friction):
    """Of a gait that limps: period and step length, means over the stride."""
    design, point, gait = varied(changed(LAME, legs=legs), friction)
    assert "biped.other_frame_com" in gait.changes.names and "biped.hip_rest_angle" in gait.changes.names
    walker = gait.walker
    names = [name for name in gait.changes.names if not name.endswith("_friction") or name == "biped.hip_friction"]
    rows = [gait.changes.names.index(name) for name in names]
    shares = np.array([2e-6 if "length" in name else 2e-5 if "radius" in name or "com" in name else 1e-4
                       for name in names])  # fmt: skip
    exact = np.array([gait.period[rows] * walker.time, gait.step_length[rows] * walker.length]) * shares
    for group, weights in together(np.abs(exact).max(axis=0), 18):
        by = {names[row]: weight * shares[row] for row, weight in zip(group, weights, strict=True)}
        wanted = gait_slope(design, point.z, by, 1.0)
        # what each of them may be off by at most, if it is alone
        allowed = np.abs(weights) * (2e-6 * np.abs(exact[:, group]) + 1e-8 * shares[group])
        off = np.abs(exact[:, group] @ weights - wanted)
        assert (off <= allowed.min(axis=1)).all(), [names[row] for row in group]


def test_a_number_of_both_legs_moves_as_the_two_legs_numbers_together():
    """Where the other leg's number is given, though equal, each leg's has a derivative of its own; they add up."""
    alike = changed(TABLE_1, frame_mass=0.01, frame_com=0.02)
    _, _, one = varied(alike, None, ("biped.foot_mass", "biped.frame_com", "biped.frame_mass"))
    both = ("biped.foot_mass", "biped.other_foot_mass", "biped.frame_com", "biped.other_frame_com")
    given = changed(alike, other_foot_mass=0.335, other_frame_com=0.02)
    _, _, two = varied(given, None, both)
    assert two.period[0] + two.period[1] == pytest.approx(one.period[0], rel=1e-9)
    assert two.period[2] + two.period[3] == pytest.approx(one.period[1], rel=1e-9)
