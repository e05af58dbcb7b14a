"""The gait over the slope and from other starts, against walks that know nothing of continuation."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import brentq

from stages.analytic.derivatives.gait import gait_derivatives
from stages.analytic.errors import NoGait, StepFailed
from stages.analytic.gait import continuation
from stages.analytic.gait.continuation import PERIOD_DOUBLING, TURNING_POINT, follow_family, newborn
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.gait_search import find_gait
from stages.analytic.gait.poincare import fixed_point, poincare_map, require_landing, start_state
from stages.analytic.integration.phase import walk_step
from stages.analytic.integration.readable import advance, clearance, double_stance, heel_strike, integrate
from stages.analytic.parameters import Settings as OfAnalytic
from stages.analytic.result import BACK, ENDINGS, FORWARD, NO_START, REACHES, WALKS_ON
from stages.biped.question import WrongOption
from stages.ground.blocks import Blocks, BlocksDoNotFit, drawn_heights
from stages.ground.slope import Slope
from stages.stability.blocks import rare
from stages.stability.blocks.borne import EVERY, STEPS, Borne
from stages.stability.blocks.passage import Counted, from_weighed, ways_of
from stages.stability.blocks.rare import (
    PATTERN,
    PLACES,
    NoFalls,
    Patterns,
    Weighed,
    generator_of,
    learnt_patterns,
    weighed,
)
from stages.stability.blocks.walks import KEPT, Rough, Walk, heights_of, some_walks, walk_on
from stages.stability.parameters import Settings
from stages.stability.questions import rough as question
from stages.stability.result import Passage
from stages.stability.run import SLOPE as OVER, over_slope, section_of, starts_around
from tests.analytic.designs import FRICTION, SLOPE, TABLE_1, TABLE_1_RIGID, changed, found_gait
from tests.asking import Asking

SETTINGS = Settings(0.4, 2.8, 2, 0.1, 1e-9, 0.5, 2.0, 0.3, 2.3, 12, 30)
TOLERANCE = 1e-10


@pytest.fixture(scope="module")
def gait():
    return find_gait(TABLE_1, SLOPE, TOLERANCE)


@pytest.fixture(scope="module")
def families(gait):
    return over_slope(DesignPoint(TABLE_1, SLOPE), gait[1].z, SETTINGS)


@pytest.fixture(scope="module")
def basin(gait):
    return starts_around(*_of(gait), SETTINGS)


def _of(gait):
    walker, point = gait
    return walker, point.z


def walker_on(slope):
    return DesignPoint(TABLE_1, SLOPE).with_value(OVER, slope).walker()


def test_a_gait_in_si_units_leads_back_to_its_section(gait):
    walker, point = gait
    assert section_of(walker, walker.stance_state(start_state(walker, point.z))) == pytest.approx(point.z, abs=1e-14)


def test_a_doubling_is_where_newtons_gaits_have_a_multiplier_of_minus_one(families, gait):
    """Brent's method on the least multiplier of gaits found by Newton's at single slopes, without continuation."""
    turn = next(turn for turn in families[0].turns if turn.value > 2)
    z = np.array(fixed_point(walker_on(4.0), _nearest_start(gait, 4.0), TOLERANCE).z)

    def least(slope):
        return min(fixed_point(walker_on(slope), z, TOLERANCE).floquet_multipliers.real)

    doubles = brentq(lambda slope: least(slope) + 1, 4.1, 4.25, xtol=1e-8)
    assert turn.value == pytest.approx(doubles, abs=1e-6)
    assert turn.multiplier == pytest.approx(-1, abs=1e-8)


def _nearest_start(gait, slope):
    z = gait[1].z
    for value in np.linspace(2.0, slope, 9):
        z = fixed_point(walker_on(value), z, TOLERANCE).z
    return z


@pytest.mark.parametrize(("slope", "cycle"), [(3.0, 1), (4.8, 2), (5.45, 4)])
def test_where_a_family_is_stable_walks_settle_on_its_steps(families, gait, slope, cycle):
    """Many steps from somewhere near: the durations that come back are those of the family, each once."""
    family = next(one for one in families if one.cycle == cycle and one.value.max() > slope > one.value.min())
    order = np.argsort(family.value)
    assert family.stable[order][np.searchsorted(family.value[order], slope)]
    wanted = np.sort([np.interp(slope, family.value[order], column[order]) for column in family.step_duration.T])
    walker, z, durations = walker_on(slope), _nearest_start(gait, slope) + 1e-3, []
    for _ in range(200):
        step = poincare_map(walker, z, 1e-8)
        z = step.z
        durations.append(step.period * walker.time)
    assert np.sort(durations[-cycle:]) == pytest.approx(wanted, abs=3e-4)  # between two gaits of the family
    assert durations[-1] == pytest.approx(durations[-1 - cycle], abs=1e-7)
    assert cycle == 1 or abs(durations[-1] - durations[-1 - cycle // 2]) > 1e-3


def test_each_doubling_gives_a_family_that_is_stable_at_first(families):
    assert [family.cycle for family in families] == [1, 2, 2, 4]
    for family in families:
        assert family.step_duration.shape == (len(family.value), family.cycle)
        assert {turn.kind for turn in family.turns} <= {PERIOD_DOUBLING}
    for turn in families[0].turns:
        born = min(families[1:3], key=lambda family: abs(family.value[0] - turn.value))
        assert born.value[0] == pytest.approx(turn.value, abs=2e-3) and born.stable[1]
        assert born.step_duration[0] == pytest.approx(turn.step_duration[0], abs=0.02)


def test_a_family_that_folds_beside_its_doubling_is_followed_from_there():
    """Another gait of the family lies on the far side of the fold: from there the family was followed twice."""
    light = changed(
        TABLE_1, hip_mass=0.1429, foot_mass=0.1565, leg_length=0.7098, foot_radius=0.1631, foot_com=0.2283,
        stiffness=977.2, damping=3.375)
    design = DesignPoint(light, Slope(slope_deg=1.027, gravity=24.11))
    z = find_gait(light, design.slope, TOLERANCE)[1].z
    first, family = over_slope(design, z, replace(SETTINGS, doublings=1))[:2]
    assert [turn.kind for turn in family.turns] == [TURNING_POINT]
    assert family.turns[0].value == pytest.approx(0.5213885, abs=1e-6)
    assert family.step_duration[0] == pytest.approx(first.turns[0].step_duration[0], abs=3e-3)


def test_which_step_of_a_doubled_gait_comes_first_does_not_hang_on_where_newtons_method_led(gait, monkeypatch):
    """At a tenth of a tolerance it led to the other half: steps' durations were .056 s off, with errors of 1e-8."""

    def first(walker, *given):
        return list(newborn(walker, *given))[:1]

    def other(walker, *given):
        return [fixed_point(walker, point.steps[0].z, TOLERANCE, 2) for point in first(walker, *given)]

    found = []
    for half in (first, other):
        monkeypatch.setattr(continuation, "newborn", half)
        branches = follow_family(DesignPoint(TABLE_1, SLOPE), OVER, (1.9, 4.4), gait[1].z, TOLERANCE, 1)
        found.append(branches[-1].points[0].z)
    assert branches[-1].cycle == 2
    assert found[0] == pytest.approx(found[1], abs=1e-7)


