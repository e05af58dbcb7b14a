"""The ladder as a whole, its parts as a sum, and mid-stance in numbers."""

import dataclasses
import itertools
from types import SimpleNamespace

import numpy as np
import pytest

from pipeline.cache import artefact
from stages.analytic.gait.gait_search import find_gait, step_lengths
from stages.multibody.walking.cycle import SectionWalker
from stages.multibody.walking.walk import simulate
from stages.penalty.step_map import PenaltyStepper
from stages.penalty.walk import Settings as PenaltySettings
from stages.planar.limit_cycle import gait_near
from stages.planar.run import rolling_state
from stages.planar.sampling import sample
from stages.planar.section import NoLimitCycle, section_numbers, section_scales, section_state as planar_state
from stages.studies.result import COMPLETED
from stages.twin.machine.machine import build, join
from stages.twin.machine.projection import project
from stages.twin.walking.record import find_events
from stages.twin.walking.simulate import rolling_start, simulate_twin
from stages.twin_ladder.cycle import (
    SIDE_UNITS,
    UPRIGHT,
    Search,
    SectionState,
    Step,
    leading,
    multipliers_of,
    section_state,
    start_from,
    step_map,
)
from stages.twin_ladder.result import Result, RungGait, SameMachine, pair_text
from stages.twin_ladder.run import (
    NO_HIP,
    PHASES,
    STANDING,
    Inputs,
    again,
    beside,
    constraint_gait,
    constraint_gaits,
    in_the_plane,
    ladder,
    planar_rung,
    run,
    rungs,
    without_gait,
)
from tests.planar_start import ROUGH, SCALES, SLOPE, TABLE_1

NAMED = {"name": "made up", "added": "", "is_twin": False}


def inputs(planar_gait):
    analytic = SimpleNamespace(gait=SimpleNamespace(period_s=0.48, step_length_m=0.16), mid_stance=ROUGH)
    planar = SimpleNamespace(mid_stance=planar_gait, unsettled="no fixed point of its step was found (fell in step 1)")
    return Inputs(analytic, planar, SimpleNamespace(settling=SimpleNamespace(period_s=0.5, step_length_m=0.15)))


@pytest.fixture(scope="module")
def made_up():
    """Four rungs, of which the second has no gait, and the constraint model of each, of which the third has none."""
    multipliers, apart = np.array([[-0.7, 0.0], [0.5, 0.1]]), np.array([1e-3, 1e-4])

    def rung(name, period, length):
        return RungGait(name, COMPLETED, period, length, 0.0, "more", name == "third", multipliers, multipliers, 1e-6,
                        800.0, 20)  # fmt: skip

    rows = (rung("first", 0.49, 0.161), without_gait("second", "more", "fell in step 1", False),
            rung("third", 0.47, 0.165), rung("fourth", 0.46, 0.166))  # fmt: skip
    own = tuple(SameMachine(row.name, "no gait" if row.is_twin else COMPLETED, 0.495, 0.160, 0.0, row.plane_multipliers,
                            apart, 2 * apart) for row in rows)  # fmt: skip
    return Result(0.48, 0.16, rows, 0.471, 0.164, own)


def test_how_many_steps_solvers_take_is_in_no_error_of_a_gait(made_up):
    more = tuple(dataclasses.replace(rung, solver_steps=1e4, residual=1e-3) for rung in made_up.rungs)
    fields = artefact.tree(artefact.encoded(made_up, {}, {}, dataclasses.replace(made_up, rungs=more))[1], "ladder.h5")
    errors = [each.error for each in fields if each.error is not None]
    assert len(errors) > 5 and max(errors) < 1e-12


def test_changes_up_to_the_twin_add_up_to_its_difference(made_up):
    changes = made_up.changes()
    assert [name for name, *_ in changes] == ["first", "third", "fourth"]
    assert sum(period for _, period, _ in changes[:2]) == pytest.approx(0.47 - 0.48)
    assert sum(length for *_, length in changes[:2]) == pytest.approx(0.165 - 0.16)


