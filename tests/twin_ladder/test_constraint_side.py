"""The constraint model of a rung's machine: its numbers, its alternation, and what is left between the two."""

import dataclasses

import numpy as np
import pytest

from stages.analytic.gait.gait_search import find_gait, step_lengths
from stages.multibody.walking.cycle import SectionWalker
from stages.planar.section import section_state as planar_state
from stages.studies.result import COMPLETED
from stages.twin.machine.projection import project
from stages.twin_ladder.cycle import UPRIGHT, SectionState, step_map
from stages.twin_ladder.run import PHASES, STANDING, beside, constraint_gait

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


def test_a_machine_with_legs_alike_does_not_limp(simple, parameters):
    walker, point = find_gait(parameters.biped, parameters.slope, TOLERANCE)
    assert simple.outcome == COMPLETED
    assert simple.period == pytest.approx(point.period * walker.time, abs=1e-12)
    assert simple.step_length == pytest.approx(step_lengths(walker, point)[0] * walker.length, abs=1e-12)
    assert simple.multipliers == pytest.approx(point.floquet_multipliers[:2], abs=1e-9)
    assert abs(simple.limp) < 1e-6
    half = len(PHASES) // 2
    assert simple.hip[half] == pytest.approx(simple.hip[0] + [simple.step_length, 0.0], abs=1e-6)


def test_multipliers_of_a_step_are_roots_of_the_strides(own, twin, parameters):
    _, point = find_gait(project(twin), parameters.slope, TOLERANCE)
    assert len(point.steps) == 2
    assert own.multipliers**2 == pytest.approx(point.floquet_multipliers[:2], abs=1e-9)
    assert own.multipliers[0].real < -0.7 and own.multipliers[1].real > 0.6
    assert own.hip[-1] == pytest.approx(own.hip[0] + [2 * own.step_length, 0.0], abs=1e-6)


def test_legs_exchanged_limp_the_other_way(own, twin, parameters):
    other = constraint_gait(project(twin).exchanged, parameters.slope, TOLERANCE)
    assert other.period == pytest.approx(own.period, abs=1e-9)
    assert other.step_length == pytest.approx(own.step_length, abs=1e-9)
    assert other.multipliers == pytest.approx(own.multipliers, abs=1e-6)
    assert abs(own.limp) > 5e-4 and other.limp == pytest.approx(-own.limp, abs=1e-6)


def test_a_machine_without_a_gait_says_why(parameters, simple):
    level = constraint_gait(parameters.biped, dataclasses.replace(parameters.slope, slope_deg=0.0), TOLERANCE)
    assert level.outcome != COMPLETED and np.isnan(level.period) and not len(level.multipliers)
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
