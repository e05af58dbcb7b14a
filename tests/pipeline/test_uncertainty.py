"""How far a value in a parameter file may be off: what is read, what is refused, and what makes a value exact."""

import dataclasses
import json
import shutil
from types import SimpleNamespace

import pytest

from pipeline.commands.run import _say_what_gives_way
from pipeline.errors import StudyError
from pipeline.parameters import loading, value
from pipeline.parameters.value import half_width
from pipeline.parameters.yaml_text import parse
from pipeline.study import Study, locate
from pipeline.sweep.chain import Chain
from pipeline.sweep.spec import read
from tests.pipeline.toy import HOME


def study(*settings: str) -> Study:
    return locate(settings=settings, start=HOME)


def widths(*settings: str) -> dict[str, float]:
    return study(*settings).parameters(["analytic"])["analytic"].half_widths


def test_an_edited_value_says_that_its_half_width_is_lost(tmp_path, capsys):
    """As `dvc exp run -S params/ground.yaml:slope_deg.value=2.1` edits it, which leaves the digits of the print."""
    shutil.copytree(HOME / "params", tmp_path / "params")
    ground = tmp_path / "params/ground.yaml"
    ground.write_text(ground.read_text().replace("value: 2.0,", "value: 2.1,"))
    given = locate(params=str(tmp_path / "params"), start=HOME).parameters(["analytic"])["analytic"].half_widths
    assert "ground.slope_deg" not in given and "biped.hip_mass" in given
    (line,) = capsys.readouterr().err.splitlines()
    assert line.endswith('ground.yaml:2: slope_deg = 2.1 is not the printed "2": it is taken as exact; with '
                         "uncertainty in place of printed it has a half width")  # fmt: skip


@pytest.mark.parametrize("entry, width", [
    *(({"value": value, "printed": printed}, width) for value, printed, width in (
        (0.1, "0.100", 5e-4), (0.1, "0.1", 0.05), (2800.0, "2800.00", 5e-3), (2.0, "2", 0.5), (-3, "-3.0", 0.05),
        (0.31, "0.3", None))),
    ({"value": 0.0, "unit": "kg", "source": "point masses"}, None), ({"value": 0.0, "uncertainty": 1e-3}, 1e-3),
    ({"value": 3, "uncertainty": 0}, 0.0)])
def test_digits_as_printed_leave_half_of_the_last_one_and_other_values_are_exact_unless_something_is_said(entry, width):
    assert half_width(entry) == (None if width is None else pytest.approx(width, rel=1e-15))


@pytest.mark.parametrize("key, entry, words", [
    *(("biped.hip_mass", entry, f"hip_mass {words}") for entry, words in (
        ("{value: 0.3, printed: 0.300}", "is printed as 0.3; write the digits as text"),
        ('{value: 0.3, printed: "3e-1"}', "is printed as '3e-1'; write the digits as text"),
        ('{value: 0.3, printed: "0.3", uncertainty: 0.1}', "has both an uncertainty and digits as printed"),
        ("{value: 0.3, uncertainty: -0.1}", "has the uncertainty -0.1; allowed: a number >= 0"),
        ("{value: 0.3, uncertainty: .inf}", "has the uncertainty inf; allowed: a number >= 0"),
        ("{value: 0.3, uncertainty: yes}", "has the uncertainty 'yes'; allowed: a number >= 0"))),
    ("biped.legs", "{value: rigid, uncertainty: 1}", 'legs has a part "uncertainty", which only a number can have'),
    *(("twin.tolerance", entry, words) for entry, words in (
        ("{value: 1e-6, levels: [1e-5, 1e-6]}", "tolerance has levels that are not a list of 3 values"),
        ("{value: 1e-6, levels: 1e-5}", "levels that are not a list of 3 values: draft, paper, reference"),
        ("{value: 1e-6, levels: [1e-5, 1e-6, -1e-7]}", "tolerance = -1e-07 is not allowed; allowed: "))),
])
def test_what_cannot_be_is_one_sentence(key, entry, words):
    with pytest.raises(StudyError) as refused:
        study(f"{key}={entry}").parameters(["twin"])
    assert len(refused.value.sentences) == 1 and words in refused.value.sentences[0]


def test_the_paper_prints_table_1_and_the_slope_and_nothing_else_is_rounded():
    assert widths() == pytest.approx({
        **{f"biped.{name}": 5e-4 for name in ("hip_mass", "foot_mass", "leg_length", "foot_radius", "foot_com")},
        "biped.stiffness": 5e-3, "biped.damping": 5e-4, "ground.slope_deg": 0.5})