def test_tables_say_which_rung_has_no_gait(made_up):
    (_, columns, ladder), (_, beside, own), (_, _, added), (_, _, twin) = made_up.tables()
    assert [row[0] for row in own] == ["first", "fourth"] and all(len(row) == len(beside) for row in own)
    assert own[0][1:5] == ["0.49500", "-5.00", "160.00", "+1.00"]
    assert all(len(row) == len(columns) for row in ladder) and len(ladder) == 5 and len(added) == 4
    assert ladder[2][:2] == ["second", "fell in step 1"] and ladder[3][0] == "third = the twin"
    assert len(twin) == 2
    assert "no gait for second" in made_up.summary()


def test_what_is_left_of_the_twin_is_told(made_up):
    assert made_up.left_of_twin() is None and "same robot" not in made_up.summary()
    found = dataclasses.replace(made_up, same_machine=tuple(
        dataclasses.replace(own, outcome=COMPLETED) for own in made_up.same_machine))  # fmt: skip
    assert found.left_of_twin() == pytest.approx((0.47 - 0.495, 0.165 - 0.16))
    assert "from the constraint model of the same robot -25 ms" in found.summary()


def test_a_twin_beyond_its_period_doubling_is_said_to_limp(made_up):
    """Near a doubling the twin of a robot takes a long step and a short one, and looked twice as stable."""
    assert "limps" not in made_up.summary()
    uneven = tuple(dataclasses.replace(rung, inner_outer_difference=-0.218) for rung in made_up.rungs)
    assert "it limps, its two steps last 22 % of their mean apart" in dataclasses.replace(
        made_up, rungs=uneven).summary()


def test_a_multiplier_without_a_part_is_told_without_it():
    """A limping twin's was -0.000-1.212i."""
    told = [pair_text(np.array(pair)) for pair in ((-1e-9, -1.212), (0.4, 1e-9), (0.4, -0.3), (0.0, 0.0))]
    assert told == ["-1.212i", "+0.400", "+0.400-0.300i", "+0.000"]


def test_a_walk_that_is_not_at_the_gait_is_said_to_be_elsewhere(made_up):
    """A robot with large feet on soft ground drifts from an unstable gait to a stable one in hundreds of steps."""
    assert "own walk" not in made_up.summary()
    for changes in ({"walked_step_length_m": 0.13}, {"walked_period_s": 0.5}):
        assert "its own walk is not there: its last four steps are" in dataclasses.replace(made_up, **changes).summary()
    fallen = dataclasses.replace(made_up, walked_period_s=float("nan"), walked_step_length_m=float("nan"))
    assert "own walk" not in fallen.summary()


@pytest.fixture
def nothing_found(monkeypatch):
    """No machine in space has a gait: the names of those that were looked for, by search."""
    sought: list[list[str]] = []

    def climb(_, machines, *rest):
        sought.append([rung.name for rung in machines])
        return [(without_gait(rung.name, rung.added, "it fell", rung.is_twin), NO_HIP) for rung in machines]

    monkeypatch.setattr("stages.twin_ladder.run.climb", climb)
    return sought


@pytest.mark.parametrize("steps", [1, 2])
def test_in_the_plane_the_derivative_is_that_of_a_stride(parameters, machines, monkeypatch, steps):
    """Of two steps, where a cycle of the penalty walker is one step and where it limps."""
    matrix = np.random.default_rng(steps).normal(size=(10, 10))
    cycle = SimpleNamespace(section_state=np.arange(10.0), monodromy_matrix=matrix)
    monkeypatch.setattr("stages.twin_ladder.run.PenaltyStepper", lambda *_: SimpleNamespace(steps_a_cycle=steps))
    monkeypatch.setattr("stages.twin_ladder.run.gait_near", lambda *_: cycle)
    state, stride = in_the_plane(parameters, machines[0].machine, None)
    assert state is cycle.section_state
    np.testing.assert_allclose(stride, matrix @ matrix if steps == 1 else matrix)


def test_no_gait_at_all_is_a_result(parameters, nothing_found):
    result = run(parameters, inputs(None))
    assert not any(rung.found for rung in result.rungs) and result.rungs[0].outcome
    assert result.twin is None and "no gait for planar model" in result.summary()
    assert len(result.same_machine) == len(result.rungs) and not result.left()


