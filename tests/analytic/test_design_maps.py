"""Maps of designs: every answer is the gait that the search finds; a wrong file is refused in a sentence."""

import json
import re
from dataclasses import replace
from types import SimpleNamespace

import h5py
import matplotlib.pyplot as plt
import numpy as np
import pytest

from pipeline.parameters import yaml_text
from pipeline.questions.command import Described
from stages.analytic.errors import NoGait
from stages.analytic.gait.design_point import DesignPoint
from stages.analytic.gait.gait_report import report_gait
from stages.analytic.gait.gait_search import find_gait
from stages.analytic.gait.poincare import by_stability, poincare_map
from stages.analytic.maps import answers, box as boxes
from stages.analytic.maps.answers import (
    COLUMNS,
    HOMOTOPY,
    NONE,
    OUTCOMES,
    STABLE,
    TANGENT,
    UNSTABLE,
    Anchors,
    Task,
    along_tangent,
    anchor,
    anchors_of,
    block,
    corrected,
    followed,
    friction_needed,
    in_parts,
    numbers_of,
)
from stages.analytic.parameters import Settings
from stages.biped.question import WrongOption
from stages.model_error.questions import map as design_map
from tests.analytic.designs import FRICTION, SLOPE, TABLE_1, TABLE_1_RIGID, changed, found_gait, gait_beside
from tests.asking import Asking

TOLERANCE = 1e-8
BASE = DesignPoint(TABLE_1, SLOPE)
PARAMETERS = SimpleNamespace(biped=TABLE_1, slope=SLOPE, friction=FRICTION, analytic=Settings(TOLERANCE, 1, 100.0))
GRID = {"kind": "grid", "vary": {"biped.stiffness": {"low": 1000, "high": 4000, "steps": 2, "scale": "log"},
                                 "ground.slope_deg": {"low": 1.5, "high": 3.0, "steps": 3}}}  # fmt: skip
CLOUD = {"count": 12, "seed": 3, "vary": {"biped.foot_com": {"low": 0.09, "high": 0.11},
                                          "biped.damping": {"low": 30, "high": 90},
                                          "ground.slope_deg": {"low": 1.5, "high": 3.0}}}  # fmt: skip


def asked(asking, given, **options):
    return design_map.ask(asking.parameters, design_map.Options(given, **options), asking)


@pytest.fixture(scope="module")
def grid_file(tmp_path_factory):
    return tmp_path_factory.mktemp("map") / "grid.h5"


@pytest.fixture(scope="module")
def grid(grid_file):
    answer = asked(Asking(PARAMETERS), GRID, out=grid_file)
    with h5py.File(grid_file) as file:
        return answer, {name: column[()] for name, column in file["table"].items()}, dict(file["table"].attrs)


def test_every_design_has_the_gait_that_the_search_finds(grid):
    _, columns, _ = grid
    outcomes = set()
    for row in range(6):
        design = BASE.with_values({name: columns[name][row] for name in GRID["vary"]})
        try:
            walker, point = find_gait(design.biped, design.slope, TOLERANCE)
        except NoGait:
            assert columns["outcome"][row] == NONE and np.isnan(columns["period_s"][row])
            outcomes.add(NONE)
            continue
        validity = report_gait(walker, point, TOLERANCE, 1.0).validity
        assert columns["largest_multiplier"][row] == pytest.approx(by_stability(point), abs=1e-5)
        assert columns["period_s"][row] == pytest.approx(point.steps[0].period * walker.time, rel=1e-6)
        assert columns["friction_single_stance"][row] == pytest.approx(validity.friction_single_stance, rel=2e-3)
        assert columns["residual"][row] <= TOLERANCE
        outcomes.add(columns["outcome"][row])
        assert (columns["outcome"][row] == STABLE) == (by_stability(point) < 1)
    assert outcomes == {STABLE, UNSTABLE, NONE}


def test_a_hip_that_turns_round_in_single_stance_needs_friction_in_every_part_of_it():
    """A twelfth more is needed before the hip turns round here than after it."""
    biped = changed(TABLE_1_RIGID, hip_mass=0.1, foot_com=0.06, foot_radius=0.04, hip_friction=2.5e-3)
    walker, point = find_gait(biped, SLOPE, TOLERANCE)
    found = report_gait(walker, point, TOLERANCE, 1.0)
    assert len(found.segments) == 2
    assert friction_needed(walker, point, TOLERANCE) == pytest.approx(found.validity.friction_single_stance, rel=2e-3)


