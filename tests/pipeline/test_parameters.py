"""Parameters are checked before anything runs, and every error is reported at once."""

import dataclasses
import math
import os
import shutil
from types import SimpleNamespace

import pytest
from hypothesis import given, strategies as st

from pipeline.cache.fingerprint import compact
from pipeline.commands.run import _say_what_gives_way
from pipeline.errors import StudyError
from pipeline.parameters import loading, value, yaml_text
from pipeline.parameters.overrides import rewritten
from pipeline.parameters.value import half_width
from pipeline.parameters.yaml_text import parse
from pipeline.study import Study, locate
from pipeline.sweep.chain import Chain
from pipeline.sweep.spec import read
from tests.pipeline.toy import HOME


def sentences(toy, *settings, names=("fall", "bounce")):
    with pytest.raises(StudyError) as caught:
        toy.study(*settings).parameters(names)
    assert caught.value.exit_code == 2
    return list(caught.value.sentences)


def sentence(toy, *settings, **options):
    found = sentences(toy, *settings, **options)
    assert len(found) == 1, found
    return found[0]


def write(toy, name, text):
    (toy.root / "params" / name).write_text(text)


def test_values_arrive_with_their_types(toy):
    values = toy.study().parameters(["fall", "bounce"])
    settings = values["fall"].settings
    assert settings.marks == (0.5, 1e-7)
    assert type(settings.steps) is int and settings.steps == 5
    assert [(part.name, part.mass) for part in settings.parts] == [("ball", 0.1), ("shell", 0.2)]
    assert settings.label == "none"
    assert values["bounce"].ground.contact_stiffness == 1e5
    assert values["bounce"].ground.dynamic_friction == 1.0


def test_a_value_that_states_less_than_its_file_does_is_remarked(toy, capsys):
    """Not one that --set gives, a pure number, or a value of a file that states nothing of any."""
    toy.study("fall.height=3").parameters(["fall", "bounce", "picture"])
    assert capsys.readouterr().err == ""
    toy.edit("params/fall.yaml", '{value: 2.0, unit: m, source: "assumed"}', "2.0")
    toy.edit("params/ground.yaml", '9.81, unit: m/s^2, source: "standard value"', "9.81, unit: m/s^2")
    for _ in range(2):
        assert toy.study().parameters(["fall"])["fall"].settings.height == 2.0
    gravity, height = capsys.readouterr().err.splitlines()
    assert height.endswith("params/fall.yaml:2: height states no unit and no source, which others of this file do; it "
                           "is taken in m")  # fmt: skip
    assert height.startswith("note: ") and ": gravity states no source, which" in gravity


