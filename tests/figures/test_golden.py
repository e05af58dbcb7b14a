"""Every figure against a golden picture, and against itself: drawn from made-up results, so that physics may change.

Golden pictures hold for one version of Matplotlib, named in drawn_by.txt, which is edited by hand for another.
For a new figure and after a wanted change: `python -m pytest tests/figures/test_golden.py --write-golden`, and look at
what it wrote."""

import dataclasses
from pathlib import Path
from typing import get_type_hints

import matplotlib
import numpy as np
import pytest
from matplotlib.figure import Figure

from pipeline.report.figures import TOLERANCE, difference, rms
from stages.drawing import style
from stages.figures.drawn import NAMES, contact_laws, figure, measurement, two_models
from tests.comparison.made_up import DEFAULTS, make_budget, make_study, make_walk
from tests.figures.made_up_results import analytic, comparison, drawn, given, multibody, rough_ground, shown

GOLDEN = Path(__file__).parents[1] / "baseline"
DRAWN_BY = GOLDEN / "drawn_by.txt"
DPI = 80
VERSION = "matplotlib " + ".".join(matplotlib.__version__.split(".")[:2])
#: Matplotlib 3.8 and 3.11 set text so differently that pictures differ by 20 to 35 of 255 rms.
same_version = pytest.mark.skipif(
    DRAWN_BY.read_text().strip() != VERSION, reason=f"golden pictures are of {DRAWN_BY.read_text().strip()}"
)


#: All but the fragments of pages.
PICTURES = [name for name in NAMES if get_type_hints(figure(name).draw)["return"] is Figure]
#: Drawings of the robot, and errors over nine decades: a thousandth more in every number is not seen, a tenth is.
DRAWINGS = (*(f"figure_{name}" for name in (
    "03_simple_model", "09_section", "12_ramp", "13_steps", "14_data_way", "15_sensors")),
    "price_and_error")  # fmt: skip
#: Two figures that are drawn quickly, and a drawing; the others are drawn again by the slow tests.
QUICK = ("figure_03_simple_model", "twin_ladder", "extremes")
DRAWN_AGAIN = [name if name in QUICK else pytest.param(name, marks=pytest.mark.slow) for name in PICTURES]


pytestmark = pytest.mark.usefixtures("drawing")


def draw(name, scale, path):
    """A figure of the made-up results times a factor, at a low resolution."""
    picture = shown(name) if scale == 1.0 else drawn(name, scale)
    with style.laid_out(picture, DPI):
        picture.savefig(path, dpi=DPI)
    return path


@pytest.mark.parametrize("name", DRAWN_AGAIN)
def test_a_figure_has_the_same_bytes_twice(name):
    first, second = (style.pictures(name, one, DPI) for one in (shown(name), drawn(name)))
    assert set(first) - {f"figures/{name}.csv"} == {f"figures/{name}.png", f"figures/{name}.pdf"}
    assert second == first


@same_version
@pytest.mark.parametrize("name", PICTURES)
def test_a_figure_is_the_golden_picture(name, tmp_path, request):
    golden, now = GOLDEN / f"{name}.png", draw(name, 1.0, tmp_path / f"{name}.png")
    if request.config.getoption("--write-golden"):
        golden.write_bytes(now.read_bytes())
    assert golden.is_file(), "it has no golden picture: --write-golden makes one"
    found = difference(golden, now, tmp_path / "differences", TOLERANCE)
    assert not found["fails"], found


@same_version
@pytest.mark.parametrize("name", DRAWN_AGAIN)
def test_a_thousandth_more_in_the_data_is_seen(name, tmp_path):
    changed = draw(name, 1.1 if name in DRAWINGS else 1.001, tmp_path / f"{name}.png")
    assert rms(GOLDEN / f"{name}.png", changed) > 3 * TOLERANCE


def test_every_golden_picture_belongs_to_a_figure():
    assert {path.stem for path in GOLDEN.glob("*.png")} == set(PICTURES)


