"""`map --within`: each design by the cheapest rung, as `ask` answers it alone, whatever the blocks."""

import contextlib
import dataclasses
import json

import h5py
import numpy as np
import pytest

from pipeline.questions.asking import Asked
from stages.biped.question import WrongOption
from stages.model_error.choice import Ladder
from stages.model_error.miss import Learnt
from stages.model_error.questions.map import Options, ask
from stages.model_error.result import MODELS

BOX = {"count": 6, "seed": 2, "vary": {"biped.stiffness": {"low": 1800, "high": 2400},
                                       "ground.slope_deg": {"low": 1.8, "high": 2.4}}}  # fmt: skip


class Asking:
    """An `Asking` that computes here, and has a result or none."""

    jobs = 1

    def __init__(self, parameters, found):
        self.parameters, self.found = parameters, found

    def result(self, stage=""):
        return self.found, "results/model_error.h5 is not there"

    def each(self, function, arguments, *shared):
        for argument in arguments:
            given = json.loads(json.dumps([shared, argument]))
            yield json.loads(json.dumps(function(self.parameters, *given[0], given[1])))

    @contextlib.contextmanager
    def new_file(self, path):
        yield path

    new_table = Asked.new_table


def test_each_design_is_answered_as_if_it_were_asked_alone(parameters, small, tmp_path):
    options = Options(BOX, out=tmp_path / "map.h5", within=("step_frequency=3%", "period=1e-4"))
    answer = ask(parameters, options, Asking(parameters, small))
    with h5py.File(options.out) as file:
        found = {name: column[()] for name, column in file["table"].items()}
        words = {value: word for word, value in h5py.check_enum_dtype(file["table/period_model"].dtype).items()}
    assert sum(answer.plain["answered_by"]["period"].values()) == 6
    for row in range(6):
        biped = dataclasses.replace(parameters.biped, stiffness=found["biped.stiffness"][row])
        slope = dataclasses.replace(parameters.slope, slope_deg=found["ground.slope_deg"][row])
        alone = Ladder(dataclasses.replace(parameters, biped=biped, slope=slope), Learnt(small))
        one, other = alone.within("step_frequency", 0.03, True), alone.within("period", 1e-4, False)
        assert found["step_frequency"][row] == pytest.approx(one.value, rel=1e-6)
        assert found["step_frequency_error"][row] == pytest.approx((one.solver + one.model) * one.value, rel=1e-3)
        assert found["step_frequency_error"][row] <= 0.03 * one.value and found["period_error"][row] <= 1e-4
        assert words[found["period_model"][row]] == other.rung == MODELS[2]


def test_a_design_that_breaks_a_rule_or_that_no_model_has_is_no_number(parameters, small, tmp_path):
    wide = {"kind": "grid", "vary": {"biped.foot_radius": {"low": 0.05, "high": 0.5, "steps": 2}}}
    options = Options(wide, out=tmp_path / "map.h5", within=("multiplier=1e-5",))
    plain = ask(parameters, options, Asking(parameters, small)).plain["answered_by"]["multiplier"]
    assert plain == {"no model": 1, "not allowed": 1}
    with h5py.File(options.out) as file:
        assert np.isnan(file["table/multiplier"][()]).all()


@pytest.mark.parametrize(("within", "said"), [
    ("1%", "names the measure"), ("hop=1%", "hop is no measure"), ("multiplier=1%", "can be 0"),
    ("speed=0", "not a positive error"),
])  # fmt: skip
def test_a_bad_request_is_one_sentence(parameters, small, within, said):
    with pytest.raises(WrongOption, match=said):
        ask(parameters, Options(BOX, within=(within,)), Asking(parameters, small))


def test_without_what_was_learnt_the_command_that_learns_is_named(parameters):
    with pytest.raises(WrongOption, match="bipedstudy run model_error"):
        ask(parameters, Options(BOX, within=("speed=1%",)), Asking(parameters, None))