def test_the_answer_counts_what_the_file_holds(grid):
    answer, columns, attributes = grid
    json.dumps(answer.plain)
    assert answer.plain["designs"] == 6 == len(columns["outcome"])
    assert answer.plain["outcomes"]["none"] == (columns["outcome"] == NONE).sum()
    assert answer.plain["answered_by"]["tangent"] == (columns["answered_by"] == TANGENT).sum() > 0
    assert answer.plain["ranges"]["period_s"]["high"] == np.nanmax(columns["period_s"])
    assert attributes["map"].splitlines()[1] == "biped.stiffness = 1000 .. 4000 N/m, log, 2 steps"
    assert np.allclose(columns["speed_m_s"] * columns["period_s"], columns["step_length_m"], equal_nan=True)


def test_rows_are_the_designs_in_words_and_of_a_large_map_none(grid, monkeypatch):
    answer, columns, _ = grid
    assert [row["outcome"] for row in answer.rows] == [OUTCOMES[int(code)] for code in columns["outcome"]]
    for name in ("ground.slope_deg", "period_s", "multiplier_2_imag"):
        assert np.array_equal([row[name] for row in answer.rows], columns[name], equal_nan=True)
    assert [*answer.rows[0]] == [*GRID["vary"], *(column.name for column in COLUMNS)]
    monkeypatch.setattr(design_map, "LISTED", 5)
    assert asked(Asking(PARAMETERS), GRID, search="none").rows == []


@pytest.fixture(scope="module")
def cloud(tmp_path_factory):
    """The answer, who asked, and the file of a cloud in blocks of four designs."""
    whole, path = Asking(PARAMETERS), tmp_path_factory.mktemp("cloud") / "whole.h5"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(design_map, "BLOCK", 4)
        return asked(whole, CLOUD, out=path, search="none"), whole, path


@pytest.mark.parametrize("given", ["grid", "cloud"])
def test_a_map_has_a_picture(given, request):
    (answer, *_), drawn = request.getfixturevalue(given), []
    answer.draw(drawn.append)
    assert all("[" in text for axes in drawn[0].axes for text in [axes.get_xlabel()] if text)
    plt.close(drawn[0])


def test_a_map_opens_in_xarray_with_units_and_words(grid, grid_file):
    xarray, _ = pytest.importorskip("xarray"), pytest.importorskip("h5netcdf")
    with xarray.open_dataset(grid_file, engine="h5netcdf", group="table") as table:
        assert set(table.dims) == {"row"} and table.row.values.tolist() == [*range(table.sizes["row"])]
        assert table.period_s.units == "s" and table.period_s.long_name
        words = dict(zip(table.outcome.flag_meanings.split(), table.outcome.flag_values, strict=True))
    with h5py.File(grid_file) as file:
        known = h5py.check_enum_dtype(file["table/outcome"].dtype)
    assert words == {word.replace(" ", "_"): place for word, place in known.items()} and "stable" in words


def test_a_map_that_was_killed_goes_on_where_it_was_and_gives_the_same_bytes(cloud, tmp_path, monkeypatch):
    monkeypatch.setattr(design_map, "BLOCK", 4)
    _, whole, file = cloud
    kept = {}
    with pytest.raises(KeyboardInterrupt):
        asked(Asking(PARAMETERS, kept, 2), CLOUD, out=tmp_path / "again.h5", search="none")
    assert list(tmp_path.iterdir()) == []
    second = Asking(PARAMETERS, kept)
    asked(second, CLOUD, out=tmp_path / "again.h5", search="none")
    assert second.computed == whole.computed - 2
    assert file.read_bytes() == (tmp_path / "again.h5").read_bytes()


@pytest.mark.parametrize(
    ("design", "name", "to"),
    [
        (DesignPoint(TABLE_1, SLOPE), "biped.foot_com", 0.104),
        (DesignPoint(TABLE_1, SLOPE, FRICTION), "biped.foot_com", 0.103),
        (DesignPoint(TABLE_1_RIGID, SLOPE), "ground.slope_deg", 2.3),
    ],
    ids=["rolling", "limited", "rigid"],
)
def test_a_gait_follows_from_its_neighbour_for_every_kind_of_walker(design, name, to):
    known = anchor(*found_gait(design.biped, design.friction), TOLERANCE)
    there = design.with_value(name, to)
    walker, point = find_gait(there.biped, there.slope, TOLERANCE, there.friction)
    for found in (along_tangent(walker, known, TOLERANCE), in_parts(walker, known, TOLERANCE)):
        assert found.residual <= TOLERANCE
        assert np.abs(found.z - point.z).max() < 1e-6
    # the tangent is that of the family: its error falls with the square of the way
    errors = []
    for share in (0.5, 0.25):
        part = design.with_value(name, design.value(name) + share * (to - design.value(name)))
        beside = part.walker()
        exact = corrected(beside, known.towards(numbers_of(beside)), 1e-10)
        errors.append(np.abs(known.towards(numbers_of(beside)) - exact.z).max())
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.25)