def test_kinds_of_ending_are_those_of_single_steps(basin, gait):
    walker, point = gait
    assert {REACHES, FORWARD, BACK, NO_START} <= set(basin.ending.ravel())
    for number in (REACHES, FORWARD, BACK, NO_START):
        i, j = np.argwhere(basin.ending == number)[0]
        z = point.z.copy()
        z[0], z[3] = -basin.stance_angle[i], basin.stance_rate[j] * walker.time
        if number == NO_START:
            with pytest.raises(StepFailed, match="cannot reach the ground"):
                start_state(walker, z)
            continue
        for _ in range(basin.steps[i, j]):
            z = poincare_map(walker, z, 1e-6).z
        if number == REACHES:
            assert np.abs(z - point.z).max() < basin.near
            continue
        y = start_state(walker, z)
        status, phase, *_ = walk_step(y, walker.p, 1e-6, 30.0, 400_000)
        with pytest.raises(StepFailed):
            require_landing(walker, y, status, phase)
        assert (y[0] > 0) == (number == FORWARD)


def test_a_few_steps_are_not_enough_to_reach_the_gait(basin, gait):
    few = starts_around(*_of(gait), replace(SETTINGS, most_steps=4))
    late = (basin.ending == REACHES) & (basin.steps > 4)
    assert late.any() and (few.ending[late] == WALKS_ON).all() and (few.steps[late] == 4).all()
    soon = (basin.ending != WALKS_ON) & (basin.steps < 4)
    assert (few.ending[soon] == basin.ending[soon]).all()


