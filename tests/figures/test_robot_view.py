"""Drawings of the robot: its parts where the walk has them, its symbols, and the report's first picture in space."""

import dataclasses
import json
import math
import re
import xml.etree.ElementTree as ElementTree
from types import SimpleNamespace

import matplotlib.pyplot as plt
import numpy as np
import pytest

from stages.biped.design import Biped
from stages.comparison.claims.judge import STATEMENTS
from stages.drawing import style
from stages.figures import view
from stages.figures.drawn import figure_09_section, robot_in_space, robot_symbols
from stages.figures.drawn.robot_symbols import DrawnLeg, Page, formula
from stages.ground.blocks import Blocks, BlocksDoNotFit
from stages.twin.exports.solids import box, ring
from stages.twin.machine.parts import Part
from stages.twin.ramp import laid
from tests.comparison.made_up import make_walk
from tests.figures.made_up_results import drawn, given, machine, parameters, twin
from tests.figures.test_golden import same_version
from tests.study import ROOT, parameters_of

NATURAL, RADIUS = 0.333, 0.083


def part(shape, size, axis="z", position=(0.0, 0.0, 0.0), group="inner_foot", pieces=1):
    return Part("one", group, "steel", shape, axis, size, 1.0, position, pieces)


@pytest.mark.parametrize(("azimuth", "elevation", "slope"), [(0.0, 0.0, 0.0), (0.5, 0.3, 0.1), (-0.8, 0.2, 0.6)])
def test_a_camera_keeps_lengths_and_gravity_points_down_the_page(azimuth, elevation, slope):
    camera = view.Camera(azimuth, elevation, slope)
    assert camera.axes @ camera.axes.T == pytest.approx(np.eye(3), abs=1e-15)
    assert np.linalg.det(camera.axes) == pytest.approx(1.0)
    down = camera.page(np.array([math.sin(slope), -math.cos(slope), 0.0]))
    assert down == pytest.approx([0.0, -math.cos(elevation)], abs=1e-15)
    assert camera.axes[2] @ [0.0, 0.0, 1.0] > 0.0, "it looks at the left side"


def test_a_foot_is_where_the_walk_has_it():
    walk = make_walk()
    time = 0.3 * walk.time[-1]
    pose = view.pose_at(walk, time, (NATURAL, NATURAL))
    for pair, group in enumerate(("inner_foot", "outer_foot")):
        found = pose.point((0.0, RADIUS - NATURAL, 0.02), group)
        angle, length = (np.interp(time, walk.time, each[:, pair]) for each in (walk.leg_angle, walk.leg_length))
        expected = pose.hip + (length - RADIUS) * np.array([math.sin(angle), -math.cos(angle)])
        assert found == pytest.approx([*expected, 0.02])
        assert pose.point((0.0, 0.0, 0.0), f"{group[:5]}_frame") == pytest.approx([*pose.hip, 0.0])


def test_the_machine_stands_on_the_ground_when_upright():
    foot = part("arc", (RADIUS, 0.012, 0.02, 0.11), position=(0.0, RADIUS - NATURAL, 0.04), pieces=2)
    found = view.upright(NATURAL).robot(view.by_group((foot,), 400))
    assert found.corners[..., 1].min() == pytest.approx(0.0, abs=1e-5)
    assert sorted(set(found.corners[..., 2].ravel().round(6))) == [-0.05, -0.03, 0.03, 0.05]