def test_a_correction_that_leads_nowhere_is_no_answer():
    walker = BASE.walker()
    assert corrected(walker, np.array([-0.6, 1.0, 1.0, 0.05, 0.0]), TOLERANCE) is None
    assert Anchors([]).nearest(numbers_of(walker), 3) == []


def test_blocks_do_not_depend_on_each_other():
    box = boxes.read(CLOUD, BASE)
    anchors = [one for one in anchors_of(Task(box, BASE, TOLERANCE, "none"), 0, 4) if one]
    task = Task(box, BASE, TOLERANCE, "none", anchors)
    rows = np.array(block(task, 8, 12))
    assert rows.shape == (4, len(COLUMNS))
    assert np.array_equal(rows, np.array(block(task, 8, 12)), equal_nan=True)
    assert np.array_equal(box.values(8, 12), box.values(0, 24)[8:12])
    walker = box.design(BASE, box.values(9, 10)[0]).walker()
    assert np.isfinite(poincare_map(walker, np.array(anchors[0][1]), TOLERANCE).z).all()


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"kind": "cloud", "vary": {}}, "kind: 'cloud', must be sobol or grid"),
        ({"counts": 3}, "counts: a map has no such key; its keys are kind, count, seed, vary; did you mean count?"),
        ({"count": 3}, "vary: must be names like ground.slope_deg"),
        ({"count": 3, "vary": ["ground.slope_deg"]}, "vary: must be names like ground.slope_deg"),
        ({"vary": {"ground.slope_deg": {"low": 1, "high": 2}}}, "count: None, must be a whole number from 1"),
        ({"count": 9.5, "vary": {"ground.slope_deg": {"low": 1, "high": 2}}}, "count: 9.5, must be a whole number"),
        ({"count": 0, "vary": {"ground.slope_deg": {"low": 1, "high": 2}}}, "count: 0, must be a whole number"),
        ({"count": 9, "vary": {"ground.slope": {"low": 1, "high": 2}}}, "ground.slope: not a number of the design"),
        ({"count": 9, "vary": {"ground.slope_deg": {"low": 1, "high": 95}}}, "slope_deg.high: 95, must be >= 0"),
        ({"count": 9, "vary": {"ground.slope_deg": {"low": 2, "high": 1}}}, "high: 1, must be > low = 2"),
        ({"count": 9, "vary": {"ground.slope_deg": {"low": 0, "high": 1, "scale": "log"}}}, "must be > 0 where"),
        ({"count": 9, "vary": {"ground.slope_deg": {"low": "x", "high": 1}}}, "low: 'x', must be a number"),
        ({"count": 9, "vary": {"ground.slope_deg": [1, 2]}}, "ground.slope_deg: [1, 2], must be {low"),
        ({"count": 9, "vary": {"ground.slope_deg": {"low": 1, "high": 2, "steps": 3}}}, "only a grid has steps"),
        ({"kind": "grid", "vary": {"ground.slope_deg": {"low": 1, "high": 2}}}, "steps: None, must be a whole number"),
        ({"kind": "grid", "count": 3, "vary": {"ground.slope_deg": {"low": 1, "high": 2, "steps": 3}}},
         "count: 3, must be left out of a grid"),
    ],
)  # fmt: skip
def test_a_wrong_file_is_refused_with_key_value_and_what_is_allowed(given, words):
    with pytest.raises(WrongOption) as refused:
        asked(Asking(PARAMETERS), given)
    assert words in str(refused.value) and "\n" not in str(refused.value)


def test_a_jump_to_an_unstable_gait_of_another_family_is_not_taken(monkeypatch):
    """From the nearest anchor Newton's method leads to a gait with a multiplier of 2.66; the family's has .685.

    Without another anchor to lead to either, or where the nearest one's gait is unstable itself, 2.66 was the answer.
    """
    design = BASE.with_value("ground.slope_deg", 3.465546218487395).with_value("biped.stiffness", 2077.099920803618)
    anchors = []
    wide = boxes.read({"kind": "grid", "vary": {
        "ground.slope_deg": {"low": 0.2, "high": 6, "steps": 120},
        "biped.stiffness": {"low": 300, "high": 30000, "steps": 120, "scale": "log"}}}, BASE)  # fmt: skip
    for values in wide.spread(300)[[153, 281, 89]]:
        beside = wide.design(BASE, values)
        anchors.append(anchor(*find_gait(beside.biped, beside.slope, 1e-10), 1e-10))
    walker = design.walker()
    assert by_stability(along_tangent(walker, anchors[0], 1e-10)) > 2
    _, found = followed(walker, Anchors(anchors), 1e-10, [])
    _, searched = find_gait(design.biped, design.slope, 1e-10)
    assert by_stability(found) < 0.7 and np.allclose(found.z, searched.z, atol=1e-8)
    monkeypatch.setattr(answers, "in_parts", lambda *_: None)
    alone = boxes.read({"kind": "grid", "vary": {name: {"low": design.value(name), "high": 2 * design.value(name),
                        "steps": 2} for name in ("ground.slope_deg", "biped.stiffness")}}, BASE)  # fmt: skip
    for stable in (True, False):
        known = [replace(anchors[0], stable=stable).plain]
        [row] = block(Task(alone, BASE, 1e-10, "complete", known), 0, 1)
        assert dict(zip([column.name for column in COLUMNS], row, strict=True))["largest_multiplier"] < 0.7


