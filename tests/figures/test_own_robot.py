"""Pictures of a biped of one's own: its own lengths and parts, feet on the ground, the whole robot in the frame."""

import dataclasses
import itertools
import re
from functools import cache
from types import SimpleNamespace

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.collections import PolyCollection
from matplotlib.text import Text

from stages.drawing import style
from stages.figures import view
from stages.figures.drawn import figure, gait_animation, robot_in_space, robot_scenes
from stages.figures.view import SMALL, by_group, of_twin
from tests.comparison.made_up import make_walk, resampled
from tests.figures.made_up_results import given
from tests.study import SLOPE, TABLE_1, parameters_of

#: Leg length [m], foot radius and height of its mass as shares of it, and whether there are parts.
ROBOTS = [(0.1, 0.25, 0.3, "parts"), (0.5, 0.25, 0.3, "planar"), (1.2, 0.6, 0.05, "parts"), (1.2, 0.0, 0.0, "planar"),
          (0.65, 0.9, 0.8, "parts")]  # fmt: skip
FIGURES = ("figure_03_simple_model", "figure_09_section", "figure_10_twin", "figure_12_ramp", "figure_13_steps",
           "figure_15_sensors")  # fmt: skip


#: Two that are drawn quickly; the others by the slow tests.
QUICK = ("figure_10_twin", ROBOTS[3]), ("figure_13_steps", ROBOTS[1])
CASES = [(name, one) if (name, one) in QUICK else pytest.param(name, one, marks=pytest.mark.slow)
         for name in FIGURES for one in ROBOTS[:4]]  # fmt: skip


@cache
def robot(length, radius, com, inertia):
    """Parameters of a biped of this leg length whose feet and masses are such shares of it."""
    own = {"leg_length": length, "foot_radius": radius * length, "foot_com": com * length, "hip_mass": 2.0 * length}
    return parameters_of("twin", *(f"biped.{key}={value!r}" for key, value in own.items()), f"twin.inertia={inertia}")


def walked(name, known):
    """What a figure is given of the made-up results, with a walk of the robot's size."""
    shown, length = given(name), known.biped.leg_length
    for stage in {"twin", "multibody"} & set(vars(shown)):
        result = getattr(shown, stage)
        walk = result.walk
        larger = {key: getattr(walk, key) * length / 0.333 for key in ("hip_position", "leg_length")}
        setattr(shown, stage, SimpleNamespace(**vars(result) | {"walk": dataclasses.replace(walk, **larger)}))
    if "analytic" in vars(shown):
        gait = SimpleNamespace(**vars(shown.analytic.gait) | {"step_length_m": 0.5 * length})
        shown.analytic = SimpleNamespace(**vars(shown.analytic) | {"gait": gait})
    shown.parameters = SimpleNamespace(**vars(shown.parameters) | {"biped": known.biped, "twin": known.settings})
    return shown


def bodies_of(known):
    """The robot as it is drawn in space, and as the simple model."""
    yield of_twin(known.settings, known.biped, SMALL)
    yield by_group(robot_scenes.parts(known.biped), 40)


@pytest.mark.parametrize("shares", ROBOTS)
def test_a_foot_that_stands_is_drawn_on_the_ground(shares):
    known = robot(*shares)
    length, radius = known.biped.leg_length, known.biped.foot_radius
    for angle in (-0.3, 0.18):
        hip = np.array([0.0, radius + (0.995 * length - radius) * np.cos(angle)])  # its springs are loaded
        pose = view.Pose(hip, np.full(2, angle), np.full(2, 0.005 * length))
        for shown in bodies_of(known):
            for group in ("inner_foot", "outer_foot"):
                lowest = pose.placed(shown[group], group).corners[..., 1].min()
                assert abs(lowest) < 0.01 * length, (angle, group, lowest / length)
            assert pose.robot(shown).corners[..., 1].min() > -0.01 * length


