"""Figures of the study, of questions and of the package as a referee reads them."""

import csv
import dataclasses
import json
from itertools import combinations
from types import SimpleNamespace
from unittest.mock import patch

import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PathCollection
from matplotlib.text import Text
from matplotlib.ticker import FixedLocator

import bipedstudy
from benchmarks import tradeoff
from benchmarks.extremes_table import DOCS
from stages.analytic.maps.answers import NONE, STABLE, UNSTABLE
from stages.analytic.maps.box import Axis, Box
from stages.analytic.pictures import design_map, families, gaits
from stages.calibration.information.identifiability import Identifiability
from stages.calibration.reports import angle_report, identifiability_report
from stages.calibration.reports.sensor_picture import fit_picture
from stages.comparison.agreement import HipDifference
from stages.drawing import style
from stages.extremes.result import Result as Extremes
from stages.figures.drawn import at_level, figure, given_to, work_and_extremes
from stages.imu.export import picture
from tests.comparison.made_up import make_walk
from tests.figures.made_up_results import calibration, comparison, drawn, parameters, results, stability
from tests.figures.test_golden import PICTURES

AXES = (Axis("ground.slope_deg", "deg", 1.0, 4.0, False, 30), Axis("biped.stiffness", "N/m", 1e3, 1e4, True, 20),
        Axis("biped.foot_radius", "m", 0.05, 0.12, False, 5), Axis("biped.leg_inertia", "kg m^2", 1e-4, 2e-3, True, 4))


def design_map_of(count, size=None):
    """A map of so many axes, a grid or `size` scattered designs: some do not walk, some not stably."""
    axes = AXES[:count]
    box = Box(axes, size or int(np.prod([axis.steps for axis in axes])), None if size is None else 1)
    values = box.values(0, box.size)
    shares = box.shares(0, box.size)
    largest = 0.4 + shares.sum(axis=1) / count
    outcome = np.where(shares[:, 0] > 0.9, NONE, np.where(
        largest < 1, STABLE, UNSTABLE))
    gait = outcome != NONE
    columns = {axis.name: column for axis, column in zip(axes, values.T)}
    columns |= {"outcome": outcome, "largest_multiplier": np.where(gait, largest, np.nan),
                "period_s": np.where(gait, 0.5 + 0.05 * shares[:, -1] + 0.02 * shares[:, 0], np.nan)}
    return design_map.draw(box, columns)


def searches(goal_unit="1"):
    """A search over four parameters, and two that end elsewhere."""
    names = ("biped.foot_radius", "biped.foot_com", "biped.stiffness", "biped.damping")
    path = np.linspace([0.083, 0.1, 2800.0, 58.0], [0.1, 0.08, 3300.0, 70.0], 8)
    bounds = {name: (0.8 * value, 1.25 * value) for name, value in zip(names, path[0])}
    made = [SimpleNamespace(history=tuple(0.64 - 0.03 * (row + start) for row in range(8)), path=path)
            for start in range(3)]
    goal = SimpleNamespace(title="largest multiplier", unit=goal_unit)
    return gaits.draw_searches(made, bounds, goal)


def elasticities(steps=1):
    """A gait with as many parameters as one in detail has, and a pair of multipliers."""
    names = ("biped.hip_mass", "biped.foot_mass", "biped.leg_length", "biped.foot_radius", "biped.foot_com",
             "biped.stiffness", "biped.damping", "biped.leg_inertia", "ground.slope_deg", "ground.gravity")
    shares = np.linspace(-1.0, 1.0, len(names))
    changes = SimpleNamespace(names=names, values=np.ones(len(names)))
    measures = ("period_s", "step_length_m", "speed_m_s", "step_frequency_hz")
    tangents = SimpleNamespace(changes=changes, elasticities=lambda: dict.fromkeys(measures, shares),
                               point=SimpleNamespace(steps=steps * [None]))
    pair = SimpleNamespace(values=np.array([-0.62 + 0.21j, -0.62 - 0.21j]),
                           elasticities=lambda: np.array([shares, np.where(shares > 0, np.nan, shares)]))
    return gaits.draw_elasticities(tangents, pair)