# --- legs that differ ------------------------------------------------------------------------------------------------

LAME_CLOUD = {"count": 6, "seed": 5, "vary": {
    "biped.other_foot_mass": {"low": 0.3335, "high": 0.3365},
    "biped.other_leg_length": {"low": 0.33298, "high": 0.33302},
    "biped.frame_mass": {"low": 0.0, "high": 0.02}, "ground.slope_deg": {"low": 1.8, "high": 2.2}}}  # fmt: skip


def mapped(given, biped, anchors):
    """The designs of a map, and its columns by name."""
    base = DesignPoint(biped, SLOPE)
    box = boxes.read(given, base)
    known = [each for each in anchors_of(Task(box, base, TOLERANCE, "complete"), 0, anchors) if each]
    rows = np.array(block(Task(box, base, TOLERANCE, "complete", known), 0, box.size))
    designs = [box.design(base, values) for values in box.values(0, box.size)]
    return designs, dict(zip([column.name for column in COLUMNS], rows.T, strict=True))


@pytest.mark.parametrize("biped", [TABLE_1, TABLE_1_RIGID])
def test_a_map_of_legs_that_differ_has_the_gaits_that_the_search_finds(biped):
    """Gaits of a stride: means of its two steps, multipliers of both together."""
    designs, columns = mapped(LAME_CLOUD, biped, 2)
    assert (columns["answered_by"] <= HOMOTOPY).sum() >= 4  # followed, not searched
    for row, design in [*enumerate(designs)][:: 1 if biped is TABLE_1_RIGID else 2]:
        try:
            walker, point = find_gait(design.biped, design.slope, TOLERANCE)
        except NoGait:
            assert columns["outcome"][row] == NONE
            continue
        assert len(point.steps) == 2
        assert columns["period_s"][row] == pytest.approx(point.period * walker.time, rel=1e-6)
        assert columns["largest_multiplier"][row] == pytest.approx(by_stability(point), abs=2e-5)


@pytest.mark.parametrize("biped", [TABLE_1_RIGID, TABLE_1])
def test_a_map_over_the_friction_of_a_hip_begins_without_it(biped):
    """Of a hip that does not rub a walker has a number less."""
    given = {"kind": "grid", "vary": {"biped.hip_friction": {"low": 0.0, "high": 2e-3, "steps": 2}}}
    designs, columns = mapped(given, biped, 1)
    for design, period in zip(designs, columns["period_s"], strict=True):
        walker, point = gait_beside(design.biped, found_gait(biped)[1].z)
        assert period == pytest.approx(point.period * walker.time, rel=1e-6)


def test_the_front_is_of_stable_designs_that_no_other_beats_in_both():
    columns = {"ground.slope_deg": np.arange(6.0), "outcome": np.array([0, 0, 0, 1, 0, 0]),
               "largest_multiplier": np.array([0.5, 0.6, 0.7, 0.1, 0.6, 0.5]), "period_s": np.ones(6),
               "speed_m_s": np.array([0.2, 0.3, 0.25, 0.9, 0.35, 0.1])}
    assert design_map.front(columns) == [
        {"ground.slope_deg": 0.0, "largest_multiplier": 0.5, "speed_m_s": 0.2},
        {"ground.slope_deg": 4.0, "largest_multiplier": 0.6, "speed_m_s": 0.35}]
    assert design_map.front(columns | {"outcome": np.full(6, 2)}) == []


@pytest.mark.parametrize(("line", "said"), [
    ("kind: gird", "box.yaml:1: kind: 'gird', must be sobol or grid"),
    ("count: 9", "box.yaml:3: vary.ground.slope_deg.high: 95, must be >= 0"),
    ("counts: 9", "box.yaml:1: counts: a map has no such key; its keys are kind, count, seed, vary"),
])
def test_what_is_wrong_is_told_with_file_and_line(tmp_path, line, said):
    (tmp_path / "box.yaml").write_text(f"{line}\nvary:\n  ground.slope_deg: {{low: 1, high: 95}}\n")
    given = Described(yaml_text.read(tmp_path / "box.yaml", "box.yaml"), "box.yaml")
    with pytest.raises(WrongOption, match=re.escape(said)):
        boxes.read(given, BASE)
