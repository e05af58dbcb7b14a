"""`design --within`: a target is held as the twin has it, and told within its error."""

import dataclasses

import pytest

from stages.biped.question import WrongOption
from stages.ground.blocks import Blocks
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


def on_blocks(parameters, rms, **changes):
    return dataclasses.replace(parameters, blocks=Blocks(rms), **changes)


def test_a_design_walks_longer_on_blocks_within_its_limits(parameters):
    """Both steps to a fall are counted on the blocks asked for, and their intervals are apart."""
    rigid = on_blocks(parameters, 8e-4, biped=dataclasses.replace(parameters.biped, legs="rigid"))
    options = Options(goal="steps_to_fall", vary=("biped.foot_radius=0.08:0.1", "biped.foot_com"), iterations=3,
                      target=("speed=0.35:0.4",))  # fmt: skip
    answer = ask(rigid, options, Listening(None))
    told, own = answer.plain["steps_to_fall"], answer.plain["goal"]
    assert told["best"]["steps_low"] > told["start"]["steps_high"] > told["start"]["steps_low"] > 3
    assert own["best"] > own["start"] and answer.plain["path"]["goal"][0] == own["start"]
    assert 0.35 <= answer.plain["measures"]["speed_m_s"] <= 0.4 * (1 + 1e-6) and not answer.no
    assert answer.plain["targets"] == {"speed_m_s": [0.35, 0.4]}
    assert any("mean steps to a fall on blocks of 0.8 mm" in line for line in answer.lines)


def test_what_cannot_be_made_to_walk_longer_is_refused(parameters):
    limited = dataclasses.replace(parameters.analytic, transition="coulomb")
    for there, options, words in (
        (on_blocks(parameters, 0.0), {}, "--goal steps_to_fall: ground.block_height_rms = 0 m"),
        (on_blocks(parameters, 1e-3), {"maximise": True}, "is made most without --maximise"),
        (on_blocks(parameters, 1e-3, analytic=limited), {}, "--goal steps_to_fall: .* limited friction"),
    ):
        with pytest.raises(WrongOption, match=words):
            ask(there, Options(goal="steps_to_fall", **options), Listening(None))
