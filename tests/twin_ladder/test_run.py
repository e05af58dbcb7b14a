"""The ladder as a whole, and its parts as a sum."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest

from pipeline.cache import artefact
from stages.multibody.walking.cycle import SectionWalker
from stages.planar.limit_cycle import gait_near
from stages.planar.run import rolling_state
from stages.planar.section import section_scales
from stages.studies.result import COMPLETED
from stages.twin.machine.machine import build
from stages.twin.walking.record import find_events
from stages.twin.walking.simulate import rolling_start, simulate_twin
from stages.twin_ladder.cycle import SIDE_UNITS, Search, SectionState, Step
from stages.twin_ladder.result import Result, RungGait, SameMachine, pair_text
from stages.twin_ladder.run import NO_HIP, Inputs, again, in_the_plane, ladder, run, without_gait
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