# --- The height of blocks that a design bears, and the search for designs that walk longer on them.


LARGE = changed(
    TABLE_1_RIGID, hip_mass=8 * 0.316, foot_mass=8 * 0.335, leg_length=2 * 0.333, foot_radius=2 * 0.083, foot_com=0.2)


@pytest.mark.parametrize("design", [TABLE_1, TABLE_1_RIGID])
def test_on_blocks_as_high_as_it_bears_a_walker_falls_as_often_as_the_staircase_wants(design):
    walker, point = found_gait(design)
    height = Borne(Blocks()).of(walker, point.z)
    counted = Counted(10)
    counted.add(some_walks(Rough(walker, point.z, height / walker.length, 0.08 / walker.length), 5, 0, STEPS), STEPS)
    found = counted.passage()
    assert found.steps_low < 1.15 * EVERY and found.steps_high > EVERY / 1.15  # the staircase is spread about its mean


def test_a_robot_twice_as_large_bears_blocks_twice_as_high():
    heights = [Borne(Blocks(block_length=length)).of(walker, point.z) for length, (walker, point) in (
        (0.08, found_gait(TABLE_1_RIGID)), (0.16, found_gait(LARGE)))]
    assert heights[1] == pytest.approx(2 * heights[0], rel=0.02)  # round-off alone makes another walk in the end


def test_slopes_are_the_differences_of_gaits_solved_anew():
    """On the same numbers, in heights; on others and over a longer way, within the scatter of walks. Of rigid legs the
    ratio of the masses counts alone."""
    names = ["biped.foot_radius", "biped.hip_mass", "biped.foot_mass", "biped.leg_length"]
    _, point = found_gait(TABLE_1_RIGID)
    design, bears = DesignPoint(TABLE_1_RIGID, SLOPE), Borne(Blocks())
    [slopes] = bears.slopes(gait_derivatives(design, point, tuple(names), 1e-10), 1e-10)

    def beside(name, share, seed):
        walkers = [design.with_value(name, design.value(name) * (1 + end)).walker() for end in (share, -share)]
        ends = [Borne(Blocks(block_seed=seed)).of(each, fixed_point(each, point.z, 1e-10).z) for each in walkers]
        return (ends[0] - ends[1]) / (2 * share)

    height = bears.of(design.walker(), point.z)
    assert slopes / height == pytest.approx(np.array([beside(name, 0.04, 0) for name in names]) / height, abs=0.15)
    assert slopes[0] == pytest.approx(beside(names[0], 0.1, 5), rel=0.2)
    assert slopes[1] + slopes[2] == pytest.approx(0.0, abs=0.02 * height)


def test_blocks_that_reach_the_other_foot_are_not_borne():
    walker, point = found_gait(TABLE_1)
    with pytest.raises(StepFailed, match="reaches the other foot"):
        Borne(Blocks(block_length=0.3)).of(walker, point.z)


# --- Walks over blocks of drawn heights, against a loop of SciPy's on the readable equations and against each
# other.


def rough_of(design, rms, tolerance=1e-6):
    """The design in its gait on blocks of this rms height [m]."""
    walker, point = found_gait(design)
    return Rough(walker, point.z, rms / walker.length, Blocks().block_length / walker.length, tolerance)


def readable_step(walker, y, rise, begins):
    """State after a step onto a block this much higher, by SciPy; raises StepFailed for a fall."""
    if not walker.rigid:
        _, y = double_stance(walker, y, 1e-9)
    for _ in range(4):  # a fall through zero nearer than the block is none
        _, y = integrate(walker, y, lambda _, state: clearance(walker, state) - rise, False, 1e-9)
        if not np.cos(y[0]) > 0.3:
            raise StepFailed("fallen")
        if advance(walker, y) > begins:
            y = heel_strike(walker, y)
            if y[1 if walker.rigid else 2] >= 0.0:
                raise StepFailed("the hip is behind both feet")
            return y
        half = y.size // 2
        y = np.concatenate([y[:half] + 1e-6 * y[half:], y[half:]])
    raise StepFailed("scuffs without end")


