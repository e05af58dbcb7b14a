"""The usual parameters are looked at once, while the code is compiled, and every point gets its own verdict."""

from collections import Counter

import pytest

from stages.extremes import run as stage
from stages.extremes.parameters import LIMIT, RIGHT
from stages.extremes.result import Finding
from tests.study import parameters_of


@pytest.mark.parametrize("resolution", ["few", "coarse", "full"])
def test_each_point_has_its_own_verdict(monkeypatch, resolution):
    parameters, usual = parameters_of("extremes", f"extremes.resolution={resolution}"), Counter()

    def evaluate(_, point):
        usual[point.engine] += not point.changes
        return Finding(RIGHT, reason=told(point))

    def told(point):
        return f"{point.engine} {point.value if point.engine == LIMIT else ''} {point.changes}"

    monkeypatch.setattr(stage, "evaluate", evaluate)
    monkeypatch.setattr(stage, "compute", lambda evaluate, common, points, **_: [evaluate(common, p) for p in points])
    assert stage.run(parameters).reason == tuple(told(point) for point in stage.points(parameters))
    assert len(usual) > 2
    assert {number for engine, number in usual.items() if engine != LIMIT} <= {0, 1}