CHOICES = "well, raise, answer, crash, exit, sleep, extra, hidden, disk"
WRONG_SETTINGS = {
    "fall.parts.²2.mass=1": "--set fall.parts.²2.mass=1: there is no row ²2; rows are 0 to 1",
    "fall.height=!!float 3": "--set fall.height=!!float 3: the tag tag:yaml.org,2002:float is not allowed; write the "
    "value as it is",
    "fall.height=-1": "--set fall.height=-1: height = -1 m is not allowed; allowed: >= 0 m",
    "fall.height=.nan": "--set fall.height=.nan: height = nan m is not allowed; allowed: >= 0 m",
    "fall.height=.inf": "--set fall.height=.inf: height = inf m is not allowed; allowed: >= 0 m",
    "fall.height=1e999": "--set fall.height=1e999: height = inf m is not allowed; allowed: >= 0 m",
    "fall.height=high": '--set fall.height=high: height = "high" is not a number; allowed: >= 0 m',
    "fall.height=true": "--set fall.height=true: height = true is not a number; allowed: >= 0 m",
    "fall.height='2'": "--set fall.height='2': height = \"2\" is not a number; allowed: >= 0 m",
    "fall.height=[1]": "--set fall.height=[1]: height = [1] is not a number; allowed: >= 0 m",
    "fall.height=null": "--set fall.height=null: height = null is not a number; allowed: >= 0 m",
    "ground.gravity=100.5": "--set ground.gravity=100.5: gravity = 100.5 m/s^2 is not allowed; "
    "allowed: > 0 and <= 100 m/s^2",
    "fall.steps=2.5": "--set fall.steps=2.5: steps = 2.5 is not a whole number; allowed: >= 1",
    "fall.steps=0": "--set fall.steps=0: steps = 0 is not allowed; allowed: >= 1",
    "fall.behaviour=wel": f'--set fall.behaviour=wel: behaviour = "wel" is not allowed; allowed: {CHOICES}; '
    'did you mean "well"?',
    "fall.behaviour=3": f"--set fall.behaviour=3: behaviour = 3 is not a word; allowed: {CHOICES}",
    "fall.marks=3": "--set fall.marks=3: marks = 3 is not a list; allowed in it: >= 0 m",
    "fall.parts=3": "--set fall.parts=3: parts = 3 is not a list; allowed in it: a table",
    "fall.label=3": "--set fall.label=3: label = 3 is not a word",
    "fall.marks=[1, -2]": "--set fall.marks=[1, -2]: marks[1] = -2 m is not allowed; allowed: >= 0 m",
    "fall.parts=[{name: x}]": "--set fall.parts=[{name: x}]: parts[0] lacks the column mass (allowed: > 0 kg)",
    "fall.parts=[3]": "--set fall.parts=[3]: parts[0] = 3 is not a row like {name, mass}",
    "fall.parts.1.mass=0": "--set fall.parts.1.mass=0: parts[1]: mass = 0 kg is not allowed; allowed: > 0 kg",
    "fall.parts.2.mass=1": "--set fall.parts.2.mass=1: there is no row 2; rows are 0 to 1",
    "fall.parts.1.mas=1": '--set fall.parts.1.mas=1: parts[1] has an unknown column "mas"; did you mean "mass"?',
    "fall.height.x=1": "--set fall.height.x=1: height is not a table, so .x leads nowhere",
    "fall.heigth=1": '--set fall.heigth=1: there is no parameter "heigth" in fall; did you mean "height"?',
    "fall.gravity=1": '--set fall.gravity=1: there is no parameter "gravity" in fall; did you mean "ground.gravity"?',
    "fal.height=1": '--set fal.height=1: there is no parameter file "fal"; did you mean "fall"?',
    "height=1": "--set height=1: the form is --set file.key=value, for example --set ground.gravity=9.81",
    "fall.height": "--set fall.height: the form is --set file.key=value, for example --set ground.gravity=9.81",
    "fall.height=": "--set fall.height=: the form is --set file.key=value, for example --set ground.gravity=9.81",
    "fall..x=1": "--set fall..x=1: the form is --set file.key=value, for example --set ground.gravity=9.81",
    "fall.height={a: 1": "--set fall.height={a: 1: not valid YAML: while parsing a flow mapping did not find expected "
    "',' or '}'",
    "ground.dynamic_friction=2": "--set ground.dynamic_friction=2: dynamic_friction = 2 is not allowed; "
    "allowed: <= static_friction = 1.1",
}


@pytest.mark.parametrize("setting", WRONG_SETTINGS)
def test_a_wrong_setting_is_one_sentence(toy, setting):
    assert sentence(toy, setting) == WRONG_SETTINGS[setting]


WRONG_LINES = {
    "height: -1": ":1: height = -1 m is not allowed; allowed: >= 0 m",
    "\n\nheight: {value: -1, unit: m}": ":3: height = -1 m is not allowed; allowed: >= 0 m",
    "height: {value: 1, unit: mm}": ':1: height has the unit "mm"; it must be given in "m"',
    "height: {value: 1, unit: [m]}": ':1: height has the unit ["m"]; it must be given in "m"',
    "height: {valu: 1}": ':1: height has a part "valu" that means nothing here (only value, rows, unit, '
    'source, levels, uncertainty, printed); did you mean "value"?',
    "height: {unit: m}": ":1: height has no value; write it as {value: ..., unit: ..., source: ...}",
    "height: 1\nheight: 2": ':2: the key "height" is given twice, first on line 1',
    "height: {value: 1, value: 2}": ':1: the key "value" is given twice, first on line 1',
    "height: 1\nheigth: 2": ':2: there is no parameter "heigth"; did you mean "height"?',
    "": ": height is missing; allowed: >= 0 m",
    "height: [1": ":1: not valid YAML: while parsing a flow sequence did not find expected ',' or ']'",
    "- height": ": expected lines of the form key: value",
    "? [height]\n: 1\nheight: 1": ":1: a key must be a single word",
    "height: &a [*a]": ": not valid YAML: nested too deeply, or an alias inside itself",
    "height: 1_000": ':1: height = "1_000" is not a number; allowed: >= 0 m',
}
REST = "\nsteps: 5\nbehaviour: well\nmarks: []\nparts: []\n"


@pytest.mark.parametrize("text", WRONG_LINES)
def test_a_wrong_line_is_one_sentence_with_file_and_line(toy, text):
    write(toy, "fall.yaml", text + (REST if "- " not in text and text[-2:] != "[1" else ""))
    found = sentence(toy)
    assert found.startswith(str(toy.root)) or found.startswith("params")
    assert found.partition("params/fall.yaml")[2] == WRONG_LINES[text]


