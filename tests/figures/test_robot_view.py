"""Drawings of the robot: its parts are where the walk has them, gravity points down, nothing is lost in the cutting."""

import dataclasses
import math

import matplotlib.pyplot as plt
import numpy as np
import pytest

from pipeline.parameters.loading import load
from stages.figures import view
from stages.figures.drawn import figure_09_section
from stages.ground.blocks import Blocks, BlocksDoNotFit
from stages.stability.parameters import Parameters as Stability
from stages.twin.exports.solids import box, ring
from stages.twin.machine.parts import Part
from stages.twin.parameters import Parameters
from stages.twin.ramp import laid
from tests.comparison.made_up import make_walk

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
    pose = view.pose_at(walk, time, NATURAL)
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
    assert figure_09_section.area(found) == pytest.approx(2.0 * area)
    assert {round(abs(cut.z + cut.width / 2), 9) for cut in found if axis != "y"} <= {0.04}
    assert found, "what the plane misses is drawn behind it"


def test_pale_paint_is_nearer_to_white():
    faces = view.faces(box((0.1, 0.1, 0.1)), np.array([0.2, 0.4, 0.1]))
    figure, panels = plt.subplots(1, 2)
    for axes, strength in zip(panels, (1.0, 0.5)):
        view.paint(axes, view.Camera(0.3, 0.3, 0.0), [faces], strength=strength)
    full, pale = (axes.collections[0].get_facecolor()[:, :3] for axes in panels)
    plt.close(figure)
    assert len(full) == len(pale) == (faces.normals @ view.Camera(0.3, 0.3, 0.0).axes[2] > 0).sum()
    assert pale == pytest.approx(0.5 + 0.5 * full)


@pytest.mark.parametrize("step", [0.01, 0.05, 0.161, 0.4, 1.5])
def test_there_are_blocks_for_steps_of_any_length(repository, step):
    settings = load(repository / "params", [], {"twin": Parameters}, [Parameters, Stability])["twin"].settings
    ramp, blocks = laid(settings, Blocks(), step), Blocks()
    assert ramp.step == step and 2 <= ramp.sets <= blocks.block_sets
    assert ramp.lanes[0].length <= blocks.block_length
    with pytest.raises(BlocksDoNotFit):
        laid(dataclasses.replace(settings, scene="ramp"), blocks, 1.5)
