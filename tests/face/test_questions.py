"""Every question of the command line can be asked from Python, with parameters by name."""

from __future__ import annotations

import pytest

import bipedstudy as bs
from pipeline.errors import StudyError
from pipeline.questions.command import questions
from pipeline.study import locate

BOX = {"count": 3, "vary": {"biped.hip_mass": {"low": 0.3, "high": 0.33}}}


def test_each_question_that_a_stage_declares_is_there_and_says_what_it_takes():
    declared = [question for _, _, question in questions(locate())[0]]
    assert len(declared) >= 11
    for question in declared:
        name = {"continue": "continue_"}.get(question.name, question.name.replace("-", "_"))
        assert name in dir(bs)
        if name != "gait":  # of which the report itself is given
            assert question.help.strip().splitlines()[0] in getattr(bs, name).__doc__


def test_an_answer_is_read_by_key_and_prints_as_the_command_does():
    found = bs.sensitivity(slope_deg=2.2)
    assert found.plain and repr(found).startswith("gait: ")
    assert bs.sensitivity(settings={"ground.slope_deg": 2.2}).plain == found.plain


def test_a_mapping_stands_for_a_file_and_an_answer_draws_itself(tmp_path):
    found = bs.map(BOX, study=_study(tmp_path), jobs=1)
    assert found["designs"] == 3
    assert found.figure().axes


def test_parameters_by_name_are_those_of_a_setting():
    ways = bs.gait(hip_mass=0.4), bs.gait("biped.hip_mass=0.4"), bs.gait({"biped.hip_mass": 0.4})
    assert len({one.gait.period_s for one in ways}) == 1 and ways[0].gait.period_s != bs.gait().gait.period_s


@pytest.mark.parametrize(("ask", "said"), [
    (lambda: bs.gait(hip_mas=0.4), 'there is no parameter "hip_mas" of stage analytic; did you mean "hip_mass"'),
    (lambda: bs.sensitivity(tolerance=1e-9, foot=1), 'no parameter "foot"'),
    (lambda: bs.ask("period", within="1%", tolerance=1e-3), "several files; name one: analytic.tolerance"),
    (lambda: bs.ask("hop", within="1%"), "is not allowed; allowed: period"),
    (lambda: bs.ask(), "ask needs what"),
    (lambda: bs.sensitivity("x", "y"), "arguments without a name"),
    (lambda: bs.map("nowhere.yaml"), "nowhere.yaml"),
])  # fmt: skip
def test_what_is_not_allowed_is_one_sentence(ask, said):
    with pytest.raises(StudyError, match=said):
        ask()


def test_a_name_that_is_none_is_told_with_those_that_are():
    with pytest.raises(AttributeError, match=r"no attribute 'hop'; it has .*ask"):
        _ = bs.hop


def _study(folder):
    """A new study there."""
    from click.testing import CliRunner

    from pipeline.commands.house import init

    assert CliRunner().invoke(init, [str(folder / "mine")]).exit_code == 0
    return folder / "mine"