def test_every_error_of_every_file_is_reported_at_once(toy):
    toy.edit("params/fall.yaml", "value: 2.0, unit: m", "value: -2.0, unit: m")
    toy.edit("params/fall.yaml", "value: 5", "value: many")
    toy.edit("params/ground.yaml", "value: 1e5, unit: N/m", "value: 0, unit: N/m")
    found = sentences(toy, "side.sed=1", "nonsense")
    assert [line.split("params/")[-1] for line in found] == [
        "--set nonsense: the form is --set file.key=value, for example --set ground.gravity=9.81",
        '--set side.sed=1: there is no parameter "sed" in side; did you mean "seed"?',
        'fall.yaml:1: steps = "many" is not a number; allowed: >= 1'.replace("a number", "a whole number"),
        "fall.yaml:2: height = -2 m is not allowed; allowed: >= 0 m",
        "ground.yaml:3: contact_stiffness = 0 N/m is not allowed; allowed: > 0 N/m",
    ]


def test_a_missing_or_binary_file_is_one_sentence(toy):
    (toy.root / "params/fall.yaml").unlink()
    assert sentence(toy).endswith("params/fall.yaml: there is no such file")
    (toy.root / "params/fall.yaml").write_bytes(b"\xff\xfe\x00")
    assert sentence(toy).endswith("params/fall.yaml: not a text file in UTF-8")


def test_errors_of_files_a_stage_does_not_read_do_not_stop_it(toy):
    write(toy, "picture.yaml", "nonsense: [")
    assert toy.study().parameters(["fall"])["fall"].settings.height == 2.0


def test_a_setting_of_another_stage_is_checked_all_the_same(toy):
    """Stage fall reads gravity only; the stiffness in the same file is bounce's."""
    assert "contact_stiffness = -1" in sentence(toy, "ground.contact_stiffness=-1", names=["fall"])


def test_dvc_yaml_must_list_the_parameters_a_stage_reads(toy):
    toy.edit("dvc.yaml", "gravity, contact_stiffness, ", "gravity, ")
    assert (
        sentence(toy) == "dvc.yaml: stage bounce reads contact_stiffness of ground.yaml, which its params do not list"
    )
    toy.edit("dvc.yaml", "[gravity, static", "[gravity, contact_stiffness, wind, static")
    assert sentence(toy) == "dvc.yaml: stage bounce lists wind of ground.yaml, which it does not read"


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_every_way_of_writing_a_number_is_read_as_that_number(value):
    for text in (repr(value), f"{value:e}", f"{value:.17g}", compact(value)):
        read = yaml_text.scalar(text)
        assert isinstance(read, (int, float))
        assert read == float(text)


@pytest.mark.parametrize(
    ("text", "value"),
    [("1e-7", 1e-7), ("1e5", 1e5), ("+.5", 0.5), ("5.", 5.0), ("-3", -3), ("no", "no"), ("0x1f", "0x1f"), ("~", None),
     ("true", True), ("1:30", "1:30"), ("e5", "e5"), ("-.inf", -math.inf)],
)  # fmt: skip
def test_scalars_follow_yaml_1_2(text, value):
    read = yaml_text.scalar(text)
    assert read == value and type(read) is type(value)


def test_compact_numbers():
    assert [compact(value) for value in (1e5, 2.0, 0.1, 1e-7, 123456, 1 / 3, True, [1.0, 2e6])] == [
        "1e5", "2", "0.1", "1e-7", "123456", "0.3333333333333333", "true", "[1, 2e6]"
    ]  # fmt: skip
    assert [compact(value) for value in (math.inf, -math.inf, math.nan)] == ["inf", "-inf", "nan"]


BOMB = "a: &a [x, x, x, x, x, x, x, x, x, x]\n" + "".join(
    f"{new}: &{new} [{', '.join([f'*{old}'] * 10)}]\n" for old, new in zip("abcdefghi", "bcdefghij"))  # fmt: skip


def test_an_alias_bomb_is_refused_before_it_grows(toy, monkeypatch):
    assert yaml_text._MOST_VALUES == 200_000
    monkeypatch.setattr(yaml_text, "_MOST_VALUES", 20_000)
    write(toy, "side.yaml", BOMB)
    assert "side.yaml: more than 20000 values, counted through its aliases" in sentence(toy, names=("side",))