def run_of_sensors(stamp=True):
    """A run with phone stamps or with none but the sensors' own, and a verdict of many words."""
    time = np.arange(0.0, 8.0, 0.01)
    stamps = time + 0.03 + 0.002 * np.sin(9 * time)
    empty = np.full(len(time), np.nan)
    recording = SimpleNamespace(rows=len(time), phone_stamp=stamps if stamp else empty, server_stamp=empty,
                                device_stamp=empty)
    indexed = SimpleNamespace(recording=recording, index=np.arange(len(time)), segment=np.zeros(len(time), dtype=int),
                              batch_size=1, resets=0)
    motion = np.column_stack([np.sin(6 * time), 9.8 + np.cos(6 * time), 0 * time])
    sensor = SimpleNamespace(time=time, trace=SimpleNamespace(indexed=indexed), force=motion, rate=motion)
    words = tuple(f"the foot's stamps of packet {number} are late against those of the hip by more than they may be"
                  for number in range(4))
    return picture(SimpleNamespace(
        experiment=SimpleNamespace(name="2026-03-04_treadmill_long_name_of_a_run_007", origin="measured"),
        sensors={"hip": sensor, "foot": sensor},
        strikes=SimpleNamespace(time=np.arange(0.4, 8.0, 0.5), leg=np.arange(16) % 2),
        leg=SimpleNamespace(time=time, angle=0.3 * np.sin(6 * time), angle_error=0.01),
        verdict=SimpleNamespace(outcome="used with remarks",
                                sentences=lambda refused: () if refused else words)))


def saved(draw):
    """The one figure that a question saves."""
    kept = []
    draw(kept.append)
    return kept[0]


def residual_angles():
    """Encoders' residuals of steps that were not fitted."""
    wave = np.sin(np.linspace(0, 6, 60))
    residuals = {number: 2e-3 * np.column_stack([wave, wave]) * number for number in range(1, 6)}
    return saved(lambda save: angle_report._draw(
        SimpleNamespace(found=SimpleNamespace(residuals=residuals, steps=5)), save))


def standard_deviations():
    """What runs tell of eight parameters, and what further measurements would."""
    names = ("biped.hip_mass", "biped.foot_mass", "biped.leg_length", "biped.foot_radius", "biped.foot_com",
             "biped.stiffness", "biped.damping", "biped.leg_inertia")
    ones = np.ones(len(names))
    single, found = (Identifiability(names, ones, ones, runs, share * ones, np.zeros((0, 8)), (), ones, ones)
                     for runs, share in ((1, 0.05), (30, 0.01)))
    tried = [(f"a measurement of {name} by itself, to a share of a thousandth", 5e-3 * ones, "")
             for name in names[:6]]
    return saved(lambda save: identifiability_report._draw(found, single, tried, save))


def fit_of(side="fit"):
    """A fitted run."""
    fit = calibration().fits[0]
    return fit_picture({"hip": fit.hip, "foot": fit.foot}, fit.strikes, side)


#: Names of pictures, and what draws them.
OF_QUESTIONS = {
    "map --figure, one axis": lambda: design_map_of(1),
    "map --figure, two axes": lambda: design_map_of(2),
    "map --figure, two axes, scattered": lambda: design_map_of(2, 300),
    "map --figure, three axes": lambda: design_map_of(3),
    "map --figure, three axes, scattered": lambda: design_map_of(3, 2000),
    "map --figure, four axes": lambda: design_map_of(4),
    "design --figure": searches,
    "sensitivity --figure": elasticities,
    "continue --figure": lambda: families.draw_families(stability().families, "slope [°]"),
    "basin --figure": lambda: families.draw_basin(stability().basin),
    "ingest --figure": run_of_sensors,
    "ingest --figure, no stamps": lambda: run_of_sensors(stamp=False),
    "calibrate --figure": fit_of,
    "calibrate --figure, angles": residual_angles,
    "calibrate --figure, plan": standard_deviations,
    "bs.plot": lambda: bipedstudy.plot(make_walk()),
    "bs.plot, six signals": lambda: bipedstudy.plot(
        make_walk(), "hip_position", "hip_velocity", "leg_angle", "ground_reaction", "hip_specific_force",
        "hip_angular_velocity"),
}