@pytest.mark.parametrize(("name", "shares"), CASES)
def test_the_whole_robot_is_in_the_frame(name, shares):
    with style.drawing():
        picture = figure(name).draw(walked(name, robot(*shares)))
        plt.close(picture)
    seen = 0
    for axes in picture.axes[: 1 if name == "figure_15_sensors" else None]:
        painted = [one for one in axes.collections if isinstance(one, PolyCollection)]
        for robot_s in painted[1:] if name == "figure_10_twin" else painted[-1:]:
            corners = np.concatenate([path.vertices for path in robot_s.get_paths()])
            for low, high, limits in zip(corners.min(axis=0), corners.max(axis=0),
                                         (axes.get_xlim(), axes.get_ylim()), strict=True):  # fmt: skip
                assert limits[0] <= low and high <= limits[1]
            seen += 1
    assert seen


@pytest.mark.parametrize("shares", ROBOTS[:4])
def test_the_first_picture_of_the_report_holds_the_whole_robot(shares):
    """In its drawing; the moving picture's camera goes as far away as `size` says, where the ramp is as wide again."""
    known = robot(*shares)
    shown = walked("robot_in_space", known)
    moving = robot_in_space.scene(shown)
    assert moving["size"] * robot_in_space.WIDE >= known.settings.outer_lane
    assert moving["size"] >= known.biped.leg_length / 0.333 * 0.999
    drawn = robot_in_space.drawing(moving)
    left, top, width, height = map(float, re.search(r'viewBox="([^"]*)"', drawn)[1].split())
    for path in re.findall(r'<path class="(?:inner|outer) [^"]*" d="([^"]*)"', drawn):
        across, down = np.array(re.findall(r"(-?[\d.]+) (-?[\d.]+)", path), float).T
        assert left <= across.min() and across.max() <= left + width
        assert top <= down.min() and down.max() <= top + height


@pytest.mark.slow
@pytest.mark.parametrize("length", [0.1, 0.333, 1.2])
def test_numbers_of_parts_stand_beside_one_another(length):
    with style.drawing():
        picture = figure("figure_09_section").draw(walked("figure_09_section", robot(length, 0.25, 0.3, "parts")))
        with style.laid_out(picture, 80):
            picture.draw_without_rendering()
            numbers = [text for text in picture.axes[1].texts if text.get_text().isdigit()]
            places = [Text.get_window_extent(text).padded(1.0) for text in numbers]  # without their arrows
    assert len(places) > 9 and not any(one.overlaps(other) for one, other in itertools.combinations(places, 2))


def test_feet_of_legs_that_differ_are_drawn_on_the_ground():
    """Each by its own length and radius, as the simple model, in space and as the moving page has it."""
    known = robot(*ROBOTS[1])
    biped = dataclasses.replace(known.biped, other_leg_length=0.46, other_foot_radius=0.1)
    own = SimpleNamespace(biped=biped, settings=known.settings)
    hip = np.array([0.0, 0.46])
    lengths = view.unloaded(own.settings, biped)
    assert lengths == (0.5, 0.46)
    walk = make_walk()
    standing = dataclasses.replace(walk, hip_position=0.0 * walk.hip_position + hip, leg_angle=0.0 * walk.leg_angle,
                                   leg_length=0.0 * walk.leg_length + 0.46)  # fmt: skip
    pose = view.pose_at(standing, 0.0, lengths)
    for shown in bodies_of(own):
        for group in ("inner_foot", "outer_foot"):
            assert pose.placed(shown[group], group).corners[..., 1].min() == pytest.approx(0.0, abs=1e-3)
    moving = robot_in_space.scene(walked("robot_in_space", own))
    assert moving["natural"]["ghost"] == [0.5, 0.46] and moving["radius"] == [0.125, 0.1]
    for leg, (length, radius) in enumerate(((0.5, 0.125), (0.46, 0.1))):
        [ghost] = [row for row in moving["parts"] if row["group"] == f"ghost_foot_{leg}" and row["shape"] == "arc"]
        assert ghost["size"][0] == radius and ghost["place"][1] == pytest.approx(radius - length)