def test_where_the_planar_model_falls_the_twin_may_have_a_gait(parameters, machines):
    """It is looked for from the constraint model's: the planar model of legs of .76 m on points fell, their twin walks.
    """
    quick = dataclasses.replace(parameters, settings=dataclasses.replace(parameters.settings, sideways=False))
    twin = [rung for rung in machines if rung.is_twin]
    result = ladder(quick, inputs(None), twin)
    assert not result.rungs[0].found and "no gait for planar model" in result.summary()
    assert result.twin.period_s == pytest.approx(0.489723, abs=2e-6) and len(result.left()) == 1


def test_newton_finds_the_fixed_point_of_a_known_step():
    """A made-up linear step of two different pairs: the gait of the stride and its multipliers are known."""
    rng = np.random.default_rng(4)
    steps = [0.3 * rng.normal(size=(10, 10)) for _ in (0, 1)]
    fixed = rng.normal(size=(2, 10))

    def take(state, stance):
        away = steps[stance] @ ((state.plane - fixed[stance]) / SCALES)
        end = SectionState(fixed[1 - stance] + SCALES * away, 0.5 * state.side)
        return Step(end, 0.5 + 0.01 * stance, 0.16, 100, None)

    stride = steps[1] @ steps[0]
    like = (stride + 1e-5 * rng.normal(size=(10, 10))) * SCALES[:, None] / SCALES
    search = Search(take, (SCALES, section_scales(TABLE_1, SLOPE, SIDE_UNITS)), 1e-10, 1e-3)
    gait = search.find(fixed[0] + 0.1 * SCALES, like, np.ones((9, 1)), **NAMED)
    assert gait.plane == pytest.approx(fixed[0], abs=1e-9)
    wanted = np.linalg.eigvals(stride)
    wanted = wanted[np.argsort(-np.abs(wanted))][:2]
    row = gait.row
    squares = (row.plane_multipliers @ [1.0, 1.0j]) ** 2
    assert np.sort_complex(squares) == pytest.approx(np.sort_complex(wanted), abs=1e-6)
    assert row.period_s == pytest.approx(0.505) and row.inner_outer_difference == pytest.approx(-0.01 / 0.505)
    assert row.side_multipliers == pytest.approx(np.array([[0.5, 0.0]])) and row.strides_walked == search.steps // 2
    again = Search(take, (SCALES, section_scales(TABLE_1, SLOPE, SIDE_UNITS)), 1e-10, 1e-3)
    found = again.find(gait.plane, like, gait.sideways, **NAMED)
    assert found.row.plane_multipliers == pytest.approx(row.plane_multipliers, abs=1e-6)
    assert again.steps < search.steps, "from its own gait a search takes fewer steps"


def assert_contact_alone_is_left(result):
    """What parts each machine from the constraint model of the same robot is what parts the simple ones: contact.

    The machines' own differences are many times that.
    """
    (planar, simple), *others = result.left()
    assert len(others) == len(result.rungs) - 1
    contact = np.array([planar.period_s - simple.period_s, planar.step_length_m - simple.step_length_m])
    for rung, own in others:
        left = np.array([rung.period_s - own.period_s, rung.step_length_m - own.step_length_m])
        assert left == pytest.approx(contact, rel=0.2), rung.name
        assert rung.plane_multipliers == pytest.approx(own.multipliers, abs=4e-3), rung.name
        assert rung.inner_outer_difference == pytest.approx(own.inner_outer_difference, abs=5e-5), rung.name
        assert own.hip_apart_m == pytest.approx(simple.hip_apart_m, rel=0.3), rung.name
    before = result.twin.period_s - result.simple_period_s
    assert abs(before) > 5 * abs(result.left_of_twin()[0])
    assert np.linalg.norm(next(own for rung, own in others if rung.is_twin).hip_from_simple_m) > 2.5e-3


