"""`design --within`: a target is held as the twin has it, and told within its error."""

import dataclasses

import pytest

from stages.biped.question import WrongOption
from stages.model_error.measures import NAMES
from stages.model_error.questions.design import Options, ask
from stages.model_error.result import TWIN
from stages.model_error.run import design_of
from stages.model_error.rungs import RUNGS
from tests.model_error.test_ask import Asking


class Listening(Asking):
    """An `Asking` to whom something is said."""

    def note(self, text):
        assert text


def test_a_target_is_held_as_the_twin_has_it(parameters, small):
    options = Options(vary=("biped.foot_radius", "biped.foot_com"), target=("speed=0.33",), within=("speed=0.3%",),
                      iterations=20)  # fmt: skip
    answer = ask(parameters, options, Listening(small))
    told = answer.plain["within"]["speed"]
    assert not answer.no and answer.plain["targets"] == {"speed_m_s": 0.33}
    assert told["met"] and abs(told["value"] / 0.33 - 1.0) <= 3e-3
    assert abs(answer.plain["measures"]["speed_m_s"] / 0.33 - 1.0) > 3e-3  # the constraint model has another speed
    changed = {name.removeprefix("biped."): value for name, value in answer.parameters.items()}
    biped = dataclasses.replace(parameters.biped, **changed)
    twin = RUNGS[TWIN].find(design_of(dataclasses.replace(parameters, biped=biped)), 1e-7)
    assert abs(twin.values[NAMES.index("speed")] / told["value"] - 1.0) <= 3e-3
    assert any(line.startswith("speed: ") for line in answer.lines)


def test_a_design_names_the_measure_of_each_error_and_needs_what_was_learnt(parameters, small):
    with pytest.raises(WrongOption, match="names the measure"):
        ask(parameters, Options(within=("1%",)), Listening(small))
    with pytest.raises(WrongOption, match="model_error learns it"):
        ask(parameters, Options(within=("speed=1%",)), Listening(None))