@pytest.mark.parametrize("surface", [box((0.1, 0.02, 0.3)), ring(0.05, 0.04, 0.2)])
def test_cut_triangles_cover_the_same_area_with_short_edges(surface):
    before = surface.corners[surface.triangles]

    def area(corners):
        return np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum()

    after = view.cut(before, 0.03)
    assert area(after) == pytest.approx(area(before))
    assert np.linalg.norm(after[:, (1, 2, 0)] - after, axis=2).max() <= 0.03
    assert np.cross(after[:, 1] - after[:, 0], after[:, 2] - after[:, 0]).sum(axis=0) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(
    ("shape", "size", "axis", "x", "area"),
    [
        ("box", (0.02, 0.1, 0.03), "z", 0.0, 0.1 * 0.03),
        ("box", (0.02, 0.1, 0.03), "z", 0.011, 0.0),
        ("cylinder", (0.05, 0.2), "z", 0.0, 0.1 * 0.2),
        ("cylinder", (0.05, 0.2), "z", 0.03, 0.08 * 0.2),
        ("tube", (0.05, 0.03, 0.2), "z", 0.0, 2 * 0.02 * 0.2),
        ("tube", (0.05, 0.03, 0.2), "y", 0.04, 0.06 * 0.2),
        ("tube", (0.05, 0.03, 0.2), "z", 0.06, 0.0),
        ("cylinder", (0.05, 0.2), "x", 0.0, 0.0),
        ("arc", (0.08, 0.012, 0.02, 0.1), "z", 0.0, 0.012 * 0.02),
    ],
)
def test_a_section_has_the_area_that_the_plane_cuts(shape, size, axis, x, area):
    found = list(figure_09_section.cuts(part(shape, size, axis, (x, -0.1, 0.04), pieces=2)))
    assert sum(cut.width * cut.height for cut in found if cut.solid) == pytest.approx(2.0 * area)
    assert {round(abs(cut.z + cut.width / 2), 9) for cut in found if axis != "y"} <= {0.04}
    assert found, "what the plane misses is drawn behind it"


def test_a_part_is_numbered_on_the_left_half_and_beside_the_axis_only_in_the_middle():
    pipe, shaft = (part(*each, group="inner_frame") for each in (
        ("tube", (0.006, 0.004, 0.1), "y"), ("cylinder", (0.005, 0.2), "z")))  # fmt: skip
    ((_, (on_pipe, _)),), ((_, (on_shaft, _)),) = (figure_09_section.numbered([each], 0.3) for each in (pipe, shaft))
    assert 0.004 < on_pipe < 0.006 and 0.0 < on_shaft < 0.1


def test_pale_paint_is_nearer_to_white():
    faces = view.faces(box((0.1, 0.1, 0.1)), np.array([0.2, 0.4, 0.1]), 0.2)
    _, panels = plt.subplots(1, 2)
    for axes, strength in zip(panels, (1.0, 0.5)):
        view.paint(axes, view.Camera(0.3, 0.3, 0.0), [faces], strength=strength)
    full, pale = (axes.collections[0].get_facecolor()[:, :3] for axes in panels)
    assert len(full) == len(pale) == (faces.normals @ view.Camera(0.3, 0.3, 0.0).axes[2] > 0).sum()
    assert pale == pytest.approx(0.5 + 0.5 * full)


@pytest.mark.parametrize("large", [0.01, 100.0])
def test_the_ramp_of_a_larger_robot_is_drawn_alike(large):
    """Its blocks were 30 mm high whatever walked on them, and a leg of 33 m had 10 million triangles."""
    settings, blocks = parameters_of("twin").settings, Blocks()
    larger = (dataclasses.replace(one, **{name: large * getattr(one, name) for name in names}) for one, names in (
        (settings, ("ramp_length", "inner_lane", "outer_lane")), (blocks, ("block_length", "block_width"))))
    table_1, other = laid(settings, blocks, 0.16), laid(*larger, 0.16 * large)
    for one, its in ((view.blocks(table_1, 1.0), view.blocks(other, large)),
                     (view.deck(-0.2, 1.8, 0.3, 1.0), view.deck(-0.2 * large, 1.8 * large, 0.3 * large, large))):
        assert len(its.corners) == len(one.corners)
        for edge in (np.min, np.max):
            assert edge(its.corners, axis=(0, 1)) == pytest.approx(large * edge(one.corners, axis=(0, 1)))