@pytest.mark.slow
def test_the_twins_walk_settles_to_the_last_rung_at_the_rates_of_its_multipliers(parameters):
    """An independent check of fixed point and multipliers: a long walk of the twin's own stage.

    Changes of the period c_k are sums of powers of the two multipliers a, b that are not near zero, so
    c_{k+2} = (a + b) c_{k+1} - a b c_k.
    """
    quick = dataclasses.replace(parameters, settings=dataclasses.replace(parameters.settings, sideways=False))
    start = rolling_state(parameters.biped, parameters.contact, ROUGH, 9.4)
    where = parameters.biped, parameters.slope, parameters.contact
    gait = gait_near(SectionWalker(*where, start, parameters.planar, 5e-4), start)
    result = run(quick, inputs(gait))
    twin = result.twin
    assert all(rung.found for rung in result.rungs)
    planar, paired, wide = result.rungs[:3]
    for rung in (paired, wide):
        assert rung.period_s == pytest.approx(planar.period_s, abs=2e-6)
        assert rung.plane_multipliers[:2] == pytest.approx(planar.plane_multipliers[:2], abs=5e-3)
    assert_contact_alone_is_left(result)
    machine = build(parameters.biped, parameters.twin)
    solver = dataclasses.replace(parameters.twin, tolerance=1e-8)
    start = rolling_start(machine, parameters.contact, ROUGH, 9.4)
    record = simulate_twin(machine, parameters.slope, parameters.contact, start, solver, steps=41)
    periods = np.diff(find_events(record).heel_strike_time)
    assert 0.5 * (periods[-1] + periods[-2]) == pytest.approx(twin.period_s, abs=2e-5)
    change = (periods[2:] - periods[:-2])[6:24]  # of the same pair from stride to stride
    weight = 0.7 ** -np.arange(16.0)
    two = np.linalg.lstsq(np.stack([change[1:-1], change[:-2]], axis=1) * weight[:, None], change[2:] * weight)[0]
    assert sorted(np.roots([1.0, *-two])) == pytest.approx(sorted(twin.plane_multipliers[:2, 0]), abs=0.01)


def test_every_rung_has_the_closer_gait_of_its_own_constraint_model(parameters, nothing_found):
    """Where no machine has a gait, constraint models are solved at closer settings all the same."""
    analytic = dataclasses.replace(parameters.analytic, tolerance=1e-6)
    first = run(dataclasses.replace(parameters, analytic=analytic), inputs(None))
    near = again(parameters, inputs(None), first)
    apart = [abs(one.period_s - other.period_s) for one, other in zip(first.same_machine, near.same_machine)]
    assert len(apart) > 4 and min(apart) > 0.0
    (twin,) = (rung.name for rung in first.rungs if rung.is_twin)
    assert nothing_found[1] == ["paired legs", twin], "whose multipliers others read"


# --- Mid-stance in numbers, and what a step may and may not do to them.


@pytest.fixture(scope="module")
def take(machines, parameters):
    """A step of the rung with this number at a fine tolerance."""
    fine = dataclasses.replace(parameters.twin, tolerance=1e-7, largest_step=1e-3)
    maps = {}

    def step(rung, plane, side=UPRIGHT, stance=0):
        if rung not in maps:
            maps[rung] = step_map(machines[rung].machine, parameters.slope, parameters.contact, fine)
        return maps[rung](SectionState(plane, side), stance)

    return step


@pytest.mark.parametrize("stance", [0, 1])
def test_numbers_and_start_are_inverse(stance):
    length = np.array([0.333, 0.334, 0.335, 0.336])
    rng = np.random.default_rng(3)
    state = SectionState(rng.normal(size=10), rng.normal(size=9))
    start = start_from(state, stance, length)
    back = section_state(start.position, start.velocity, stance, length)
    assert back.plane == pytest.approx(state.plane, abs=1e-14) and back.side == pytest.approx(state.side, abs=1e-14)
    assert start.in_play == (stance == 0, stance == 1)


def test_pairs_and_width_do_not_change_a_step_in_the_plane(take, plane, parameters):
    """Without and with width, from the inner and from the outer pair: the step of the planar checker."""
    steps = [take(rung, plane, stance=stance) for rung in (0, 1) for stance in (0, 1)]
    start = planar_state(plane, STANDING)
    planar = dataclasses.replace(parameters.planar, assembly="tree", tolerance=1e-7, largest_step=1e-3)
    assert np.array_equal(section_numbers(start), plane)
    run = simulate(parameters.biped, parameters.slope, parameters.contact, start, planar, steps=1)
    landed = sample(run.trajectory, parameters.biped, parameters.slope, 500.0).heel_strike_time
    assert len(landed) == 1
    for step in steps:
        assert abs(step.end.plane - steps[0].end.plane).max() < 1e-6
        assert abs(step.end.side).max() < 1e-9
        hip = run.trajectory.at(np.array([step.duration]))[0][0]
        assert step.length == pytest.approx(hip[0], abs=1e-7) and step.end.plane[0] == pytest.approx(hip[1], abs=1e-7)


