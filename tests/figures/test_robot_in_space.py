"""The robot of the report's first picture: its parts are the bill's, its poses the walks', at the same phases."""

from __future__ import annotations

import dataclasses
import json
import re
from types import SimpleNamespace

import numpy as np
import pytest

from stages.comparison.claims.judge import STATEMENTS
from stages.figures.drawn import robot_in_space as robot
from tests.comparison.made_up import make_walk
from tests.figures.made_up_results import drawn, given, machine, parameters, twin


def scene(**other):
    return robot.scene(given("robot_in_space", **other))


def shown(page):
    return json.loads(page.split('class="data">')[1].split("</script>")[0])


def test_poses_are_those_of_the_last_stride_at_even_phases():
    walk, moving = twin().walk, scene()
    begin, end = walk.heel_strike_time[walk.heel_strike_leg == 0][-2:]
    assert moving["loops"] and moving["duration"] == pytest.approx(end - begin, abs=1e-6)
    assert moving["count"] == round(robot.FRAME_RATE * (end - begin))
    time = begin + np.arange(moving["count"]) / moving["count"] * (end - begin)
    for key, signal, unit in (
        ("angle", walk.leg_angle, "angle"),
        ("length", walk.leg_length, "length"),
        ("force", walk.ground_reaction, "force"),
        ("hip", walk.hip_position - [np.interp(begin, walk.time, walk.hip_position[:, 0]), 0.0], "length"),
    ):
        columns = signal.reshape(len(walk.time), -1).T
        expected = np.column_stack([np.interp(time, walk.time, column) for column in columns])
        step = moving["units"][unit]
        found = np.reshape(moving["twin"][key], expected.shape) * step
        assert found == pytest.approx(expected, abs=0.5001 * step), key


def test_twin_and_ghost_begin_at_one_place_and_each_goes_on_by_its_own_stride():
    moving = scene()
    assert moving["twin"]["hip"][0] == moving["ghost"]["hip"][0] == 0
    assert moving["twin"]["advance"] == pytest.approx(0.3 * 2 * 0.51, abs=1e-6), "speed times two steps"
    assert moving["ghost"]["advance"] == pytest.approx(0.3 * 2 * 0.5, abs=1e-6)


def test_every_part_of_the_bill_that_has_a_shape_is_shown():
    bill, found = machine().parts, scene()["parts"]
    solids = [part for part in bill if part.shape != "point"]
    for part, row in zip(solids, found):
        assert (row["group"], row["shape"], row["axis"]) == (part.group, part.shape, part.axis)
        assert (tuple(row["size"]), tuple(row["place"]), row["pieces"]) == (part.size, part.position, part.pieces)
    others = {row["group"] for row in found[len(solids) :]}
    assert others == {"inner_frame", "outer_frame", "inner_foot", "outer_foot", "ghost_frame", "ghost_foot"}


def test_an_outsole_is_shown_and_the_legs_are_longer_by_it():
    known = parameters()
    known.twin = machine(outsole=2e-3)
    shown = given("robot_in_space")
    shown.parameters = known
    moving = robot.scene(shown)
    assert len(moving["parts"]) == len(scene()["parts"]) + 2
    assert moving["natural"] == {"twin": pytest.approx(0.335), "ghost": 0.333}
    assert moving["radius"] == pytest.approx(0.085)


def test_a_walk_without_a_stride_is_shown_once_from_end_to_end():
    short, walk = twin(), make_walk(steps=2)
    short.walk = dataclasses.replace(walk, heel_strike_time=walk.heel_strike_time[:1], heel_strike_leg=np.array([0]))
    moving = scene(twin=short)
    assert not moving["loops"] and moving["duration"] == pytest.approx(walk.time[-1], abs=1e-6)


def test_the_numbers_are_the_results_and_lead_to_claims_that_are_judged():
    page = drawn("robot_in_space")
    found = re.findall(r'href="#claim-(\w+)"><b>([^<]*)</b> <span>([^<]*)<', page)
    assert [number for _, number, _ in found] == ["2.072 Hz", "0.19 mm", "0.60"] and "2.0400 ± 0.0005 Hz" in found[0][2]
    assert {claim for claim, _, _ in found} <= set(STATEMENTS)
    fell = twin()
    fell.outcome = "fell"
    assert "the twin: fell<" in drawn("robot_in_space", twin=fell)


def test_the_page_has_the_same_bytes_twice_and_no_address():
    page = drawn("robot_in_space")
    assert page == drawn("robot_in_space")
    assert "://" not in page and not re.search("@[A-Z]+@", page)
    assert shown(page)["count"] > 100 and len(page) < 80_000


def test_the_drawing_leans_with_the_slope_and_shows_both_feet_of_a_pair():
    def paths(degrees):
        steep = given("robot_in_space")
        known = vars(parameters()) | {"slope": SimpleNamespace(angle=np.radians(degrees))}
        steep.parameters = SimpleNamespace(**known)
        return re.findall(r'<path class="([^"]*)" d="([^"]*)"', robot.draw(steep))

    level, steep = paths(0.0), paths(10.0)
    assert level[0][0] == "ramp" and len(level) == 1 + sum(
        row["pieces"] for row in scene()["parts"] if not row["group"].startswith("ghost")
    )
    corners = [np.array(re.findall(r"(-?[\d.]+) (-?[\d.]+)", one[0][1]), float) for one in (level, steep)]
    slopes = [(across[1, 1] - across[0, 1]) / (across[1, 0] - across[0, 0]) for across in corners]
    assert slopes == pytest.approx([0.0, np.tan(np.radians(10.0))], abs=1e-3), "down to the right"
