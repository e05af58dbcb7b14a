"""The level of a study: what values are at each, what is refused, and what an edited value means."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace

import pytest

from pipeline.commands.run import _say_what_gives_way
from pipeline.errors import StudyError
from pipeline.parameters import value
from pipeline.parameters.yaml_text import parse
from pipeline.study import Study, locate
from tests.pipeline.toy import HOME


def study(*settings: str, asked: str = "") -> Study:
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


@pytest.mark.parametrize("entry, words", [
    ("{value: 1e-6, levels: [1e-5, 1e-6]}", "tolerance has levels that are not a list of 3 values"),
    ("{value: 1e-6, levels: 1e-5}", "levels that are not a list of 3 values: draft, paper, reference"),
    ("{value: 1e-6, levels: [1e-5, 1e-6, -1e-7]}", "tolerance = -1e-07 is not allowed; allowed: "),
])
def test_levels_that_cannot_be_are_one_sentence(entry, words):
    with pytest.raises(StudyError) as refused:
        study(f"twin.tolerance={entry}").parameters(["twin"])
    assert len(refused.value.sentences) == 1 and words in refused.value.sentences[0]


def test_an_unknown_level_is_told_with_those_there_are():
    with pytest.raises(StudyError, match=r'level = "rough" is not allowed; allowed: draft, paper, reference'):
        study("accuracy.level=rough").parameters(["twin"])
    with pytest.raises(StudyError, match=r'--accuracy drft: the form is .*; did you mean "draft"'):
        study(asked="drft").parameters(["twin"])


def test_every_level_of_every_file_is_allowed_and_every_stage_says_at_which_it_is():
    found = study()
    for level in value.LEVELS:
        values = study(asked=level).parameters(found.graph.stages)
        assert {name for name, one in values.items() if one.level.level == level} == set(found.graph.stages)
    files = {path.stem: parse(path.read_text(), path.name).value for path in found.params.glob("*.yaml")}
    spread = {f"{file}.{key}" for file, entries in files.items() for key, entry in entries.items()
              if value.has_levels(entry) and len({str(one.plain()) for one in entry.value[value.OF_LEVELS].value}) > 1}
    assert len(spread) > 5


def test_results_of_a_higher_level_do_not_give_way_without_a_word():
    values = study(asked="draft").parameters(["twin"])
    notes: list[str] = []
    for kept, words in (("paper", "are of accuracy paper and give way to draft"), ("draft", ""), (None, "")):
        last = None if kept is None else SimpleNamespace(ingredients={"parameters": {"accuracy": {"level": kept}}})
        store = SimpleNamespace(current=lambda name, last=last: last)
        notes.clear()
        _say_what_gives_way(SimpleNamespace(store=store, settings=()), values, SimpleNamespace(note=notes.append))  # type: ignore[arg-type]
        assert bool(notes) == bool(words) and words in "".join(notes)