# --- What figures show is what they are given, in the units that their axes say.


def labels(figure):
    return [
        text for axes in figure.get_axes() if axes.axison for text in (axes.get_xlabel(), axes.get_ylabel()) if text
    ]


@pytest.mark.parametrize("name", PICTURES)
def test_every_axis_label_carries_a_unit(name):
    found = labels(shown(name))
    assert all("[" in label and "]" in label for label in found), found


def test_figure_08_shows_the_walks_and_their_difference_in_millimetres():
    faster = multibody()
    faster.walk = make_walk(speed=0.31)
    position, _, difference, *_ = drawn("figure_08_hip_motion", multibody=faster).get_axes()
    time, shown = position.lines[0].get_data()
    assert shown == pytest.approx(make_walk().hip_position[: len(time), 0])
    time, shown = difference.lines[0].get_data()
    assert shown == pytest.approx(1e3 * 0.01 * time, abs=1e-6)


def test_figure_16_says_what_is_synthetic():
    synthetic, measured = shown("figure_16_measurement"), drawn(
        "figure_16_measurement", comparison=comparison("measured"))
    said, not_said = (" ".join(text.get_text() for axes in figure.get_axes() for text in axes.texts)
                      for figure in (synthetic, measured))  # fmt: skip
    for words in ("SYNTHETIC", "RMSE", "multiple correlation", "ICC(A,1)", "bias", "limit of agreement",
                  "inside the envelope"):  # fmt: skip
        assert words in said
    assert "mHz" in synthetic.get_supxlabel() and "SYNTHETIC" not in not_said
    small = dataclasses.replace(next(iter(comparison().measurement.twin.values())), rmse=1.2e-3, bias=-3.4e-5)
    rows = dict(row[:2] for row in measurement.agreement_rows(small, small, "rad/s"))
    assert (rows["RMSE [rad/s]"], rows["bias [rad/s]"]) == ("0.0012", "-3.4e-05"), "of a slow robot they were zeros"


def test_figure_02_shows_the_leg_with_the_peak_of_its_caption_where_legs_differ():
    walk, limping = make_walk(), analytic()
    limping.gait.steps = 2
    for leg in (0, 1):
        harder = multibody()
        harder.walk = dataclasses.replace(walk, ground_reaction=walk.ground_reaction * np.where(
            np.arange(2) == leg, 100.0, 1.0)[:, None])  # fmt: skip
        axes = drawn("figure_02_ground_reaction", analytic=limping, multibody=harder).get_axes()
        assert max(axes[1].lines[1].get_ydata()) == pytest.approx(900.0)


@pytest.mark.parametrize("size", [0.1, 4.0])
def test_a_similar_robots_law_of_the_ground_is_drawn_at_a_similar_speed(size):
    """At Table 1's 20 mm/s a ground of a small robot pulled where it lets go: its curve was 0."""
    asked = given("figure_04_normal_force")
    own, speed = dataclasses.replace(asked.parameters.biped, leg_length=size), (size / 0.333) ** 0.5
    asked.parameters.biped, asked.parameters.contact = own, dataclasses.replace(
        asked.parameters.contact, impact_speed=0.3 * speed)
    usual, other = (picture.get_axes()[2].lines[5].get_ydata() for picture in (
        shown("figure_04_normal_force"), figure("figure_04_normal_force").draw(asked)))  # fmt: skip
    assert other == pytest.approx(usual, rel=1e-3) and max(other) > 0.0


def test_figure_02_takes_one_whole_contact():
    walk = make_walk()
    time, _ = two_models.contact(walk, 1, 0)
    landed = walk.heel_strike_time[walk.heel_strike_leg == 1][0]
    lifted = walk.toe_off_time[(walk.toe_off_leg == 1) & (walk.toe_off_time > landed)][0]
    assert time[0] == pytest.approx(-0.01, abs=1e-3)
    assert time[-1] == pytest.approx(lifted - landed + 0.02, abs=1e-3)