@pytest.mark.parametrize(("design", "rms", "walk", "most"), [(TABLE_1, 8e-4, 4, 30), (TABLE_1_RIGID, 8e-4, 0, 40)])
def test_walks_fall_where_a_loop_on_the_readable_equations_falls(design, rms, walk, most):
    rough = rough_of(design, rms, 1e-10)
    heights = rough.rms * drawn_heights(2, walk, 0, most)
    y, at, made, before = start_state(rough.walker, rough.z), rough.start, 0, 0.0
    for height in heights.tolist():
        at, ending = rough.step(at, height / rough.rms)
        try:
            y = readable_step(rough.walker, y, height - before, rough.middles[0] - 0.5 * rough.length)
        except StepFailed:
            assert ending != REACHES
            break
        assert ending == REACHES and at.y == pytest.approx(y, abs=1e-4)
        made, before = made + 1, height
    found = walk_on(rough, (heights / rough.rms).tolist())
    assert (found.steps, found.ending == REACHES) == (made, made == most) and 3 < made < most


def test_parts_of_a_walk_have_the_same_blocks():
    rough, heights = rough_of(TABLE_1_RIGID, 4e-4), heights_of(0, 0)
    first = [next(heights) for _ in range(300)]
    assert first == drawn_heights(0, 0, 0, 300).tolist()
    walks = some_walks(rough, 0, 0, 500)
    assert walks[0] == walk_on(rough, drawn_heights(0, 0, 0, 500).tolist())
    assert sum(walk.steps + (walk.ending != REACHES) for walk in walks[:-1]) < 500 and len(walks) > 2


UNEQUAL = replace(TABLE_1_RIGID, other_foot_mass=0.33, other_foot_radius=0.0835)


@pytest.mark.parametrize(("design", "rms"), [(TABLE_1_RIGID, 3e-4), (TABLE_1_RIGID, 3.5e-4), (UNEQUAL, 2.5e-4)])
@pytest.mark.slow
def test_weighed_walks_fall_as_often_as_counted_ones(design, rms):
    rough, counted = rough_of(design, rms), Counted(10)
    counted.add(some_walks(rough, 0, 0, 60_000), 60_000)
    patterns, _ = learnt_patterns(rough, 1)
    parts = [weighed(rough, patterns, generator_of(number), 1500) for number in range(2)]
    found, count = from_weighed(parts, counted), counted.passage()
    assert count.falls > 40 and found.steps_high / found.steps_low < 1.6
    assert found.steps_low < count.steps_high and count.steps_low < found.steps_high


def test_weights_of_a_fall_whose_chance_is_known_add_up_to_it():
    """A walker that falls off each block higher than three times the rms, to 4 %; and every step counts."""
    made, chance = [], math.erfc(3.0 / math.sqrt(2.0)) / 2.0

    def step(at, height):
        made.append(height)
        return at, FORWARD if height > 3.0 else REACHES

    patterns = Patterns(np.array([0.8, 0.2]), np.array([[0.0, 0.0, 0.0, 0.0, 3.2], [1.0, 0.0, 0.0, 0.0, 0.0]]))
    found = weighed(SimpleNamespace(start="here", step=step), patterns, generator_of(5), 20_000)
    assert found.steps == len(made)
    assert sum(weight for _, weight, _ in found.falls) / found.walks == pytest.approx(chance, rel=0.04)
    told = from_weighed([found], Counted(10))
    assert told.steps_low < 1 / chance < told.steps_high < 1.08 * told.steps_low


def test_walks_cut_short_before_a_ramps_end_do_not_count_on_it():
    """Of these the falls alone were counted: of 1,000 steps .21 where .257 is right."""
    generator, counted, share = np.random.default_rng(0), Counted(1000), 1 / 735
    for _ in range(400):
        left, walks = 2500, []
        while left > 0:
            steps = int(generator.geometric(share)) - 1
            walks.append(Walk(steps, FORWARD) if steps < left else Walk(left, REACHES))
            left -= steps + 1
        counted.add(walks, 2500)
    found = counted.passage()
    assert found.ramp_low < (1 - share) ** 1000 < found.ramp_high and found.steps_low < 1 / share < found.steps_high


