from dataclasses import dataclass

from toystages.bounce.result import Result
from toystages.fall.result import Result as Fall


@dataclass(frozen=True)
class Inputs:
    fall: Fall


def run(parameters, inputs, progress=lambda fraction, what: None):
    fall = inputs.fall
    assert not fall.files
    return Result(float(fall.sample.distance[-1] * parameters.ground.contact_stiffness))
