"""Walks over blocks of drawn heights, against a loop of SciPy's on the readable equations and against each other."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from stages.analytic.errors import NoGait, StepFailed
from stages.analytic.gait.poincare import start_state
from stages.analytic.integration.readable import advance, clearance, double_stance, heel_strike, integrate
from stages.analytic.parameters import Settings
from stages.analytic.result import REACHES
from stages.biped.question import WrongOption
from stages.ground.blocks import Blocks, BlocksDoNotFit, drawn_heights
from stages.stability.blocks import rare
from stages.stability.blocks.passage import Counted, from_weighed
from stages.stability.blocks.rare import PATTERN, PLACES, NoFalls, Patterns, generator_of, learnt_patterns, weighed
from stages.stability.blocks.walks import KEPT, Rough, heights_of, some_walks, walk_on
from stages.stability.questions import rough as question
from tests.analytic.designs import FRICTION, SLOPE, TABLE_1, TABLE_1_RIGID, found_gait
from tests.analytic.test_questions import Listener


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
            y = readable_step(rough.walker, y, height - before, rough.begins)
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


@pytest.mark.parametrize("rms", [3e-4, 3.5e-4])
def test_weighed_walks_fall_as_often_as_counted_ones(rms):
    rough, counted = rough_of(TABLE_1_RIGID, rms), Counted(10)
    counted.add(some_walks(rough, 0, 0, 60_000))
    patterns, _ = learnt_patterns(rough, 1)
    parts = [weighed(rough, patterns, generator_of(number), 1500) for number in range(2)]
    found, count = from_weighed(parts, counted), counted.passage()
    assert count.falls > 40 and found.steps_high / found.steps_low < 1.6
    assert found.steps_low < count.steps_high and count.steps_low < found.steps_high


def test_blocks_so_low_that_no_walk_falls_are_said_to_be(monkeypatch):
    """Weights of what leads to a fall on blocks much higher would overflow."""
    monkeypatch.setattr(rare, "WATCHED", 200)
    with pytest.raises(NoFalls, match="no walk falls even on blocks 11 times as high"):
        learnt_patterns(rough_of(TABLE_1_RIGID, 1e-6), 1)


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


class Asking(Listener):
    """Answers in this process."""

    def each(self, function, arguments, *shared):
        return iter([function(self.parameters, *shared, argument) for argument in arguments])


def asked(rms, **changes):
    asking = Asking()
    asking.parameters = SimpleNamespace(
        biped=TABLE_1_RIGID, slope=SLOPE, friction=FRICTION, blocks=Blocks(rms, 0),
        analytic=replace(Settings(tolerance=1e-10, steps=2, sampling_rate_hz=100.0), **changes))
    return question.ask(asking.parameters, question.Options(effort=40_000), asking)


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
    settings = Settings(tolerance=1e-10, steps=2, sampling_rate_hz=100.0, transition="coulomb")
    asking = SimpleNamespace(biped=TABLE_1, slope=SLOPE, friction=FRICTION, blocks=Blocks(1e-3, 0), analytic=settings)
    with pytest.raises(NoGait, match="limited friction"):
        question.ask(asking, question.Options(), Asking())


def test_blocks_that_reach_the_foot_that_stands_are_refused():
    parameters = SimpleNamespace(
        blocks=Blocks(1e-3, block_length=0.3), biped=TABLE_1, slope=SLOPE, friction=FRICTION,
        analytic=SimpleNamespace(tolerance=1e-9, limited={}.get))  # fmt: skip
    with pytest.raises(BlocksDoNotFit, match=r"ground.block_length = 0.3 m .* allowed: < 0.2414 m"):
        question.ask(parameters, question.Options(), Listener())