def test_a_ramps_interval_holds_for_walks_that_begin_on_level_blocks():
    """Of 150,000 walks of a rigid robot of .8 m on blocks of .65 mm none fell in three steps: its chance to pass ten,
    .9962, was told to be from .9949 to .9958."""
    fallen = Weighed(1_000_000, 0, [(FORWARD, 1.0, np.zeros(KEPT))] * 550)
    found = from_weighed([fallen], Counted(10))
    assert found.ramp_low < (1 - 5.5e-4) ** 7 < found.ramp_high
    assert from_weighed([fallen], Counted(100)).ramp_high < (1 - 4.9e-4) ** 90


def test_either_leg_begins_as_many_branches(monkeypatch):
    """Where legs differ one of them falls more often: of the unequal ones here, four in five times."""
    rough, begun = rough_of(UNEQUAL, 1e-5), []

    def walk(_rough, _heights, at, _last):
        begun.append(at.leg)
        return Walk(KEPT, REACHES)

    monkeypatch.setattr(rare, "walk_on", walk)
    weighed(rough, Patterns(np.ones(1), np.zeros((1, PATTERN))), generator_of(0), 40)
    assert begun.count(0) == begun.count(1) == 20


def test_blocks_so_low_that_no_walk_falls_are_said_to_be(monkeypatch):
    """Weights of what leads to a fall on blocks much higher would overflow."""
    low = rough_of(TABLE_1_RIGID, 1e-6)
    monkeypatch.setattr(rare, "WATCHED", 200)
    with pytest.raises(NoFalls, match="no walk falls even on blocks 11 times as high"):
        learnt_patterns(low, 1)
    as_they_are = Patterns(np.ones(1), np.zeros((1, PATTERN)))
    assert not weighed(low, as_they_are, generator_of(1), 20).falls


def test_ways_to_fall_have_their_share_and_mean_heights_by_weight():
    one, other = np.linspace(-1.0, 1.0, KEPT), np.ones(KEPT)
    often, seldom = ways_of([(FORWARD, 1.0, other), (BACK, 1.0, one), (BACK, 3.0, other)])
    assert (often["ending"], seldom["ending"]) == (ENDINGS[BACK], ENDINGS[FORWARD])
    assert (often["share"], seldom["share"]) == (0.8, 0.2)
    assert often["last_blocks_rms"] == pytest.approx((one + 3.0 * other) / 4.0)
    assert seldom["last_blocks_rms"] == pytest.approx(other)
    told = Passage(741.0, 700.0, 800.0, "counted", 5, 3700, 10, 0.98, 0.97, 0.99)
    _, steps, chance, first, second, spread = question.lines(1e-3, told, [often, seldom], 2e-3)
    assert steps.endswith(": 741, 95 % interval 700 to 800")
    assert chance.endswith(" within 10 steps: 0.02, 95 % interval 0.01 to 0.03") and " by 2 ms " in spread
    assert first.startswith(f"   80.0 % {ENDINGS[BACK]}; last blocks +0.50 +") and second.startswith("   20.0 %")


def test_weights_of_drawn_heights_are_those_of_normal_ones():
    patterns = Patterns(np.array([0.3, 0.7]), np.array([np.linspace(-1.0, 1.0, PATTERN), np.ones(PATTERN)]))
    heights = patterns.drawn(generator_of(3), 200_000)
    weights = patterns.weights(heights)
    assert weights.max() <= 1 / 0.1
    placed = [np.roll(heights, place, axis=1) for place in range(PLACES)]  # a branch is looked at with each place last
    weights = np.array([patterns.weights(each) for each in placed])
    assert weights.mean() == pytest.approx(1.0, abs=0.05)
    assert np.mean(weights[..., None] * placed, axis=(0, 1)) == pytest.approx(np.zeros(KEPT), abs=0.05)
    assert np.mean(weights[..., None] * np.square(placed), axis=(0, 1)) == pytest.approx(np.ones(KEPT), abs=0.1)