def test_a_value_that_is_set_anew_is_exact_unless_an_uncertainty_is_given():
    assert "biped.hip_mass" not in widths("biped.hip_mass=0.316")
    given = widths("biped.leg_inertia={value: 1e-4, uncertainty: 2e-5}", "ground.slope_deg=2")
    assert given["biped.leg_inertia"] == 2e-5 and "ground.slope_deg" not in given


def test_a_swept_value_is_exact_and_the_others_are_not(tmp_path):
    path = tmp_path / "masses.yaml"
    path.write_text("stage: analytic\nkind: grid\nvary: {biped.hip_mass: [0.3, 0.4]}\noutputs: [gait.period_s]\n")
    chain = Chain(study(), read(path))
    at = chain.parameters({"biped.hip_mass": 0.3})["analytic"]
    assert at.biped.hip_mass == 0.3 and "biped.hip_mass" not in at.half_widths
    assert set(at.half_widths) == set(widths()) - {"biped.hip_mass"}


def test_half_widths_are_no_parameters_but_a_result_rests_on_them():
    values = study().parameters(["analytic", "twin"])
    plain = loading.as_plain(values["analytic"])
    assert plain["biped"]["hip_mass half-width"] == 5e-4
    assert "hip_mass half-width" not in loading.as_plain(values["twin"])["biped"], "no stage rests on what it ignores"
    exact = study("biped.hip_mass=0.316").parameters(["analytic"])["analytic"]
    assert loading.as_plain(exact) != plain


def test_half_widths_reach_workers():
    """As parameters travel: plain, by way of JSON."""
    given = study("biped.foot_com={value: 0.1, uncertainty: 0.003}").parameters(["analytic"])["analytic"]
    again = loading.from_plain(type(given), json.loads(json.dumps(loading.as_plain(given))))
    assert again == given and again.half_widths["biped.foot_com"] == 0.003 and "ground.slope_deg" in again.half_widths


# --- The level of a study: what values are at each, what is refused, and what an edited value means.


def at_level(*settings: str, asked: str = "") -> Study:
    return dataclasses.replace(locate(settings=settings, start=HOME), requested=(("accuracy", asked),))


def at(text: str, level: str) -> object:
    return value.at_level(parse(text, "a text"), level).plain()["value"]


@pytest.mark.parametrize("level, value", [*zip(value.LEVELS, (1e-5, 1e-7, 1e-9), strict=True)])
def test_a_value_is_that_of_its_level_unless_it_was_edited(level, value):
    assert at("{value: 1e-7, levels: [1e-5, 1e-7, 1e-9]}", level) == value
    assert at("{value: 2e-7, levels: [1e-5, 1e-7, 1e-9]}", level) == 2e-7
    assert at("{value: [1, 2], levels: [[1], [1, 2], [1, 2, 3]]}", level) == {1e-5: [1], 1e-7: [1, 2]}.get(
        value, [1, 2, 3])
    assert at("{value: 3}", level) == 3


def test_an_unknown_level_is_told_with_those_there_are():
    with pytest.raises(StudyError, match=r'level = "rough" is not allowed; allowed: draft, paper, reference'):
        at_level("accuracy.level=rough").parameters(["twin"])
    with pytest.raises(StudyError, match=r'--accuracy drft: the form is .*; did you mean "draft"'):
        at_level(asked="drft").parameters(["twin"])


def test_every_level_of_every_file_is_allowed_and_every_stage_says_at_which_it_is():
    found = at_level()
    for level in value.LEVELS:
        values = at_level(asked=level).parameters(found.graph.stages)
        assert {name for name, one in values.items() if one.level.level == level} == set(found.graph.stages)
    files = {path.stem: parse(path.read_text(), path.name).value for path in found.params.glob("*.yaml")}
    spread = {f"{file}.{key}" for file, entries in files.items() for key, entry in entries.items()
              if value.has_levels(entry) and len({str(one.plain()) for one in entry.value[value.OF_LEVELS].value}) > 1}
    assert len(spread) > 5


def test_results_of_a_higher_level_do_not_give_way_without_a_word():
    values = at_level(asked="draft").parameters(["twin"])
    notes: list[str] = []
    for kept, words in (("paper", "are of accuracy paper and give way to draft"), ("draft", ""), (None, "")):
        last = None if kept is None else SimpleNamespace(ingredients={"parameters": {"accuracy": {"level": kept}}})
        store = SimpleNamespace(current=lambda name, last=last: last)
        notes.clear()
        _say_what_gives_way(SimpleNamespace(store=store, settings=()), values, SimpleNamespace(note=notes.append))  # type: ignore[arg-type]
        assert bool(notes) == bool(words) and words in "".join(notes)
