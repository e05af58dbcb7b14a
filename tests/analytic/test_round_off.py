"""Round-off of one step: similar bipeds, three precisions, orders of summation."""

import numpy as np
import pytest

from benchmarks.round_off import eliminate, orders_of_summation, precisions, similarity, step, system
from stages.analytic.integration.readable import accelerations
from stages.analytic.phases.section import section_state
from tests.analytic.designs import double_stance_states

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
