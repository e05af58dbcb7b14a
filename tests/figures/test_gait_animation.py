"""The animation shows the walks' own samples, on common times, to the stated resolution."""

from __future__ import annotations

import json

import numpy as np
import pytest

from stages.figures.drawn import gait_animation as animation
from tests.comparison.made_up import make_walk, resampled
from tests.figures.made_up_results import drawn


@pytest.fixture(scope="module")
def walks():
    return make_walk(), make_walk(period=0.51), make_walk(speed=0.31, steps=6)


def test_poses_and_forces_are_those_of_the_walks(walks):
    shown = animation.content(animation.sources(*walks), 0.083, np.radians(2))
    assert shown["count"] == int(walks[2].time[-1] * animation.FRAME_RATE) + 1, "the shortest walk decides"
    time = np.arange(shown["count"]) / shown["rate"]
    for source, walk in zip(shown["sources"], walks, strict=True):
        for key, signal, unit in (
            ("hip", walk.hip_position, animation.POSITION),
            ("angle", walk.leg_angle, animation.ANGLE),
            ("length", walk.leg_length, animation.POSITION),
            ("force", walk.ground_reaction, animation.FORCE),
        ):
            columns = signal.reshape(len(walk.time), -1)
            expected = np.column_stack([np.interp(time, walk.time, column) for column in columns.T])
            assert np.reshape(source[key], expected.shape) * unit == pytest.approx(expected, abs=0.5001 * unit), key


def test_the_scale_of_forces_leaves_impacts_out_and_the_gait_in(walks):
    assert animation.content(animation.sources(*walks), 0.083, 0.0)["limit"] == 15.0, "all walks carry 9 N"


def test_the_scale_of_forces_does_not_follow_the_samples(walks):
    """Half of this walk's samples lie in half a millisecond of impact, as in walks sampled densely around one."""
    walk = walks[0]
    time = np.sort(np.concatenate([walk.time, np.linspace(0.3501, 0.3506, len(walk.time))]))
    dense = resampled(walk, time)
    dense.ground_reaction[(time > 0.35) & (time < 0.351), 0, 1] = 700.0
    assert animation.content(animation.sources(dense, *walks[1:]), 0.083, 0.0)["limit"] == 15.0


def test_the_page_holds_the_data_once_and_no_address():
    page = drawn("gait_animation")
    data = page.split('class="data">')[1].split("</script>")[0]
    assert json.loads(data)["count"] > 100
    assert "DATA<" not in page and "://" not in page
    assert len(page) < 250_000