def test_figure_04_shows_the_laws_of_the_ground():
    millimetre = np.array([1e-3])
    for exponent in contact_laws.EXPONENTS:  # k_c is in N/mm^e: at 1 mm every exponent gives the same force
        assert contact_laws.spring_force(DEFAULTS, exponent, millimetre) == pytest.approx([1e5])
    depths = np.array([-1e-5, 0.0, 0.5e-4, 1e-4, 1e-3])
    assert contact_laws.damping(DEFAULTS, depths) == pytest.approx([0.0, 0.0, 5e3, 1e4, 1e4])
    spring, ramp, whole = shown("figure_04_normal_force").get_axes()
    depth, damping = ramp.lines[0].get_data()
    assert 1e3 * damping == pytest.approx(contact_laws.damping(DEFAULTS, 1e-3 * depth))
    depth, force = spring.lines[2].get_data()
    assert 1e3 * force == pytest.approx(contact_laws.spring_force(DEFAULTS, 2.2, 1e-3 * depth))
    pressed, rest, let_out = (line.get_ydata() for line in whole.lines[:3])
    assert np.all(pressed >= rest) and np.all(rest >= let_out) and let_out.max() > 0.0


def test_figure_05_lays_each_variation_over_the_constraint_model():
    study, walk = make_study(), make_walk()
    figure = shown("figure_05_contact_parameters")
    for row, (key, *_, factor) in enumerate(contact_laws.ROWS):
        impact, after = figure.get_axes()[2 * row : 2 * row + 2]
        exact, default, *varied, chosen = [line for line in impact.lines if len(line.get_xdata()) > 10]
        leg = walk.ground_reaction[:, 1, 1]
        assert np.delete(exact.get_ydata(), np.flatnonzero(np.isnan(exact.get_ydata()))) == pytest.approx(leg)
        assert default.get_ydata() == pytest.approx(study.default_force[:, 1])
        assert chosen.get_ydata() == pytest.approx(study.chosen_force[:, 1]) and chosen.get_linestyle() == "--"
        rows = study.variations.rows(key)
        assert len(varied) == len(rows) == 2
        for line, row in zip(varied, rows):
            assert line.get_xdata() == pytest.approx(1e3 * study.time)
            assert line.get_ydata() == pytest.approx(study.variations.force[row, :, 1])
        texts = [text.get_text() for text in after.get_legend().get_texts()]
        assert texts == [f"{factor * value:g}" for value in getattr(DEFAULTS, key) * np.array([1.0, 0.5, 2.0])]
        for panel in (impact, after):  # no curve leaves at the top
            assert panel.get_ylim()[1] > np.nanmax([np.nanmax(line.get_ydata()) for line in panel.lines])
    *differences, chosen, limit = figure.get_axes()[-2].lines
    assert len(differences) == len(contact_laws.ROWS)
    for line in differences:
        values, found = line.get_data()
        assert values == pytest.approx([0.5, 1.0, 2.0]) and found == pytest.approx([1.0, 2.0, 4.0]), "mm"
    assert chosen.get_ydata() == pytest.approx([0.2] * 2)
    assert limit.get_ydata() == pytest.approx([0.25] * 2), "the rigid limit"


