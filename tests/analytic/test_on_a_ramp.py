"""What `gait` says first: whether a gait walks so on a plain ramp, by the forces it needs."""

from __future__ import annotations

import dataclasses

import pytest

from stages.analytic.gait.gait_report import report_gait
from stages.analytic.gait.gait_search import find_gait
from stages.analytic.result import Validity
from stages.analytic.walk.on_a_ramp import DOES_NOT, WALKS, WALKS_IF, on_a_ramp
from stages.biped.design import Biped
from stages.ground.slope import Slope

TABLE_1 = Biped("compliant", 0.316, 0.335, 0.333, 0.083, 0.1, 2800.0, 58.35, 0.0)
#: A gait that asks for nothing a plain ramp has not.
GOOD = Validity(5.0, 1.0, 0.2, 0.4, 1.1, 0.0, 0.0, 0.3, 0.5, 0.01, 0.0, 0.0, True)


def test_table_1_needs_blocks_and_a_trailing_foot_that_slips():
    walker, point = find_gait(TABLE_1, Slope(2.0, 9.81), 1e-10)
    found = report_gait(walker, point, 1e-10, 1.1)
    said = on_a_ramp(found.validity, found.gait.stable)
    assert said.verdict == WALKS_IF and len(said.because) == 2
    assert "4.1 mm below ground" in said.because[0] and "needs friction 24 and the ground has 1.1" in said.because[1]
    enough = dataclasses.replace(found.validity, friction_there_is=30.0, time_outside_cone=0.0, deepest_scuff=0.0)
    assert on_a_ramp(enough, True).verdict == WALKS


@pytest.mark.parametrize(("change", "verdict", "word"), [
    ({}, WALKS, "walks on a plain ramp"),
    ({"deepest_scuff": 2e-3}, WALKS_IF, "stepping blocks or feet that retract"),
    ({"impulse_friction_trailing": 1.2}, WALKS_IF, "trailing foot may slip"),
    ({"time_outside_cone": 0.1}, WALKS_IF, "trailing foot may slip"),
    ({"impulse_normal_trailing": -1e-3}, WALKS_IF, "may lift"),
    ({"friction_single_stance": 1.2}, DOES_NOT, "the stance foot needs friction 1.2, the ground has 1.1"),
    ({"impulse_friction_landing": 1.2, "deepest_scuff": 2e-3}, DOES_NOT, "the impulse on the landing foot needs"),
    ({"least_normal_force_stance": -0.5}, DOES_NOT, "pull the stance foot with 0.5 N"),
])
def test_each_force_that_the_ground_has_not_decides(change, verdict, word):
    said = on_a_ramp(dataclasses.replace(GOOD, **change), True)
    assert said.verdict == verdict and word in said.sentence


def test_an_unstable_gait_does_not_walk():
    assert on_a_ramp(GOOD, False).sentence == "does not walk on a plain ramp: a step enlarges what disturbs it"
