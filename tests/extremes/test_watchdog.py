"""A point that dies or hangs costs itself alone."""

from stages.extremes.verdict import CRASHED, HUNG, RIGHT
from stages.extremes.watchdog import compute
from tests.extremes.hands import behave


def test_a_dead_and_a_hung_process_are_told_and_replaced():
    points = ["first", "die", "second", "hang", "third"]
    told = []
    found = compute(behave, 0.5, points, processes=2, longest_s=4.0, done=told.append)
    assert [finding.status for finding in found] == [RIGHT, CRASHED, RIGHT, HUNG, RIGHT]
    assert [finding.reason for finding in found[::2]] == points[::2], "findings stand in the order of the points"
    assert found[0].error == 0.5 and told[-1] == len(points)