def test_a_mirrored_disturbance_ends_mirrored(take, plane):
    side = np.array([0.01, 0.0, 0.0, 0.0, 0.01, 0.05, 0.02, 0.0, 0.0])
    one, other = (take(1, plane, sign * side).end for sign in (1.0, -1.0))
    assert one.side == pytest.approx(-other.side, abs=1e-7) and abs(one.side).max() > 1e-3
    assert one.plane == pytest.approx(other.plane, abs=1e-7)


def test_width_resists_what_a_line_does_not(take, plane):
    """A foot without width turns more freely: half a yaw rate is lost in both, but the twist goes on longer."""
    spin = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.3, 0.0, 0.0, 0.0])
    narrow, wide = (take(rung, plane, spin).end.side[0] for rung in (0, 1))
    assert 0.0 < wide < narrow


def test_a_start_that_falls_back_has_no_step(take, plane):
    back = plane.copy()
    back[[4, 6, 7]] = -0.66, 2.0, 0.0
    with pytest.raises(NoLimitCycle):
        take(1, back)


def test_multipliers_of_alike_steps_are_those_of_one():
    rng = np.random.default_rng(11)
    vectors = rng.normal(size=(5, 5))
    block = np.array([[0.3, -0.4], [0.4, 0.3]])
    wanted = np.zeros((5, 5))
    wanted[:2, :2], wanted[2, 2], wanted[3, 3] = block, -0.9, 0.6
    derivative = vectors @ wanted @ np.linalg.inv(vectors)
    found = multipliers_of(np.eye(5), derivative, derivative @ derivative)
    assert found[0] == pytest.approx(-0.9) and found[1] == pytest.approx(0.6)
    assert sorted(found[2:4], key=lambda value: value.imag) == pytest.approx([0.3 - 0.4j, 0.3 + 0.4j])


def test_multipliers_of_a_step_square_to_those_of_the_stride():
    rng = np.random.default_rng(12)
    one, other = rng.normal(size=(2, 4, 4))
    found = np.sort_complex(multipliers_of(np.eye(4), one, other @ one) ** 2)
    assert found == pytest.approx(np.sort_complex(np.linalg.eigvals(other @ one).astype(complex)))
    assert found == pytest.approx(np.sort_complex(multipliers_of(np.eye(4), one, other @ one, steps=2)))


@pytest.mark.parametrize(
    ("values", "wanted", "all_nine"),
    [
        ((-0.9, 0.6, 0.01), [-0.9, 0.6], False),
        ((0.7, 0.7j, 0.02), [0.7j, -0.7j], True),  # three of one size: two changes cannot hold them
        ((0.9j, 0.02, 0.01), [0.9j, -0.9j], False),
        ((0.8, 0.7999, 0.7998), [0.8, 0.7999], None),
    ],
)
def test_leading_multipliers_are_found_from_few_changes(values, wanted, all_nine):
    """An imaginary one stands for a pair. The made-up step is linear, its vectors are far from orthogonal."""
    rng = np.random.default_rng(8)
    blocks = [np.array([[0.0, abs(value)], [-abs(value), 0.0]]) if isinstance(value, complex) else np.array([[value]])
              for value in values]  # fmt: skip
    diagonal, at = np.zeros((9, 9)), 0
    for block in blocks:
        diagonal[at : at + len(block), at : at + len(block)] = block
        at += len(block)
    vectors = rng.normal(size=(9, 9))
    step = vectors @ diagonal @ np.linalg.inv(vectors)
    asked = []

    def changes(change):
        asked.append(change)
        return step @ change, step @ step @ change

    found, basis = leading(changes, rng.normal(size=(9, 2)), 5e-4)
    assert basis.shape == (9, 2) and np.sort_complex(np.abs(found)) == pytest.approx(np.sort(np.abs(wanted)), abs=2e-3)
    if all_nine is not None:
        assert (len(asked) > 12) is all_nine
    if all_nine is False:
        assert np.sort_complex(found) == pytest.approx(np.sort_complex(np.array(wanted, dtype=complex)), abs=2e-3)