def test_the_figure_of_contact_sets_shows_distances_that_do_not_cancel():
    limit = make_study().limit
    cost, stiffness, parts, period, length = shown("contact_sets").get_axes()
    for axes, places in (
        (cost, [400, 800, 1600, 3200]),
        (stiffness, [one.law.contact_stiffness for one in limit.family]),
    ):
        values, far = axes.lines[1].get_data()
        assert values == pytest.approx(places)
        assert far == pytest.approx([1e3 * one.position_parts.sum() for one in limit.family])
        assert axes.lines[2].get_ydata() == pytest.approx([6.2]) and axes.lines[3].get_ydata() == pytest.approx([0.62])
        assert axes.lines[4].get_ydata() == pytest.approx([0.25] * 2)
    bars = [bar.get_width() for bar in parts.patches[:3]]
    assert bars == pytest.approx([0.4, 0.2, 0.02]) and parts.lines[0].get_xdata() == pytest.approx([0.2] * 2)
    assert period.lines[0].get_ydata() == pytest.approx([0.4, 0.2, 0.1, 0.05]), "ms"
    assert length.lines[0].get_ydata() == pytest.approx([1e3 * abs(one.step_length) for one in limit.family]), "mm"


def test_without_a_rigid_limit_the_figures_say_so():
    study = dataclasses.replace(make_study(), limit=None, candidates=None, limit_outcome="the foot slips away")
    assert drawn("contact_sets", contact_study=study).get_axes()[0].get_title() == "the foot slips away"
    for name in ("figure_05_contact_parameters", "figure_06_friction"):
        labels = [line.get_label() for panel in drawn(name, contact_study=study).get_axes() for line in panel.lines]
        said = [*labels, figure(name).caption(given(name, contact_study=study))]
        assert "starting set" in said[-1] and not any("chosen set" in each for each in said)


def test_a_set_without_a_cycle_is_not_called_chosen():
    known = make_study().limit
    limit = dataclasses.replace(known, chosen=dataclasses.replace(known.chosen, outcome="fell"))
    study = dataclasses.replace(make_study(), limit=limit)
    for name in ("contact_sets", "figure_05_contact_parameters", "figure_06_friction"):
        panels = drawn(name, contact_study=study).get_axes()
        said = [line.get_label() for panel in panels for line in panel.lines]
        said += [tick.get_text() for panel in panels for tick in panel.get_yticklabels()]
        assert not any("chosen" in each for each in said)
    caption = figure("contact_sets").caption(given("contact_sets", contact_study=study))
    assert "No set was chosen (fell)." in caption and "The best set tried is" in caption


def test_a_rigid_limit_that_is_rolling_feet_is_said_and_not_drawn():
    """A logarithmic axis has no zero: with a line there figure 5 of a robot with rigid legs had no scale."""
    known = make_study().limit
    hard = dataclasses.replace(known.hard, hip_position=np.zeros(2), period=0.0, step_length=0.0)
    study = dataclasses.replace(make_study(), limit=dataclasses.replace(known, hard=hard))
    for name in ("contact_sets", "figure_05_contact_parameters"):
        panels = drawn(name, contact_study=study).get_axes()
        assert all(np.any(line.get_ydata()) for panel in panels if panel.get_yscale() == "log" for line in panel.lines)
        assert "0.00 mm" not in figure(name).caption(given(name, contact_study=study))


def test_a_design_that_never_fell_bounds_the_front_from_below():
    """Its mean steps to a fall are infinite: the figure ended with a traceback."""
    found = rough_ground()
    high = dataclasses.replace(found, front=tuple(
        dataclasses.replace(row, block_height_rms=2.5e-4) for row in found.front))
    front = drawn("rough_ground", rough_ground=high).get_axes()[-1]
    assert front.lines[-1].get_label() == "given design, at least" and front.lines[-1].get_ydata()[0] == 270.0
    said = figure("rough_ground").caption(given("rough_ground", rough_ground=high))
    assert "where the design makes more than 270 steps" in said and "inf" not in said


@pytest.mark.parametrize(("sides", "panels"), [({}, 8), ({"cycle": None}, 4), ({"step": None}, 4)])
def test_the_error_budget_has_no_empty_panels(sides, panels):
    found = drawn("error_budget", error_budget=dataclasses.replace(make_budget(), **sides)).get_axes()
    assert len(found) == panels and all(panel.lines for panel in found)
    assert [panel.get_title(loc="left") for panel in found] == [f"({letter})" for letter in "abcdefgh"[:panels]]