# --- What a referee would complain of in these, and in the study's own.


pytestmark = pytest.mark.usefixtures("drawing")


def all_extremes():
    """The map of extremes that is kept in the docs."""
    with open(DOCS / "extremes.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    columns = {name: tuple(row[name] for row in rows) for name in rows[0]}
    none = np.full(len(rows), np.nan)
    columns |= {"value": np.array([float(value) for value in columns["value"]]), "error": none, "audit": none}
    return work_and_extremes.draw_extremes(SimpleNamespace(extremes=Extremes("full", **columns)))


def all_prices():
    """Work and precision of every model, as it is kept in the docs."""
    result, times = tradeoff.as_result(json.loads(tradeoff.KEPT.read_text(encoding="utf-8")))
    return work_and_extremes.work_and_precision(result, times, "time of a step [yardsticks]")


def without_bandwidth():
    """Figure 16 with sensors of unknown bandwidth."""
    measured = dataclasses.replace(comparison("measured").measurement, bandwidth=float("nan"))
    return drawn("figure_16_measurement", comparison=SimpleNamespace(measurement=measured))


def at_draft():
    """A figure that says how accurate its study is."""
    given = given_to("error_budget_bars", parameters("draft"), results())
    return at_level(figure("error_budget_bars").draw(given), "draft")


LARGE = {"extremes, all": all_extremes, "tradeoff, all": all_prices, "figure 16, no bandwidth": without_bandwidth,
         "at draft": at_draft}  # fmt: skip


@pytest.mark.parametrize("name", PICTURES)
def test_a_figure_passes_a_referee(name):
    assert complaints(drawn(name), phone=True) == []


@pytest.mark.parametrize("name", [
    *OF_QUESTIONS, pytest.param("extremes, all", marks=pytest.mark.slow), *list(LARGE)[1:]])
def test_a_picture_of_a_question_and_a_large_one_pass_a_referee(name):
    assert complaints((OF_QUESTIONS | LARGE)[name]()) == []


def test_what_is_largest_over_the_first_step_stands_in_its_panel():
    compared = SimpleNamespace(**vars(comparison()))
    compared.models = SimpleNamespace(same_start=HipDifference(np.array([0.1, 0.2]), np.array([3.0, 4.0])))
    for panel in drawn("figure_08_hip_motion", comparison=compared).axes[2:4] + drawn("figure_08_hip_motion").axes[2:4]:
        low, high = panel.get_ylim()
        assert all(low < y < high for lines in panel.collections for (_, y), _ in lines.get_segments())


def test_a_spike_is_told_above_its_panel_in_the_panels_unit():
    twin = results()["twin"]
    turning = dataclasses.replace(twin.walk, hip_angular_velocity=100.0 * twin.walk.hip_angular_velocity)
    spiky = SimpleNamespace(**{**vars(twin), "walk": turning})
    panel = next(one for one in drawn("figure_16_measurement", twin=spiky).axes if "rad/s" in one.get_ylabel())
    assert panel.get_title("right").startswith("twin's spike") and panel.get_title("right").endswith(" rad/s")
    assert not panel.texts, "none stands over a curve"


@pytest.mark.parametrize("factor", [1e-2, 1.0, 30.0])
def test_blocks_of_any_robot_have_heights_and_steps_at_their_axes(factor):
    falls, ramp, _, reached = drawn("rough_ground", factor).axes
    for axis in (falls.xaxis, ramp.xaxis, falls.yaxis, reached.yaxis):
        low, high = axis.get_view_interval()
        assert sum(low <= tick <= high for tick in axis.get_majorticklocs()) >= (1 if axis.axis_name == "x" else 2)


def test_enough_figures_are_refereed():
    assert len(PICTURES) + len(OF_QUESTIONS) + len(LARGE) >= 40


def test_a_referee_sees_what_is_wrong():
    picture, (good, empty) = plt.subplots(2, 1, figsize=(3.0, 3.0))
    good.plot([0, 1], [0, 1])
    good.set(xlabel="time [s]", ylabel="speed")
    empty.plot([0, 1], [5, 6])
    empty.set(xlabel="time [s]", ylabel="speed [m/s]", ylim=(0, 1))
    good.text(0.4, 0.5, "one above")
    good.text(0.42, 0.5, "the other", fontsize=6)
    good.text(0.9, 0.2, "words that go on to the right of the picture", in_layout=False)
    said = complaints(picture)
    for words in ("'one above' overlaps 'the other'", "leaves the picture", "'the other' has 6 points",
                  "'speed' has no unit along y", "'speed [m/s]' shows nothing"):
        assert any(words in one for one in said), said
    assert len(said) == 5, said


@pytest.mark.parametrize("width, readable", [(3.5, True), (3.9, False)])
def test_a_referee_has_a_phone(width, readable):
    _, axes = plt.subplots(figsize=(width, 3.0))
    axes.set(xlabel="x [m]", ylabel="y [m]")
    axes.plot([0, 1], [0, 1])
    said = [] if readable else ["the smallest letter has 6.7 points on a phone"]
    assert complaints(axes.figure, phone=True) == said


@pytest.mark.parametrize("apart, count", [(0.15, 0), (0.02, 1)])
def test_turned_texts_overlap_only_where_they_meet(apart, count):
    _, axes = plt.subplots(figsize=(3.0, 3.0))
    axes.set(xlabel="x [m]", ylabel="y [m]")
    axes.plot([0, 1], [0, 1])
    for shift in (0.0, apart):
        axes.text(0.2 + shift, 0.2, "a long turned text", rotation=60)
    assert len(complaints(axes.figure)) == count


# --- What a referee sees of a figure: texts that overlap or leave it, letters too small, axes without units, idle
# panels.


#: The smallest letter [points], in figures that are shown at the size they are made for.
SMALLEST = 7.0
#: Boxes are those of whole lines, with room for accents and tails: so much of it may be shared [points].
SHARED = 1.0
DPI = 100
#: Width of a figure on a phone of 390 px, and pixels an inch there: a point is 1/72 of it.
PHONE, INCH = 358.0, 96.0
#: Pixels an inch that the report gives a piece, where there is room.
PIECE = 100.0


def complaints(figure, phone=False):
    """Everything a referee has to say of a figure, a sentence each; of one of the report also on a phone."""
    FigureCanvasAgg(figure)
    with style.laid_out(figure, DPI):
        texts = drawn_texts(figure)
        words = {id(text): "".join(text.get_text().split("\n"))[:40] for text in texts}
        boxes = [corners(text, figure) for text in texts]
        width, height = (size * DPI for size in figure.get_size_inches())
        room = 0.5 * DPI / 72
        pairs = combinations(zip(texts, boxes), 2)
        said = [f"{words[id(one)]!r} overlaps {words[id(other)]!r}"
                for (one, box), (other, beside) in pairs if overlap(box, beside)]  # fmt: skip
        said += [f"{words[id(text)]!r} leaves the picture" for text, box in zip(texts, boxes)
                 if (box < -room).any() or (box[:, 0] > width + room).any() or (box[:, 1] > height + room).any()]
        said += [f"{words[id(text)]!r} has {text.get_fontsize():g} points" for text in texts
                 if text.get_fontsize() < SMALLEST]
        for axes in (axes for axes in figure.get_axes() if axes.axison and axes.get_visible()):
            name = axes.get_title(loc="left") or axes.get_title() or axes.get_ylabel() or "a panel"
            said += [f"{name!r} has no unit along {way}" for way in "xy" if not has_unit(axes, way)]
            said += [f"{name!r} shows nothing"] * idle(axes)
        if phone:
            least = min(text.get_fontsize() for text in texts) * scale_on_a_phone(figure)
            said += [f"the smallest letter has {least:.1f} points on a phone"] * (least < SMALLEST)
    return said


def scale_on_a_phone(figure):
    """By how much the widest piece of a figure is smaller on a phone than in print; the report enlarges a little."""
    whole, *parts = ([float(number) for number in box.split()] for box in style.pieces(figure).split(";")[:-1])
    widest = max(part[2] for part in parts) if len(parts) > 1 else whole[0]
    return min(PIECE, PHONE / widest) / INCH


def drawn_texts(figure):
    """The texts that are drawn, in their order; an empty one is not."""
    texts, draw = [], Text.draw

    def kept(text, renderer):
        if text.get_visible() and text.get_text().strip():
            texts.append(text)
        draw(text, renderer)

    with patch.object(Text, "draw", kept):
        figure.draw(figure.canvas.get_renderer())
    return list({id(text): text for text in texts}.values())


def corners(text, figure):
    """Corners (4, 2) [pixels] of a text's box, one after another."""
    renderer = figure.canvas.get_renderer()
    upright = Text.get_window_extent(text, renderer)
    turn = np.radians(text.get_rotation())
    if np.isclose(turn % (np.pi / 2), 0.0):
        half = 0.5 * np.array([upright.width, upright.height])
        turn = 0.0
    else:
        rotation = text.get_rotation()
        text.set_rotation(0)
        level = Text.get_window_extent(text, renderer)
        text.set_rotation(rotation)
        half = 0.5 * np.array([level.width, level.height])
    middle = 0.5 * np.array([upright.x0 + upright.x1, upright.y0 + upright.y1])
    across = half * [[-1, -1], [1, -1], [1, 1], [-1, 1]]
    return middle + across @ [[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]]


def overlap(one, other):
    """Whether two rectangles share more than a text may: no line along a side of one of them parts them."""
    shared = SHARED * DPI / 72
    for box in (one, other):
        for along in (box[1] - box[0], box[2] - box[1]):
            along = along / max(np.linalg.norm(along), 1e-9)
            a, b = one @ along, other @ along
            if min(a.max(), b.max()) - max(a.min(), b.min()) <= shared:
                return False
    return True


def has_unit(axes, way):
    """Whether an axis with numbers has a label with a unit: its own, or that of its column, row, figure or strip."""
    axis = getattr(axes, f"{way}axis")
    below = [tick.label1 for tick in axis.get_major_ticks()]  # or at the left
    numbers = [label for label in below if label.get_visible() and label.get_text()]
    words = isinstance(axis.get_major_locator(), FixedLocator)
    if words or not numbers:
        return True
    whole = [axes.figure, axes.figure.figure]  # the figure around a part of one, or itself
    labels = [axis.get_label_text(), *(getattr(part, f"get_sup{way}label")() for part in whole)]
    return any("[" in label and "]" in label for label in labels)


def idle(axes):
    """Whether nothing is drawn in a panel, or nothing that lies in it."""
    low, high = np.sort([axes.get_xlim(), axes.get_ylim()]).T

    def inside(points):
        points = np.ma.filled(np.ma.asarray(points, dtype=float), np.nan)
        return ((points >= low) & (points <= high)).all(axis=1).any()

    lines = [line for line in axes.lines if line.get_transform() == axes.transData]
    points = [one for one in axes.collections if isinstance(one, PathCollection)]
    others = [one for one in axes.collections if not isinstance(one, PathCollection)]
    return not (axes.patches or axes.images or others or any(inside(line.get_xydata()) for line in lines)
                or any(inside(one.get_offsets()) for one in points))


def test_multipliers_of_two_steps_are_called_so_where_elasticities_are_drawn():
    for steps, words in ((1, "[1]"), (2, "multipliers are of two steps")):
        assert elasticities(steps).get_supxlabel().endswith(words)