@pytest.mark.parametrize("step", [0.01, 0.05, 0.161, 0.4, 1.5])
def test_there_are_blocks_for_steps_of_any_length(step):
    settings, blocks = parameters_of("twin").settings, Blocks()
    ramp = laid(settings, blocks, step)
    assert ramp.step == step and 2 <= ramp.sets <= blocks.block_sets
    assert ramp.lanes[0].length <= blocks.block_length
    with pytest.raises(BlocksDoNotFit):
        laid(dataclasses.replace(settings, scene="ramp"), blocks, 1.5)


# --- The drawing of the biped: all symbols, the design's own lengths, readable on light and dark pages.


COLOUR = re.compile(r"(?:stroke|fill): (#[0-9a-f]{6})")


@pytest.fixture(scope="module")
def picture():
    """The drawing of the study's own parameters."""
    values = parameters_of("figures")
    with style.drawing():
        return robot_symbols.draw(SimpleNamespace(parameters=values))


def symbols_in(picture):
    """Symbols in the picture, from what Matplotlib notes beside their outlines."""
    return {symbol for words in re.findall("<!-- (.*?) -->", picture) for symbol in re.findall(r"\$[^$]*\$", words)}


def test_every_symbol_of_the_parameters_is_in_the_drawing_and_no_unknown_one(picture):
    symbols = {field.metadata["symbol"] for field in dataclasses.fields(Biped)
               if field.metadata.get("symbol") and field.metadata["unit"] != "s"}  # a time has no place in a drawing
    motion = {formula(symbol) for symbol in ("theta", "psi", "L_1", "L_2", "alpha")} | {"$x$", "$y$", "$g$"}
    assert len(symbols) > 25
    assert symbols_in(picture) == {formula(symbol) for symbol in symbols} | motion


def test_symbols_are_set_as_mathematics():
    assert formula("L_nat_2") == r"$L_{\mathrm{nat},2}$"
    assert formula("tau_h") == r"$\tau_{h}$"
    assert formula("k") == "$k$"


def test_it_is_a_picture_of_its_own_and_has_a_title(picture):
    root = ElementTree.fromstring(picture)
    assert root.tag.endswith("svg") and root.attrib["role"] == "img" and root[0].text == robot_symbols.TITLE
    assert len(picture) < 80_000


def test_every_colour_has_its_place_on_a_dark_page(picture):
    rules, body = picture.split("</style>", 1)
    used = set(COLOUR.findall(body))
    assert {robot_symbols.FIRST.lower(), robot_symbols.OTHER.lower()} < used
    assert used <= set(COLOUR.findall(rules)) == {colour.lower() for colour in robot_symbols.DARK}


def test_words_and_lines_stand_out_from_both_pages():
    """Contrast by WCAG 2: 3 for lines and large signs."""

    def light(colour):
        parts = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
        linear = [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts]
        return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2] + 0.05

    for colour, other in robot_symbols.DARK.items():
        if colour != "#FFFFFF":
            assert light("#FFFFFF") / light(colour) > 3.0
            assert light(other) / light("#121416") > 3.0


def test_a_leg_is_drawn_with_the_designs_lengths():
    _, axes = plt.subplots()
    leg = DrawnLeg(Page(axes, 0.0), 0.1 + 0.3j, 0.2, 0.333, 0.083, 0.1, "#000000")
    leg.draw()
    x, y = max((line.get_data() for line in axes.lines), key=lambda data: len(data[0]))
    centre = leg.at(0.0, 0.25)
    assert abs(centre - leg.hip) == pytest.approx(0.25) and centre.real > leg.hip.real
    assert abs(x + 1j * y - centre) == pytest.approx(0.083)
    assert abs(leg.at(0.0, 0.233) - leg.at(0.0, 0.333)) == pytest.approx(0.1)