# --- The machines of the ladder: one thing more each, the same masses, the twin among them.


def test_each_rung_differs_from_the_one_before(machines):
    for one, other in itertools.pairwise(machines):
        with pytest.raises(AssertionError):
            np.testing.assert_equal(*map(dataclasses.asdict, (one.machine, other.machine)))


def test_no_rung_changes_the_masses_of_table_1(machines, parameters):
    """But the outsole, which comes on top of them."""
    for rung in machines[:-1]:
        assert rung.machine.mass == pytest.approx(parameters.biped.total_mass, abs=1e-4)
        for pair in (rung.machine.bodies[1:3], rung.machine.bodies[4:6]):
            assert join(pair).mass == pytest.approx(parameters.biped.foot_mass, abs=5e-5)


def test_the_outsoles_weigh_what_their_rubber_does(machines, parameters):
    rubber = parameters.twin.mass(parameters.biped.foot_radius, parameters.settings.outsole)
    assert machines[-1].machine.mass - machines[-2].machine.mass == pytest.approx(4.0 * rubber) and rubber > 0.004


def test_the_twin_is_one_of_them(machines, parameters):
    (twin,) = [rung for rung in machines if rung.is_twin]
    np.testing.assert_equal(*map(dataclasses.asdict, (twin.machine, build(parameters.biped, parameters.twin))))
    assert machines[-1].name == "rubber outsoles" and not machines[-1].is_twin


def test_an_outsole_or_friction_of_the_twin_moves_it_up(parameters):
    soled = dataclasses.replace(parameters.twin, outsole=0.001, slider_friction=2.0)
    found = rungs(parameters.biped, soled, 0.002)
    assert [rung.is_twin for rung in found] == [False] * 5 + [True]
    np.testing.assert_equal(*map(dataclasses.asdict, (found[-1].machine, build(parameters.biped, soled))))
    assert found[-1].machine.length == pytest.approx(parameters.biped.leg_length + 0.001)
    assert found[-2].name == "joint friction"


def test_planar_inertia_leaves_out_the_rungs_of_the_parts(parameters):
    planar = dataclasses.replace(parameters.twin, inertia="planar")
    assert [rung.name for rung in rungs(parameters.biped, planar, 0.002)] == [
        "paired legs", "foot width", "rubber outsoles",
    ]  # fmt: skip


def test_rungs_of_rigid_legs_name_no_spring(machines, parameters):
    rigid = [(one.name, one.added) for one in rungs(dataclasses.replace(parameters.biped, legs="rigid"),
                                                    parameters.twin, 0.002)]  # fmt: skip
    assert "spring" not in str(rigid) and "leg mass above the spring" in [rung.name for rung in machines]


def test_distributed_inertia_keeps_the_mass_centres(machines):
    points, spread = (rung.machine for rung in machines[1:3])
    for one, other in zip(points.bodies, spread.bodies, strict=True):
        assert other.centre == pytest.approx(one.centre, abs=2e-6)
    assert np.trace(spread.bodies[1].inertia) > 0.0 and not points.bodies[1].inertia.any()


# --- The constraint model of a rung's machine: its numbers, its alternation, and what is left between the two.


TOLERANCE = 1e-9


@pytest.fixture(scope="module")
def twin(machines):
    """The machine of the bill, without rubber."""
    return next(rung.machine for rung in machines if rung.name == "leg mass above the spring")


@pytest.fixture(scope="module")
def own(twin, parameters):
    return constraint_gait(project(twin), parameters.slope, TOLERANCE)


@pytest.fixture(scope="module")
def simple(parameters):
    return constraint_gait(parameters.biped, parameters.slope, TOLERANCE)


def multipliers_in(gait):
    return gait.row.multipliers @ [1.0, 1.0j]


def test_a_machine_with_legs_alike_does_not_limp(simple, parameters):
    walker, point = find_gait(parameters.biped, parameters.slope, TOLERANCE)
    assert simple.row.outcome == COMPLETED
    assert simple.row.period_s == pytest.approx(point.period * walker.time, abs=1e-12)
    assert simple.row.step_length_m == pytest.approx(step_lengths(walker, point)[0] * walker.length, abs=1e-12)
    assert multipliers_in(simple) == pytest.approx(point.floquet_multipliers[:2], abs=1e-9)
    assert abs(simple.row.inner_outer_difference) < 1e-6
    half = len(PHASES) // 2
    assert simple.hip[half] == pytest.approx(simple.hip[0] + [simple.row.step_length_m, 0.0], abs=1e-6)