def test_patterns_move_to_the_falls_each_of_which_counts_by_its_weight_however_likely_it_was():
    """Two kinds of falls far apart, of which one is e^12 times likelier: of five falls one is a fifth all the same."""
    about = np.array([np.full(PATTERN, 2.0), np.full(PATTERN, -3.0)])
    falls = np.random.default_rng(2).normal(size=(500, KEPT))
    falls[:400, :PATTERN] += about[0]
    falls[400:, :PATTERN] += about[1]
    found = Patterns(np.full(2, 0.5), about + 0.3).moved(falls, np.ones(500))
    assert found.shares.sum() == pytest.approx(1.0, abs=1e-15)
    assert found.shares == pytest.approx([0.8, 0.2], abs=0.01)
    assert found.heights == pytest.approx(about, abs=0.3)


def asked(rms, **changes):
    asking = Asking(SimpleNamespace(
        biped=TABLE_1_RIGID, slope=SLOPE, friction=FRICTION, blocks=Blocks(rms, 0),
        analytic=replace(OfAnalytic(tolerance=1e-10, steps=2, sampling_rate_hz=100.0), **changes)))
    return question.ask(asking.parameters, question.Options(effort=40_000), asking)


def test_what_was_walked_to_learn_of_falls_leaves_steps_to_weigh_them_by(monkeypatch):
    """The lower the blocks, the more steps lead to them: the least effort was gone before a walk was drawn."""
    design = SimpleNamespace(blocks=Blocks(2.4e-4, 0))
    rough = SimpleNamespace(middles=(1.0, 1.0), walker=SimpleNamespace(length=0.3))
    drawn = []

    def parts(function, arguments, *shared):
        if function is question.walked:
            return iter([[[question.PART, REACHES, *[0.0] * KEPT]] for _ in arguments])
        if function is question.learnt:
            return iter([([[1.0], [[0.0] * PATTERN]], 50_000)])
        drawn.append(shared[-1])
        return iter([(0, []) for _ in arguments])

    monkeypatch.setattr(question, "rough_of", lambda *_: rough)
    asking = SimpleNamespace(each=parts, progress=lambda *_: None)
    question.passage(design, question.Options(effort=40_000), asking, [0.0])
    question.passage(design, question.Options(effort=200_000), asking, [0.0])
    assert drawn == [40_000 // 4 // (15 * 8), (200_000 - 60_000) // (15 * 8)]


@pytest.mark.slow
def test_the_question_counts_where_falls_are_frequent_and_weighs_where_they_are_rare():
    often, seldom = asked(6e-4).plain, asked(2.4e-4).plain
    assert often["method"] == "counted" and seldom["method"] == "importance sampling"
    for plain in (often, seldom):
        assert plain["steps_low"] < plain["steps_to_fall"] < plain["steps_high"]
        assert plain["ramp_low"] <= plain["ramp_chance"] <= plain["ramp_high"]
        assert sum(way["share"] for way in plain["fell"]) == pytest.approx(1.0)
        assert all(len(way["last_blocks_rms"]) == KEPT for way in plain["fell"])
    assert seldom["steps_to_fall"] > 100 * often["steps_to_fall"]


def test_what_has_no_answer_is_refused():
    with pytest.raises(WrongOption, match=r"block_height_rms = 0 m"):
        asked(0.0)
    settings = OfAnalytic(tolerance=1e-10, steps=2, sampling_rate_hz=100.0, transition="coulomb")
    asking = SimpleNamespace(biped=TABLE_1, slope=SLOPE, friction=FRICTION, blocks=Blocks(1e-3, 0), analytic=settings)
    with pytest.raises(NoGait, match="limited friction"):
        question.ask(asking, question.Options(), Asking())


def test_blocks_that_reach_the_foot_that_stands_are_refused():
    parameters = SimpleNamespace(
        blocks=Blocks(1e-3, block_length=0.3), biped=TABLE_1, slope=SLOPE, friction=FRICTION,
        analytic=SimpleNamespace(tolerance=1e-9, limited={}.get))  # fmt: skip
    with pytest.raises(BlocksDoNotFit, match=r"ground.block_length = 0.3 m .* allowed: < 0.2414 m"):
        question.ask(parameters, question.Options(), Asking())