@pytest.mark.parametrize("tag", ["!!python/object/apply:os.system", "!mine", "!!str"])
def test_a_tag_is_refused_with_its_line(toy, tag):
    write(toy, "side.yaml", f"wait: 0\nseed: {tag} 1\n")
    assert any("side.yaml:2: the tag " in text and "is not allowed" in text for text in sentences(toy, names=("side",)))


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes here")
def test_a_parameter_file_that_is_a_pipe_or_too_large_is_refused_at_once(toy):
    path = toy.root / "params/side.yaml"
    path.unlink()
    os.mkfifo(path)
    assert sentence(toy, names=("side",)).endswith("side.yaml: is a pipe, device or socket, not a file")
    path.unlink()
    with open(path, "wb") as file:
        file.truncate(10**11)
    assert "has 100000000000 bytes; at most 16000000 are read" in sentence(toy, names=("side",))


# --- How far a value in a parameter file may be off: what is read, what is refused, and what makes a value exact.


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
        ('{value: 0.3, printed: "3e-1"}', 'is printed as "3e-1"; write the digits as text'),
        ('{value: 0.3, printed: "0.3", uncertainty: 0.1}', "has both an uncertainty and digits as printed"),
        ("{value: 0.3, uncertainty: -0.1}", "has the uncertainty -0.1; allowed: a number >= 0"),
        ("{value: 0.3, uncertainty: .inf}", "has the uncertainty inf; allowed: a number >= 0"),
        ("{value: 0.3, uncertainty: yes}", 'has the uncertainty "yes"; allowed: a number >= 0'))),
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


@pytest.mark.parametrize(("before", "after"), [
    ('"mass": {value: 1, unit: kg}', ""), ("\ufeffmass: {value: 1, unit: kg}  # of today", ""),
    ("mass:\n# of the lab\n  value: 1\n\n  unit: kg", "# of the legs\n"),
    ("mass: {value: 1,\nunit: kg\n}", "\n# legs\n"),
    ("mass:\n  value: 1\n  unit: kg\n  source: |\n    by me\n\n    twice", "# legs\n"), ("mass : 1", ""),
])
def test_an_entry_is_replaced_however_it_is_written(tmp_path, before, after):
    """Some were left beside the new one, or half of them: what was fitted stood in a folder that could not be read."""
    (tmp_path / "legs.yaml").write_text(f"{before}\n{after}length: {{value: 2, unit: m}}\n")
    text = rewritten(tmp_path, {"legs.mass": 3}, (), "a fit")["legs.yaml"].decode()
    unit = {"unit": "kg"} if "kg" in before else {}
    assert yaml_text.parse(text, "legs.yaml").plain() == {
        "mass": {"value": 3, **unit, "source": "a fit"}, "length": {"value": 2, "unit": "m"}}  # fmt: skip
    assert text.endswith(f"\n{after}length: {{value: 2, unit: m}}\n")


def test_an_entry_that_another_one_names_is_not_replaced(tmp_path):
    (tmp_path / "legs.yaml").write_text("mass: &one {value: 1, unit: kg}\nother_mass: *one\n")
    with pytest.raises(StudyError, match=r"legs\.yaml, with mass put in:2: not valid YAML: found undefined alias"):
        rewritten(tmp_path, {"legs.mass": 3}, (), "a fit")


def test_errors_that_go_together_stand_in_a_table_and_are_of_parameters_that_there_are(tmp_path):
    shutil.copytree(HOME / "params", tmp_path / "params")
    rows = {"rows": [{"one": "biped.hip_mass", "other": "biped.foot_com", "correlation": -0.5}]}
    files = rewritten(tmp_path / "params", {"biped.correlations": rows}, (), "a fit")
    for _ in range(2):  # and again in place of the first
        (tmp_path / "params/biped.yaml").write_bytes(files["biped.yaml"])
        found = locate(params=str(tmp_path / "params"), start=HOME).parameters(["analytic"])["analytic"]
        assert found.correlations == {("biped.hip_mass", "biped.foot_com"): -0.5}
        files = rewritten(tmp_path / "params", {"biped.correlations": rows}, (), "another fit")
    turned = {"one": "biped.foot_com", "other": "biped.hip_mass", "correlation": -0.5}
    for wrong, words in (({**turned, "one": "biped.foot_con"}, "two parameters of the design, by file.key, not of biped"
                          ".foot_con"), (turned, "each pair of parameters once")):  # fmt: skip
        both = {"rows": [*rows["rows"], wrong]}
        (tmp_path / "params/biped.yaml").write_bytes(
            rewritten(HOME / "params", {"biped.correlations": both}, (), "by hand")["biped.yaml"])
        with pytest.raises(StudyError, match=f"correlations.*{words}"):
            locate(params=str(tmp_path / "params"), start=HOME).parameters(["analytic"])