def test_what_a_detailed_design_adds_to_its_bill_is_named_below_the_section():
    """The bill is that of the plain design, whatever the details are."""
    known, about = robot(*ROBOTS[0]), figure("figure_09_section")
    more = {"frame_mass": 0.01, "frame_com": 0.02, "other_leg_length": known.biped.leg_length + 1e-3}
    plain, detailed = (SimpleNamespace(parameters=SimpleNamespace(biped=biped, twin=known.settings))
                       for biped in (known.biped, dataclasses.replace(known.biped, **more)))
    said = about.caption(detailed)
    assert said.startswith(about.caption(plain)) and "frame_mass, frame_com, other_leg_length of this design" in said
    with style.drawing():
        hips = [about.draw(given).axes[1] for given in (plain, detailed)]
    one, other = ([patch.get_bbox().bounds for patch in hip.patches] for hip in hips)
    plt.close("all")
    assert len(one) > 20 and one == other


@pytest.mark.parametrize(("large", "heavy", "limit", "mark"), [(10.0, 200.0, 2500.0, 1.0), (1e-2, 1e-6, 1.5e-5, 1e-3)],
                         ids=["3.33 m", "3.33 mm"])  # fmt: skip
def test_marks_and_forces_of_the_animation_suit_the_robot(large, heavy, limit, mark):
    """Arrows, marks, the scale of forces and what poses are whole numbers of follow its legs and its weight."""
    walk = make_walk()
    own = dataclasses.replace(TABLE_1, leg_length=large * TABLE_1.leg_length, foot_mass=heavy * TABLE_1.foot_mass,
                              hip_mass=heavy * TABLE_1.hip_mass)  # fmt: skip
    loaded = dataclasses.replace(walk, ground_reaction=heavy * walk.ground_reaction)
    shown, usual = (gait_animation.content([one] * 3, biped, SLOPE) for one, biped in ((loaded, own), (walk, TABLE_1)))
    assert (shown["limit"], shown["mark"], usual["mark"]) == (pytest.approx(limit), pytest.approx(mark), 0.1)
    assert shown["arrow"] * shown["limit"] == pytest.approx(large * usual["arrow"] * usual["limit"])
    assert shown["units"] == pytest.approx({"length": 1e-5 * large, "angle": 1e-4, "force": 9.67e-3 * heavy}, rel=1e-3)


# --- The animation shows the walks' own samples, on common times, to the stated resolution.


@pytest.fixture(scope="module")
def walks():
    return make_walk(), make_walk(period=0.51), make_walk(speed=0.31, steps=6)


def test_poses_and_forces_are_those_of_the_walks(walks):
    shown = gait_animation.content(walks, TABLE_1, SLOPE)
    assert shown["count"] == int(walks[2].time[-1] * gait_animation.FRAME_RATE) + 1, "the shortest walk decides"
    time = np.arange(shown["count"]) / shown["rate"]
    for source, walk in zip(shown["sources"], walks, strict=True):
        for key, signal, kind in (
            ("hip", walk.hip_position, "length"),
            ("angle", walk.leg_angle, "angle"),
            ("length", walk.leg_length, "length"),
            ("force", walk.ground_reaction, "force"),
        ):
            columns, unit = signal.reshape(len(walk.time), -1), shown["units"][kind]
            expected = np.column_stack([np.interp(time, walk.time, column) for column in columns.T])
            assert np.reshape(source[key], expected.shape) * unit == pytest.approx(expected, abs=0.5001 * unit), key


def test_the_scale_of_forces_leaves_impacts_out_and_the_gait_in(walks):
    limit = gait_animation.content(walks, TABLE_1, SLOPE)["limit"]
    assert limit == 15.0, "all walks carry 9 N"


def test_the_scale_of_forces_does_not_follow_the_samples(walks):
    """Half of this walk's samples lie in half a millisecond of impact, as in walks sampled densely around one."""
    walk = walks[0]
    time = np.sort(np.concatenate([walk.time, np.linspace(0.3501, 0.3506, len(walk.time))]))
    dense = resampled(walk, time)
    dense.ground_reaction[(time > 0.35) & (time < 0.351), 0, 1] = 700.0
    assert gait_animation.content((dense, *walks[1:]), TABLE_1, SLOPE)["limit"] == 15.0