def in_parts(drawing):
    """A drawing without its paths, and their extents (n, 4) [pt]. Last digits, another on each processor, decide which
    points a path leaves out, and the names of clips: here 0, 1, ..."""
    names = list(dict.fromkeys(re.findall(r'<clipPath id="(\w+)"', drawing)))
    drawing = re.sub("|".join(names), lambda found: str(names.index(found[0])), drawing)
    points = [np.reshape(re.findall(r"-?[\d.]+", path), (-1, 2)).astype(float)
              for path in re.findall(r' d="([^"]+)"', drawing)]  # fmt: skip
    return re.sub(r' d="[^"]+"', "", drawing), [[*each.min(axis=0), *each.max(axis=0)] for each in points]


@same_version
def test_the_picture_of_the_docs_is_that_of_the_parameters(picture):
    (text, its_paths), (wanted, paths) = in_parts((ROOT / "docs/robot.svg").read_text()), in_parts(picture)
    assert text == wanted, "make readme"
    np.testing.assert_allclose(its_paths, paths, rtol=0, atol=0.05, err_msg="make readme")


# --- The robot of the report's first picture: its parts are the bill's, its poses the walks', at the same phases.


def scene(**other):
    return robot_in_space.scene(given("robot_in_space", **other))


def shown(page):
    return json.loads(page.split('class="data">')[1].split("</script>")[0])


def test_poses_are_those_of_the_last_stride_at_even_phases():
    walk, moving = twin().walk, scene()
    begin, end = walk.heel_strike_time[walk.heel_strike_leg == 0][-2:]
    assert moving["loops"] and moving["duration"] == pytest.approx(end - begin, abs=1e-6)
    assert moving["count"] == round(robot_in_space.FRAME_RATE * (end - begin))
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
    assert others == {"inner_frame", "outer_frame", "inner_foot", "outer_foot", "ghost_frame_0", "ghost_foot_0",
                      "ghost_frame_1", "ghost_foot_1"}  # fmt: skip


def test_an_outsole_is_shown_and_the_legs_are_longer_by_it():
    known = parameters()
    known.twin = machine(outsole=2e-3)
    shown = given("robot_in_space")
    shown.parameters = known
    moving = robot_in_space.scene(shown)
    assert len(moving["parts"]) == len(scene()["parts"]) + 2
    assert moving["natural"] == {"twin": pytest.approx([0.335, 0.335]), "ghost": [0.333, 0.333]}
    assert moving["radius"] == pytest.approx([0.085, 0.085])


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


@pytest.mark.parametrize(("name", "most"), [("robot_in_space", 80_000), ("gait_animation", 250_000)])
def test_a_moving_page_has_the_same_bytes_twice_its_data_once_and_no_address(name, most):
    page = drawn(name)
    assert page == drawn(name)
    assert not re.search("://|DATA<|@[A-Z]+@", page)
    assert shown(page)["count"] > 100 and len(page) < most


def test_the_drawing_leans_with_the_slope_and_shows_both_feet_of_a_pair():
    def paths(degrees):
        steep = given("robot_in_space")
        known = vars(parameters()) | {"slope": SimpleNamespace(angle=np.radians(degrees), gravity=9.81)}
        steep.parameters = SimpleNamespace(**known)
        return re.findall(r'<path class="([^"]*)" d="([^"]*)"', robot_in_space.draw(steep))

    level, steep = paths(0.0), paths(10.0)
    assert level[0][0] == "ramp" and len(level) == 1 + sum(
        row["pieces"] for row in scene()["parts"] if not row["group"].startswith("ghost")
    )
    corners = [np.array(re.findall(r"(-?[\d.]+) (-?[\d.]+)", one[0][1]), float) for one in (level, steep)]
    slopes = [(across[1, 1] - across[0, 1]) / (across[1, 0] - across[0, 0]) for across in corners]
    assert slopes == pytest.approx([0.0, np.tan(np.radians(10.0))], abs=1e-3), "down to the right"