def test_multipliers_of_a_step_are_roots_of_the_strides(own, twin, parameters):
    _, point = find_gait(project(twin), parameters.slope, TOLERANCE)
    assert len(point.steps) == 2
    assert multipliers_in(own)**2 == pytest.approx(point.floquet_multipliers[:2], abs=1e-9)
    assert multipliers_in(own)[0].real < -0.7 and multipliers_in(own)[1].real > 0.6
    assert own.hip[-1] == pytest.approx(own.hip[0] + [2 * own.row.step_length_m, 0.0], abs=1e-6)


def test_legs_exchanged_limp_the_other_way(own, twin, parameters):
    other = constraint_gait(project(twin).exchanged, parameters.slope, TOLERANCE)
    assert other.row.period_s == pytest.approx(own.row.period_s, abs=1e-9)
    assert other.row.step_length_m == pytest.approx(own.row.step_length_m, abs=1e-9)
    assert multipliers_in(other) == pytest.approx(multipliers_in(own), abs=1e-6)
    limp = own.row.inner_outer_difference
    assert abs(limp) > 5e-4 and other.row.inner_outer_difference == pytest.approx(-limp, abs=1e-6)


def test_the_planar_rung_of_legs_that_differ_limps_as_the_constraint_model(parameters, plane):
    """And its multipliers are those of two steps, as those of the machines in space."""
    lame = dataclasses.replace(parameters, biped=dataclasses.replace(parameters.biped, other_foot_mass=0.338))
    stepper = PenaltyStepper(lame.biped, lame.slope, lame.contact, planar_state(plane, STANDING), PenaltySettings(1e-9))
    found, _ = planar_rung(lame, gait_near(stepper, stepper.start))
    own = constraint_gaits(lame, [lame.biped])[0].row
    assert abs(own.inner_outer_difference) > 0.05
    assert found.inner_outer_difference == pytest.approx(own.inner_outer_difference, abs=5e-3)
    _, point = find_gait(lame.biped, lame.slope, TOLERANCE)
    np.testing.assert_allclose(own.multipliers @ [1.0, 1.0j], point.floquet_multipliers[:2], atol=1e-6)
    np.testing.assert_allclose(found.plane_multipliers, own.multipliers, atol=0.02)


def test_a_machine_without_a_gait_says_why(parameters, simple):
    level = constraint_gait(parameters.biped, dataclasses.replace(parameters.slope, slope_deg=0.0), TOLERANCE)
    assert level.row.outcome != COMPLETED and np.isnan(level.row.period_s) and not len(level.row.multipliers)
    row = beside("level", level, simple, simple.hip)
    assert not row.found and np.isnan(row.hip_apart_m).all() and row.hip_from_simple_m == pytest.approx([0.0, 0.0])


@pytest.mark.parametrize("stance", [0, 1])
def test_in_exudyn_the_twin_steps_as_its_planar_projection(twin, plane, parameters, stance):
    """Two models of Exudyn's, one with eleven coordinates, one with six: a step from either pair."""
    fine = dataclasses.replace(parameters.twin, tolerance=3e-8, largest_step=1e-3)
    spatial = step_map(twin, parameters.slope, parameters.contact, fine)(SectionState(plane, UPRIGHT), stance)
    biped = project(twin) if stance == 0 else project(twin).exchanged
    settings = dataclasses.replace(parameters.planar, assembly="tree", tolerance=3e-8, largest_step=1e-3)
    start = planar_state(plane, STANDING)
    walker = SectionWalker(biped, parameters.slope, parameters.contact, start, settings, 1e-4)
    step = walker.walk(start, 1)
    assert step.numbers == pytest.approx(spatial.end.plane, abs=2e-6)
    assert step.duration == pytest.approx(spatial.duration, abs=1e-7)
    assert step.length == pytest.approx(spatial.length, abs=1e-7)
    simple = SectionWalker(parameters.biped, parameters.slope, parameters.contact, start, settings, 1e-4)
    assert abs(simple.walk(start, 1).duration - spatial.duration) > 1e-3