def test_figure_06_shows_the_friction_law_its_force_and_what_the_velocities_do():
    study = make_study()
    law, force, hip, creep = shown("figure_06_friction").get_axes()
    slip, coefficient = law.lines[0].get_data()
    assert np.interp([-0.1, 0.0, 0.1, 1.0], slip, coefficient) == pytest.approx([-1.1, 0.0, 1.1, 1.0], abs=1e-6)
    assert force.lines[1].get_ydata() == pytest.approx(study.default_force[:, 0])
    values, found = hip.lines[0].get_data()
    assert values == pytest.approx([0.05, 0.1, 0.2]) and found == pytest.approx([1.0, 2.0, 4.0])
    values, speed = creep.lines[1].get_data()
    assert values == pytest.approx([0.5, 1.0, 2.0]) and speed == pytest.approx([2.0, 4.0, 8.0])


def test_no_multiplier_of_a_rung_lies_beyond_an_axis():
    """Past a period doubling one of -1.47 was cut off, without a mark."""
    usual = given("twin_ladder").twin_ladder
    beyond = np.array([[-1.47, 0.0], [0.2, 0.0]])
    far = tuple(dataclasses.replace(rung, plane_multipliers=beyond) for rung in usual.rungs)
    axes = drawn("twin_ladder", twin_ladder=dataclasses.replace(usual, rungs=far)).get_axes()[2]
    assert axes.get_xlim() == pytest.approx((-1.617, 1.617))
    assert shown("twin_ladder").get_axes()[2].get_xlim() == (-1.2, 1.2)
    turning = tuple(dataclasses.replace(rung, plane_multipliers=beyond[:, ::-1]) for rung in usual.rungs)
    circle = drawn("multipliers", twin_ladder=dataclasses.replace(usual, rungs=turning)).get_axes()[0]
    assert circle.get_ylim()[0] == pytest.approx(-1.617) and shown("multipliers").get_axes()[0].get_ylim()[0] == -1.1


def test_multipliers_of_families_beyond_the_axis_have_wedges():
    """One of -2.6 was cut off, without a mark."""
    usual = given("bifurcation").stability
    far = tuple(dataclasses.replace(one, floquet_multipliers=4.0 * one.floquet_multipliers) for one in usual.families)
    for families, beyond in ((usual.families, False), (far, True)):
        figure = drawn("bifurcation", stability=dataclasses.replace(usual, families=families))
        assert any(words.get_text() == "beyond the axis" for words in figure.legends[0].get_texts()) == beyond
        assert any(line.get_label() == "_beyond" and len(line.get_xdata()) for line in figure.axes[1].lines) == beyond


def test_a_law_of_much_friction_is_drawn_whole():
    """Of a coefficient above 1.25 the lower half was outside."""
    study = given("figure_06_friction").contact_study
    rough = {which: dataclasses.replace(one, law=dataclasses.replace(one.law, static_friction=2.5))
             for which, one in (("default", study.default), ("chosen", study.chosen))}  # fmt: skip
    law = drawn("figure_06_friction", contact_study=dataclasses.replace(study, **rough)).axes[0]
    assert law.get_ylim()[0] < -2.5 and law.get_ylim()[1] > 2.5


def test_the_ladder_leads_from_the_simple_model_to_the_last_rung():
    bars = shown("twin_ladder").get_axes()[0].patches
    ends = [end for bar in bars for end in (bar.get_x(), bar.get_x() + bar.get_width())]
    assert ends == pytest.approx([480.0, 490.0, 490.0, 470.0])


def test_a_fall_is_crossed_where_it_happened():
    roll, yaw, _ = shown("twin_pushes").get_axes()
    (cross,) = (line for line in yaw.lines if line.get_marker() == "x")
    assert len(roll.lines) == 3 and cross.get_xydata()[0] == pytest.approx([2.0, np.degrees(0.4)])
